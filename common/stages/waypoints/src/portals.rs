//! Portals between storeys (stairs, ramps, lifts) and their staging poses.

use crate::free_space::FreeSpace;
use crate::options::MissionPlanOptions;
use crate::outdoor_ends::add_outdoors;
use crate::portal::{Portal, PortalKind, Staging, length_m, plan_area_m2, slope_rad, staging};
use crate::sloped_slabs::sloped_slabs;
use crate::stair_ends::{ends_at, is_flight, stair_treads};
use frames::{Map, Point2, TENTHS_PER_M, metres};
use geometry::upward_triangles;
use messages::{EdgeKind, ElementState, FloorKind, NONE, RobotProfile, ScheduleState, Site, element_flags};
use std::collections::BTreeMap;

/// Maximum distance in height of treads and landings from the floor of their storey, in tenths of a millimetre.
const LEVEL_TENTHS: i64 = 4_500;

/// Minimum height difference of storeys; nearer floors are levels of one storey, and an element that reaches such a level
/// need not lead to it.
const MIN_STOREY_HEIGHT_TENTHS: i64 = 20_000;

/// Maximum distance in height and minimum area of a stair's landing at a level.
const LANDING_TENTHS: i64 = 500;

const MIN_LANDING_M2: f64 = 0.5;

/// Tolerance of slopes, because vertices are rounded to tenths of a millimetre.
const SLOPE_TOLERANCE_RAD: f64 = 1e-3;

/// Maximum distance of a landing door from its lift, in metres.
const LANDING_DOOR_M: f64 = 1.0;

/// What an element that leads to other storeys is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum VerticalKind {
    Stair,
    Ramp,
    Lift,
    Escalator,
}

impl VerticalKind {
    /// Its edge in the route graph.
    pub(crate) fn edge_kind(self) -> EdgeKind {
        match self {
            Self::Stair => EdgeKind::Stair,
            Self::Ramp => EdgeKind::Ramp,
            Self::Lift => EdgeKind::Lift,
            Self::Escalator => EdgeKind::Escalator,
        }
    }
}

/// The portals between neighbouring storeys, by element; only of built elements.
pub(crate) fn portals(
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    robot: &RobotProfile,
    options: &MissionPlanOptions,
    free_spaces: &[&FreeSpace],
) -> Vec<Portal> {
    let is_built = |element: usize| schedule_state.effective(element) == ElementState::Built;
    let mut portals = element_portals(site, is_built, robot, options, free_spaces);
    portals.extend(sloped_slabs(site, schedule_state, robot, free_spaces));
    portals
}

/// The portals that stairs, ramps and lifts make, of those elements for which `is_there` is true.
pub(crate) fn element_portals(
    site: &Site<'_>,
    is_there: impl Fn(usize) -> bool,
    robot: &RobotProfile,
    options: &MissionPlanOptions,
    free_spaces: &[&FreeSpace],
) -> Vec<Portal> {
    let mut wholes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (index, element) in site.elements.iter().enumerate().filter(|(_, e)| e.has(element_flags::VERTICAL)) {
        if element.n_parts > 0 && is_there(index) {
            wholes.entry(whole_of(site, index)).or_default().push(index);
        }
    }
    let mut from_below: Vec<usize> = site.levels().map(|(storey, _)| storey).collect();
    from_below.sort_by_key(|&storey| site.map_storeys[storey].floor_z_tenths);
    let mut portals = Vec::new();
    for (whole, elements) in wholes {
        let Some(kind) = kind_of(site, whole).or_else(|| elements.iter().find_map(|&e| kind_of(site, e))) else {
            continue;
        };
        let mut stagings: Vec<Staging> = Vec::new();
        for &storey in &from_below {
            let free_space = free_spaces[storey];
            let entrances = entrances(site, &elements, kind, storey);
            let Some((cell, part)) = staging(free_space, robot, &entrances) else { continue };
            stagings.push(Staging { storey, cell, part });
        }
        if matches!(kind, VerticalKind::Stair | VerticalKind::Ramp) {
            add_outdoors(site, robot, (&elements, kind == VerticalKind::Stair), free_spaces, &mut stagings);
        }
        for pair in stagings.windows(2) {
            let ends = [pair[0], pair[1]];
            let length_m = length_m(free_spaces, ends);
            let kind = match kind {
                VerticalKind::Stair => PortalKind::Stair,
                VerticalKind::Ramp => PortalKind::Ramp { slope_rad: slope_rad(site, &elements, free_spaces, ends) },
                VerticalKind::Lift => PortalKind::Lift,
                VerticalKind::Escalator => PortalKind::Escalator,
            };
            let usable = usable(site, robot, options, whole, kind);
            // A ramp that the robot climbs is ground on both maps, and a stair in a garden leads to no other map.
            let is_outdoors = ends.iter().any(|end| site.map_storeys[end.storey].floor == FloorKind::Ground);
            let is_ground = is_outdoors && usable && matches!(kind, PortalKind::Ramp { .. });
            if is_ground || ends[0].storey == ends[1].storey {
                continue;
            }
            portals.push(Portal { element: whole, kind, ends, length_m, usable });
        }
    }
    portals
}

/// Stairs, ramps and lifts that reach from the floor of a map storey to that of another one, whether or not a robot can stand
/// before them; only of elements for which `is_there` is true.
pub(crate) fn between_storeys(
    site: &Site<'_>,
    is_there: impl Fn(usize) -> bool,
    map_storeys: [u32; 2],
) -> Vec<(VerticalKind, usize)> {
    let mut floors = map_storeys.map(|storey| i64::from(site.map_storeys[storey as usize].floor_z_tenths));
    floors.sort_unstable();
    let mut heights: BTreeMap<usize, (VerticalKind, [i64; 2])> = BTreeMap::new();
    for (index, element) in site.elements.iter().enumerate().filter(|(_, e)| e.has(element_flags::VERTICAL)) {
        let whole = whole_of(site, index);
        let Some(kind) = kind_of(site, whole).or_else(|| kind_of(site, index)) else { continue };
        if element.n_parts > 0 && is_there(index) {
            let [low, high] = [element.min_tenths[2], element.max_tenths[2]].map(i64::from);
            let (_, heights) = heights.entry(whole).or_insert((kind, [low, high]));
            *heights = [heights[0].min(low), heights[1].max(high)];
        }
    }
    let joins = |[low, high]: [i64; 2]| low <= floors[0] + LEVEL_TENTHS && floors[1] - LEVEL_TENTHS <= high;
    heights.into_iter().filter(|(_, (_, heights))| joins(*heights)).map(|(whole, (kind, _))| (kind, whole)).collect()
}

/// The outermost stair, ramp or lift of which an element is a part.
fn whole_of(site: &Site<'_>, element: usize) -> usize {
    let mut at = element;
    // The bound ends cycles in broken files.
    for _ in 0..16 {
        match site.elements[at].whole {
            NONE => break,
            whole if kind_of(site, whole as usize).is_some() => at = whole as usize,
            _ => break,
        }
    }
    at
}

fn kind_of(site: &Site<'_>, element: usize) -> Option<VerticalKind> {
    let record = &site.elements[element];
    let is_a = |entity: &str| site.is_a(record, entity);
    let predefined = site.text(record.predefined_type);
    if is_a("IfcStair") || is_a("IfcStairFlight") {
        Some(VerticalKind::Stair)
    } else if is_a("IfcRamp") || is_a("IfcRampFlight") {
        Some(VerticalKind::Ramp)
    } else if is_a("IfcTransportElement") {
        match predefined {
            "ESCALATOR" | "MOVINGWALKWAY" => Some(VerticalKind::Escalator),
            "CRANEWAY" | "LIFTINGGEAR" => None,
            _ => Some(VerticalKind::Lift),
        }
    } else {
        None
    }
}

/// Entrances of a portal on a storey: its points at that level; for a lift its doors, else its outline.
fn entrances(site: &Site<'_>, elements: &[usize], kind: VerticalKind, storey: usize) -> Vec<Point2<Map>> {
    let floor = i64::from(site.map_storeys[storey].floor_z_tenths);
    let point = |x: i32, y: i32| Point2::new(metres(x), metres(y));
    let is_here = |z: i64| (z - floor).abs() <= LEVEL_TENTHS && is_nearest(site, storey, z);
    if kind != VerticalKind::Lift {
        let levels = levels_beside(site, storey);
        if kind != VerticalKind::Ramp {
            let steps = stair_treads(site, elements);
            let ends = ends_at(&steps, site.map_storeys[storey].floor_z_tenths, &levels);
            if !ends.is_empty() || !levels.is_empty() && is_flight(&steps) {
                return ends;
            }
        }
        if !levels.is_empty() && !elements.iter().any(|&e| stops_at(site, e, floor, is_here)) {
            return Vec::new();
        }
        let vertices = elements.iter().flat_map(|&e| site.element_meshes(&site.elements[e])).flat_map(|m| m.vertices);
        return vertices.filter(|v| is_here(i64::from(v[2]))).map(|v| point(v[0], v[1])).collect();
    }
    let boxes = elements.iter().map(|&e| &site.elements[e]);
    let here =
        boxes.filter(|e| i64::from(e.min_tenths[2]) - LEVEL_TENTHS <= floor && floor < i64::from(e.max_tenths[2]));
    let mut points = Vec::new();
    for lift in here {
        let outside = |p: [f64; 2]| {
            let beyond = |k: usize| (metres(lift.min_tenths[k]) - p[k]).max(p[k] - metres(lift.max_tenths[k])).max(0.0);
            libm::hypot(beyond(0), beyond(1))
        };
        let doors = site.doors.iter().filter(|d| is_here(i64::from(site.elements[d.element as usize].min_tenths[2])));
        let centres = doors.map(|d| d.passage.centre.map(|c| c / f64::from(TENTHS_PER_M)));
        let near: Vec<Point2<Map>> =
            centres.filter(|c| outside(*c) <= LANDING_DOOR_M).map(|c| Point2::new(c[0], c[1])).collect();
        if near.is_empty() && levels_beside(site, storey).is_empty() {
            let [x, y] = [0, 1].map(|k| [lift.min_tenths[k], lift.max_tenths[k]]);
            let middle = |r: [i32; 2]| r[0].midpoint(r[1]);
            points.extend([
                point(x[0], middle(y)),
                point(x[1], middle(y)),
                point(middle(x), y[0]),
                point(middle(x), y[1]),
            ]);
        } else {
            points.extend(near);
        }
    }
    points
}

/// True if no other storey's floor is nearer to this height.
fn is_nearest(site: &Site<'_>, storey: usize, z: i64) -> bool {
    let far = |k: usize| (i64::from(site.map_storeys[k].floor_z_tenths) - z).abs();
    site.levels().all(|(k, _)| far(storey) <= far(k))
}

/// Heights of the other mapped levels of a storey.
fn levels_beside(site: &Site<'_>, storey: usize) -> Vec<i32> {
    let floor_z = site.map_storeys[storey].floor_z_tenths;
    let others = site.levels().filter(|(k, _)| *k != storey).map(|(_, s)| s.floor_z_tenths);
    others.filter(|z| (i64::from(*z) - i64::from(floor_z)).abs() < MIN_STOREY_HEIGHT_TENTHS).collect()
}

/// True if a stair, ramp or flight begins or ends at a floor, or has a landing there.
fn stops_at(site: &Site<'_>, element: usize, floor: i64, is_here: impl Fn(i64) -> bool) -> bool {
    let record = &site.elements[element];
    if is_here(i64::from(record.min_tenths[2])) || is_here(i64::from(record.max_tenths[2])) {
        return true;
    }
    let faces = site.element_meshes(record).flat_map(|mesh| upward_triangles(mesh, 0.01));
    let level = faces.filter(|t| t.iter().all(|v| (i64::from(v[2]) - floor).abs() <= LANDING_TENTHS));
    level.map(|t| plan_area_m2(&t)).sum::<f64>() >= MIN_LANDING_M2
}

fn usable(site: &Site<'_>, robot: &RobotProfile, options: &MissionPlanOptions, whole: usize, kind: PortalKind) -> bool {
    match kind {
        PortalKind::Stair => robot.climbs_stairs == 1,
        PortalKind::Ramp { slope_rad } => slope_rad <= robot.max_slope_rad + SLOPE_TOLERANCE_RAD,
        PortalKind::Lift => options.takes_lift(site, whole),
        PortalKind::Escalator | PortalKind::Step | PortalKind::Ground => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_space::tests::drawn_at;
    use bytemuck::Zeroable;
    use messages::*;

    /// A hall of 4.0 x 2.0 m, on every storey.
    fn hall() -> String {
        let (wall, row) = ("#".repeat(42), format!("#{}#", ".".repeat(40)));
        [wall.as_str()].into_iter().chain([row.as_str(); 20]).chain([wall.as_str()]).collect::<Vec<_>>().join("\n")
    }

    /// Elements of a building of halls, 3 m apart.
    #[derive(Default)]
    struct Building {
        site: SiteBuilder,
        states: Vec<ElementState>,
    }

    impl Building {
        /// An element with a box from corner to corner in metres, flagged as a way up.
        fn add(&mut self, entity: &str, predefined: &str, boxes: &[[[f64; 3]; 2]]) -> usize {
            let b = &mut self.site;
            let (supertypes, predefined_type) = (b.texts.add_list([entity]), b.texts.add(predefined));
            let global_id = b.texts.add(&format!("{entity}-{}", b.elements.len()));
            let first_part = b.parts.len() as u32;
            let (mut low, mut high) = ([i32::MAX; 3], [i32::MIN; 3]);
            for corners in boxes {
                let corners = corners.map(|c| c.map(|m| (m * f64::from(TENTHS_PER_M)).round() as i32));
                b.parts.push(PartRecord { first_vertex: b.vertices.len() as u32, n_vertices: 8, ..Zeroable::zeroed() });
                b.vertices.extend((0..8).map(|i| [0, 1, 2].map(|k| corners[i >> k & 1][k])));
                for k in 0..3 {
                    (low[k], high[k]) = (low[k].min(corners[0][k]), high[k].max(corners[1][k]));
                }
            }
            if boxes.is_empty() {
                (low, high) = ([0; 3], [0; 3]);
            }
            b.elements.push(ElementRecord {
                global_id,
                supertypes,
                predefined_type,
                min_tenths: low,
                max_tenths: high,
                first_part,
                n_parts: boxes.len() as u32,
                whole: NONE,
                storey: NONE,
                space: NONE,
                door: NONE,
                stair: NONE,
                flags: element_flags::VERTICAL,
                ..Zeroable::zeroed()
            });
            self.states.push(ElementState::Built);
            b.elements.len() - 1
        }

        fn portals(mut self, n_storeys: usize, climbs: bool, lifts: &[&str]) -> Vec<Portal> {
            let floor = FloorKind::Built.into();
            for storey in 0..n_storeys as i32 {
                let floor_z_tenths = storey * 30_000;
                self.site.map_storeys.push(MapStoreyRecord { floor_z_tenths, floor, ..Zeroable::zeroed() });
            }
            let site = self.site.finish();
            let site = Site::open(site.bytes()).unwrap();
            let mut schedule_state =
                ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), 0);
            self.states.iter().enumerate().for_each(|(k, state)| schedule_state.set_element(k, *state, *state));
            let schedule_state = schedule_state.finish();
            let schedule_state = ScheduleState::open(schedule_state.bytes()).unwrap();
            let free_space = |storey: &MapStoreyRecord| {
                FreeSpace::of(&Grid::open(drawn_at(&hall(), storey.floor_z_tenths).bytes()).unwrap(), 0.3)
            };
            let free_spaces: Vec<FreeSpace> = site.map_storeys.iter().map(free_space).collect();
            let robot = RobotProfile { climbs_stairs: u32::from(climbs), ..RobotProfile::DEFAULT };
            let options = MissionPlanOptions {
                lifts: lifts.iter().map(|l| (*l).to_owned()).collect(),
                ..MissionPlanOptions::default()
            };
            portals(&site, &schedule_state, &robot, &options, &free_spaces.iter().collect::<Vec<_>>())
        }
    }

    /// A flight from (1, 1) on the floor to (x, 1) on the next.
    fn flight(x: f64, storey: f64) -> [[[f64; 3]; 2]; 2] {
        let (low, high) = (3.0 * storey, 3.0 * storey + 3.0);
        [[[1.0, 1.0, low], [1.2, 1.2, low + 0.2]], [[x, 1.0, high - 0.2], [x + 0.2, 1.2, high]]]
    }

    fn kinds(portals: &[Portal]) -> Vec<(EdgeKind, bool)> {
        portals.iter().map(|p| (p.kind.edge_kind(), p.usable)).collect()
    }

    #[test]
    fn a_stair_joins_the_storeys_between_which_it_leads() {
        let mut building = Building::default();
        building.add("IfcStair", "", &flight(3.0, 0.0));
        let found = building.portals(3, true, &[]);
        assert_eq!(kinds(&found), [(EdgeKind::Stair, true)]);
        let [low, high] = found[0].ends;
        assert_eq!((low.storey, high.storey), (0, 1));
        assert_ne!((low.part, high.part), (0, 0));
        assert!((found[0].length_m - libm::hypot(2.0, 3.0)).abs() < 0.15, "{}", found[0].length_m);
    }

    #[test]
    fn a_stair_through_all_storeys_joins_neighbours() {
        let mut building = Building::default();
        building.add("IfcStair", "", &[flight(3.0, 0.0), flight(3.0, 1.0)].concat());
        let ends: Vec<[usize; 2]> = building.portals(3, false, &[]).iter().map(|p| p.ends.map(|e| e.storey)).collect();
        assert_eq!(ends, [[0, 1], [1, 2]]);
    }

    #[test]
    fn flights_of_a_stair_are_one_way() {
        let mut building = Building::default();
        let stair = building.add("IfcStair", "", &[]);
        let [low, high] = flight(3.0, 0.0);
        for part in [low, high] {
            let flight = building.add("IfcStairFlight", "", &[part]);
            building.site.elements[flight].whole = stair as u32;
        }
        let found = building.portals(2, false, &[]);
        assert_eq!((kinds(&found), found[0].element), (vec![(EdgeKind::Stair, false)], stair));
    }

    #[test]
    fn parts_that_are_wholes_of_each_other_end() {
        let mut building = Building::default();
        let stair = building.add("IfcStair", "", &flight(3.0, 0.0));
        let other = building.add("IfcStair", "", &[]);
        building.site.elements[stair].whole = other as u32;
        building.site.elements[other].whole = stair as u32;
        assert_eq!(building.portals(2, true, &[]).len(), 1);
    }

    #[test]
    fn what_is_not_built_leads_nowhere() {
        for state in [ElementState::NotStarted, ElementState::InProgress, ElementState::BeingRemoved] {
            let mut building = Building::default();
            building.add("IfcStair", "", &flight(3.0, 0.0));
            building.states[0] = state;
            assert!(building.portals(2, true, &[]).is_empty());
        }
    }

    #[test]
    fn a_stair_without_a_staging_pose_leads_nowhere() {
        let mut building = Building::default();
        let away = flight(3.0, 0.0).map(|b| b.map(|[x, y, z]| [x + 20.0, y, z]));
        building.add("IfcStair", "", &away);
        assert!(building.portals(2, true, &[]).is_empty());
    }

    #[test]
    fn a_ramp_is_taken_if_it_is_not_too_steep() {
        let slope = |rise_m: f64| {
            let mut building = Building::default();
            let [low, high] = flight(3.0, 0.0);
            building.add("IfcRamp", "", &[low, high]);
            // The upper floor is this high: the run is two metres and a bit.
            let free_space = |z: i32| FreeSpace::of(&Grid::open(drawn_at(&hall(), z).bytes()).unwrap(), 0.3);
            let free_spaces = [0.0, rise_m].map(|z_m| free_space((z_m * f64::from(TENTHS_PER_M)) as i32));
            let end = |storey: usize, x_m: f64| {
                let free_space = &free_spaces[storey];
                let cell = free_space.spec.index(free_space.spec.cell_at(Point2::new(x_m, 1.05)).unwrap());
                Staging { storey, cell, part: free_space.part(cell) }
            };
            let floor = FloorKind::Built.into();
            for z_m in [0.0, rise_m] {
                let floor_z_tenths = (z_m * f64::from(TENTHS_PER_M)) as i32;
                building.site.map_storeys.push(MapStoreyRecord { floor_z_tenths, floor, ..Zeroable::zeroed() });
            }
            let site = building.site.finish();
            let site = Site::open(site.bytes()).unwrap();
            let (robot, options) = (RobotProfile::DEFAULT, MissionPlanOptions::default());
            let ends = [end(0, 1.05), end(1, 3.05)];
            let slope_rad = slope_rad(&site, &[0], &free_spaces.each_ref(), ends);
            usable(&site, &robot, &options, 0, PortalKind::Ramp { slope_rad })
        };
        // The default robot drives up a slope of 0.1 rad: 0.2 m in two metres.
        assert!(slope(0.19) && slope(0.0));
        assert!(!slope(0.21));
    }

    #[test]
    fn a_ramp_is_as_steep_as_its_faces_wherever_its_ends_are() {
        let mut building = Building::default();
        // Half a metre on four metres, and a level landing.
        let ramp = building.add("IfcRamp", "", &[[[0.0, 0.0, 0.0], [4.0, 1.0, 0.5]]]);
        let b = &mut building.site;
        b.vertices = vec![[0, 0, 0], [40_000, 0, 5_000], [40_000, 10_000, 5_000], [0, 10_000, 0]];
        b.vertices.extend([[50_000, 0, 5_000], [50_000, 10_000, 5_000]]);
        b.triangles = vec![[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2]];
        b.parts[0] = PartRecord { n_vertices: 6, n_triangles: 4, ..b.parts[0] };
        let site = building.site.finish();
        let site = Site::open(site.bytes()).unwrap();
        let nowhere = Staging { storey: 0, cell: 0, part: 0 };
        let slope_rad = slope_rad(&site, &[ramp], &[], [nowhere; 2]);
        assert!((slope_rad - libm::atan2(0.5, 4.0)).abs() < 1e-4, "{slope_rad}");
    }

    #[test]
    fn a_stair_beside_another_level_does_not_lead_to_it() {
        let mut building = Building::default();
        building.add("IfcStair", "", &flight(3.0, 0.0));
        let floor = FloorKind::Built.into();
        building.site.map_storeys.push(MapStoreyRecord { floor_z_tenths: 4_500, floor, ..Zeroable::zeroed() });
        // The level half a step up is the first of the list; the storeys follow.
        let ends: Vec<[usize; 2]> = building.portals(2, true, &[]).iter().map(|p| p.ends.map(|e| e.storey)).collect();
        assert_eq!(ends, [[1, 2]]);
    }

    #[test]
    fn lifts_are_taken_if_options_name_them_and_escalators_never() {
        let found = |predefined: &str, lifts: &[&str]| {
            let mut building = Building::default();
            building.add("IfcTransportElement", predefined, &[[[1.0, 0.5, 0.0], [2.0, 1.5, 3.2]]]);
            kinds(&building.portals(2, true, lifts))
        };
        assert_eq!(found("ELEVATOR", &[]), [(EdgeKind::Lift, false)]);
        assert_eq!(found("ELEVATOR", &["IfcTransportElement-0"]), [(EdgeKind::Lift, true)]);
        assert_eq!(found("", &["Ifc*"]), [(EdgeKind::Lift, true)], "only lifts are lifts");
        assert_eq!(found("ESCALATOR", &["*"]), [(EdgeKind::Escalator, false)]);
        assert!(found("CRANEWAY", &["*"]).is_empty());
    }

    #[test]
    fn one_waits_for_a_lift_before_its_door() {
        let mut building = Building::default();
        // Its door looks to the right; without one the middle of any side would do.
        building.add("IfcTransportElement", "ELEVATOR", &[[[1.0, 0.5, 0.0], [2.0, 1.5, 5.5]]]);
        for storey in [0.0, 3.0] {
            let door = building.add("IfcDoor", "", &[[[2.0, 0.6, storey], [2.2, 1.4, storey + 2.1]]]);
            building.site.elements[door].flags = 0;
            building.site.elements[door].door = building.site.doors.len() as u32;
            building.site.doors.push(DoorRecord {
                clear_width_from: ClearWidth::Assumed.into(),
                element: door as u32,
                opening: NONE,
                spaces: [NONE; 2],
                beside: [NONE; 2],
                passage: BoxRecord { centre: [21_000.0, 10_000.0], axis: [0.0, 1.0], half: [4_000.0, 1_000.0] },
                ..Zeroable::zeroed()
            });
        }
        let free_space = FreeSpace::of(&Grid::open(drawn_at(&hall(), 0).bytes()).unwrap(), 0.3);
        let found = building.portals(2, false, &[]);
        assert_eq!(found.len(), 1);
        for end in found[0].ends {
            let at = free_space.middle(end.cell);
            assert!((at.x_m() - 2.1).abs() < 0.11 && (at.y_m() - 1.0).abs() < 0.11, "{at:?}");
        }
    }
}
