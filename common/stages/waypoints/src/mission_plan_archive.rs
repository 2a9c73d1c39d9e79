//! Assembles the `mission-plan` archive.

use crate::drive_cost::{Driven, driven_line, driven_portal, rise_m};
use crate::flight::FlightPlan;
use crate::free_space::{FreeSpace, is_planned};
use crate::input::MissionPlanInput;
use crate::portal::{Portal, PortalKind};
use crate::reachability::Reachability;
use crate::route_graph::NodePlace;
use crate::scan_budget::{merged, mission_j, mission_s};
use crate::scan_growth::GrownScan;
use crate::sensor_place::{SensorPlace, sensor_place};
use crate::spaces::Refusal;
use crate::stair_traversal::stair_traversal;
use crate::start_pose::why_blocked;
use crate::storey_planner::PlannedStorey;
use crate::tour_stops::{StopPurpose, TourStop};
use frames::{Map, Point2};
use messages::{
    Diagnostic, DiagnosticCode, DiagnosticRecord, EdgeKind, ElementRecord, FloorPartRecord, GridHead, GrownScanRecord,
    MapGrids, MissionPlanBuilder, MissionPlanHead, MissionPlanSpaceRecord, MissionPlanStoreyRecord, NONE, Named,
    NoWaypoint, NodeKind, RouteEdgeRecord, RouteNodeRecord, ScheduleStateHead, Severity, Site, SpaceAccess,
    StoreyEntry, Text, WaypointRecord,
};

/// Assembles the archive: storeys in the order in which they are reached, refusals, and the graph over all storeys.
pub(crate) fn assemble(
    input: &MissionPlanInput<'_>,
    free_spaces: &[&FreeSpace],
    planned_storeys: &[&PlannedStorey],
    refusals: Vec<Option<Refusal>>,
    reached: &Reachability,
    portals: &[Portal],
    parts: Vec<FloorPartRecord>,
) -> MissionPlanBuilder {
    let mut builder = MissionPlanBuilder::new(head(input, planned_storeys), input.site.spaces.len());
    builder.floor_parts = parts;
    for (space, refusal) in refusals.into_iter().enumerate() {
        if let Some(refusal) = refusal {
            refuse(&mut builder, space, &refusal);
        } else {
            builder.spaces[space].why = NoWaypoint::Has.into();
        }
    }
    // Storeys in the order in which they are reached; the others have no waypoints.
    for &at in &reached.order {
        add_stops(&mut builder, input, (input.grids.head(at), free_spaces[at]), planned_storeys[at]);
    }
    for (at, planned) in planned_storeys.iter().enumerate() {
        for (space, refusal) in &planned.refused {
            refuse(&mut builder, *space, refusal);
        }
        for (record, seen) in builder.spaces.iter_mut().zip(&planned.space_coverage[1..]) {
            record.n_faces += seen.n_faces;
            record.n_seen += seen.n_seen;
        }
        let record = storey_record(&mut builder.tour_points, input.grids.head(at).map_storey, planned);
        builder.storeys.push(MissionPlanStoreyRecord { entry: reached.entered[at].into(), ..record });
    }
    judge_access(&mut builder, input, planned_storeys);
    add_graph(&mut builder, input, free_spaces, planned_storeys, portals);
    find_spaces_of_nodes(&mut builder.nodes, input.grids);
    if let Some(start) = input.options.start.filter(|_| reached.start_is_blocked) {
        let storey = start.storey as usize;
        let why = free_spaces.get(storey).map_or("[tour] start: there is no such storey".to_owned(), |free_space| {
            input.grids.with(storey, |grid| why_blocked(input.site, grid, free_space, start))
        });
        warn(&mut builder, Severity::Error, DiagnosticCode::StartBlocked, why);
    }
    let growths: Vec<&[GrownScan]> = planned_storeys.iter().map(|planned| planned.growth.as_slice()).collect();
    let record = |(at, scan): (usize, &GrownScan)| GrownScanRecord {
        map_storey: input.grids.head(at).map_storey,
        n_new: scan.n_new,
    };
    builder.growth = merged(&growths).into_iter().map(record).collect();
    notice_scans(&mut builder, input, planned_storeys);
    notice_outdoors(&mut builder, input);
    free_spaces
        .iter()
        .zip(planned_storeys)
        .for_each(|(floor, planned)| notice_distances(&mut builder, input.site, floor, planned));
    for &element in planned_storeys.iter().flat_map(|planned| &planned.mesh.unseen) {
        unseen_element(&mut builder, input.site, &input.site.elements[element as usize]);
    }
    builder
}

/// Adds flight waypoints, with a notice if none are planned.
pub(crate) fn add_flight(builder: &mut MissionPlanBuilder, flight: &FlightPlan) {
    builder.flight = Some(flight.records.clone());
    if let Some(refusal) = &flight.refusal {
        warn(builder, Severity::Error, DiagnosticCode::FlightTooLarge, refusal.clone());
    }
}

/// Notices about scans: those that do not register, a budget that driving alone uses up, storeys without target faces.
fn notice_scans(builder: &mut MissionPlanBuilder, input: &MissionPlanInput<'_>, planned_storeys: &[&PlannedStorey]) {
    let (goal, n_unregistered) =
        (input.options.overlap, planned_storeys.iter().map(|p| p.n_unregistered).sum::<usize>());
    if n_unregistered > 0 {
        let message = format!(
            "scans of whose faces the others saw less than {goal}, and that nothing can join: {n_unregistered}"
        );
        warn(builder, Severity::Warning, DiagnosticCode::ScanNotJoined, message);
    }
    let minutes = builder.head.mission_s.iter().sum::<f64>() / 60.0;
    if let Some(minutes_max) = input.options.minutes_max.filter(|minutes_max| *minutes_max < minutes) {
        let message = format!(
            "driving to the centres alone takes {minutes:.1} minutes of the {minutes_max} that there are: no scan is planned"
        );
        warn(builder, Severity::Warning, DiagnosticCode::BudgetTooSmall, message);
    }
    for (head, planned) in input.grids.heads().zip(planned_storeys) {
        if planned.is_without_structure {
            let name = input.site.text(input.site.map_storeys[head.map_storey as usize].name);
            let message = format!(
                "storey {name:?} has obstacles, and none of the classes that scans are to see: classes = [\"all\"] scans them"
            );
            warn(builder, Severity::Warning, DiagnosticCode::NoTargetFaces, message);
        }
    }
}

/// A warning where the ground outdoors is too large for ways over it.
fn notice_outdoors(builder: &mut MissionPlanBuilder, input: &MissionPlanInput<'_>) {
    for head in input.grids.heads().filter(|head| !is_planned(head)) {
        let name = input.site.text(input.site.map_storeys[head.map_storey as usize].name);
        let message = format!(
            "no ways are planned over the ground outdoors, map storey {name:?}: {} million cells are too many, a coarser resolution has fewer",
            head.spec().n_cells() / 1_000_000
        );
        warn(builder, Severity::Warning, DiagnosticCode::OutdoorsNotPlanned, message);
    }
}

/// Notices about waypoints within distances that the robot keeps: no other place serves.
fn notice_distances(
    builder: &mut MissionPlanBuilder,
    site: &Site<'_>,
    free_space: &FreeSpace,
    planned: &PlannedStorey,
) {
    for stop in planned.stops.iter().filter(|stop| free_space.is_kept_off_at(stop.at)) {
        let kind = stop.purpose.kind().name();
        let space = stop.space.map_or("outside of spaces".to_owned(), |space| {
            let record = &site.spaces[space];
            format!("in the space {} {:?}", site.text(record.global_id), site.text(record.name))
        });
        let message = format!(
            "the {kind} at x {:.2} m, y {:.2} m {space} lies within a distance that the robot is to keep: no other place serves",
            stop.at.x_m(),
            stop.at.y_m()
        );
        warn(builder, Severity::Warning, DiagnosticCode::WithinSafetyDistance, message);
    }
}

fn unseen_element(builder: &mut MissionPlanBuilder, site: &Site<'_>, element: &ElementRecord) {
    let diagnostic = Diagnostic {
        severity: Severity::Warning,
        code: DiagnosticCode::ElementUnseen,
        entity: Some(Named {
            step_id: element.step_id,
            global_id: site.text(element.global_id).to_owned(),
            name: site.text(element.name).to_owned(),
        }),
        source: Some(element.source),
        message: "some of it can be seen from where the robot gets to, and no scan sees any".to_owned(),
    };
    builder.diagnostics.push(DiagnosticRecord::of(&diagnostic, &mut builder.texts));
}

fn head(input: &MissionPlanInput<'_>, planned_storeys: &[&PlannedStorey]) -> MissionPlanHead {
    let options = input.options;
    MissionPlanHead {
        site_hash: input.site.content_hash(),
        schedule_state_hash: input.schedule_state.content_hash(),
        plan_time_s: input.schedule_state.head.plan_time_s,
        sensor: options.sensor,
        coverage_goal: if options.plans_scans() { options.coverage } else { 0.0 },
        min_gain_m: options.min_gain_m,
        overlap_goal: options.overlap,
        separation_m: options.separation_m,
        minutes_max: options.minutes_max.unwrap_or(f64::INFINITY),
        drive: options.drive,
        mission_s: mission_s(options, planned_storeys),
        mission_j: mission_j(options, planned_storeys),
        changed_since_s: options.changed_since_s.unwrap_or(ScheduleStateHead::NO_TIME),
        closed_tours: u32::from(options.closed_tours),
        scans_max: options.scans_max.unwrap_or(NONE),
        classes: options.classes,
        reserved: 0,
    }
}

fn refuse(builder: &mut MissionPlanBuilder, space: usize, refusal: &Refusal) {
    let reason = builder.texts.add(&refusal.reason);
    let record = &mut builder.spaces[space];
    *record = MissionPlanSpaceRecord { reason, why: refusal.why.into(), door: refusal.door, ..*record };
}

/// Whether the robot gets to each space: what the schedule closes is closed, and of the rest the planner looked for a way.
fn judge_access(builder: &mut MissionPlanBuilder, input: &MissionPlanInput<'_>, planned_storeys: &[&PlannedStorey]) {
    let has_grid = |map_storey: u32| input.grids.heads().any(|head| head.map_storey == map_storey);
    for space in 0..builder.spaces.len() {
        let record = builder.spaces[space];
        let (access, reason) = match record.why.get() {
            NoWaypoint::MetadataOnly | NoWaypoint::NoBody => (SpaceAccess::NotJudged, Text::default()),
            _ if input.schedule_state.is_blocked(space) => (SpaceAccess::Closed, Text::default()),
            NoWaypoint::Has if has_grid(input.site.spaces[space].map_storey) => (SpaceAccess::Reached, Text::default()),
            // These are looked at whether or not they are asked for.
            NoWaypoint::Has | NoWaypoint::External | NoWaypoint::Closing | NoWaypoint::NotAsked => {
                looked_at(builder, planned_storeys, space)
            }
            _ => (SpaceAccess::NoWay, record.reason),
        };
        builder.spaces[space].access = access.into();
        builder.spaces[space].access_reason = reason;
    }
}

/// Access to a space that needs no waypoint; the closed door on the way there is noted.
fn looked_at(
    builder: &mut MissionPlanBuilder,
    planned_storeys: &[&PlannedStorey],
    space: usize,
) -> (SpaceAccess, Text) {
    let mut all = planned_storeys.iter().flat_map(|planned| &planned.looked_at);
    match all.find(|(looked_at, _)| *looked_at == space) {
        None => (SpaceAccess::NotJudged, Text::default()),
        Some((_, None)) => (SpaceAccess::Reached, Text::default()),
        Some((_, Some(refusal))) => {
            builder.spaces[space].door = refusal.door;
            (SpaceAccess::NoWay, builder.texts.add(&refusal.reason))
        }
    }
}

fn warn(builder: &mut MissionPlanBuilder, severity: Severity, code: DiagnosticCode, message: String) {
    let diagnostic = Diagnostic { severity, code, entity: None, source: None, message };
    builder.diagnostics.push(DiagnosticRecord::of(&diagnostic, &mut builder.texts));
}

fn add_stops(
    builder: &mut MissionPlanBuilder,
    input: &MissionPlanInput<'_>,
    (head, free_space): (&GridHead, &FreeSpace),
    planned: &PlannedStorey,
) {
    let first_id = builder.waypoints.len() as u32;
    let id_of_scan = |set: u32| {
        let is_it = |stop: &TourStop| stop.scan().is_some_and(|scan| scan.planned.scan.set == set);
        planned.stops.iter().position(is_it).map_or(NONE, |at| first_id + at as u32)
    };
    for stop in &planned.stops {
        let floor_m = free_space.z_m(stop.at);
        let SensorPlace { at_m: sensor_in_map_m, up: up_in_map } =
            sensor_place(input.site, &input.index.head.robot, input.options, free_space, stop.at, stop.space);
        let space = stop.space.map(|s| &input.site.spaces[s]);
        let centroid = space.map_or(stop.at.coordinates_m(), |s| s.centroid_m);
        let id = builder.waypoints.len() as u32;
        match (&stop.purpose, stop.space) {
            (StopPurpose::Centre, Some(space)) => builder.spaces[space].centre = id,
            (StopPurpose::Centre, None) | (StopPurpose::Scan(_), _) => {}
        }
        let (scan, planned) = (stop.scan(), stop.scan().map(|scan| scan.planned));
        let joins = planned.and_then(|planned| planned.scan.joins);
        builder.waypoints.push(WaypointRecord {
            position_in_map_m: [stop.at.x_m(), stop.at.y_m(), floor_m],
            sensor_in_map_m,
            up_in_map,
            yaw_rad: stop.yaw_rad,
            centroid_in_map_m: [centroid[0], centroid[1], floor_m],
            clearance_m: stop.clearance_m,
            covers_m2: scan.map_or(0.0, |scan| scan.covers_m2),
            overlap: scan.map_or(0.0, |scan| scan.overlap),
            leg_m: stop.leg_m,
            id,
            order: id,
            kind: stop.purpose.kind().into(),
            map_storey: head.map_storey,
            space: stop.space.map_or(NONE, |s| s as u32),
            joins: joins.map_or(NONE, |joined| id_of_scan(joined.set)),
            n_faces: scan.map_or(0, |scan| scan.n_faces),
            registration_overlap: planned.map_or(0.0, |planned| planned.scan.overlap),
            overlap_without: joins.map_or(0.0, |joined| joined.overlap_without),
            registration_order: planned.map_or(NONE, |planned| planned.registration_order),
        });
    }
}

fn storey_record(tour_points: &mut Vec<[f64; 2]>, map_storey: u32, planned: &PlannedStorey) -> MissionPlanStoreyRecord {
    let first_tour_point = tour_points.len() as u32;
    tour_points.extend(planned.tour.iter().map(|p| p.coordinates_m()));
    let scans = || planned.stops.iter().filter_map(TourStop::scan);
    MissionPlanStoreyRecord {
        tour_m: planned.tour_m,
        tour_bound_m: planned.bound_m,
        reached_m2: planned.reached_m2,
        unreached_m2: planned.unreached_m2,
        map_storey,
        n_targets: planned.n_targets,
        n_faces: planned.space_coverage.iter().map(|s| s.n_faces).sum(),
        n_seen: planned.space_coverage.iter().map(|s| s.n_seen).sum(),
        n_places: planned.n_places,
        n_scans: scans().count() as u32,
        n_connecting: scans().filter(|scan| scan.planned.scan.joins.is_some()).count() as u32,
        n_parts: planned.n_parts,
        n_mesh_points: planned.mesh.n_points,
        n_mesh_seen: planned.mesh.n_seen,
        first_tour_point,
        n_tour_points: planned.tour.len() as u32,
        entry: StoreyEntry::None.into(),
        reserved: 0,
    }
}

fn add_graph(
    builder: &mut MissionPlanBuilder,
    input: &MissionPlanInput<'_>,
    free_spaces: &[&FreeSpace],
    planned_storeys: &[&PlannedStorey],
    portals: &[Portal],
) {
    for (at, planned) in planned_storeys.iter().enumerate() {
        let first = builder.nodes.len();
        for node in &planned.graph.nodes {
            builder.nodes.push(node_record(
                input.grids.head(at),
                free_spaces[at],
                (node.at, node.place),
                node.clearance_m,
            ));
        }
        for edge in &planned.graph.edges {
            let first_point = builder.points.len() as u32;
            let free_space = free_spaces[at];
            let back: Vec<Point2<Map>> = edge.line.iter().rev().copied().collect();
            let driven = [&edge.line, &back].map(|line| driven_line(&input.options.drive, free_space, line));
            builder.points.extend(edge.line.iter().map(|p| [p.x_m(), p.y_m(), free_space.z_m(*p)]));
            builder.edges.push(RouteEdgeRecord {
                length_m: edge.walked.length_m,
                clearance_m: edge.clearance_m,
                slope_rad: edge.walked.slope_rad,
                duration_s: driven.map(|driven| driven.duration_s),
                energy_j: driven.map(|driven| driven.energy_j),
                clear_width_m: 0.0,
                nodes: edge.nodes.map(|n| (first + n) as u32),
                kind: edge.door.map_or(EdgeKind::Floor, |_| EdgeKind::Door).into(),
                of: edge.door.unwrap_or(NONE),
                first_point,
                n_points: edge.line.len() as u32,
                usable: 1,
                n_risers: NONE,
            });
        }
    }
    let is_wanted =
        |p: &&Portal| p.ends.iter().all(|end| input.options.wants_storey(input.grids.head(end.storey).map_storey));
    // A portal to a storey that is not selected has staging nodes but no edge.
    for portal in portals.iter().filter(is_wanted) {
        let nodes = portal.ends.map(|end| {
            let at = free_spaces[end.storey].middle(end.cell);
            let head = input.grids.head(end.storey);
            let is_it = |n: &RouteNodeRecord| {
                n.kind == NodeKind::Staging
                    && (n.of, n.map_storey) == (portal.element as u32, head.map_storey)
                    && n.position_in_map_m[..2] == at.coordinates_m()
            };
            builder.nodes.iter().position(is_it).unwrap_or_else(|| {
                // Not reachable for this robot.
                let clearance_m = free_spaces[end.storey].clearance_of(end.cell);
                let place = NodePlace::Staging(portal.element as u32);
                builder.nodes.push(node_record(head, free_spaces[end.storey], (at, place), clearance_m));
                builder.nodes.len() - 1
            }) as u32
        });
        let first_point = builder.points.len() as u32;
        let ends = portal.ends.map(|end| {
            let at = free_spaces[end.storey].middle(end.cell);
            [at.x_m(), at.y_m(), free_spaces[end.storey].z_m(at)]
        });
        let is_stepped = matches!(portal.kind, PortalKind::Stair | PortalKind::Escalator);
        let traversal =
            is_stepped.then(|| stair_traversal(input.site, input.schedule_state, portal.element, ends)).flatten();
        let line = traversal.as_ref().map_or(ends.as_slice(), |traversal| &traversal.line);
        builder.points.extend_from_slice(line);
        let n_points = line.len() as u32;
        let length_m = traversal.as_ref().map_or(portal.length_m, |traversal| traversal.length_m);
        let rise_m = rise_m(free_spaces, portal);
        let driven: [Driven; 2] =
            [rise_m, -rise_m].map(|rise_m| driven_portal(&input.options.drive, portal.kind, length_m, rise_m));
        builder.edges.push(RouteEdgeRecord {
            length_m,
            clearance_m: 0.0,
            slope_rad: portal.slope_rad(),
            duration_s: driven.map(|driven| driven.duration_s),
            energy_j: driven.map(|driven| driven.energy_j),
            clear_width_m: traversal.as_ref().map_or(0.0, |traversal| traversal.clear_width_m),
            nodes,
            kind: portal.kind.edge_kind().into(),
            of: portal.element as u32,
            first_point,
            n_points,
            usable: u32::from(portal.usable),
            n_risers: traversal
                .filter(|_| portal.kind == PortalKind::Stair)
                .map_or(NONE, |traversal| traversal.n_risers),
        });
    }
}

/// A node whose space is not known yet.
fn node_record(
    head: &GridHead,
    free_space: &FreeSpace,
    (at, place): (Point2<Map>, NodePlace),
    clearance_m: f64,
) -> RouteNodeRecord {
    let (kind, of) = match place {
        NodePlace::Space(space) => (NodeKind::Space, space),
        NodePlace::Door(door) => (NodeKind::Door, door),
        NodePlace::Junction => (NodeKind::Junction, NONE),
        NodePlace::Staging(element) => (NodeKind::Staging, element),
    };
    RouteNodeRecord {
        position_in_map_m: [at.x_m(), at.y_m(), free_space.z_m(at)],
        clearance_m,
        kind: kind.into(),
        map_storey: head.map_storey,
        of,
        space: NONE,
    }
}

/// The space in which each node lies, storey by storey.
fn find_spaces_of_nodes(nodes: &mut [RouteNodeRecord], grids: &dyn MapGrids) {
    for at in 0..grids.count() {
        let map_storey = grids.head(at).map_storey;
        if !nodes.iter().any(|node| node.map_storey == map_storey) {
            continue;
        }
        grids.with(at, |grid| {
            let spec = grid.spec();
            for node in nodes.iter_mut().filter(|node| node.map_storey == map_storey) {
                let [x_m, y_m, _] = node.position_in_map_m;
                let cell = spec.cell_at(Point2::new(x_m, y_m));
                let space = cell.map_or(0, |cell| grid.space[spec.index(cell)]);
                node.space = u32::from(space).checked_sub(1).unwrap_or(NONE);
            }
        });
    }
}
