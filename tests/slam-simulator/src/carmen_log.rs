//! Logs of laser scans and odometry as text, as CARMEN writes them and as programs for SLAM read them.

use crate::robot::odometry::OdometryPose;
use crate::strengths::Lidar;
use std::fmt::Write;

/// Type of the laser, in the numbers of CARMEN: a simulated one.
const SIMULATED_LASER: usize = 3;
/// Time between two scans.
const SECONDS_PER_SCAN: f64 = 0.25;

/// One message `ROBOTLASER1` for each scan, with the pose of the odometry; the lidar is in the middle of the robot.
///
/// `scans` are ranges in metres by beam, from the right to the left. A beam without anything in range has the largest range, one
/// whose answer was lost 0. A lidar that sees all around has its first beam, straight behind, once more as its last: the beams of
/// a message lie evenly about the direction of travel.
///
/// # Source
/// CARMEN, "Log file format" (`logger` of the Carnegie Mellon robot navigation toolkit).
pub(crate) fn carmen_log(scans: &[Vec<f32>], odometry: &[OdometryPose], lidar: &Lidar) -> String {
    let field_rad = lidar.field_of_view_deg.to_radians();
    let is_whole_turn = lidar.field_of_view_deg >= 360.0;
    let n = lidar.beams + usize::from(is_whole_turn);
    let mut text = String::from("# message_name [message contents] ipc_timestamp ipc_hostname logger_timestamp\n");
    for (number, (ranges, pose)) in scans.iter().zip(odometry).enumerate() {
        // Writing into a string cannot fail.
        let _ = write!(
            text,
            "ROBOTLASER1 {SIMULATED_LASER} {:.9} {field_rad:.9} {:.9} {:.3} {:.3} 0 {n}",
            -field_rad / 2.0,
            field_rad / (n - 1) as f64,
            lidar.range_m,
            lidar.noise_m,
        );
        let again = ranges.iter().take(usize::from(is_whole_turn));
        for &range in ranges.iter().chain(again) {
            let _ = match range {
                _ if range.is_nan() => write!(text, " 0"),
                _ if range.is_infinite() => write!(text, " {:.3}", lidar.range_m),
                // Noise leaves a beam that met something within the largest range.
                _ => write!(text, " {:.3}", f64::from(range).min(lidar.range_m - 0.001)),
            };
        }
        let OdometryPose { place: [x, y], yaw_rad } = *pose;
        let pose = format!("{x:.6} {y:.6} {yaw_rad:.9}");
        let time_s = SECONDS_PER_SCAN * number as f64;
        let _ = writeln!(text, " 0 {pose} {pose} 0 0 0 0 0 {time_s:.3} slam-pairs {time_s:.3}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lidar(field_of_view_deg: f64) -> Lidar {
        Lidar { range_m: 12.0, field_of_view_deg, beams: 4, noise_m: 0.01, drop_out_share: 0.0 }
    }

    /// Numbers of the message of one scan, after its name.
    fn message(ranges: &[f32], lidar: &Lidar) -> Vec<f64> {
        let pose = OdometryPose { place: [1.5, -2.0], yaw_rad: 0.25 };
        let text = carmen_log(&[ranges.to_vec()], &[pose], lidar);
        let line = text.lines().nth(1).unwrap();
        line.split(' ').skip(1).filter(|word| *word != "slam-pairs").map(|word| word.parse().unwrap()).collect()
    }

    #[test]
    fn a_message_tells_the_beams_their_ranges_and_the_pose() {
        let numbers = message(&[1.0, f32::INFINITY, f32::NAN, 12.003], &lidar(270.0));
        let field = 270f64.to_radians();
        let head = [3.0, -field / 2.0, field, field / 3.0, 12.0, 0.01, 0.0, 4.0];
        assert!(numbers.iter().zip(head).all(|(a, b)| (a - b).abs() < 1e-6), "{numbers:?}");
        assert_eq!(numbers[8..12], [1.0, 12.0, 0.0, 11.999]);
        assert_eq!(numbers[12..19], [0.0, 1.5, -2.0, 0.25, 1.5, -2.0, 0.25]);
        assert_eq!(numbers.len(), 19 + 5 + 2);
    }

    #[test]
    fn a_lidar_that_sees_all_around_has_its_first_beam_on_both_ends() {
        let numbers = message(&[1.0, 2.0, 3.0, 4.0], &lidar(360.0));
        assert!((numbers[3] - 90f64.to_radians()).abs() < 1e-6, "{numbers:?}");
        assert_eq!(numbers[7..13], [5.0, 1.0, 2.0, 3.0, 4.0, 1.0]);
    }
}
