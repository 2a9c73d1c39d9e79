//! The robot's pose in the model's map with its covariance, as a file from which Nav2's AMCL begins.

use super::pose_file::PoseFile;
use messages::PoseRecord;
use ros::msg::geometry_msgs::PoseWithCovariance;
use ros::transforms::pose_in_map;

/// Every initial pose that this program wrote begins so.
const FIRST_WORDS: &str = "# ros2 topic pub --once /initialpose geometry_msgs/msg/PoseWithCovarianceStamped";

/// The initial pose as a file.
pub(super) const INITIAL_POSE: PoseFile = PoseFile { what: "initial pose", first_words: FIRST_WORDS };

/// Parameters of AMCL, with the same pose as a message in the first line. AMCL reads no covariance from parameters; it stands
/// there for programs that do.
///
/// `robot_in_slam` is x and y in metres and yaw in radians.
pub(super) fn text(pose: &PoseRecord, robot_in_slam: [f64; 3]) -> String {
    let message = pose_in_map(pose, robot_in_slam, "map", Default::default());
    let PoseWithCovariance { pose: robot, covariance } = message.pose;
    // A number without a point is an integer to ROS, and one with an exponent and no point a text.
    let (x_m, y_m, q) = (robot.position.x, robot.position.y, robot.orientation);
    let yaw_rad = frames::wrapped(pose.map_from_slam().yaw_rad() + robot_in_slam[2]);
    let numbers: Vec<String> = covariance.iter().flatten().map(|value| format!("{value:.12}")).collect();
    let (rows, covariance) = (numbers.chunks(6).map(|row| row.join(", ")), numbers.join(", "));
    let rows = rows.collect::<Vec<_>>().join(",\n        ");
    format!(
        "{FIRST_WORDS} '{{header: {{frame_id: map}}, pose: {{pose: {{position: {{x: {x_m:.9}, y: {y_m:.9}, z: 0.0}}, \
         orientation: {{x: 0.0, y: 0.0, z: {:.9}, w: {:.9}}}}}, covariance: [{covariance}]}}}}'\n\
         amcl:\n  ros__parameters:\n    set_initial_pose: true\n    initial_pose:\n      x: {x_m:.9}\n      y: {y_m:.9}\n      \
         z: 0.0\n      yaw: {yaw_rad:.9}\n      covariance: [\n        {rows}]\n",
        q.z, q.w
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_robot_is_where_the_alignment_has_it_with_the_covariance_of_that_place() {
        let covariance = [1e-4, 0.0, 0.0, 0.0, 4e-4, 0.0, 0.0, 0.0, 1e-6];
        let pose = PoseRecord { map_from_slam: [3.0, -7.0, 3.0], covariance, about_m: [0.0; 2], ..PoseRecord::NONE };
        let text = text(&pose, [10.0, 0.0, 0.5]);
        let number = |key: &str| {
            let line = text.lines().find_map(|line| line.trim().strip_prefix(key)).unwrap();
            line.trim().parse::<f64>().unwrap()
        };
        let (sin, cos) = libm::sincos(3.0);
        assert!((number("x:") - 3.0 - 10.0 * cos).abs() < 1e-8 && (number("y:") + 7.0 - 10.0 * sin).abs() < 1e-8);
        assert!((number("yaw:") - 3.5 + std::f64::consts::TAU).abs() < 1e-8, "{text}");
        let values: Vec<f64> = text
            .split("covariance: [")
            .nth(2)
            .unwrap()
            .split(']')
            .next()
            .unwrap()
            .split(',')
            .map(|value| value.trim().parse().unwrap())
            .collect();
        assert_eq!((values.len(), values[35]), (36, 1e-6));
        // A turn about a place that is 10 m away moves the robot across.
        assert!((values[0] - 1e-4 - (10.0 * sin).powi(2) * 1e-6).abs() < 1e-12, "{values:?}");
        assert!(values[7] > 4e-4 && values[14] == 0.0, "{values:?}");
        assert!(text.lines().next().unwrap().ends_with("]}}'"), "{text}");
    }
}
