//! Traversal of a stair over its treads and landings, with length, clear width and number of risers.

use frames::{TENTHS_PER_M, metres};
use geometry::{Bounds, Footprint, MultiPolygon, Point, Slab, Tread, footprint, treads};
use grid::Class;
use messages::{ElementState, NONE, ScheduleState, Site};

/// The traversal of a stair.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct StairTraversal {
    /// Line from the lower to the upper end, in `map`, in metres.
    pub(crate) line: Vec<[f64; 3]>,
    /// Length of the line, along the slope.
    pub(crate) length_m: f64,
    /// Minimum clear width of the flights; 0 if unknown.
    pub(crate) clear_width_m: f64,
    /// Number of risers.
    pub(crate) n_risers: u32,
}

/// Limit of level faces of a stair.
const MAX_TREADS: usize = 1_000;

/// Maximum horizontal gap between a tread and the next.
const REACH: f64 = 0.10 * TENTHS_PER_M as f64;

/// Faces whose heights differ by less are one level.
pub(crate) const ONE_LEVEL: i32 = 6 * TENTHS_PER_M / 100;

/// Maximum rise of a step. The first and last may be higher than others, where the floor is not at the height for which the
/// stair was modelled.
pub(crate) const MAX_RISE: i32 = 45 * TENTHS_PER_M / 100;

/// Rise of a step for stairs with too few treads to measure it.
const DEFAULT_RISE: i32 = 19 * TENTHS_PER_M / 100;

/// Heights above a tread between which rails, walls and stringers reduce its clear width. Below is the next tread.
const BESIDE: [i32; 2] = [30 * TENTHS_PER_M / 100, 120 * TENTHS_PER_M / 100];

/// Maximum number of centimetre steps to either side in the measurement of widths.
const MAX_STEPS_ASIDE: i32 = 500;

/// Number of treads at which the width is measured.
const N_WIDTHS: usize = 5;

/// A tread this many times as large as the median one is a landing.
pub(crate) const LANDING_SIZE_FACTOR: f64 = 1.8;

/// Tolerance of line simplification, in metres.
const TOLERANCE_M: f64 = 0.01;

/// The traversal of the stair `whole` between two ends; `None` where its level faces do not connect them, as for a ramp or a
/// body without steps.
pub(crate) fn stair_traversal(
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    whole: usize,
    ends: [[f64; 3]; 2],
) -> Option<StairTraversal> {
    let is_built = |index: usize| schedule_state.effective(index) == ElementState::Built;
    let parts = (0..site.elements.len()).filter(|&e| is_part_of(site, e, whole) && is_built(e));
    let carries = |e: &usize| site.elements[*e].class() != Class::Railing;
    let parts: Vec<usize> = parts.filter(carries).collect();
    let [low, high] = ends.map(|end| (end[2] * f64::from(TENTHS_PER_M)).round() as i32);
    let between = |t: &Tread| low - ONE_LEVEL <= t.z && t.z <= high + ONE_LEVEL;
    let steps: Vec<Tread> = treads(parts.iter().flat_map(|&e| site.element_meshes(&site.elements[e])))
        .into_iter()
        .filter(between)
        .collect();
    if steps.len() > MAX_TREADS {
        return None;
    }
    let way = path_over_treads(&steps, ends, [low, high])?;
    let mut line = vec![ends[0]];
    line.extend(way.iter().map(|&at| point_m(&steps[at])));
    line.push(ends[1]);
    let is_up = |ends: &&[[f64; 3]]| ends[1][2] - ends[0][2] > metres(ONE_LEVEL) / 2.0;
    let n_risers = line.windows(2).filter(is_up).count() as u32;
    let clear_width_m = clear_width_m(site, &is_built, &steps, &way);
    let line = straightened(&line);
    let length_m = line.windows(2).map(|ends| distance_m(ends[0], ends[1])).sum();
    Some(StairTraversal { line, length_m, clear_width_m, n_risers })
}

/// True if the element is the whole or directly or indirectly a part of it.
fn is_part_of(site: &Site<'_>, element: usize, whole: usize) -> bool {
    let mut at = element;
    // The bound ends cycles in broken files.
    for _ in 0..16 {
        if at == whole {
            return true;
        }
        match site.elements[at].whole {
            NONE => return false,
            next => at = next as usize,
        }
    }
    false
}

fn point_m(tread: &Tread) -> [f64; 3] {
    let [x, y] = tread.centre.map(|c| c / f64::from(TENTHS_PER_M));
    [x, y, metres(tread.z)]
}

fn distance_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    libm::hypot(libm::hypot(b[0] - a[0], b[1] - a[1]), b[2] - a[2])
}

/// Shortest path over adjacent treads, as indices of treads.
fn path_over_treads(steps: &[Tread], ends: [[f64; 3]; 2], [low, high]: [i32; 2]) -> Option<Vec<usize>> {
    let rise = max_rise(steps);
    let n = steps.len();
    // The first and last rise may be higher, where the floor is not at the height for which the stair was modelled.
    let within = |far: &dyn Fn(&Tread) -> i32| -> Vec<bool> {
        let is_at = |limit: i32| steps.iter().map(|t| (-ONE_LEVEL..=limit).contains(&far(t))).collect::<Vec<bool>>();
        Some(is_at(rise)).filter(|at| at.contains(&true)).unwrap_or_else(|| is_at(MAX_RISE))
    };
    let (is_first, is_last) = (within(&|t| t.z - low), within(&|t| high - t.z));
    let plan_m = |a: [f64; 3], b: [f64; 3]| libm::hypot(b[0] - a[0], b[1] - a[1]);
    let mut length_m: Vec<f64> =
        (0..n).map(|k| if is_first[k] { plan_m(ends[0], point_m(&steps[k])) } else { f64::INFINITY }).collect();
    let mut before: Vec<Option<usize>> = vec![None; n];
    let mut is_done = vec![false; n];
    loop {
        let open = (0..n).filter(|&k| !is_done[k] && length_m[k] < f64::INFINITY);
        let Some(at) = open.min_by(|&a, &b| length_m[a].total_cmp(&length_m[b]).then(a.cmp(&b))) else { break };
        is_done[at] = true;
        for next in (0..n).filter(|&k| !is_done[k]) {
            let up = steps[next].z - steps[at].z;
            let far_m = length_m[at] + plan_m(point_m(&steps[at]), point_m(&steps[next]));
            if (-ONE_LEVEL..=rise).contains(&up) && far_m < length_m[next] && touch(&steps[at].plan, &steps[next].plan)
            {
                (length_m[next], before[next]) = (far_m, Some(at));
            }
        }
    }
    let to_end_m = |k: usize| length_m[k] + plan_m(point_m(&steps[k]), ends[1]);
    let reached = (0..n).filter(|&k| is_last[k] && is_done[k]);
    let last = reached.min_by(|&a, &b| to_end_m(a).total_cmp(&to_end_m(b)).then(a.cmp(&b)))?;
    let mut way: Vec<usize> = std::iter::successors(Some(last), |&k| before[k]).collect();
    way.reverse();
    Some(way)
}

/// Maximum rise between adjacent treads of this stair.
pub(crate) fn max_rise(steps: &[Tread]) -> i32 {
    typical_rise(steps) * 8 / 5
}

/// Median rise between neighbouring levels, in tenths of a millimetre.
pub(crate) fn typical_rise(steps: &[Tread]) -> i32 {
    let mut rises: Vec<i32> =
        steps.windows(2).map(|t| t[1].z - t[0].z).filter(|r| (1..=MAX_RISE).contains(r)).collect();
    rises.sort_unstable();
    rises.get(rises.len() / 2).copied().unwrap_or(DEFAULT_RISE).max(ONE_LEVEL)
}

/// True if two treads are adjacent in plan.
pub(crate) fn touch(a: &MultiPolygon, b: &MultiPolygon) -> bool {
    let (Some(p), Some(q)) = (a.bounds(), b.bounds()) else { return false };
    let reach = REACH as i32;
    if !grown(p, reach).meets(&q) {
        return false;
    }
    let is_near = |from: &MultiPolygon, to: &MultiPolygon| {
        from.rings().flatten().any(|corner| {
            let corner = corner.map(f64::from);
            to.contains(corner) || to.rings().any(|ring| sides(ring).any(|side| off(corner, side) <= REACH))
        })
    };
    is_near(a, b) || is_near(b, a)
}

fn grown(bounds: Bounds, by: i32) -> Bounds {
    Bounds { min: bounds.min.map(|c| c - by), max: bounds.max.map(|c| c + by) }
}

fn sides(ring: &[Point]) -> impl Iterator<Item = [[f64; 2]; 2]> {
    ring.iter().zip(ring.iter().cycle().skip(1)).map(|(a, b)| [a.map(f64::from), b.map(f64::from)])
}

/// Distance of a point from a line segment.
fn off(p: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let d = [b[0] - a[0], b[1] - a[1]];
    let e = [p[0] - a[0], p[1] - a[1]];
    let length2 = d[0] * d[0] + d[1] * d[1];
    let t = if length2 > 0.0 { ((e[0] * d[0] + e[1] * d[1]) / length2).clamp(0.0, 1.0) } else { 0.0 };
    libm::hypot(e[0] - t * d[0], e[1] - t * d[1])
}

/// Minimum clear width of the treads across the path, without landings; 0 where none can be measured.
fn clear_width_m(site: &Site<'_>, is_built: &dyn Fn(usize) -> bool, steps: &[Tread], way: &[usize]) -> f64 {
    let mut areas: Vec<f64> = way.iter().map(|&at| steps[at].plan.area_m2()).collect();
    areas.sort_by(f64::total_cmp);
    let defaults = areas.get(areas.len() / 2).copied().unwrap_or_default();
    let is_of_flight = |at: &usize| steps[way[*at]].plan.area_m2() <= LANDING_SIZE_FACTOR * defaults;
    let of_flights: Vec<usize> = (0..way.len()).filter(is_of_flight).collect();
    let stride = of_flights.len().div_ceil(N_WIDTHS).max(1);
    let widths = of_flights.iter().step_by(stride).filter_map(|&at| {
        // The floor before the first and after the last step does not define the direction of the flight.
        let [a, b] = [at.saturating_sub(1), (at + 1).min(way.len() - 1)].map(|at| steps[way[at]].centre);
        let d = [b[0] - a[0], b[1] - a[1]];
        let length = libm::hypot(d[0], d[1]);
        (length > 0.0).then(|| width_m(site, is_built, &steps[way[at]], [-d[1] / length, d[0] / length]))
    });
    widths.reduce(f64::min).unwrap_or(0.0)
}

/// Clear width of a tread, measured through its middle in a direction.
fn width_m(site: &Site<'_>, is_built: &dyn Fn(usize) -> bool, tread: &Tread, across: [f64; 2]) -> f64 {
    let slab = Slab { lo: tread.z + BESIDE[0], hi: tread.z + BESIDE[1] };
    let Some(bounds) = tread.plan.bounds() else { return 0.0 };
    let beside = site.elements.iter().enumerate().filter(|(index, e)| {
        e.n_parts > 0
            && slab.meets(e.min_tenths[2], e.max_tenths[2])
            && bounds
                .meets(&Bounds { min: [e.min_tenths[0], e.min_tenths[1]], max: [e.max_tenths[0], e.max_tenths[1]] })
            && e.class() != Class::Door
            && is_built(*index)
    });
    let obstacles: Vec<Footprint> = beside.map(|(_, e)| footprint(site.element_meshes(e), slab)).collect();
    let step = f64::from(TENTHS_PER_M) / 100.0;
    let is_free = |k: i32| {
        let at = [0, 1].map(|i| tread.centre[i] + across[i] * (f64::from(k) + 0.5) * step);
        let stands_there = |f: &Footprint| {
            let near = |[a, b]: &[Point; 2]| off(at, [a.map(f64::from), b.map(f64::from)]) < step / 2.0;
            f.area.contains(at) || f.lines.iter().any(near)
        };
        tread.plan.contains(at) && !obstacles.iter().any(stands_there)
    };
    let left = (0..MAX_STEPS_ASIDE).take_while(|&k| is_free(k)).count();
    let right = (0..MAX_STEPS_ASIDE).take_while(|&k| is_free(-1 - k)).count();
    (left + right) as f64 / 100.0
}

/// A line without points that lie on the straight line between others.
fn straightened(line: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut kept = vec![line[0]];
    let mut from = 0;
    for to in 2..line.len() {
        let is_straight = line[from + 1..to].iter().all(|p| off_line_m(*p, line[from], line[to]) <= TOLERANCE_M);
        if !is_straight {
            from = to - 1;
            kept.push(line[from]);
        }
    }
    kept.extend(line[1..].last());
    kept
}

/// Distance of a point from a line segment in 3D.
fn off_line_m(p: [f64; 3], a: [f64; 3], b: [f64; 3]) -> f64 {
    let d = [0, 1, 2].map(|k| b[k] - a[k]);
    let e = [0, 1, 2].map(|k| p[k] - a[k]);
    let length2: f64 = d.iter().map(|c| c * c).sum();
    let t = if length2 > 0.0 { (0..3).map(|k| e[k] * d[k]).sum::<f64>() / length2 } else { 0.0 };
    let t = t.clamp(0.0, 1.0);
    distance_m([0.0; 3], [0, 1, 2].map(|k| e[k] - t * d[k]))
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{ArchiveBuffer, ElementRecord, PartRecord, ScheduleStateBuilder, SiteBuilder};

    pub(crate) const RISE_M: f64 = 0.175;
    pub(crate) const GOING_M: f64 = 0.28;

    /// A stair: element 0 is the whole, the others are its parts and what stands beside them.
    pub(crate) struct Stairwell(pub(crate) SiteBuilder);

    impl Stairwell {
        pub(crate) fn new() -> Self {
            let mut stairwell = Self(SiteBuilder::default());
            stairwell.add(Class::Stair, NONE, None);
            stairwell
        }

        pub(crate) fn add(&mut self, class: Class, whole: u32, corners_m: Option<[[f64; 3]; 2]>) -> usize {
            let b = &mut self.0;
            let corners = corners_m.map(|c| c.map(|p| p.map(|m| (m * f64::from(TENTHS_PER_M)).round() as i32)));
            let [min, max] = corners.unwrap_or_default();
            let first_part = b.parts.len() as u32;
            if corners.is_some() {
                let quads: [[u32; 4]; 6] =
                    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
                b.parts.push(PartRecord {
                    first_vertex: b.vertices.len() as u32,
                    n_vertices: 8,
                    first_triangle: b.triangles.len() as u32,
                    n_triangles: 12,
                    closed: 1,
                    colour: 0,
                });
                b.vertices.extend((0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 1 { max[k] } else { min[k] })));
                b.triangles.extend(quads.iter().flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]]));
            }
            b.elements.push(ElementRecord {
                class: class.into(),
                whole,
                min_tenths: min,
                max_tenths: max,
                first_part,
                n_parts: u32::from(corners.is_some()),
                storey: NONE,
                space: NONE,
                door: NONE,
                stair: NONE,
                ..Zeroable::zeroed()
            });
            b.elements.len() - 1
        }

        /// `n` steps of a flight of 1 m from x = `from_m` in either direction, the first a rise above `floor_m`.
        pub(crate) fn flight(&mut self, from_m: f64, way: f64, y_m: f64, floor_m: f64, n: u32) {
            for k in 0..n {
                let ends = [k, k + 1].map(|k| from_m + way * GOING_M * f64::from(k));
                let top = floor_m + RISE_M * f64::from(k + 1);
                let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
                self.add(Class::Stair, 0, Some([[low, y_m, top - RISE_M], [high, y_m + 1.0, top]]));
            }
        }

        pub(crate) fn site(&self) -> ArchiveBuffer {
            self.0.finish()
        }

        fn stair_traversal(&self, ends: [[f64; 3]; 2], absent: &[usize]) -> Option<StairTraversal> {
            let site = self.site();
            let site = Site::open(site.bytes()).unwrap();
            let mut schedule_state =
                ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), 0);
            absent
                .iter()
                .for_each(|&e| schedule_state.set_element(e, ElementState::NotStarted, ElementState::NotStarted));
            let schedule_state = schedule_state.finish();
            stair_traversal(&site, &ScheduleState::open(schedule_state.bytes()).unwrap(), 0, ends)
        }
    }

    #[test]
    fn a_straight_flight_is_walked_from_the_first_step_to_the_last() {
        let mut stairwell = Stairwell::new();
        stairwell.flight(1.0, 1.0, 0.0, 0.0, 15);
        // The sixteenth riser leads onto the upper floor.
        let ends = [[0.5, 0.5, 0.0], [5.7, 0.5, 16.0 * RISE_M]];
        let found = stairwell.stair_traversal(ends, &[]).unwrap();
        assert_eq!((found.n_risers, found.clear_width_m), (16, 1.0));
        assert_eq!([found.line[0], *found.line.last().unwrap()], ends);
        let slope_m = libm::hypot(14.0 * GOING_M, 14.0 * RISE_M);
        let ways_m = libm::hypot(0.64, RISE_M) + libm::hypot(5.7 - 1.0 - 14.5 * GOING_M, RISE_M);
        assert!((found.length_m - slope_m - ways_m).abs() < 0.01, "{found:?}");
    }

    #[test]
    fn a_stair_that_turns_is_walked_over_its_landing() {
        let mut stairwell = Stairwell::new();
        stairwell.flight(1.0, 1.0, 0.0, 0.0, 7);
        let landing_m = 8.0 * RISE_M;
        let far = 1.0 + 7.0 * GOING_M;
        stairwell.add(Class::Slab, 0, Some([[far, 0.0, landing_m - 0.2], [far + 1.2, 2.2, landing_m]]));
        stairwell.flight(far, -1.0, 1.2, landing_m, 7);
        let ends = [[0.5, 0.5, 0.0], [0.5, 1.7, 16.0 * RISE_M]];
        let found = stairwell.stair_traversal(ends, &[]).unwrap();
        assert_eq!(found.n_risers, 16);
        assert!(found.line.contains(&[far + 0.6, 1.1, landing_m]), "{found:?}");
        // Without the landing nothing leads from one flight to the other.
        assert_eq!(stairwell.stair_traversal(ends, &[8]), None);
    }

    #[test]
    fn rails_and_walls_beside_a_flight_make_it_narrower() {
        let mut stairwell = Stairwell::new();
        stairwell.flight(1.0, 1.0, 0.0, 0.0, 15);
        stairwell.add(Class::Railing, 0, Some([[1.0, 0.0, 0.0], [5.2, 0.05, 3.6]]));
        stairwell.add(Class::Wall, NONE, Some([[1.0, 0.9, 0.0], [5.2, 1.2, 3.6]]));
        let found = stairwell.stair_traversal([[0.5, 0.5, 0.0], [5.7, 0.5, 16.0 * RISE_M]], &[]).unwrap();
        assert!((found.clear_width_m - 0.85).abs() < 0.021, "{found:?}");
    }

    #[test]
    fn a_body_without_steps_is_no_way() {
        let mut stairwell = Stairwell::new();
        stairwell.add(Class::Stair, 0, Some([[1.0, 0.0, 0.0], [5.2, 1.0, 1.4]]));
        assert_eq!(stairwell.stair_traversal([[0.5, 0.5, 0.0], [5.7, 0.5, 2.8]], &[]), None);
    }
}
