//! Corners of free space, with a ray signature each.

use crate::image::{Image, openness};
use occupancy::{CELL_M, Cell, Raster};
use std::f64::consts::TAU;

/// A corner or junction with its ray signature.
#[derive(Debug, Clone)]
pub(crate) struct Corner {
    pub(crate) at: [f64; 2],
    /// Direction into the free space.
    pub(crate) angle_rad: f64,
    /// Distances along 16 rays from that direction on counter-clockwise, in metres.
    rays_m: [f32; N_RAYS],
    /// 1 where the ray ended at something, 0 where it ended in the unknown.
    is_known: [f32; N_RAYS],
    /// Share of free space around.
    openness: f32,
}

const N_RAYS: usize = 16;
const FIRST_STEP: usize = 4;
const LAST_STEP: usize = 99;
const MAX_SIGNATURE_M: f32 = 4.0;
const MAX_RAY_M: f32 = 5.0;
const MAX_CORNERS: usize = 1500;
const HARRIS_K: f32 = 0.04;
/// A corner has something within so many cells.
const NEAR: i64 = 2;
/// Local maxima of a window so many cells to each side.
const WINDOW: i64 = 4;
/// Of the strongest response.
const MIN_SHARE: f32 = 0.01;

/// The strongest corners of a map, strongest first.
pub(crate) fn corners(raster: &Raster) -> Vec<Corner> {
    let (width, height) = (raster.width as i64, raster.height as i64);
    let free = |cell: &Cell| if *cell == Cell::Free { 1.0 } else { 0.0 };
    let response = harris(&Image::new(raster.width, raster.cells.iter().map(free).collect()).blurred(1.2));
    let openness = openness(raster);
    let (wide, box_sum) = (openness.clone().blurred(4.0), openness.summed(15));
    let least = response.values.iter().copied().fold(0.0, f32::max) * MIN_SHARE;
    let mut found: Vec<(f32, usize)> = Vec::new();
    for row in WINDOW..height - WINDOW {
        for column in WINDOW..width - WINDOW {
            let index = (row * width + column) as usize;
            let own = response.values[index];
            if own <= least {
                continue;
            }
            let at = |dx: i64, dy: i64| (index as i64 + dy * width + dx) as usize;
            let is_near = |n: i64| (-n..=n).flat_map(move |y| (-n..=n).map(move |x| (x, y)));
            if is_near(NEAR).any(|(x, y)| raster.cells[at(x, y)] == Cell::Occupied)
                && is_near(WINDOW).all(|(x, y)| {
                    let other = response.values[at(x, y)];
                    other < own || (other == own && at(x, y) >= index)
                })
            {
                found.push((own, index));
            }
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    found.truncate(MAX_CORNERS);
    found.into_iter().map(|(_, index)| corner(raster, &wide, &box_sum, index)).collect()
}

/// Corner response of each cell.
///
/// # Source
/// Harris and Stephens, "A combined corner and edge detector", Alvey Vision Conference, 1988.
fn harris(image: &Image) -> Image {
    let n = image.values.len();
    let mut products = [vec![0.0f32; n], vec![0.0f32; n], vec![0.0f32; n]];
    let w = image.width;
    for index in (0..n).filter(|&k| image.is_inside(k)) {
        let v = |dx: i64, dy: i64| image.values[(index as i64 + dy * w as i64 + dx) as usize];
        let x = v(1, 1) + 2.0 * v(1, 0) + v(1, -1) - v(-1, 1) - 2.0 * v(-1, 0) - v(-1, -1);
        let y = v(1, 1) + 2.0 * v(0, 1) + v(-1, 1) - v(1, -1) - 2.0 * v(0, -1) - v(-1, -1);
        products[0][index] = x * x;
        products[1][index] = x * y;
        products[2][index] = y * y;
    }
    let [xx, xy, yy] = products.map(|values| Image::new(w, values).summed(7));
    let response = |k: usize| {
        let (a, b, d) = (xx.values[k], xy.values[k], yy.values[k]);
        a * d - b * b - HARRIS_K * (a + d) * (a + d)
    };
    Image::new(w, (0..n).map(response).collect())
}

fn corner(raster: &Raster, wide: &Image, box_sum: &Image, index: usize) -> Corner {
    let slope = wide.slope(index);
    let angle_rad = libm::atan2(f64::from(slope[1]), f64::from(slope[0]));
    let at = raster.middle(index);
    let (mut rays_m, mut is_known) = ([0.0; N_RAYS], [0.0; N_RAYS]);
    for k in 0..N_RAYS {
        let (sin, cos) = libm::sincos(angle_rad + TAU * k as f64 / N_RAYS as f64);
        (rays_m[k], is_known[k]) = (MAX_RAY_M, 1.0);
        for step in FIRST_STEP..=LAST_STEP {
            let far_m = step as f64 * CELL_M;
            match raster.at([at[0] + cos * far_m, at[1] + sin * far_m]) {
                Cell::Free => continue,
                Cell::Occupied => rays_m[k] = far_m as f32,
                Cell::Unknown => (rays_m[k], is_known[k]) = (far_m as f32, 0.0),
            }
            break;
        }
        rays_m[k] = rays_m[k].min(MAX_SIGNATURE_M);
    }
    Corner { at, angle_rad, rays_m, is_known, openness: box_sum.values[index] / 225.0 }
}

impl Corner {
    /// Cost of matching this corner of a SLAM map with one of the reference. A ray that ended in the unknown may be longer,
    /// not shorter.
    pub(crate) fn cost(&self, reference: &Self) -> f32 {
        let mut sum = 0.0;
        for k in 0..N_RAYS {
            let d = self.rays_m[k] - reference.rays_m[k];
            let known = self.is_known[k];
            let off = known * d.abs() + (1.0 - known) * 0.7 * d.clamp(0.0, 0.8);
            sum += off.min(0.8);
        }
        sum / N_RAYS as f32 + 0.8 * (self.openness - reference.openness).abs()
    }
}
