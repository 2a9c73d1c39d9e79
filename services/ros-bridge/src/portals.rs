//! Finds the storey of a robot that goes over a stair or a ramp.
//!
//! A robot has entered a portal when it stands at the end that is on its storey. While it stays on the line of the portal its progress
//! along that line is followed; beyond three quarters of the line it is on the storey of the other end, and if it turns back there, on
//! its way down. A robot that passes below a stair, or beside it, did not enter it. A portal that this robot cannot take is none, and
//! lifts and steps have no line to follow: their storeys are told by the parameter. Who drives between a storey and the ground outdoors
//! goes through no portal with a line, and is followed by what both maps show (`outdoors`).

use frames::{Map, Point2};
use messages::{EdgeKind, MissionPlan, RouteEdgeRecord};

/// Who is nearer to the end of a portal than this may enter it, in metres.
const MAX_ENTRY_M: f64 = 1.0;
/// Who is nearer to the line of a portal of unknown width than this is on it, in metres.
const MAX_OFFSET_M: f64 = 0.75;
/// The longest way of a robot between two looks, in metres.
const MAX_STEP_M: f64 = 3.0;
/// A line that is shorter in plan does not tell on which side of it a robot is.
const MIN_LENGTH_M: f64 = 1.0;
/// The share of the line beyond which a robot is on the other storey; well beyond the middle, so that it does not come and go.
const PASSED: f64 = 0.75;

/// A portal that a robot has entered.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Entered {
    /// Its element.
    of: u32,
    from_storey: u32,
    to_storey: u32,
    /// How far the robot has come along the line.
    progress_m: f64,
}

/// Follows a robot through portals: those that it may be in, of which several can begin at one place.
#[derive(Debug, Default)]
pub(crate) struct PortalFollower(Vec<Entered>);

impl PortalFollower {
    /// Takes where a robot is now that was on a storey: the storey that it has come to, if it is another one.
    pub(crate) fn update(&mut self, plan: &MissionPlan<'_>, storey: u32, robot: Point2<Map>) -> Option<u32> {
        let lines: Vec<Line> = lines(plan, storey).collect();
        let entered = lines.iter().filter_map(|line| Some((line, self.progress_m(line, storey, robot)?)));
        let entered: Vec<_> = entered.collect();
        let passed = entered.iter().find(|(line, progress_m)| *progress_m > PASSED * line.length_m());
        let new_storey = passed.map(|(line, _)| line.to_storey);
        self.0 = match passed {
            // It may turn back.
            Some((line, progress_m)) => vec![Entered {
                of: line.of,
                from_storey: line.to_storey,
                to_storey: storey,
                progress_m: line.length_m() - progress_m,
            }],
            None => {
                let now = |(line, progress_m): &(&Line, f64)| Entered {
                    of: line.of,
                    from_storey: storey,
                    to_storey: line.to_storey,
                    progress_m: *progress_m,
                };
                entered.iter().map(now).collect()
            }
        };
        new_storey
    }

    /// How far a robot has come along a line; `None` if it has not entered it, or has left it.
    fn progress_m(&self, line: &Line, storey: u32, robot: Point2<Map>) -> Option<f64> {
        let is_it = |last: &&Entered| (last.of, last.from_storey, last.to_storey) == (line.of, storey, line.to_storey);
        let last = self.0.iter().find(is_it);
        let followed = last.and_then(|last| line.progress_m(robot, last.progress_m));
        followed.or_else(|| (line.points[0].distance_m(&robot) < MAX_ENTRY_M).then_some(0.0))
    }
}

/// The line of a portal in plan, from a storey to another.
struct Line {
    of: u32,
    to_storey: u32,
    points: Vec<Point2<Map>>,
    /// Who is nearer to it than this is on it.
    max_offset_m: f64,
}

/// Those that begin on a storey, and that the robot can take.
fn lines<'a>(plan: &'a MissionPlan<'_>, storey: u32) -> impl Iterator<Item = Line> + 'a {
    let storey_of = |node: u32| plan.nodes[node as usize].map_storey;
    let line = move |edge: &RouteEdgeRecord| {
        let mut points: Vec<_> = plan.points_of(edge).iter().map(|&[x, y, _]| Point2::new(x, y)).collect();
        let to_storey = match edge.nodes.map(storey_of) {
            [from, to] if from == storey && to != storey => to,
            [to, from] if from == storey && to != storey => {
                points.reverse();
                to
            }
            _ => return None,
        };
        let max_offset_m = if edge.clear_width_m > 0.0 { edge.clear_width_m / 2.0 } else { MAX_OFFSET_M };
        let line = Line { of: edge.of, to_storey, points, max_offset_m };
        (line.length_m() >= MIN_LENGTH_M).then_some(line)
    };
    let is_way =
        |edge: &&RouteEdgeRecord| edge.usable == 1 && [EdgeKind::Stair, EdgeKind::Ramp].contains(&edge.kind.get());
    plan.edges.iter().filter(is_way).filter_map(line)
}

impl Line {
    fn length_m(&self) -> f64 {
        self.points.windows(2).map(|ends| ends[0].distance_m(&ends[1])).sum()
    }

    /// How far along it a robot has come that was at `last_m`; `None` if it is beside.
    ///
    /// The flights of a stair may lie side by side: only what a robot can reach since then counts.
    fn progress_m(&self, robot: Point2<Map>, last_m: f64) -> Option<f64> {
        let mut begin_m = 0.0;
        let mut nearest: Option<(f64, f64)> = None;
        for ends in self.points.windows(2) {
            let length_m = ends[0].distance_m(&ends[1]);
            let [[x0, y0], [x1, y1], [x, y]] = [ends[0], ends[1], robot].map(|point| point.coordinates_m());
            let along_m = ((x - x0) * (x1 - x0) + (y - y0) * (y1 - y0)) / length_m.max(f64::MIN_POSITIVE);
            let window = [last_m - MAX_STEP_M, last_m + MAX_STEP_M].map(|at_m| (at_m - begin_m).clamp(0.0, length_m));
            let along_m = along_m.clamp(window[0], window[1]);
            let share = if length_m > 0.0 { along_m / length_m } else { 0.0 };
            let foot = Point2::<Map>::new(x0 + (x1 - x0) * share, y0 + (y1 - y0) * share);
            let offset_m = foot.distance_m(&robot);
            if nearest.is_none_or(|(least_m, _)| offset_m < least_m) {
                nearest = Some((offset_m, begin_m + along_m));
            }
            begin_m += length_m;
        }
        nearest.filter(|(offset_m, _)| *offset_m < self.max_offset_m).map(|(_, progress_m)| progress_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{ArchiveBuffer, MissionPlanBuilder, MissionPlanHead, NodeKind, RouteNodeRecord};

    /// An edge between storeys, with its line from the first to the second.
    struct RouteEdge<'a> {
        of: u32,
        kind: EdgeKind,
        usable: u32,
        storeys: [u32; 2],
        line: &'a [[f64; 2]],
    }

    fn stair(storeys: [u32; 2], line: &[[f64; 2]]) -> RouteEdge<'_> {
        RouteEdge { of: 7, kind: EdgeKind::Stair, usable: 1, storeys, line }
    }

    fn plan(edges: &[RouteEdge<'_>]) -> ArchiveBuffer {
        let mut builder = MissionPlanBuilder::new(MissionPlanHead::zeroed(), 0);
        for RouteEdge { of, kind, usable, storeys, line } in edges {
            let first = builder.nodes.len() as u32;
            let points: Vec<[f64; 3]> = line.iter().map(|&[x, y]| [x, y, 0.0]).collect();
            for (map_storey, at) in storeys.iter().zip([points[0], points[points.len() - 1]]) {
                builder.nodes.push(RouteNodeRecord {
                    position_in_map_m: at,
                    map_storey: *map_storey,
                    kind: NodeKind::Staging.into(),
                    of: *of,
                    ..RouteNodeRecord::zeroed()
                });
            }
            builder.edges.push(RouteEdgeRecord {
                nodes: [first, first + 1],
                kind: (*kind).into(),
                of: *of,
                clear_width_m: 1.2,
                first_point: builder.points.len() as u32,
                n_points: points.len() as u32,
                usable: *usable,
                ..RouteEdgeRecord::zeroed()
            });
            builder.points.extend(points);
        }
        builder.finish()
    }

    /// The storey of a robot after each place, which begins on a storey.
    fn storeys(plan: &ArchiveBuffer, mut storey: u32, way: &[[f64; 2]]) -> Vec<u32> {
        let plan = MissionPlan::open(plan.as_ref()).unwrap();
        let mut follower = PortalFollower::default();
        let look = |&[x, y]: &[f64; 2]| {
            storey = follower.update(&plan, storey, Point2::new(x, y)).unwrap_or(storey);
            storey
        };
        way.iter().map(look).collect()
    }

    /// Two flights beside each other.
    const FLIGHTS: [[f64; 2]; 4] = [[0.0, 0.0], [4.0, 0.0], [4.0, 1.2], [0.0, 1.2]];
    const UP: [[f64; 2]; 8] =
        [[-0.5, 0.0], [1.0, 0.1], [2.5, 0.0], [4.0, 0.3], [3.5, 1.2], [1.5, 1.2], [0.0, 1.2], [-1.0, 1.2]];

    #[test]
    fn a_robot_that_climbs_a_stair_is_on_the_storey_above_at_its_end_and_comes_back() {
        let plan = plan(&[stair([0, 1], &FLIGHTS)]);
        assert_eq!(storeys(&plan, 0, &UP), [0, 0, 0, 0, 0, 1, 1, 1]);
        let there_and_back: Vec<[f64; 2]> = UP.iter().chain(UP.iter().rev()).copied().collect();
        assert_eq!(storeys(&plan, 0, &there_and_back)[8..], [1, 1, 1, 1, 1, 1, 0, 0]);
    }

    #[test]
    fn a_robot_that_turns_back_is_where_it_came_from() {
        let plan = plan(&[stair([0, 1], &FLIGHTS)]);
        assert_eq!(
            storeys(&plan, 0, &[[0.0, 0.0], [2.0, 0.0], [4.0, 0.5], [2.0, 0.0], [0.0, 0.0], [-3.0, 0.0]]),
            [0; 6]
        );
        let late = UP[..6].iter().chain(UP[..5].iter().rev()).copied().collect::<Vec<_>>();
        assert_eq!(storeys(&plan, 0, &late), [0, 0, 0, 0, 0, 1, 1, 1, 1, 0, 0]);
    }

    #[test]
    fn a_robot_below_or_beside_a_stair_stays_on_its_storey() {
        let folded = plan(&[stair([0, 1], &FLIGHTS)]);
        assert_eq!(storeys(&folded, 0, &[[2.0, 5.0], [2.0, 2.0], [2.0, 1.2], [1.0, 1.2], [2.0, -2.0]]), [0; 5]);
        let straight = plan(&[stair([0, 1], &[[0.0, 0.0], [8.0, 0.0]])]);
        let beside: Vec<[f64; 2]> = (0..10).map(|x| [f64::from(x), 0.9]).collect();
        assert_eq!(storeys(&straight, 0, &beside), [0; 10]);
    }

    #[test]
    fn what_the_robot_cannot_take_and_lifts_tell_nothing() {
        let line = &[[0.0, 0.0], [8.0, 0.0]];
        let way: Vec<[f64; 2]> = (0..9).map(|x| [f64::from(x), 0.0]).collect();
        let unusable = RouteEdge { usable: 0, ..stair([0, 1], line) };
        let lift = RouteEdge { kind: EdgeKind::Lift, ..stair([0, 1], line) };
        for edge in [unusable, lift] {
            assert_eq!(storeys(&plan(&[edge]), 0, &way), [0; 9]);
        }
    }

    #[test]
    fn of_two_flights_of_one_stair_the_one_that_is_climbed_counts() {
        let (down, up) = ([[0.0, 0.0], [8.0, 0.0]], [[8.0, 0.0], [16.0, 0.0]]);
        let plan = plan(&[stair([0, 1], &down), stair([1, 2], &up)]);
        let way: Vec<[f64; 2]> = (8..17).map(|x| [f64::from(x), 0.0]).collect();
        assert_eq!(storeys(&plan, 1, &way), [1, 1, 1, 1, 1, 1, 1, 2, 2]);
        let whole: Vec<[f64; 2]> = (0..17).map(|x| [f64::from(x), 0.0]).collect();
        assert_eq!(storeys(&plan, 0, &whole), [0, 0, 0, 0, 0, 0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 2, 2]);
    }
}
