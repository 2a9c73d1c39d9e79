//! Plans one storey: centres, scans, tours and route graph from map, reachability and options.

use crate::drive_cost::{Driven, driven_line};
use crate::free_space::FreeSpace;
use crate::mesh_visibility::{MeshCoverage, mesh_check};
use crate::options::MissionPlanOptions;
use crate::path_search::PathGrid;
use crate::route_graph::{Anchor, NodePlace, RouteGraph, graph};
use crate::scan_choice::{best_scans, fewest_scans};
use crate::scan_growth::GrownScan;
use crate::scan_places::ScanPlace;
use crate::scan_registration::RegisteredScan;
use crate::scan_survey::ScanSurvey;
use crate::set_cover_instance::SetCoverInstance;
use crate::space_centre::{SpaceCells, SpaceCentre, StoreyInputs, centre_of};
use crate::spaces::Refusal;
use crate::target_face::TargetFaces;
use crate::tour_distances::{StoreyPlaces, legs};
use crate::tour_stops::{GoalPurpose, PlannedScan, StopPurpose, StopScan, StoreyRequest, TourGoal, TourStop};
use crate::walked_line::{WalkedLine, walked};
use frames::{Map, Point2};
use grid::Class;
use messages::{FloorKind, WaypointKind};

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
    /// Spaces that need no waypoint, and why the robot does not get there; `None` if it does.
    pub(crate) looked_at: Vec<(usize, Option<Refusal>)>,
    /// All waypoints, in the order of the tour.
    pub(crate) stops: Vec<TourStop>,
    pub(crate) tour: Vec<Point2<Map>>,
    /// Along the slope.
    pub(crate) tour_m: f64,
    /// Sum of all rises on the tour.
    pub(crate) tour_climb_m: f64,
    /// Energy of driving it, in joules; 0 if the mass of the robot is unknown.
    pub(crate) tour_j: f64,
    pub(crate) bound_m: f64,
    pub(crate) n_parts: u32,
    /// Number of scans that do not register with the others.
    pub(crate) n_unregistered: usize,
    /// The scans in the order in which a plan grows: the coverage curve.
    pub(crate) growth: Vec<GrownScan>,
    /// True if the storey has faces to see, and none of the classes that scans are to see.
    pub(crate) is_without_structure: bool,
    pub(crate) n_targets: u32,
    pub(crate) n_places: u32,
    /// By space plus 1; 0 is outside of spaces.
    pub(crate) space_coverage: Vec<SpaceCoverage>,
    pub(crate) reached_m2: f64,
    pub(crate) unreached_m2: f64,
    pub(crate) graph: RouteGraph,
    pub(crate) mesh: MeshCoverage,
}

/// What a plan of a storey is chosen from.
pub(crate) struct StoreySurvey {
    /// Centres of spaces.
    centres: Vec<(usize, SpaceCentre)>,
    /// Spaces without a centre, and why.
    refused: Vec<(usize, Refusal)>,
    /// Spaces that need no waypoint, and why the robot does not get there; `None` if it does.
    looked_at: Vec<(usize, Option<Refusal>)>,
    /// None if no scans are planned.
    scans: Option<ScanSurvey>,
    /// None if nothing is reachable, or no waypoints are planned on the storey.
    path_grid: Option<PathGrid>,
}

impl StoreySurvey {
    /// The scans in the order in which a plan grows, until the goal is reached.
    pub(crate) fn growth_to_goal(&self) -> &[GrownScan] {
        self.scans.as_ref().map_or(&[], ScanSurvey::growth_to_goal)
    }
}

/// Finds centres and candidate scans.
pub(crate) fn survey_storey(storey: &StoreyInputs<'_>, request: &StoreyRequest<'_>) -> StoreySurvey {
    let space_cells = SpaceCells::of(storey.grid, storey.site.spaces.len());
    let look_at = |&space: &usize| (space, centre_of(storey, &space_cells, space).err());
    let looked_at = request.others.iter().map(look_at).collect();
    let mut survey = StoreySurvey { centres: Vec::new(), refused: Vec::new(), looked_at, scans: None, path_grid: None };
    if !request.options.wants_storey(storey.grid.head.map_storey) {
        return survey;
    }
    for &space in request.spaces {
        match centre_of(storey, &space_cells, space) {
            Ok(centre) => survey.centres.push((space, centre)),
            Err(refusal) => survey.refused.push((space, refusal)),
        }
    }
    // Scans of facades from outdoors are none of the rooms of a building.
    let is_scanned = request.options.plans_scans() && storey.grid.head.floor != FloorKind::Ground;
    survey.scans = is_scanned.then(|| survey_scans(storey, request, &survey.centres));
    survey.path_grid = PathGrid::of(storey.free_space, |part| storey.reached[part as usize]);
    survey
}

/// The plan of a storey on which there are no waypoints and no graph: how much of it the robot gets to.
pub(crate) fn without_waypoints(free_space: &FreeSpace, reached: &[bool], n_spaces: usize) -> PlannedStorey {
    let space_coverage = vec![SpaceCoverage::default(); n_spaces + 1];
    let mut planned = PlannedStorey { space_coverage, ..PlannedStorey::default() };
    let cell_m2 = free_space.spec.resolution_m().powi(2);
    for part in 1..=free_space.n_parts() {
        let size_m2 = f64::from(free_space.size(part)) * cell_m2;
        let total = if reached[part as usize] { &mut planned.reached_m2 } else { &mut planned.unreached_m2 };
        *total += size_m2;
    }
    planned
}

/// Plans a storey: as many scans as reach the goals, or the best `n_scans`.
pub(crate) fn plan_storey(
    storey: &StoreyInputs<'_>,
    request: &StoreyRequest<'_>,
    survey: &StoreySurvey,
    n_scans: Option<usize>,
) -> PlannedStorey {
    let (refused, looked_at) = (survey.refused.clone(), survey.looked_at.clone());
    let nothing = without_waypoints(storey.free_space, storey.reached, storey.site.spaces.len());
    let mut planned = PlannedStorey { refused, looked_at, ..nothing };
    let mut chosen = Vec::new();
    if let Some(scans) = &survey.scans {
        planned.n_targets = scans.faces.all.len() as u32;
        planned.n_places = scans.places.len() as u32;
        planned.growth = scans.growth.clone();
        planned.is_without_structure = scans.faces.all.is_empty() && has_obstacles(storey, request);
        chosen = match n_scans {
            Some(n) => best_scans(scans, request.options, n),
            None => fewest_scans(scans, request.options),
        };
        planned.n_unregistered = chosen.iter().filter(|scan| !scan.registers).count();
    }
    if let Some(path_grid) = &survey.path_grid {
        let inputs = TourInputs { storey, request, path_grid, scans: survey.scans.as_ref() };
        tours(&inputs, &goals(storey, request, &survey.centres, survey.scans.as_ref(), &chosen), &mut planned);
        let space =
            |(space, centre): &(usize, SpaceCentre)| Anchor { at: centre.at, place: NodePlace::Space(*space as u32) };
        let staging = |&(cell, element): &(usize, u32)| Anchor {
            at: storey.free_space.middle(cell),
            place: NodePlace::Staging(element),
        };
        let anchors = request.stagings.iter().map(staging).chain(survey.centres.iter().map(space)).collect();
        planned.graph = graph(storey, path_grid, anchors);
    }
    if let Some(scans) = survey.scans.as_ref().filter(|_| request.options.mesh_check) {
        planned.mesh = mesh_check(storey, request, scans, &planned.stops);
    }
    planned
}

/// The set-cover instance of a storey, and the sets at centres of spaces.
pub(crate) fn instance_of(storey: &StoreyInputs<'_>, request: &StoreyRequest<'_>) -> (SetCoverInstance, Vec<u32>) {
    let cells = SpaceCells::of(storey.grid, storey.site.spaces.len());
    let centre = |space: usize| centre_of(storey, &cells, space).ok().map(|centre| (space, centre));
    let centres = request.spaces.iter().filter_map(|&space| centre(space));
    let centres: Vec<(usize, SpaceCentre)> = centres.collect();
    let scans = survey_scans(storey, request, &centres);
    let is_centroid = |at: Point2<Map>| {
        centres.iter().any(|(space, c)| c.at == at && storey.site.spaces[*space].centroid_m == at.coordinates_m())
    };
    let centroids = (0..scans.poses.len() as u32).filter(|&pose| is_centroid(scans.place(pose).at)).collect();
    (scans.instance, centroids)
}

fn survey_scans(
    storey: &StoreyInputs<'_>,
    request: &StoreyRequest<'_>,
    centres: &[(usize, SpaceCentre)],
) -> ScanSurvey {
    let (grid, options) = (storey.grid, request.options);
    let has_class =
        |cell: usize| options.classes & (1 << grid.class[cell]) != 0 && grid.class[cell] != Class::None.id();
    let is_target = |cell: usize, front: usize| {
        let is_there = options.spaces.is_empty() || request.may_scan[usize::from(grid.space[front])];
        has_class(cell) && is_there && request.targets.is_none_or(|t| t[cell])
    };
    let centres: Vec<SpaceCentre> = centres.iter().map(|c| c.1).collect();
    ScanSurvey::of(storey, options, &centres, |cell| request.may_scan[usize::from(grid.space[cell])], is_target)
}

/// True if faces of any class would be targets where those of the classes of the options are none.
fn has_obstacles(storey: &StoreyInputs<'_>, request: &StoreyRequest<'_>) -> bool {
    let may_scan = |cell: usize| storey.can_scan_from(cell) && request.may_scan[usize::from(storey.grid.space[cell])];
    request.changed.is_none()
        && (0..storey.free_space.spec.n_cells()).any(may_scan)
        && !TargetFaces::of(storey.grid, |cell, _| storey.grid.class[cell] != Class::None.id()).all.is_empty()
}

/// Inputs of the tours of a storey.
struct TourInputs<'a> {
    storey: &'a StoreyInputs<'a>,
    request: &'a StoreyRequest<'a>,
    path_grid: &'a PathGrid,
    scans: Option<&'a ScanSurvey>,
}

/// Floor and faces seen by the scans up to a point of the tour.
struct SeenSoFar {
    /// Cells.
    floor: Vec<bool>,
    faces: Vec<bool>,
}

/// Plans tours through all parts: parts with an entry first, then by size.
fn tours(inputs: &TourInputs<'_>, goals: &[TourGoal], planned: &mut PlannedStorey) {
    let TourInputs { storey, request, path_grid, scans } = *inputs;
    let part_at = |p: &Point2<Map>| {
        storey.free_space.spec.cell_at(*p).map_or(0, |c| storey.free_space.part(storey.free_space.spec.index(c)))
    };
    let entry = |part: u32| request.entries.iter().find(|p| part_at(p) == part).copied();
    let mut parts: Vec<u32> = goals.iter().map(|g| g.part).collect();
    parts.sort_by_key(|&p| (entry(p).is_none(), std::cmp::Reverse(storey.free_space.size(p)), p));
    parts.dedup();
    planned.n_parts = parts.len() as u32;
    let starts: Vec<Option<Point2<Map>>> = parts.iter().map(|&part| entry(part)).collect();
    let places =
        StoreyPlaces::of(path_grid, goals.iter().map(|g| g.at).chain(starts.iter().flatten().copied()).collect());
    let mut next_start = goals.len()..;
    let mut tours = Vec::new();
    for (&part, &start) in parts.iter().zip(&starts) {
        let mut own: Vec<usize> = (0..goals.len()).filter(|&k| goals[k].part == part).collect();
        own.extend(start.and_then(|_| next_start.next()));
        let start_of_own = start.map(|_| own.len() - 1);
        let distances = places.distances(&own);
        let order = distances.order(start_of_own, request.options.closed_tours, request.options.tour_kicks);
        let goals: Vec<TourGoal> = order.places.into_iter().map(|k| goals[own[k]]).collect();
        tours.push(PartTour {
            points: tour_points(&goals, start, request.options.closed_tours),
            goals,
            start,
            bound_m: order.bound_m,
        });
    }
    let pairs: Vec<[Point2<Map>; 2]> =
        tours.iter().flat_map(|tour| tour.points.windows(2).map(|pair| [pair[0], pair[1]])).collect();
    let mut legs = legs(path_grid, storey.free_space, &request.options.drive, &pairs).into_iter();
    let mut seen_so_far = SeenSoFar {
        floor: vec![false; if scans.is_some() { storey.free_space.spec.n_cells() } else { 0 }],
        faces: vec![false; scans.map_or(0, |s| s.faces.all.len())],
    };
    for tour in tours {
        let legs: Vec<Vec<Point2<Map>>> = legs.by_ref().take(tour.points.len().saturating_sub(1)).collect();
        add_tour(inputs, &tour, &legs, planned, &mut seen_so_far);
        // Orders are compared by lengths in whole millimetres.
        planned.bound_m = (planned.bound_m + tour.bound_m).min(planned.tour_m);
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

/// The tour of a part.
struct PartTour {
    goals: Vec<TourGoal>,
    /// Where the robot comes from, if that is known.
    start: Option<Point2<Map>>,
    /// Start and goals in their order, and the first again if the tour is closed.
    points: Vec<Point2<Map>>,
    /// Lower bound of the length of any order.
    bound_m: f64,
}

fn tour_points(goals: &[TourGoal], start: Option<Point2<Map>>, is_closed: bool) -> Vec<Point2<Map>> {
    let mut points: Vec<Point2<Map>> = start.into_iter().chain(goals.iter().map(|g| g.at)).collect();
    if is_closed {
        points.extend(points.first().copied());
    }
    points
}

/// Centres and chosen scans, each with its part and space.
fn goals(
    storey: &StoreyInputs<'_>,
    request: &StoreyRequest<'_>,
    centres: &[(usize, SpaceCentre)],
    scans: Option<&ScanSurvey>,
    chosen: &[RegisteredScan],
) -> Vec<TourGoal> {
    let centre = |(space, centre): &(usize, SpaceCentre)| TourGoal {
        at: centre.at,
        part: reached_part(storey, centre.at),
        space: Some(*space),
        purpose: GoalPurpose::Centre,
    };
    let scan = |scans: &ScanSurvey, (registration_order, scan): (u32, &RegisteredScan)| {
        let ScanPlace { at, part } = scans.place(scan.set);
        let purpose = GoalPurpose::Scan(PlannedScan { registration_order, scan: *scan });
        TourGoal { at, part, space: storey.space_at(at), purpose }
    };
    let mut goals = Vec::new();
    for kind in &request.options.kinds {
        match (kind, scans) {
            (WaypointKind::Centre, _) => goals.extend(centres.iter().map(centre)),
            (WaypointKind::Scan, Some(scans)) => goals.extend((0..).zip(chosen).map(|chosen| scan(scans, chosen))),
            (WaypointKind::Scan, None) => {}
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
    tour: &PartTour,
    legs: &[Vec<Point2<Map>>],
    planned: &mut PlannedStorey,
    seen_so_far: &mut SeenSoFar,
) {
    let TourInputs { storey, request, scans, .. } = *inputs;
    let PartTour { goals, start, points, .. } = tour;
    let walks: Vec<WalkedLine> = legs.iter().map(|leg| walked(storey.free_space, leg)).collect();
    for (k, goal) in goals.iter().enumerate() {
        let leg = (k + usize::from(start.is_some())).checked_sub(1).filter(|at| *at < legs.len());
        let yaw_rad = heading(leg.map_or(&[], |at| legs[at].as_slice()), legs.first().map_or(&[], Vec::as_slice));
        let mut stop = TourStop {
            at: goal.at,
            purpose: StopPurpose::Centre,
            space: goal.space,
            yaw_rad,
            clearance_m: storey.free_space.clearance_m(goal.at),
            leg_m: leg.map_or(0.0, |at| walks[at].length_m),
        };
        match (goal.purpose, scans) {
            (GoalPurpose::Scan(planned), Some(scans)) => {
                scan_stop(storey, request.options, scans, planned, seen_so_far, &mut stop);
            }
            (GoalPurpose::Centre, _) | (GoalPurpose::Scan(_), None) => {}
        }
        planned.stops.push(stop);
    }
    planned.tour_m += walks.iter().map(|walk| walk.length_m).sum::<f64>();
    planned.tour_climb_m += walks.iter().map(|walk| walk.climb_m).sum::<f64>();
    let driven = |leg: &Vec<Point2<Map>>| driven_line(&request.options.drive, storey.free_space, leg);
    planned.tour_j += legs.iter().map(driven).sum::<Driven>().energy_j;
    // The lines of several parts are joined to one; lengths do not include the gaps between them.
    if points.len() == 1 {
        planned.tour.extend(points);
    }
    for leg in legs {
        let skip = usize::from(planned.tour.last() == leg.first());
        planned.tour.extend(&leg[skip..]);
    }
}

fn scan_stop(
    storey: &StoreyInputs<'_>,
    options: &MissionPlanOptions,
    scans: &ScanSurvey,
    planned: PlannedScan,
    seen_so_far: &mut SeenSoFar,
    stop: &mut TourStop,
) {
    let (free_space, pose) = (storey.free_space, planned.scan.set);
    if !options.sensor.sees_around() {
        stop.yaw_rad = scans.poses[pose as usize].1;
    }
    let seen = scans.seen(pose);
    let n_known = seen.iter().filter(|&&face| std::mem::replace(&mut seen_so_far.faces[face as usize], true)).count();
    let overlap = n_known as f64 / seen.len().max(1) as f64;
    let range = options.sensor.range_m / free_space.spec.resolution_m();
    let mut n_new = 0u32;
    storey.sight.look_around(
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
    let covers_m2 = f64::from(n_new) * free_space.spec.resolution_m().powi(2);
    stop.purpose = StopPurpose::Scan(StopScan { planned, n_faces: seen.len() as u32, covers_m2, overlap });
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
