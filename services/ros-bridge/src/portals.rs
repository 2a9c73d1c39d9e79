//! The way of a robot over a stair or a ramp: at its end the robot is on another storey.
//!
//! A robot has entered a portal when it stands at the end that is on its storey. While it stays beside the line of the portal its
//! progress along that line is followed; beyond three quarters of the line it is on the storey of the other end. Who passes below a
//! stair did not enter it. Steps and lifts have no line to follow: their storeys are told by the parameter.

use frames::{Map, Point2};
use messages::{MissionPlan, RouteEdgeRecord};

/// Who is nearer to the line of a portal than this is on it, in metres.
const MAX_OFFSET_M: f64 = 1.0;
/// The longest way of a robot between two looks, in metres.
const MAX_STEP_M: f64 = 3.0;
/// A line that is shorter in plan does not tell on which side of it a robot is.
const MIN_LENGTH_M: f64 = 1.0;
/// The share of the line beyond which a robot is on the other storey; well beyond the middle, so that it does not come and go.
const PASSED: f64 = 0.75;

/// A portal to another storey that a robot is in.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Entered {
    /// Its element.
    of: u32,
    from_storey: u32,
    to_storey: u32,
    /// How far it has come along the line.
    progress_m: f64,
}

/// Follows a robot through portals.
#[derive(Debug, Default)]
pub(crate) struct PortalFollower(Option<Entered>);

impl PortalFollower {
    /// Takes where a robot is now that was on a storey: the storey that it has come to, if it is another one.
    pub(crate) fn look(&mut self, plan: &MissionPlan<'_>, storey: u32, robot: Point2<Map>) -> Option<u32> {
        self.0 = self.entered(plan, storey, robot);
        let Entered { of, to_storey, progress_m, .. } = self.0?;
        let line = lines(plan, storey).find(|line| (line.of, line.to_storey) == (of, to_storey))?;
        let has_passed = progress_m > PASSED * line.length_m();
        if has_passed {
            self.0 = None;
        }
        has_passed.then_some(to_storey)
    }

    fn entered(&self, plan: &MissionPlan<'_>, storey: u32, robot: Point2<Map>) -> Option<Entered> {
        let now = |line: &Line, progress_m| Entered {
            of: line.of,
            from_storey: storey,
            to_storey: line.to_storey,
            progress_m,
        };
        let is_same = |line: &Line, last: &Entered| {
            (line.of, line.to_storey, storey) == (last.of, last.to_storey, last.from_storey)
        };
        if let Some(last) = self.0
            && let Some(line) = lines(plan, storey).find(|line| is_same(line, &last))
            && let Some(progress_m) = line.progress_m(robot, last.progress_m)
        {
            return Some(now(&line, progress_m));
        }
        lines(plan, storey).find(|line| line.points[0].distance_m(&robot) < MAX_OFFSET_M).map(|line| now(&line, 0.0))
    }
}

/// The line of a portal in plan, from a storey to another.
struct Line {
    of: u32,
    to_storey: u32,
    points: Vec<Point2<Map>>,
}

/// Those that begin on a storey.
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
        let line = Line { of: edge.of, to_storey, points };
        (line.length_m() >= MIN_LENGTH_M).then_some(line)
    };
    plan.edges.iter().filter_map(line)
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
        nearest.filter(|(offset_m, _)| *offset_m < MAX_OFFSET_M).map(|(_, progress_m)| progress_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bytemuck::Zeroable;
    use messages::{EdgeKind, MissionPlanBuilder, MissionPlanHead, NodeKind, RouteNodeRecord};

    /// A stair of two flights beside each other from storey 0 to storey 1, and a lift.
    fn plan() -> messages::ArchiveBuffer {
        let mut builder = MissionPlanBuilder::new(MissionPlanHead::zeroed(), 0);
        let flights = [[0.0, 0.0, 0.0], [4.0, 0.0, 1.5], [4.0, 1.2, 1.5], [0.0, 1.2, 3.0]];
        let lift = [[20.0, 0.0, 0.0], [20.0, 0.0, 3.0]];
        for (of, kind, line) in [(7, EdgeKind::Stair, &flights[..]), (8, EdgeKind::Lift, &lift[..])] {
            let first = builder.nodes.len() as u32;
            for (map_storey, at) in [(0, line[0]), (1, line[line.len() - 1])] {
                builder.nodes.push(RouteNodeRecord {
                    position_in_map_m: at,
                    map_storey,
                    kind: NodeKind::Staging.into(),
                    of,
                    ..RouteNodeRecord::zeroed()
                });
            }
            let first_point = builder.points.len() as u32;
            builder.points.extend_from_slice(line);
            builder.edges.push(RouteEdgeRecord {
                nodes: [first, first + 1],
                kind: kind.into(),
                of,
                first_point,
                n_points: line.len() as u32,
                usable: 1,
                ..RouteEdgeRecord::zeroed()
            });
        }
        builder.finish()
    }

    /// The storey of a robot after each place, which begins on storey 0.
    fn storeys(way: &[[f64; 2]]) -> Vec<u32> {
        let bytes = plan();
        let plan = MissionPlan::open(bytes.as_ref()).unwrap();
        let (mut follower, mut storey) = (PortalFollower::default(), 0);
        let look = |&[x, y]: &[f64; 2]| {
            storey = follower.look(&plan, storey, Point2::new(x, y)).unwrap_or(storey);
            storey
        };
        way.iter().map(look).collect()
    }

    #[test]
    fn a_robot_that_climbs_a_stair_is_on_the_storey_above_at_its_end_and_comes_back() {
        let up = [[-0.5, 0.0], [1.0, 0.1], [2.5, 0.0], [4.0, 0.3], [3.5, 1.2], [1.5, 1.2], [0.0, 1.2], [-1.0, 1.2]];
        assert_eq!(storeys(&up), [0, 0, 0, 0, 0, 1, 1, 1]);
        let there_and_back: Vec<[f64; 2]> = up.iter().chain(up.iter().rev()).copied().collect();
        assert_eq!(storeys(&there_and_back)[8..], [1, 1, 1, 1, 1, 1, 0, 0]);
    }

    #[test]
    fn a_robot_that_turns_back_or_passes_below_stays_on_its_storey() {
        assert_eq!(storeys(&[[0.0, 0.0], [2.0, 0.0], [4.0, 0.6], [2.0, 0.0], [0.0, 0.0], [-3.0, 0.0]]), [0; 6]);
        assert_eq!(storeys(&[[2.0, 5.0], [2.0, 2.0], [2.0, 1.2], [1.0, 1.2], [2.0, -2.0]]), [0; 5]);
        assert_eq!(storeys(&[[20.0, 0.5], [20.0, 0.0], [20.0, 0.5]]), [0; 3], "a lift does not tell where it stops");
    }
}
