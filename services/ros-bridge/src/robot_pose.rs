//! The robot's pose in its own map, from the transforms of others.

use daemon::facts::Pose;
use ros::msg::geometry_msgs::{Quaternion, Transform, Vector3};
use ros::msg::tf2_msgs::TFMessage;
use std::collections::HashMap;
use std::time::{Duration, Instant};

/// A pose that is older than this says nothing of where the robot is.
const MAX_AGE: Duration = Duration::from_secs(1);
/// Frames of one robot are far fewer; more are a mistake, and a loop ends here.
const MAX_FRAMES: usize = 1024;

/// Transforms by child: parent, motion, when it came.
#[derive(Default)]
pub(crate) struct TransformTree(HashMap<String, (String, Transform, Instant)>);

impl TransformTree {
    /// Takes transforms; the newest of a child counts.
    pub(crate) fn take(&mut self, message: TFMessage, now: Instant) {
        for stamped in message.transforms {
            if self.0.len() < MAX_FRAMES || self.0.contains_key(&stamped.child_frame_id) {
                self.0.insert(stamped.child_frame_id, (stamped.header.frame_id, stamped.transform, now));
            }
        }
    }

    /// How long ago the newest transform of a frame came.
    pub(crate) fn age(&self, child: &str, now: Instant) -> Option<Duration> {
        self.0.get(child).map(|(_, _, at)| now.duration_since(*at))
    }

    /// How a frame lies in another one that is above it, in the plane; `None` if there is no way, or the frame's own transform is old.
    pub(crate) fn pose(&self, parent: &str, child: &str, now: Instant) -> Option<Pose> {
        let is_moving = self.0.get(child).is_some_and(|(_, _, at)| now.duration_since(*at) <= MAX_AGE);
        let mut pose = Transform::default();
        let mut frame = child;
        for _ in 0..MAX_FRAMES {
            if frame == parent {
                let Vector3 { x, y, .. } = pose.translation;
                let pose = [x, y, yaw_rad(&pose.rotation)];
                let is_finite = pose.iter().all(|value| value.is_finite());
                return (is_moving && is_finite).then(|| Pose::of(pose));
            }
            let (above, motion, _) = self.0.get(frame)?;
            pose = after(motion, &pose);
            frame = above;
        }
        None
    }
}

/// The second motion behind the first.
fn after(second: &Transform, first: &Transform) -> Transform {
    let moved = rotated(&second.rotation, &first.translation);
    let Vector3 { x, y, z } = second.translation;
    Transform {
        translation: Vector3 { x: x + moved.x, y: y + moved.y, z: z + moved.z },
        rotation: product(&second.rotation, &first.rotation),
    }
}

fn product(a: &Quaternion, b: &Quaternion) -> Quaternion {
    Quaternion {
        x: a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
        y: a.w * b.y - a.x * b.z + a.y * b.w + a.z * b.x,
        z: a.w * b.z + a.x * b.y - a.y * b.x + a.z * b.w,
        w: a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z,
    }
}

fn rotated(by: &Quaternion, v: &Vector3) -> Vector3 {
    let vector = Quaternion { x: v.x, y: v.y, z: v.z, w: 0.0 };
    let inverse = Quaternion { x: -by.x, y: -by.y, z: -by.z, w: by.w };
    let Quaternion { x, y, z, .. } = product(&product(by, &vector), &inverse);
    Vector3 { x, y, z }
}

fn yaw_rad(q: &Quaternion) -> f64 {
    libm::atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::facts::Pose;
    use ros::msg::geometry_msgs::TransformStamped;
    use ros::msg::std_msgs::Header;
    use std::f64::consts::FRAC_PI_2;

    fn transform(parent: &str, child: &str, [x, y]: [f64; 2], yaw: f64) -> TransformStamped {
        TransformStamped {
            header: Header { frame_id: parent.to_owned(), ..Header::default() },
            child_frame_id: child.to_owned(),
            transform: Transform { translation: Vector3 { x, y, z: 0.0 }, rotation: Quaternion::of_yaw_rad(yaw) },
        }
    }

    fn tree(transforms: &[TransformStamped], at: Instant) -> TransformTree {
        let mut tree = TransformTree::default();
        tree.take(TFMessage { transforms: transforms.to_vec() }, at);
        tree
    }

    #[test]
    fn motions_are_put_together_along_the_way() {
        let now = Instant::now();
        let tree = tree(
            &[transform("map", "odom", [1.0, 2.0], FRAC_PI_2), transform("odom", "base_link", [3.0, 0.0], FRAC_PI_2)],
            now,
        );
        let pose = tree.pose("map", "base_link", now).unwrap();
        let Pose { x_m: x, y_m: y, .. } = pose;
        assert!((x - 1.0).abs() < 1e-12 && (y - 5.0).abs() < 1e-12, "{pose:?}");
        assert!((pose.yaw_rad.abs() - 2.0 * FRAC_PI_2).abs() < 1e-12, "{pose:?}");
        assert_eq!(tree.pose("earth", "base_link", now), None);
    }

    #[test]
    fn an_old_pose_is_none_and_a_loop_ends() {
        let begun = Instant::now();
        let moving = tree(&[transform("map", "base_link", [0.0, 0.0], 0.0)], begun);
        assert!(moving.pose("map", "base_link", begun + MAX_AGE).is_some());
        assert_eq!(moving.pose("map", "base_link", begun + MAX_AGE * 2), None);
        assert_eq!(moving.age("base_link", begun + MAX_AGE), Some(MAX_AGE));
        let round = tree(&[transform("a", "b", [0.0, 0.0], 0.0), transform("b", "a", [0.0, 0.0], 0.0)], begun);
        assert_eq!(round.pose("map", "a", begun), None);
        let nan = tree(&[transform("map", "base_link", [f64::NAN, 0.0], 0.0)], begun);
        assert_eq!(nan.pose("map", "base_link", begun), None);
    }
}
