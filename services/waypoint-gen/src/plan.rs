//! All storeys together: the `plan` archive, and what of the last one still holds.

use crate::centre::Storey;
use crate::changed::{cells_of, changed_elements};
use crate::cover::Instance;
use crate::ground::Ground;
use crate::options::PlanOptions;
use crate::portals::{Portal, portals};
use crate::reached::Reached;
use crate::spaces::{Refusal, refused};
use crate::storey::{StoreyPlan, Wanted, instance_of, plan_storey};
use frames::metres;
use messages::{
    ArchiveBuffer, DiagnosticRecord, DoorPassageRecord, EdgeKind, Grid, Grids, NONE, NoWaypoint, NodeKind, Phase,
    PhaseHead, PlanBuilder, PlanHead, RobotProfile, RouteEdgeRecord, RouteNodeRecord, Site, SpacePlanRecord,
    StoreyPlanRecord, Text, WaypointKind, WaypointRecord, space_flags,
};
use rayon::prelude::*;
use xxhash_rust::xxh3::Xxh3;

/// What a plan is made from; the grids are those that the index names, in its order, and all are of the site.
#[derive(Clone, Copy)]
pub struct PlanInput<'a> {
    /// Geometry and facts.
    pub site: &'a Site<'a>,
    /// States at the plan time.
    pub phase: &'a Phase<'a>,
    /// Index of the grids: robot and doors.
    pub index: &'a Grids<'a>,
    /// One grid per map storey, in their order.
    pub grids: &'a [Grid<'a>],
    /// What to plan.
    pub options: &'a PlanOptions,
}

/// Plans, and keeps what only a part of the next input can change.
///
/// A plan is a function of its input: what is kept is used only where it was made from the same.
#[derive(Default)]
pub struct Planner {
    /// With the hash of what each was made from.
    grounds: Vec<(u64, Ground)>,
    storeys: Vec<(u64, StoreyPlan)>,
}

/// Where scans of a storey could be made, for whoever compares choices.
#[derive(Debug)]
pub struct StoreyInstance {
    /// Map storey of the site.
    pub map_storey: u32,
    /// The faces that a scan from each place sees, and how many are to be seen.
    pub instance: Instance,
    /// Places at the centroids of spaces that the robot can stand at.
    pub centroids: Vec<u32>,
    /// Floor that the middle of the robot can get to.
    pub reached_m2: f64,
}

impl Planner {
    /// What the scans of each storey are chosen from.
    pub fn instances(&mut self, input: &PlanInput<'_>) -> Vec<StoreyInstance> {
        self.plan(input);
        let PlanInput { site, phase, options, .. } = *input;
        let grounds: Vec<&Ground> = self.grounds.iter().map(|g| &g.1).collect();
        let portals = portals(site, phase, &input.index.head.robot, options, &grounds);
        let reached = Reached::of(&grounds, &portals, options.start);
        let refusals: Vec<Option<Refusal>> = (0..site.spaces.len()).map(|k| refused(site, phase, options, k)).collect();
        let changed = options.changed_since_s.map(|since_s| changed_elements(site, phase, since_s));
        let jobs = input.grids.iter().enumerate();
        let jobs = jobs.map(|(at, grid)| Job::new(input, at, grid, &refusals, &reached, &portals, changed.as_deref()));
        jobs.zip(&self.storeys)
            .map(|(job, (_, plan))| {
                let (instance, centroids) = job.with(input, grounds[job.at], instance_of);
                let map_storey = job.grid.head.map_storey;
                StoreyInstance { map_storey, instance, centroids, reached_m2: plan.reached_m2 }
            })
            .collect()
    }

    /// Makes the plan. What is planned anew is whole storeys: those whose map, spaces or ways in changed.
    pub fn plan(&mut self, input: &PlanInput<'_>) -> ArchiveBuffer {
        let PlanInput { site, phase, index, grids, options } = *input;
        let robot = &index.head.robot;
        self.see_grounds(grids, robot);
        let grounds: Vec<&Ground> = self.grounds.iter().map(|g| &g.1).collect();
        let portals = portals(site, phase, robot, options, &grounds);
        let reached = Reached::of(&grounds, &portals, options.start);
        let refusals: Vec<Option<Refusal>> = (0..site.spaces.len()).map(|k| refused(site, phase, options, k)).collect();
        let changed = options.changed_since_s.map(|since_s| changed_elements(site, phase, since_s));
        let jobs: Vec<Job<'_>> = grids
            .iter()
            .enumerate()
            .map(|(at, grid)| Job::new(input, at, grid, &refusals, &reached, &portals, changed.as_deref()))
            .collect();
        let kept = &mut self.storeys;
        kept.resize_with(jobs.len(), || (0, StoreyPlan::default()));
        let old: Vec<(u64, StoreyPlan)> = std::mem::take(kept);
        *kept = jobs
            .par_iter()
            .zip(old)
            .map(|(job, (made_from, plan))| {
                let now = job.made_from(input);
                (now, if now == made_from { plan } else { job.plan(input, grounds[job.at]) })
            })
            .collect();
        let plans: Vec<&StoreyPlan> = kept.iter().map(|k| &k.1).collect();
        assemble(input, &grounds, &plans, refusals, &reached, &portals).finish()
    }

    fn see_grounds(&mut self, grids: &[Grid<'_>], robot: &RobotProfile) {
        let old = std::mem::take(&mut self.grounds);
        let mut old: Vec<Option<(u64, Ground)>> = old.into_iter().map(Some).collect();
        old.resize_with(grids.len(), || None);
        self.grounds = grids
            .par_iter()
            .zip(old)
            .map(|(grid, old)| {
                let made_from = grid.content_hash() ^ robot.radius_m.to_bits().rotate_left(17);
                old.filter(|o| o.0 == made_from).unwrap_or_else(|| (made_from, Ground::of(grid, robot.radius_m)))
            })
            .collect();
    }
}

/// What is to be done on a storey.
struct Job<'a> {
    at: usize,
    grid: &'a Grid<'a>,
    spaces: Vec<usize>,
    may_scan: Vec<bool>,
    passages: Vec<DoorPassageRecord>,
    reached: &'a [bool],
    entries: &'a [frames::Point2<frames::Map>],
    stagings: Vec<(usize, u32)>,
    changed: Option<&'a [usize]>,
}

impl<'a> Job<'a> {
    fn new(
        input: &PlanInput<'a>,
        at: usize,
        grid: &'a Grid<'a>,
        refusals: &[Option<Refusal>],
        reached: &'a Reached,
        portals: &[Portal],
        changed: Option<&'a [usize]>,
    ) -> Self {
        let site = input.site;
        let is_here = |space: usize| site.spaces[space].map_storey == grid.head.map_storey;
        // Outside of spaces it may scan, unless somebody asked for some spaces.
        let mut may_scan = vec![input.options.spaces.is_empty(); site.spaces.len() + 1];
        for (space, refusal) in refusals.iter().enumerate() {
            let is_open = |r: &Refusal| r.why == NoWaypoint::MetadataOnly && input.options.spaces.is_empty();
            may_scan[space + 1] =
                refusal.as_ref().is_none_or(is_open) && !site.spaces[space].has(space_flags::EXTERNAL);
        }
        let ends = portals.iter().flat_map(|p| p.ends.map(|end| (end, p.element as u32)));
        let mut stagings: Vec<(usize, u32)> =
            ends.filter(|(end, _)| end.storey == at).map(|(end, element)| (end.cell, element)).collect();
        stagings.sort_unstable();
        stagings.dedup();
        Self {
            at,
            grid,
            spaces: (0..site.spaces.len()).filter(|&k| refusals[k].is_none() && is_here(k)).collect(),
            may_scan,
            passages: input.index.doors.iter().filter(|d| d.map_storey == grid.head.map_storey).copied().collect(),
            reached: &reached.parts[at],
            entries: &reached.entries[at],
            stagings,
            changed,
        }
    }

    /// Hash of everything that the storey's plan is a function of.
    fn made_from(&self, input: &PlanInput<'_>) -> u64 {
        let mut hash = Xxh3::new();
        let numbers = |list: &mut dyn Iterator<Item = u64>, hash: &mut Xxh3| {
            let mut n = 0u64;
            for number in list {
                hash.update(&number.to_le_bytes());
                n += 1;
            }
            hash.update(&n.to_le_bytes());
        };
        numbers(&mut [input.site.content_hash(), self.grid.content_hash()].into_iter(), &mut hash);
        hash.update(bytemuck::bytes_of(&input.index.head.robot));
        hash.update(format!("{:?}", input.options).as_bytes());
        hash.update(bytemuck::cast_slice(&self.passages));
        numbers(&mut self.spaces.iter().map(|&k| k as u64), &mut hash);
        numbers(&mut self.may_scan.iter().map(|&b| u64::from(b)), &mut hash);
        numbers(&mut self.reached.iter().map(|&b| u64::from(b)), &mut hash);
        numbers(&mut self.entries.iter().flat_map(|p| [p.x_m.to_bits(), p.y_m.to_bits()]), &mut hash);
        numbers(&mut self.stagings.iter().flat_map(|&(cell, element)| [cell as u64, u64::from(element)]), &mut hash);
        numbers(&mut self.changed.unwrap_or_default().iter().map(|&k| k as u64), &mut hash);
        hash.digest()
    }

    fn plan(&self, input: &PlanInput<'_>, ground: &Ground) -> StoreyPlan {
        self.with(input, ground, plan_storey)
    }

    fn with<T>(&self, input: &PlanInput<'_>, ground: &Ground, work: fn(&Storey<'_>, &Wanted<'_>) -> T) -> T {
        let targets = self.changed.map(|elements| cells_of(input.site, self.grid, elements));
        let storey = Storey {
            site: input.site,
            grid: self.grid,
            ground,
            robot: &input.index.head.robot,
            passages: &self.passages,
            reached: self.reached,
        };
        let wanted = Wanted {
            options: input.options,
            spaces: &self.spaces,
            may_scan: &self.may_scan,
            targets: targets.as_deref(),
            entries: self.entries,
            stagings: &self.stagings,
        };
        work(&storey, &wanted)
    }
}

fn assemble(
    input: &PlanInput<'_>,
    grounds: &[&Ground],
    plans: &[&StoreyPlan],
    refusals: Vec<Option<Refusal>>,
    reached: &Reached,
    portals: &[Portal],
) -> PlanBuilder {
    let mut builder = PlanBuilder::new(head(input, plans), input.site.spaces.len());
    for (space, refusal) in refusals.into_iter().enumerate() {
        if let Some(refusal) = refusal {
            refuse(&mut builder, space, &refusal);
        } else {
            builder.spaces[space].why = NoWaypoint::Has as u32;
        }
    }
    // Storeys in the order in which they are come to; the others have no waypoints.
    for &at in &reached.order {
        add_stops(&mut builder, input, &input.grids[at], plans[at]);
    }
    for (at, plan) in plans.iter().enumerate() {
        for (space, refusal) in &plan.refused {
            refuse(&mut builder, *space, refusal);
        }
        for (record, seen) in builder.spaces.iter_mut().zip(&plan.seen[1..]) {
            record.n_faces += seen.n_faces;
            record.n_seen += seen.n_seen;
        }
        builder.storeys.push(storey_record(&mut builder.tour_points, input.grids[at].head.map_storey, plan));
    }
    add_graph(&mut builder, input, grounds, plans, portals);
    if reached.start_is_blocked {
        let message = "the robot cannot stand at the start that was given, so it gets nowhere";
        warn(&mut builder, "start_blocked", message, 2);
    }
    let goal = input.options.overlap;
    let alone = builder.waypoints.iter().filter(|w| w.kind == WaypointKind::Scan as u32 && w.overlap < goal);
    // The first scan of a part has nothing before it.
    let n_first: u32 = builder.storeys.iter().filter(|s| s.n_scans > 0).map(|s| s.n_parts).sum();
    let n_alone = alone.count().saturating_sub(n_first as usize);
    if n_alone > 0 {
        let message =
            format!("{n_alone} scans see less than {goal} of what scans before them saw, and nothing can join them");
        warn(&mut builder, "scan_not_joined", &message, 1);
    }
    builder
}

fn head(input: &PlanInput<'_>, plans: &[&StoreyPlan]) -> PlanHead {
    let options = input.options;
    let n_scans = plans.iter().flat_map(|p| &p.stops).filter(|s| s.kind == WaypointKind::Scan).count();
    let driven_m: f64 = plans.iter().map(|p| p.tour_m).sum();
    PlanHead {
        site_hash: input.site.content_hash(),
        phase_hash: input.phase.content_hash(),
        plan_time_s: input.phase.head.plan_time_s,
        sensor: options.sensor,
        coverage_goal: if options.scans { options.coverage } else { 0.0 },
        overlap_goal: options.overlap,
        mission_s: [driven_m / options.speed_m_s, n_scans as f64 * options.scan_s],
        changed_since_s: options.changed_since_s.unwrap_or(PhaseHead::NO_TIME),
        closed_tours: u32::from(options.closed_tours),
        reserved: 0,
    }
}

fn refuse(builder: &mut PlanBuilder, space: usize, refusal: &Refusal) {
    let reason = builder.texts.add(&refusal.reason);
    let record = &mut builder.spaces[space];
    *record = SpacePlanRecord { reason, why: refusal.why as u32, door: refusal.door, ..*record };
}

fn warn(builder: &mut PlanBuilder, code: &str, message: &str, severity: u32) {
    let record = DiagnosticRecord {
        code: builder.texts.add(code),
        global_id: Text::default(),
        name: Text::default(),
        message: builder.texts.add(message),
        severity,
        step_id: 0,
        source: NONE,
        reserved: 0,
    };
    builder.diagnostics.push(record);
}

fn add_stops(builder: &mut PlanBuilder, input: &PlanInput<'_>, grid: &Grid<'_>, plan: &StoreyPlan) {
    let floor_m = metres(grid.head.floor_z_tenths);
    for stop in &plan.stops {
        let space = stop.space.map(|s| &input.site.spaces[s]);
        let half_height_m = space.map(|s| metres(s.height_tenths) / 2.0).filter(|_| input.options.flies);
        let centroid = space.map_or([stop.at.x_m, stop.at.y_m], |s| s.centroid_m);
        let id = builder.waypoints.len() as u32;
        if let (Some(space), WaypointKind::Centre) = (stop.space, stop.kind) {
            builder.spaces[space].centre = id;
        }
        builder.waypoints.push(WaypointRecord {
            position_in_map_m: [stop.at.x_m, stop.at.y_m, floor_m],
            sensor_z_m: floor_m + half_height_m.unwrap_or(input.index.head.robot.sensor_height_m),
            yaw_rad: stop.yaw_rad,
            centroid_in_map_m: [centroid[0], centroid[1], floor_m],
            clearance_m: stop.clearance_m,
            covers_m2: stop.covers_m2,
            overlap: stop.overlap,
            leg_m: stop.leg_m,
            id,
            order: id,
            kind: stop.kind as u32,
            map_storey: grid.head.map_storey,
            space: stop.space.map_or(NONE, |s| s as u32),
            connects: u32::from(stop.connects),
            n_faces: stop.n_faces,
            reserved: 0,
        });
    }
}

fn storey_record(tour_points: &mut Vec<[f64; 2]>, map_storey: u32, plan: &StoreyPlan) -> StoreyPlanRecord {
    let first_tour_point = tour_points.len() as u32;
    tour_points.extend(plan.tour.iter().map(|p| [p.x_m, p.y_m]));
    let scans = || plan.stops.iter().filter(|s| s.kind == WaypointKind::Scan);
    StoreyPlanRecord {
        tour_m: plan.tour_m,
        tour_bound_m: plan.bound_m,
        reached_m2: plan.reached_m2,
        unreached_m2: plan.unreached_m2,
        map_storey,
        n_targets: plan.n_targets,
        n_faces: plan.seen.iter().map(|s| s.n_faces).sum(),
        n_seen: plan.seen.iter().map(|s| s.n_seen).sum(),
        n_places: plan.n_places,
        n_scans: scans().count() as u32,
        n_connecting: scans().filter(|s| s.connects).count() as u32,
        n_parts: plan.n_parts,
        n_mesh_points: 0,
        n_mesh_seen: 0,
        first_tour_point,
        n_tour_points: plan.tour.len() as u32,
    }
}

fn add_graph(
    builder: &mut PlanBuilder,
    input: &PlanInput<'_>,
    grounds: &[&Ground],
    plans: &[&StoreyPlan],
    portals: &[Portal],
) {
    for (at, plan) in plans.iter().enumerate() {
        let first = builder.nodes.len();
        for node in &plan.graph.nodes {
            builder.nodes.push(node_record(input, grounds, at, node.at, node.kind, node.of, node.clearance_m));
        }
        for edge in &plan.graph.edges {
            let first_point = builder.points.len() as u32;
            builder.points.extend(edge.line.iter().map(|p| [p.x_m, p.y_m]));
            builder.edges.push(RouteEdgeRecord {
                length_m: edge.length_m,
                clearance_m: edge.clearance_m,
                nodes: edge.nodes.map(|n| (first + n) as u32),
                kind: edge.kind as u32,
                of: edge.door,
                first_point,
                n_points: edge.line.len() as u32,
                usable: 1,
                reserved: 0,
            });
        }
    }
    for portal in portals {
        let nodes = portal.ends.map(|end| {
            let at = grounds[end.storey].middle(end.cell);
            let map_storey = input.grids[end.storey].head.map_storey;
            let is_it = |n: &RouteNodeRecord| {
                (n.kind, n.of, n.map_storey) == (NodeKind::Staging as u32, portal.element as u32, map_storey)
                    && n.position_in_map_m[..2] == [at.x_m, at.y_m]
            };
            builder.nodes.iter().position(is_it).unwrap_or_else(|| {
                // The robot does not get there; somebody else may.
                let clearance_m = grounds[end.storey].clearance_of(end.cell);
                let of = portal.element as u32;
                builder.nodes.push(node_record(input, grounds, end.storey, at, NodeKind::Staging, of, clearance_m));
                builder.nodes.len() - 1
            }) as u32
        });
        let first_point = builder.points.len() as u32;
        builder.points.extend(portal.ends.map(|end| {
            let at = grounds[end.storey].middle(end.cell);
            [at.x_m, at.y_m]
        }));
        builder.edges.push(RouteEdgeRecord {
            length_m: portal.length_m,
            clearance_m: 0.0,
            nodes,
            kind: portal.kind as u32,
            of: portal.element as u32,
            first_point,
            n_points: 2,
            usable: u32::from(portal.usable),
            reserved: 0,
        });
    }
    debug_assert!(builder.edges.iter().all(|e| EdgeKind::from_id(e.kind).is_some()));
}

fn node_record(
    input: &PlanInput<'_>,
    grounds: &[&Ground],
    storey: usize,
    at: frames::Point2<frames::Map>,
    kind: NodeKind,
    of: u32,
    clearance_m: f64,
) -> RouteNodeRecord {
    let (grid, spec) = (&input.grids[storey], &grounds[storey].spec);
    let space = spec.cell_at(at).map_or(0, |cell| grid.space[spec.index(cell)]);
    RouteNodeRecord {
        position_in_map_m: [at.x_m, at.y_m, metres(grid.head.floor_z_tenths)],
        clearance_m,
        kind: kind as u32,
        map_storey: grid.head.map_storey,
        of,
        space: u32::from(space).checked_sub(1).unwrap_or(NONE),
    }
}
