//! The plan of one storey: a pure function of map, reachability and options.

use crate::centre::{Centre, Storey, centre_of};
use crate::graph::{Anchor, Graph, graph};
use crate::instance::Instance;
use crate::mesh_visibility::{MeshSeen, mesh_check};
use crate::options::PlanOptions;
use crate::scan_overlap::Joining;
use crate::scans::Scans;
use crate::spaces::Refusal;
use crate::stops::{Goal, Stop, Wanted, goal_of};
use crate::trip::{Ways, legs};
use crate::walk::{Walk, length_m};
use frames::{Map, Point2};
use grid::Class;
use messages::{NodeKind, WaypointKind};

/// Faces of a space that can be seen, and those that are.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Seen {
    pub(crate) n_faces: u32,
    pub(crate) n_seen: u32,
}

/// What comes of a storey.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct StoreyPlan {
    /// Spaces without a centre, and why.
    pub(crate) refused: Vec<(usize, Refusal)>,
    /// All waypoints, in the order of the tour.
    pub(crate) stops: Vec<Stop>,
    pub(crate) tour: Vec<Point2<Map>>,
    pub(crate) tour_m: f64,
    pub(crate) bound_m: f64,
    pub(crate) n_parts: u32,
    /// Scans that nothing joins to earlier ones.
    pub(crate) n_alone: usize,
    pub(crate) n_targets: u32,
    pub(crate) n_places: u32,
    /// By space plus 1; 0 is outside of spaces.
    pub(crate) seen: Vec<Seen>,
    pub(crate) reached_m2: f64,
    pub(crate) unreached_m2: f64,
    pub(crate) graph: Graph,
    pub(crate) mesh: MeshSeen,
}

/// Plans a storey.
pub(crate) fn plan_storey(storey: &Storey<'_>, wanted: &Wanted<'_>) -> StoreyPlan {
    let mut plan = StoreyPlan::default();
    let cell_m2 = storey.ground.spec.resolution_m().powi(2);
    for part in 1..=storey.ground.n_parts() {
        let size_m2 = f64::from(storey.ground.size(part)) * cell_m2;
        let total = if storey.reached[part as usize] { &mut plan.reached_m2 } else { &mut plan.unreached_m2 };
        *total += size_m2;
    }
    plan.seen = vec![Seen::default(); storey.site.spaces.len() + 1];
    if !wanted.options.wants_storey(storey.grid.head.map_storey) {
        return plan;
    }
    let mut centres: Vec<(usize, Centre)> = Vec::new();
    for &space in wanted.spaces {
        match centre_of(storey, space) {
            Ok(centre) => centres.push((space, centre)),
            Err(refusal) => plan.refused.push((space, refusal)),
        }
    }
    let scans = wanted.options.scans.then(|| plan_scans(storey, wanted, &centres));
    if let Some(scans) = &scans {
        plan.n_targets = scans.faces.all.len() as u32;
        plan.n_places = scans.places.len() as u32;
    }
    let walk = Walk::of(storey.ground, |part| storey.reached[part as usize]);
    if let Some(walk) = &walk {
        let work = Work { storey, wanted, walk, scans: scans.as_ref() };
        tours(&work, &centres, &mut plan);
        let space =
            |(space, centre): &(usize, Centre)| Anchor { at: centre.at, kind: NodeKind::Space, of: *space as u32 };
        let staging = |&(cell, element): &(usize, u32)| Anchor {
            at: storey.ground.middle(cell),
            kind: NodeKind::Staging,
            of: element,
        };
        let anchors = wanted.stagings.iter().map(staging).chain(centres.iter().map(space)).collect();
        plan.graph = graph(storey, walk, anchors);
    }
    if let Some(scans) = scans.filter(|_| wanted.options.mesh_check) {
        plan.mesh = mesh_check(storey, wanted, &scans, &plan.stops);
    }
    plan
}

/// What the scans of a storey are chosen from, and the sets at centroids of spaces.
pub(crate) fn instance_of(storey: &Storey<'_>, wanted: &Wanted<'_>) -> (Instance, Vec<u32>) {
    let centres = wanted.spaces.iter().filter_map(|&space| centre_of(storey, space).ok().map(|c| (space, c)));
    let centres: Vec<(usize, Centre)> = centres.collect();
    let scans = plan_scans(storey, wanted, &centres);
    let is_centroid = |at: Point2<Map>| {
        centres.iter().any(|(space, c)| c.at == at && storey.site.spaces[*space].centroid_m == [at.x_m, at.y_m])
    };
    let centroids =
        (0..scans.poses.len()).filter(|&pose| is_centroid(scans.place(pose).at)).map(|p| p as u32).collect();
    (scans.instance, centroids)
}

fn plan_scans(storey: &Storey<'_>, wanted: &Wanted<'_>, centres: &[(usize, Centre)]) -> Scans {
    let (grid, options) = (storey.grid, wanted.options);
    let has_class =
        |cell: usize| options.classes & (1 << grid.class[cell]) != 0 && grid.class[cell] != Class::None.id();
    let is_target = |cell: usize, front: usize| {
        let is_there = options.spaces.is_empty() || wanted.may_scan[usize::from(grid.space[front])];
        has_class(cell) && is_there && wanted.targets.is_none_or(|t| t[cell])
    };
    let centres: Vec<Centre> = centres.iter().map(|c| c.1).collect();
    Scans::plan(storey, options, &centres, |cell| wanted.may_scan[usize::from(grid.space[cell])], is_target)
}

/// What tours are made from.
struct Work<'a> {
    storey: &'a Storey<'a>,
    wanted: &'a Wanted<'a>,
    walk: &'a Walk,
    scans: Option<&'a Scans>,
}

/// What the scans of a storey have seen up to a point of the tour.
struct SoFar {
    /// Cells.
    floor: Vec<bool>,
    faces: Vec<bool>,
}

/// Tours through all parts, one after the other: those with an entry first, then the larger ones.
fn tours(work: &Work<'_>, centres: &[(usize, Centre)], plan: &mut StoreyPlan) {
    let Work { storey, wanted, scans, .. } = *work;
    let goals = goals(storey, wanted, centres, scans);
    let part_at =
        |p: &Point2<Map>| storey.ground.spec.cell_at(*p).map_or(0, |c| storey.ground.part(storey.ground.spec.index(c)));
    let entry = |part: u32| wanted.entries.iter().find(|p| part_at(p) == part).copied();
    let mut parts: Vec<u32> = goals.iter().map(|g| g.part).collect();
    parts.sort_by_key(|&p| (entry(p).is_none(), std::cmp::Reverse(storey.ground.size(p)), p));
    parts.dedup();
    plan.n_parts = parts.len() as u32;
    let mut so_far = SoFar {
        floor: vec![false; if scans.is_some() { storey.ground.spec.n_cells() } else { 0 }],
        faces: vec![false; scans.map_or(0, |s| s.faces.all.len())],
    };
    for part in parts {
        let own: Vec<Goal> = goals.iter().filter(|g| g.part == part).copied().collect();
        let start = entry(part);
        let Ordered { goals: own, bound_m, n_alone } = ordered(work, own, start, &so_far.faces);
        plan.n_alone += n_alone;
        add_tour(work, &own, start, plan, &mut so_far);
        // Lengths are whole millimetres where orders are compared.
        plan.bound_m = (plan.bound_m + bound_m).min(plan.tour_m);
    }
    if let Some(scans) = scans {
        let mut held = vec![false; scans.faces.all.len()];
        scans.instance.sets.iter().flatten().for_each(|&f| held[f as usize] = true);
        for (k, face) in scans.faces.all.iter().enumerate().filter(|(k, _)| held[*k]) {
            let seen = &mut plan.seen[usize::from(face.space)];
            seen.n_faces += 1;
            seen.n_seen += u32::from(so_far.faces[k]);
        }
    }
}

/// Scans that join others change the way, and a way needs other scans to join it: so often are the two made to fit.
const JOINING_ROUNDS: u32 = 3;

/// The goals of a part in the order of a tour.
struct Ordered {
    goals: Vec<Goal>,
    /// No order is shorter.
    bound_m: f64,
    /// Scans that nothing joins to earlier ones.
    n_alone: usize,
}

/// The goals of a part in the order of a short tour, with scans that join others.
fn ordered(work: &Work<'_>, goals: Vec<Goal>, start: Option<Point2<Map>>, seen_before: &[bool]) -> Ordered {
    let Work { storey, wanted, walk, scans } = *work;
    let mut ways = Ways::over(walk, wanted.options.tour_around as usize);
    let start = start.map(|at| ways.add([at]));
    let first = ways.add(goals.iter().map(|g| g.at));
    // The place of each goal among the ways.
    let mut goals: Vec<(usize, Goal)> = (first..).zip(goals).collect();
    let in_order = |ways: &Ways<'_>, goals: &[(usize, Goal)]| {
        let places: Vec<usize> = goals.iter().map(|g| g.0).collect();
        let trip = ways.trip(&places, start, wanted.options.closed_tours, wanted.options.tour_kicks);
        (trip.order.iter().map(|&k| goals[k]).collect::<Vec<_>>(), trip.bound_m)
    };
    let mut bound_m;
    (goals, bound_m) = in_order(&ways, &goals);
    let Some(scans) = scans else {
        return Ordered { goals: goals.into_iter().map(|g| g.1).collect(), bound_m, n_alone: 0 };
    };
    let joining = Joining { storey, options: wanted.options, scans, seen_before };
    for round in 0..=JOINING_ROUNDS {
        let missing = joining.missing(&goals);
        if missing.is_empty() {
            break;
        }
        let first = ways.add(missing.iter().map(|(_, goal)| goal.at));
        // From the end back, so that places before stay where they are.
        for (place, (at, goal)) in (first..).zip(missing).collect::<Vec<_>>().into_iter().rev() {
            goals.insert(at, (place, goal));
        }
        if round < JOINING_ROUNDS {
            (goals, bound_m) = in_order(&ways, &goals);
        }
    }
    let mut n_alone = joining.n_alone(&goals);
    if joining.drop_needless(&mut goals) {
        let (shorter, bound_of_shorter_m) = in_order(&ways, &goals);
        bound_m = bound_of_shorter_m;
        if joining.n_alone(&shorter) <= n_alone {
            goals = shorter;
        }
        n_alone = joining.n_alone(&goals);
    }
    Ordered { goals: goals.into_iter().map(|g| g.1).collect(), bound_m, n_alone }
}

/// Centres and chosen scans, each with its part and space.
fn goals(storey: &Storey<'_>, wanted: &Wanted<'_>, centres: &[(usize, Centre)], scans: Option<&Scans>) -> Vec<Goal> {
    let mut goals = Vec::new();
    if wanted.options.centres {
        for (space, centre) in centres {
            let part = reached_part(storey, centre.at);
            goals.push(Goal { at: centre.at, part, space: Some(*space), pose: None, connects: false });
        }
    }
    if let Some(scans) = scans {
        for &pose in &scans.chosen {
            goals.push(goal_of(storey, scans, pose, false));
        }
    }
    goals
}

/// The part at a place, or that of a cell beside it.
fn reached_part(storey: &Storey<'_>, at: Point2<Map>) -> u32 {
    let spec = &storey.ground.spec;
    let Some(cell) = spec.cell_at(at) else { return 0 };
    let around = |at: u32, n: u32| at.saturating_sub(1)..(at + 2).min(n);
    let cells = around(cell.row, spec.height)
        .flat_map(|row| around(cell.column, spec.width).map(move |column| grid::Cell { column, row }));
    let own = std::iter::once(cell).chain(cells).map(|c| spec.index(c));
    own.filter(|&c| storey.is_reached(c)).map(|c| storey.ground.part(c)).next().unwrap_or(0)
}

/// Adds the stops of a part in their order, with the ways between them.
fn add_tour(work: &Work<'_>, goals: &[Goal], start: Option<Point2<Map>>, plan: &mut StoreyPlan, so_far: &mut SoFar) {
    let Work { storey, wanted, walk, scans } = *work;
    let mut points: Vec<Point2<Map>> = start.into_iter().chain(goals.iter().map(|g| g.at)).collect();
    if wanted.options.closed_tours {
        points.extend(points.first().copied());
    }
    let legs = legs(walk, &points);
    for (k, goal) in goals.iter().enumerate() {
        let leg = (k + usize::from(start.is_some())).checked_sub(1).and_then(|at| legs.get(at));
        let yaw_rad = heading(leg.map_or(&[], Vec::as_slice), legs.first().map_or(&[], Vec::as_slice));
        let mut stop = Stop {
            at: goal.at,
            kind: WaypointKind::Centre,
            space: goal.space,
            yaw_rad,
            clearance_m: storey.ground.clearance_m(goal.at),
            n_faces: 0,
            covers_m2: 0.0,
            overlap: 0.0,
            leg_m: leg.map_or(0.0, |leg| length_m(leg)),
            connects: goal.connects,
        };
        if let (Some(scans), Some(pose)) = (scans, goal.pose) {
            scan_stop(storey, wanted.options, scans, pose, so_far, &mut stop);
        }
        plan.stops.push(stop);
    }
    plan.tour_m += legs.iter().map(|leg| length_m(leg)).sum::<f64>();
    // A storey of several parts has several lines; they are drawn as one, and lengths do not count the jumps.
    if points.len() == 1 {
        plan.tour.extend(&points);
    }
    for leg in &legs {
        let skip = usize::from(plan.tour.last() == leg.first());
        plan.tour.extend(&leg[skip..]);
    }
}

fn scan_stop(
    storey: &Storey<'_>,
    options: &PlanOptions,
    scans: &Scans,
    pose: usize,
    so_far: &mut SoFar,
    stop: &mut Stop,
) {
    let ground = storey.ground;
    stop.kind = WaypointKind::Scan;
    stop.n_faces = scans.seen(pose).len() as u32;
    if !options.sensor.sees_around() {
        stop.yaw_rad = scans.poses[pose].1;
    }
    let seen = scans.seen(pose);
    let n_known = seen.iter().filter(|&&face| std::mem::replace(&mut so_far.faces[face as usize], true)).count();
    stop.overlap = n_known as f64 / seen.len().max(1) as f64;
    let range = options.sensor.range_m / ground.spec.resolution_m();
    let mut n_new = 0u32;
    ground.sight.look_around(ground.in_cells(stop.at), range, stop.yaw_rad, options.sensor.field_of_view_rad, |cell| {
        if !std::mem::replace(&mut so_far.floor[cell], true) {
            n_new += 1;
        }
    });
    stop.covers_m2 = f64::from(n_new) * ground.spec.resolution_m().powi(2);
}

/// The heading in which a place is come to; that in which the first one is left.
fn heading(leg: &[Point2<Map>], first: &[Point2<Map>]) -> f64 {
    let (a, b) = match (leg, first) {
        ([.., a, b], _) | ([..], [a, b, ..]) => (a, b),
        _ => return 0.0,
    };
    let yaw_rad = libm::atan2(b.y_m - a.y_m, b.x_m - a.x_m);
    if a == b { 0.0 } else { yaw_rad }
}
