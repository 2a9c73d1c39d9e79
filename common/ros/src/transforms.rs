//! Transforms between frames of maps.

use crate::msg::builtin_interfaces::Time;
use crate::msg::geometry_msgs::{Quaternion, Transform, TransformStamped, Vector3};
use crate::msg::std_msgs::Header;
use messages::{MapStoreyRecord, PoseRecord};

/// How the map of the model lies in the robot's own map: for `/tf_static`, where SLAM owns the frame `map`.
///
/// `map` is the frame of the SLAM map and becomes the parent, `site_map` that of the model's maps and becomes the child: tf
/// has one parent for each frame, and localization owns what lies below `map`. The motion is in the plane.
pub fn site_map_from_map(pose: &PoseRecord, map: &str, site_map: &str, stamp: Time) -> TransformStamped {
    let slam_from_map = pose.map_from_slam().inverse();
    let [x, y] = slam_from_map.translation_m();
    transform(map, site_map, Vector3 { x, y, z: 0.0 }, Quaternion::of_yaw_rad(slam_from_map.yaw_rad()), stamp)
}

/// How the flat map of a storey lies in the frame of the site: lifted to its floor.
pub fn storey(storey: &MapStoreyRecord, site: &str, frame_id: &str, stamp: Time) -> TransformStamped {
    let z = frames::metres(storey.floor_z_tenths);
    transform(site, frame_id, Vector3 { z, ..Vector3::default() }, Quaternion::default(), stamp)
}

fn transform(parent: &str, child: &str, translation: Vector3, rotation: Quaternion, stamp: Time) -> TransformStamped {
    TransformStamped {
        header: Header { stamp, frame_id: parent.to_owned() },
        child_frame_id: child.to_owned(),
        transform: Transform { translation, rotation },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frames::{Map, Point2, Slam};

    #[test]
    fn a_point_of_the_model_comes_to_lie_where_the_robot_has_it() {
        let pose = PoseRecord { map_from_slam: [3.0, -7.0, 0.5], ..PoseRecord::NONE };
        let message = site_map_from_map(&pose, "map", "site_map", Time::default());
        assert_eq!((message.header.frame_id.as_str(), message.child_frame_id.as_str()), ("map", "site_map"));
        let in_slam = Point2::<Slam>::new(1.5, 4.0);
        let in_model: Point2<Map> = &pose.map_from_slam() * in_slam;
        let Transform { translation, rotation } = message.transform;
        let yaw_rad = 2.0 * libm::atan2(rotation.z, rotation.w);
        let (sin, cos) = libm::sincos(yaw_rad);
        let [x, y] = in_model.coordinates_m();
        let moved = Point2::new(cos * x - sin * y + translation.x, sin * x + cos * y + translation.y);
        assert!(in_slam.distance_m(&moved) < 1e-12, "{moved:?}");
    }
}
