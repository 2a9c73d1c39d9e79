//! Plans one storey: centres, scans, tours and route graph from map, reachability and options.

use crate::mesh_visibility::{MeshCoverage, mesh_check};
use crate::options::MissionPlanOptions;
use crate::path_search::{PathGrid, length_m};
use crate::route_graph::{Anchor, RouteGraph, graph};
use crate::scan_overlap::ScanConnector;
use crate::scans::ScanSelection;
use crate::set_cover_instance::SetCoverInstance;
use crate::space_centre::{SpaceCentre, StoreyInputs, centre_of};
use crate::spaces::Refusal;
use crate::tour_distances::{TourDistances, legs};
use crate::tour_stops::{StoreyRequest, TourGoal, TourStop, goal_of};
use frames::{Map, Point2};
use grid::Class;
use messages::{NodeKind, WaypointKind};

/// Coverage of a space: faces that can be seen, and those seen by scans.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct SpaceCoverage {
    pub(crate) n_faces: u32,
    pub(crate) n_seen: u32,
}

/// The plan of a storey.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct PlannedStorey {
    /// Spaces without a centre, and why.
    pub(crate) refused: Vec<(usize, Refusal)>,
    /// All waypoints, in the order of the tour.
    pub(crate) stops: Vec<TourStop>,
    pub(crate) tour: Vec<Point2<Map>>,
    pub(crate) tour_m: f64,
    pub(crate) bound_m: f64,
    pub(crate) n_parts: u32,
    /// Number of scans that do not overlap enough with earlier ones.
    pub(crate) n_unconnected: usize,
    pub(crate) n_targets: u32,
    pub(crate) n_places: u32,
    /// By space plus 1; 0 is outside of spaces.
    pub(crate) space_coverage: Vec<SpaceCoverage>,
    pub(crate) reached_m2: f64,
    pub(crate) unreached_m2: f64,
    pub(crate) graph: RouteGraph,
    pub(crate) mesh: MeshCoverage,
}

/// Plans a storey.
pub(crate) fn plan_storey(storey: &StoreyInputs<'_>, request: &StoreyRequest<'_>) -> PlannedStorey {
    let mut planned = PlannedStorey::default();
    let cell_m2 = storey.free_space.spec.resolution_m().powi(2);
    for part in 1..=storey.free_space.n_parts() {
        let size_m2 = f64::from(storey.free_space.size(part)) * cell_m2;
        let total = if storey.reached[part as usize] { &mut planned.reached_m2 } else { &mut planned.unreached_m2 };
        *total += size_m2;
    }
    planned.space_coverage = vec![SpaceCoverage::default(); storey.site.spaces.len() + 1];
    if !request.options.wants_storey(storey.grid.head.map_storey) {
        return planned;
    }
    let mut centres: Vec<(usize, SpaceCentre)> = Vec::new();
    for &space in request.spaces {
        match centre_of(storey, space) {
            Ok(centre) => centres.push((space, centre)),
            Err(refusal) => planned.refused.push((space, refusal)),
        }
    }
    let scans = request.options.scans.then(|| plan_scans(storey, request, &centres));
    if let Some(scans) = &scans {
        planned.n_targets = scans.faces.all.len() as u32;
        planned.n_places = scans.places.len() as u32;
    }
    let path_grid = PathGrid::of(storey.free_space, |part| storey.reached[part as usize]);
    if let Some(path_grid) = &path_grid {
        let inputs = TourInputs { storey, request, path_grid, scans: scans.as_ref() };
        tours(&inputs, &centres, &mut planned);
        let space =
            |(space, centre): &(usize, SpaceCentre)| Anchor { at: centre.at, kind: NodeKind::Space, of: *space as u32 };
        let staging = |&(cell, element): &(usize, u32)| Anchor {
            at: storey.free_space.middle(cell),
            kind: NodeKind::Staging,
            of: element,
        };
        let anchors = request.stagings.iter().map(staging).chain(centres.iter().map(space)).collect();
        planned.graph = graph(storey, path_grid, anchors);
    }
    if let Some(scans) = scans.filter(|_| request.options.mesh_check) {
        planned.mesh = mesh_check(storey, request, &scans, &planned.stops);
    }
    planned
}

/// The set-cover instance of a storey, and the sets at centres of spaces.
pub(crate) fn instance_of(storey: &StoreyInputs<'_>, request: &StoreyRequest<'_>) -> (SetCoverInstance, Vec<u32>) {
    let centres = request.spaces.iter().filter_map(|&space| centre_of(storey, space).ok().map(|c| (space, c)));
    let centres: Vec<(usize, SpaceCentre)> = centres.collect();
    let scans = plan_scans(storey, request, &centres);
    let is_centroid = |at: Point2<Map>| {
        centres.iter().any(|(space, c)| c.at == at && storey.site.spaces[*space].centroid_m == at.coordinates_m())
    };
    let centroids =
        (0..scans.poses.len()).filter(|&pose| is_centroid(scans.place(pose).at)).map(|p| p as u32).collect();
    (scans.instance, centroids)
}

fn plan_scans(
    storey: &StoreyInputs<'_>,
    request: &StoreyRequest<'_>,
    centres: &[(usize, SpaceCentre)],
) -> ScanSelection {
    let (grid, options) = (storey.grid, request.options);
    let has_class =
        |cell: usize| options.classes & (1 << grid.class[cell]) != 0 && grid.class[cell] != Class::None.id();
    let is_target = |cell: usize, front: usize| {
        let is_there = options.spaces.is_empty() || request.may_scan[usize::from(grid.space[front])];
        has_class(cell) && is_there && request.targets.is_none_or(|t| t[cell])
    };
    let centres: Vec<SpaceCentre> = centres.iter().map(|c| c.1).collect();
    ScanSelection::plan(storey, options, &centres, |cell| request.may_scan[usize::from(grid.space[cell])], is_target)
}

/// Inputs of the tours of a storey.
struct TourInputs<'a> {
    storey: &'a StoreyInputs<'a>,
    request: &'a StoreyRequest<'a>,
    path_grid: &'a PathGrid,
    scans: Option<&'a ScanSelection>,
}

/// Floor and faces seen by the scans up to a point of the tour.
struct SeenSoFar {
    /// Cells.
    floor: Vec<bool>,
    faces: Vec<bool>,
}

/// Plans tours through all parts: parts with an entry first, then by size.
fn tours(inputs: &TourInputs<'_>, centres: &[(usize, SpaceCentre)], planned: &mut PlannedStorey) {
    let TourInputs { storey, request, scans, .. } = *inputs;
    let goals = goals(storey, request, centres, scans);
    let part_at = |p: &Point2<Map>| {
        storey.free_space.spec.cell_at(*p).map_or(0, |c| storey.free_space.part(storey.free_space.spec.index(c)))
    };
    let entry = |part: u32| request.entries.iter().find(|p| part_at(p) == part).copied();
    let mut parts: Vec<u32> = goals.iter().map(|g| g.part).collect();
    parts.sort_by_key(|&p| (entry(p).is_none(), std::cmp::Reverse(storey.free_space.size(p)), p));
    parts.dedup();
    planned.n_parts = parts.len() as u32;
    let mut seen_so_far = SeenSoFar {
        floor: vec![false; if scans.is_some() { storey.free_space.spec.n_cells() } else { 0 }],
        faces: vec![false; scans.map_or(0, |s| s.faces.all.len())],
    };
    for part in parts {
        let own: Vec<TourGoal> = goals.iter().filter(|g| g.part == part).copied().collect();
        let start = entry(part);
        let OrderedGoals { goals: own, bound_m, n_unconnected } = order_goals(inputs, own, start, &seen_so_far.faces);
        planned.n_unconnected += n_unconnected;
        add_tour(inputs, &own, start, planned, &mut seen_so_far);
        // Orders are compared by lengths in whole millimetres.
        planned.bound_m = (planned.bound_m + bound_m).min(planned.tour_m);
    }
    if let Some(scans) = scans {
        let mut held = vec![false; scans.faces.all.len()];
        scans.instance.sets.iter().flatten().for_each(|&f| held[f as usize] = true);
        for (k, face) in scans.faces.all.iter().enumerate().filter(|(k, _)| held[*k]) {
            let seen = &mut planned.space_coverage[usize::from(face.space)];
            seen.n_faces += 1;
            seen.n_seen += u32::from(seen_so_far.faces[k]);
        }
    }
}

/// Maximum number of rounds of adding connecting scans and ordering the tour again.
const MAX_CONNECTION_ROUNDS: u32 = 3;

/// The goals of a part, ordered as a tour.
struct OrderedGoals {
    goals: Vec<TourGoal>,
    /// Lower bound of the length of any order.
    bound_m: f64,
    /// Number of scans that do not overlap enough with earlier ones.
    n_unconnected: usize,
}

/// Orders the goals of a part as a short tour, and adds scans that connect others.
fn order_goals(
    inputs: &TourInputs<'_>,
    goals: Vec<TourGoal>,
    start: Option<Point2<Map>>,
    seen_before: &[bool],
) -> OrderedGoals {
    let TourInputs { storey, request, path_grid, scans } = *inputs;
    let mut tour_distances = TourDistances::over(path_grid, request.options.tour_neighbours as usize);
    let start = start.map(|at| tour_distances.add([at]));
    let first = tour_distances.add(goals.iter().map(|g| g.at));
    // Each goal with its index among the places of the distances.
    let mut goals: Vec<(usize, TourGoal)> = (first..).zip(goals).collect();
    let in_order = |tour_distances: &TourDistances<'_>, goals: &[(usize, TourGoal)]| {
        let places: Vec<usize> = goals.iter().map(|g| g.0).collect();
        let place_order =
            tour_distances.order(&places, start, request.options.closed_tours, request.options.tour_kicks);
        (place_order.order.iter().map(|&k| goals[k]).collect::<Vec<_>>(), place_order.bound_m)
    };
    let mut bound_m;
    (goals, bound_m) = in_order(&tour_distances, &goals);
    let Some(scans) = scans else {
        return OrderedGoals { goals: goals.into_iter().map(|g| g.1).collect(), bound_m, n_unconnected: 0 };
    };
    let connector = ScanConnector { storey, options: request.options, scans, seen_before };
    for round in 0..=MAX_CONNECTION_ROUNDS {
        let missing_connections = connector.missing_connections(&goals);
        if missing_connections.is_empty() {
            break;
        }
        let first = tour_distances.add(missing_connections.iter().map(|(_, goal)| goal.at));
        // From the end, so that earlier indices stay valid.
        for (place, (at, goal)) in (first..).zip(missing_connections).collect::<Vec<_>>().into_iter().rev() {
            goals.insert(at, (place, goal));
        }
        if round < MAX_CONNECTION_ROUNDS {
            (goals, bound_m) = in_order(&tour_distances, &goals);
        }
    }
    let mut n_unconnected = connector.n_unconnected(&goals);
    if connector.remove_redundant(&mut goals) {
        let (shorter, bound_of_shorter_m) = in_order(&tour_distances, &goals);
        bound_m = bound_of_shorter_m;
        if connector.n_unconnected(&shorter) <= n_unconnected {
            goals = shorter;
        }
        n_unconnected = connector.n_unconnected(&goals);
    }
    OrderedGoals { goals: goals.into_iter().map(|g| g.1).collect(), bound_m, n_unconnected }
}

/// Centres and chosen scans, each with its part and space.
fn goals(
    storey: &StoreyInputs<'_>,
    request: &StoreyRequest<'_>,
    centres: &[(usize, SpaceCentre)],
    scans: Option<&ScanSelection>,
) -> Vec<TourGoal> {
    let mut goals = Vec::new();
    if request.options.centres {
        for (space, centre) in centres {
            let part = reached_part(storey, centre.at);
            goals.push(TourGoal { at: centre.at, part, space: Some(*space), pose: None, connects: false });
        }
    }
    if let Some(scans) = scans {
        for &pose in &scans.chosen {
            goals.push(goal_of(storey, scans, pose, false));
        }
    }
    goals
}

/// The part at a point, or that of a cell beside it.
fn reached_part(storey: &StoreyInputs<'_>, at: Point2<Map>) -> u32 {
    let spec = &storey.free_space.spec;
    let Some(cell) = spec.cell_at(at) else { return 0 };
    let around = |at: u32, n: u32| at.saturating_sub(1)..(at + 2).min(n);
    let cells = around(cell.row, spec.height)
        .flat_map(|row| around(cell.column, spec.width).map(move |column| grid::Cell { column, row }));
    let own = std::iter::once(cell).chain(cells).map(|c| spec.index(c));
    own.filter(|&c| storey.is_reached(c)).map(|c| storey.free_space.part(c)).next().unwrap_or(0)
}

/// Adds the stops of a part in their order, with the legs between them.
fn add_tour(
    inputs: &TourInputs<'_>,
    goals: &[TourGoal],
    start: Option<Point2<Map>>,
    planned: &mut PlannedStorey,
    seen_so_far: &mut SeenSoFar,
) {
    let TourInputs { storey, request, path_grid, scans } = *inputs;
    let mut points: Vec<Point2<Map>> = start.into_iter().chain(goals.iter().map(|g| g.at)).collect();
    if request.options.closed_tours {
        points.extend(points.first().copied());
    }
    let legs = legs(path_grid, &points);
    for (k, goal) in goals.iter().enumerate() {
        let leg = (k + usize::from(start.is_some())).checked_sub(1).and_then(|at| legs.get(at));
        let yaw_rad = heading(leg.map_or(&[], Vec::as_slice), legs.first().map_or(&[], Vec::as_slice));
        let mut stop = TourStop {
            at: goal.at,
            kind: WaypointKind::Centre,
            space: goal.space,
            yaw_rad,
            clearance_m: storey.free_space.clearance_m(goal.at),
            n_faces: 0,
            covers_m2: 0.0,
            overlap: 0.0,
            leg_m: leg.map_or(0.0, |leg| length_m(leg)),
            connects: goal.connects,
        };
        if let (Some(scans), Some(pose)) = (scans, goal.pose) {
            scan_stop(storey, request.options, scans, pose, seen_so_far, &mut stop);
        }
        planned.stops.push(stop);
    }
    planned.tour_m += legs.iter().map(|leg| length_m(leg)).sum::<f64>();
    // The lines of several parts are joined to one; lengths do not include the gaps between them.
    if points.len() == 1 {
        planned.tour.extend(&points);
    }
    for leg in &legs {
        let skip = usize::from(planned.tour.last() == leg.first());
        planned.tour.extend(&leg[skip..]);
    }
}

fn scan_stop(
    storey: &StoreyInputs<'_>,
    options: &MissionPlanOptions,
    scans: &ScanSelection,
    pose: usize,
    seen_so_far: &mut SeenSoFar,
    stop: &mut TourStop,
) {
    let free_space = storey.free_space;
    stop.kind = WaypointKind::Scan;
    stop.n_faces = scans.seen(pose).len() as u32;
    if !options.sensor.sees_around() {
        stop.yaw_rad = scans.poses[pose].1;
    }
    let seen = scans.seen(pose);
    let n_known = seen.iter().filter(|&&face| std::mem::replace(&mut seen_so_far.faces[face as usize], true)).count();
    stop.overlap = n_known as f64 / seen.len().max(1) as f64;
    let range = options.sensor.range_m / free_space.spec.resolution_m();
    let mut n_new = 0u32;
    free_space.sight.look_around(
        free_space.in_cells(stop.at),
        range,
        stop.yaw_rad,
        options.sensor.field_of_view_rad,
        |cell| {
            if !std::mem::replace(&mut seen_so_far.floor[cell], true) {
                n_new += 1;
            }
        },
    );
    stop.covers_m2 = f64::from(n_new) * free_space.spec.resolution_m().powi(2);
}

/// Heading of arrival at a stop; for the first one, of departure.
fn heading(leg: &[Point2<Map>], first: &[Point2<Map>]) -> f64 {
    let (a, b) = match (leg, first) {
        ([.., a, b], _) | ([..], [a, b, ..]) => (a, b),
        _ => return 0.0,
    };
    let yaw_rad = libm::atan2(b.y_m() - a.y_m(), b.x_m() - a.x_m());
    if a == b { 0.0 } else { yaw_rad }
}
