//! Transforms between frames of maps, and the pose of a SLAM map with its covariance.

use crate::msg::builtin_interfaces::Time;
use crate::msg::geometry_msgs::{
    Point, Pose, PoseWithCovariance, PoseWithCovarianceStamped, Quaternion, Transform, TransformStamped, Vector3,
};
use crate::msg::std_msgs::Header;
use messages::{MapStoreyRecord, PoseRecord};

/// The places of x, y and yaw among x, y, z and the rotations about X, Y and Z.
const PLANAR: [usize; 3] = [0, 1, 5];

/// How the map of the model lies in the robot's own map: for `/tf_static`, where SLAM owns the frame `map`.
///
/// `map` is the frame of the SLAM map and becomes the parent, `site_map` that of the model's maps and becomes the child: tf
/// has one parent for each frame, and localization owns what lies below `map`. The motion is in the plane.
pub fn site_map_from_map(pose: &PoseRecord, map: &str, site_map: &str, stamp: Time) -> TransformStamped {
    let slam_from_map = pose.map_from_slam().inverse();
    let [x, y] = slam_from_map.translation_m();
    transform(map, site_map, Vector3 { x, y, z: 0.0 }, Quaternion::of_yaw_rad(slam_from_map.yaw_rad()), stamp)
}

/// Where the SLAM map begins in the model's map `site_map`.
pub fn alignment_pose(pose: &PoseRecord, site_map: &str, stamp: Time) -> PoseWithCovarianceStamped {
    pose_in_map(pose, [0.0; 3], site_map, stamp)
}

/// Where a pose of the SLAM map lies in the model's map `site_map`, with the covariance of that place and of its yaw; both lie
/// in the plane, which has no variance.
///
/// `in_slam_map` is x and y in metres and yaw in radians.
pub fn pose_in_map(pose: &PoseRecord, in_slam_map: [f64; 3], site_map: &str, stamp: Time) -> PoseWithCovarianceStamped {
    let (map_from_slam, [x, y, yaw_rad]) = (pose.map_from_slam(), in_slam_map);
    let ([x, y], [x_about, y_about]) = (map_from_slam.apply([x, y]), map_from_slam.apply(pose.about_m));
    let rows = pose.pose_covariance().transported([x - x_about, y - y_about]).rows();
    let mut covariance = [[0.0; 6]; 6];
    for (i, row) in PLANAR.into_iter().zip(rows) {
        for (j, value) in PLANAR.into_iter().zip(row) {
            covariance[i][j] = value;
        }
    }
    let orientation = Quaternion::of_yaw_rad(map_from_slam.yaw_rad() + yaw_rad);
    let pose = Pose { position: Point { x, y, z: 0.0 }, orientation };
    let header = Header { stamp, frame_id: site_map.to_owned() };
    PoseWithCovarianceStamped { header, pose: PoseWithCovariance { pose, covariance } }
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

    #[test]
    fn the_pose_of_a_slam_map_is_as_uncertain_as_its_beginning() {
        let covariance = [1e-4, 0.0, 0.0, 0.0, 4e-4, 0.0, 0.0, 0.0, 1e-6];
        let pose = PoseRecord { map_from_slam: [3.0, -7.0, 0.0], covariance, about_m: [10.0, 0.0], ..PoseRecord::NONE };
        let message = alignment_pose(&pose, "site_map", Time::default());
        assert_eq!(message.header.frame_id, "site_map");
        let PoseWithCovariance { pose, covariance } = message.pose;
        assert_eq!((pose.position, pose.orientation), (Point { x: 3.0, y: -7.0, z: 0.0 }, Quaternion::default()));
        // A turn about the place that is 10 m away moves the beginning across.
        let expected = |i: usize, j: usize| match [i, j] {
            [0, 0] => 1e-4,
            [1, 1] => 4e-4 + 100.0 * 1e-6,
            [1, 5] | [5, 1] => -10.0 * 1e-6,
            [5, 5] => 1e-6,
            _ => 0.0,
        };
        for (i, row) in covariance.iter().enumerate() {
            for (j, value) in row.iter().enumerate() {
                assert!((value - expected(i, j)).abs() < 1e-12, "{i} {j}: {value}");
            }
        }
    }

    #[test]
    fn a_robot_in_the_middle_of_its_map_is_as_certain_as_the_alignment_and_turned_with_it() {
        let covariance = [1e-4, 0.0, 0.0, 0.0, 4e-4, 0.0, 0.0, 0.0, 1e-6];
        let about_m = [10.0, 0.0];
        let pose = PoseRecord { map_from_slam: [3.0, -7.0, 0.5], covariance, about_m, ..PoseRecord::NONE };
        let PoseWithCovariance { pose: robot, covariance } =
            pose_in_map(&pose, [10.0, 0.0, 0.25], "site_map", Time::default()).pose;
        assert_eq!(robot.orientation, Quaternion::of_yaw_rad(0.75));
        let (sin, cos) = libm::sincos(0.5);
        assert!((robot.position.x - 3.0 - 10.0 * cos).abs() < 1e-12, "{robot:?}");
        assert!((robot.position.y + 7.0 - 10.0 * sin).abs() < 1e-12, "{robot:?}");
        assert_eq!([covariance[0][0], covariance[1][1], covariance[5][5], covariance[1][5]], [1e-4, 4e-4, 1e-6, 0.0]);
    }
}
