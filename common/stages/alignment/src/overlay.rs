//! Overlay image of two aligned maps.

use crate::alignment::AlignedPose;
use crate::prepared_map::{PreparedMap, between_cells};
use frames::{Map, Slam};
use image::{ImageError, ImageFormat, Rgb, RgbImage};
use occupancy::{CELL_M, Cell};
use std::io::Cursor;

const FREE: Rgb<u8> = Rgb([255, 255, 255]);
const UNKNOWN: Rgb<u8> = Rgb([220, 220, 220]);
const MODEL: Rgb<u8> = Rgb([110, 110, 110]);
/// Free space seen by the robot.
const SEEN: Rgb<u8> = Rgb([205, 228, 250]);
/// Walls of both maps.
const EXPLAINED: Rgb<u8> = Rgb([0, 130, 60]);
/// Seen by the robot, not in the model.
const ADDED: Rgb<u8> = Rgb([210, 30, 30]);
/// In the model, but the robot saw through it.
const MISSING: Rgb<u8> = Rgb([240, 140, 0]);

/// Walls nearer than this are the same.
const SAME_WALL_M: f64 = 0.15;

/// The model's map with the SLAM map over it, as PNG; a pixel for each cell of 0.05 m, row 0 at the top, in the axes of the
/// model's map. Walls of both are green, what only the robot saw red, what it saw through orange.
///
/// # Errors
/// A picture too large for PNG.
pub fn overlay(
    reference: &PreparedMap<Map>,
    slam: &PreparedMap<Slam>,
    pose: &AlignedPose,
) -> Result<Vec<u8>, ImageError> {
    let pose = between_cells(reference, slam, &pose.map_from_slam);
    let (model, seen) = (&reference.features.raster, &slam.features.raster);
    // Both maps lie in the picture: cells from that of the reference's corner.
    let cells_of = |p: [f64; 2]| p.map(|c| libm::floor(c / CELL_M) as i64);
    let known = seen.cells.iter().enumerate().filter(|(_, c)| **c != Cell::Unknown);
    let (mut lo, mut hi) = ([0; 2], [model.width as i64, model.height as i64]);
    for (index, _) in known {
        let at = cells_of(pose.apply(seen.middle(index)));
        for k in 0..2 {
            (lo[k], hi[k]) = (lo[k].min(at[k]), hi[k].max(at[k] + 1));
        }
    }
    let size = [0, 1].map(|k| (hi[k] - lo[k]) as u32);
    let at_pixel = |x: u32, y: u32| [i64::from(x) + lo[0], hi[1] - 1 - i64::from(y)];
    let picture = RgbImage::from_fn(size[0], size[1], |x, y| {
        let p = at_pixel(x, y).map(|c| (c as f64 + 0.5) * CELL_M);
        let robot = seen.at(pose.apply_inverse(p));
        match (model.at(p), robot) {
            (_, Cell::Occupied) if is_near(reference.features.nearest(p).map(|n| n.1)) => EXPLAINED,
            (_, Cell::Occupied) => ADDED,
            (Cell::Occupied, Cell::Free) if !is_near(slam.features.nearest(pose.apply_inverse(p)).map(|n| n.1)) => {
                MISSING
            }
            (Cell::Occupied, _) => MODEL,
            (_, Cell::Free) => SEEN,
            (Cell::Free, Cell::Unknown) => FREE,
            (Cell::Unknown, Cell::Unknown) => UNKNOWN,
        }
    });
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, ImageFormat::Png)?;
    Ok(bytes.into_inner())
}

fn is_near(squared: Option<f64>) -> bool {
    squared.is_some_and(|s| s <= SAME_WALL_M * SAME_WALL_M)
}
