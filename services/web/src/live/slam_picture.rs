//! The robot's own map as a picture, and where it lies in the model's map.

use frames::{Map, Point2, Slam};
use messages::{PoseRecord, SlamMap};
use serde::Serialize;

/// Occupied cells, and free ones, in the colours of the robot.
const OCCUPIED: [u8; 4] = [190, 24, 160, 235];
const FREE: [u8; 4] = [224, 130, 208, 60];

/// Where the picture lies.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct SlamPlace {
    pub(super) hash: String,
    pub(super) storey: u32,
    pub(super) resolution_m: f64,
    /// Pixels.
    pub(super) size: [u32; 2],
    /// Lower left, lower right and upper left corner in `map`, metres.
    pub(super) corners_m: [[f64; 2]; 3],
    pub(super) sigma_m: f64,
    pub(super) sigma_deg: f64,
}

/// Places a map by a pose.
pub(super) fn place(hash: String, map: &SlamMap<'_>, pose: &PoseRecord) -> SlamPlace {
    let head = map.head;
    let [x, y, yaw] = head.origin;
    let (sin, cos) = (libm::sin(yaw), libm::cos(yaw));
    let (width_m, height_m) = (f64::from(head.width) * head.resolution_m, f64::from(head.height) * head.resolution_m);
    let map_from_slam = pose.map_from_slam();
    let corner = |along: f64, up: f64| {
        let in_slam = Point2::<Slam>::new(x + along * cos - up * sin, y + along * sin + up * cos);
        let in_map: Point2<Map> = &map_from_slam * in_slam;
        in_map.coordinates_m()
    };
    let [sigma_m, sigma_deg] = sigmas(pose);
    SlamPlace {
        hash,
        storey: pose.map_storey,
        resolution_m: head.resolution_m,
        size: [head.width, head.height],
        corners_m: [corner(0.0, 0.0), corner(width_m, 0.0), corner(0.0, height_m)],
        sigma_m,
        sigma_deg,
    }
}

/// Standard deviations of a pose at the middle of the SLAM map: metres, the larger of x and y, and degrees.
pub(super) fn sigmas(pose: &PoseRecord) -> [f64; 2] {
    let variance = |k: usize| pose.covariance[k].max(0.0);
    [variance(0).max(variance(4)).sqrt(), variance(8).sqrt().to_degrees()]
}

/// The map as a PNG file, row 0 at the top.
pub(super) fn picture(map: &SlamMap<'_>) -> Vec<u8> {
    let (width, height) = (map.head.width, map.head.height);
    let rows = map.occupancy.chunks_exact((width as usize).max(1)).rev();
    let pixels: Vec<u8> = rows
        .flatten()
        .map(|occupancy| match occupancy {
            -1 => 0,
            0..50 => 1,
            _ => 2,
        })
        .collect();
    let colours = [[0; 4], FREE, OCCUPIED];
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width.max(1), height.max(1));
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(colours.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect::<Vec<u8>>());
    encoder.set_trns(colours.iter().map(|colour| colour[3]).collect::<Vec<u8>>());
    let mut writer = encoder.write_header().expect("memory takes all bytes");
    writer.write_image_data(if pixels.is_empty() { &[0] } else { &pixels }).expect("there is a byte for each pixel");
    writer.finish().expect("memory takes all bytes");
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{Checked, SlamMapHead, payload};

    #[test]
    fn corners_follow_the_origin_and_the_pose() {
        let head = SlamMapHead { resolution_m: 0.1, origin: [1.0, 2.0, 0.0], width: 20, height: 10 };
        let archive = Checked::<payload::SlamMap>::new(SlamMap::write(&head, &[0; 200])).unwrap();
        let quarter = std::f64::consts::FRAC_PI_2;
        let pose = PoseRecord { map_from_slam: [10.0, 0.0, quarter], map_storey: 2, ..PoseRecord::NONE };
        let placed = place("x".into(), &archive.view(), &pose);
        let expected = [[8.0, 1.0], [8.0, 3.0], [7.0, 1.0]];
        for (found, expected) in placed.corners_m.iter().zip(expected) {
            assert!((found[0] - expected[0]).abs() < 1e-9 && (found[1] - expected[1]).abs() < 1e-9, "{placed:?}");
        }
        assert_eq!((placed.storey, placed.size), (2, [20, 10]));
        assert!(picture(&archive.view()).starts_with(b"\x89PNG"));
    }
}
