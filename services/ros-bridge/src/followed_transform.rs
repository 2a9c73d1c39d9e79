//! The transform from the robot's map to the site around the robot: a SLAM map bends, so that it changes as the robot drives, slowly.

use frames::{Map, Rigid2, Slam, wrapped};
use messages::{PoseRecord, PoseValidity};
use std::time::Duration;

/// Largest change of where the robot is put, and of its yaw, for each second: far less than a robot drives, so that a planner follows.
const MAX_M_PER_S: f64 = 0.05;
const MAX_RAD_PER_S: f64 = 0.02;
/// A larger change is no bend: an operator has confirmed another pose.
const JUMP_M: f64 = 0.5;
/// Smaller changes are not worth a message.
const STILL_M: f64 = 0.001;
const STILL_RAD: f64 = 0.0002;

/// The pose of the SLAM map around the robot, as it is published.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct FollowedTransform {
    published: Option<PoseRecord>,
}

impl FollowedTransform {
    /// What is published; `None` if it is withdrawn.
    pub(crate) fn published(&self) -> Option<&PoseRecord> {
        self.published.as_ref()
    }

    /// Withdraws it.
    pub(crate) fn withdraw(&mut self) {
        self.published = None;
    }

    /// Moves towards the pose around the robot, which is at `robot_m` in its map, after so much time; true if there is something new to
    /// publish. A pose that is not effective there is withdrawn, and what was withdrawn comes back where it lies; the pose of the whole
    /// map, where nobody tells where the robot is, is taken as it is.
    pub(crate) fn update(
        &mut self,
        (pose, validity): (PoseRecord, PoseValidity),
        robot_m: Option<[f64; 2]>,
        elapsed: Duration,
    ) -> bool {
        if validity != PoseValidity::Effective {
            self.withdraw();
            return false;
        }
        let Some(before) = self.published.filter(|before| before.map_storey == pose.map_storey) else {
            self.published = Some(pose);
            return true;
        };
        let (from, to) = (before.map_from_slam(), pose.map_from_slam());
        let place_m = robot_m.unwrap_or(pose.about_m);
        let (at, wanted) = (from.apply(place_m), to.apply(place_m));
        let by_m = [0, 1].map(|k| wanted[k] - at[k]);
        let (distance_m, turn_rad) = (libm::hypot(by_m[0], by_m[1]), wrapped(to.yaw_rad() - from.yaw_rad()));
        if robot_m.is_none() || distance_m > JUMP_M {
            self.published = Some(pose);
            return true;
        }
        if distance_m < STILL_M && turn_rad.abs() < STILL_RAD {
            return false;
        }
        let share = |limit_per_s: f64, wanted: f64| (limit_per_s * elapsed.as_secs_f64() / wanted.abs()).min(1.0);
        let share = share(MAX_M_PER_S, distance_m).min(share(MAX_RAD_PER_S, turn_rad));
        let stepped = stepped(&from, place_m, by_m.map(|m| m * share), turn_rad * share);
        self.published = Some(PoseRecord { map_from_slam: stepped.x_y_yaw(), ..pose });
        true
    }
}

/// A pose that puts a place of the SLAM map elsewhere, and turns it.
fn stepped(pose: &Rigid2<Map, Slam>, place_m: [f64; 2], by_m: [f64; 2], turn_rad: f64) -> Rigid2<Map, Slam> {
    let yaw_rad = wrapped(pose.yaw_rad() + turn_rad);
    let (at, turned) = (pose.apply(place_m), Rigid2::<Map, Slam>::new([0.0; 2], yaw_rad).apply(place_m));
    Rigid2::new([0, 1].map(|k| at[k] + by_m[k] - turned[k]), yaw_rad)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    fn pose(x_m: f64, yaw_rad: f64) -> PoseRecord {
        PoseRecord { map_from_slam: [x_m, 0.0, yaw_rad], map_storey: 0, ..PoseRecord::NONE }
    }

    #[test]
    fn a_bend_is_followed_slowly_and_reached() {
        let (mut followed, robot_m) = (FollowedTransform::default(), [20.0, 3.0]);
        let robot = Some(robot_m);
        assert!(followed.update((pose(0.0, 0.0), PoseValidity::Effective), robot, SECOND));
        let target = pose(0.12, 0.01);
        let mut at = followed.published().unwrap().map_from_slam().apply(robot_m);
        let mut n_steps = 0;
        while followed.update((target, PoseValidity::Effective), robot, SECOND) {
            let now = followed.published().unwrap().map_from_slam().apply(robot_m);
            assert!(libm::hypot(now[0] - at[0], now[1] - at[1]) <= MAX_M_PER_S + 1e-9);
            (at, n_steps) = (now, n_steps + 1);
        }
        let wanted = target.map_from_slam().apply(robot_m);
        assert!(libm::hypot(at[0] - wanted[0], at[1] - wanted[1]) < 2.0 * STILL_M && n_steps > 2);
    }

    #[test]
    fn where_the_pose_is_not_known_it_is_withdrawn_and_comes_back_where_it_lies() {
        let (mut followed, robot_m) = (FollowedTransform::default(), Some([1.0, 0.0]));
        followed.update((pose(0.0, 0.0), PoseValidity::Effective), robot_m, SECOND);
        assert!(!followed.update((pose(0.0, 0.0), PoseValidity::Uncertain), robot_m, SECOND));
        assert!(followed.published().is_none());
        assert!(followed.update((pose(2.0, 0.0), PoseValidity::Effective), robot_m, SECOND));
        assert_eq!(followed.published().unwrap().map_from_slam, [2.0, 0.0, 0.0]);
    }

    #[test]
    fn another_pose_is_taken_at_once_and_so_is_any_without_the_robots_place() {
        let mut followed = FollowedTransform::default();
        for (x_m, robot_m) in [(0.0, Some([1.0, 0.0])), (7.0, Some([1.0, 0.0])), (7.2, None)] {
            assert!(followed.update((pose(x_m, 0.0), PoseValidity::Effective), robot_m, SECOND));
            assert_eq!(followed.published().unwrap().map_from_slam[0], x_m);
        }
    }
}
