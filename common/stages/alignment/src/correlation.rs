//! Candidate poses by FFT cross-correlation of wall maps.

use crate::features::Features;
use crate::image::Image;
use crate::pose::Pose;
use crate::wall_points::WallPoint;
use occupancy::CELL_M;
use rustfft::num_complex::Complex32;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// Half of it is what a refinement reaches. With bins of 0.1 m no more true poses were found, in four times the time.
const BIN_M: f64 = 0.2;
const BLUR_BINS: f64 = 1.0;
const N_PEAKS: usize = 24;
const CLEARED_M: f64 = 0.5;

/// What a wall point on the other face of a wall does to the score of a pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum OtherFace {
    /// It counts against the pose, and in a thin wall the two faces take from each other.
    Against,
    /// Nothing: thin walls count like others.
    Ignored,
}

/// The poses in which the most of these wall points of a SLAM map lie on those of the reference, for the given turns; so many at
/// most.
pub(crate) fn correlated(
    slam: &Features,
    wall_points: &[WallPoint],
    reference: &Features,
    turns: &[f64],
    other_face: OtherFace,
    n: usize,
) -> Vec<Pose> {
    let parts = match other_face {
        OtherFace::Against => &[whole as Part][..],
        OtherFace::Ignored => &[across, along],
    };
    let size_of = |f: &Features| [f.raster.width, f.raster.height].map(|n| (n as f64 * CELL_M / BIN_M) as usize + 1);
    let (reference_size, slam_size) = (size_of(reference), size_of(slam));
    // Turned, the SLAM map is as wide as its diagonal at most.
    let diagonal = libm::hypot(slam_size[0] as f64, slam_size[1] as f64).ceil() as usize + 2;
    let size = reference_size.map(|n| smooth(n + diagonal));
    let mut plane = Plane::new(size);
    let walls: Vec<Vec<Complex32>> = parts
        .iter()
        .map(|part| {
            let mut walls = reference_plane(reference, size, *part);
            plane.forward(&mut walls);
            walls
        })
        .collect();
    let mut sum = vec![Complex32::default(); size[0] * size[1]];
    let mut poses: Vec<(f32, Pose)> = Vec::new();
    for &turn in turns {
        let turned = Pose::new([0.0; 2], turn);
        let middle = [slam.raster.width, slam.raster.height].map(|n| n as f64 * CELL_M / 2.0);
        let turned_middle = turned.rotate(middle);
        // The corner of the square that holds the turned map.
        let corner = turned_middle.map(|c| c - diagonal as f64 * BIN_M / 2.0);
        sum.fill(Complex32::default());
        for (part, walls) in parts.iter().zip(&walls) {
            let mut own = normal_plane(wall_points, &turned, corner, size, *part);
            plane.forward(&mut own);
            sum.iter_mut().zip(own.iter().zip(walls)).for_each(|(sum, (own, walls))| *sum += walls * own.conj());
        }
        plane.backward(&mut sum);
        let mut scores: Vec<f32> = sum.iter().map(|c| c.re).collect();
        for (score, shift) in peaks(&mut scores, size, diagonal) {
            let t = [0, 1].map(|k| shift[k] as f64 * BIN_M - corner[k]);
            poses.push((score, Pose::new(t, turn)));
        }
    }
    poses.sort_by(|a, b| b.0.total_cmp(&a.0));
    poses.truncate(n);
    poses.into_iter().map(|p| p.1).collect()
}

/// Normals of wall points as complex numbers, at most of length 1 in a bin, and blurred.
///
/// What is free in one map and occupied in the other is not compared: free cells share their bins with the walls beside them, which
/// kept true poses from being found.
fn reference_plane(reference: &Features, size: [usize; 2], part: Part) -> Vec<Complex32> {
    let normals = normal_plane(reference.wall_points(), &Pose::new([0.0; 2], 0.0), [0.0; 2], size, part);
    let part = |of: fn(&Complex32) -> f32| Image::new(size[0], normals.iter().map(of).collect()).blurred(BLUR_BINS);
    let (x, y) = (part(|c| c.re), part(|c| c.im));
    x.values.iter().zip(&y.values).map(|(re, im)| Complex32::new(*re, *im)).collect()
}

/// What a plane has of a normal.
type Part = fn([f64; 2]) -> [f64; 2];

fn whole(normal: [f64; 2]) -> [f64; 2] {
    normal
}

/// Of the first coordinate both directions apart, so that opposite normals do not meet.
fn across([x, _]: [f64; 2]) -> [f64; 2] {
    [x.max(0.0), (-x).max(0.0)]
}

/// The same of the second.
fn along([_, y]: [f64; 2]) -> [f64; 2] {
    across([y, 0.0])
}

fn normal_plane(
    wall_points: &[WallPoint],
    turned: &Pose,
    corner: [f64; 2],
    size: [usize; 2],
    part: Part,
) -> Vec<Complex32> {
    let mut plane = vec![Complex32::default(); size[0] * size[1]];
    for wall_point in wall_points {
        let (p, n) = (turned.rotate(wall_point.at), part(turned.rotate(wall_point.normal)));
        let [x, y] = [0, 1].map(|k| (((p[k] - corner[k]) / BIN_M) as usize).min(size[k] - 1));
        plane[y * size[0] + x] += Complex32::new((n[0] * wall_point.weight) as f32, (n[1] * wall_point.weight) as f32);
    }
    for c in &mut plane {
        let length = c.norm();
        if length > 1.0 {
            *c /= length;
        }
    }
    plane
}

/// The best shifts, in bins: where the corner of the SLAM map's square comes to lie.
fn peaks(scores: &mut [f32], size: [usize; 2], diagonal: usize) -> Vec<(f32, [i64; 2])> {
    let cleared = (CLEARED_M / BIN_M) as i64;
    let mut found = Vec::new();
    for _ in 0..N_PEAKS {
        let best = (0..scores.len()).max_by(|&a, &b| scores[a].total_cmp(&scores[b]).then(b.cmp(&a)));
        let Some(best) = best.filter(|&b| scores[b] > 0.0) else { break };
        let at = [(best % size[0]) as i64, (best / size[0]) as i64];
        // Shifts beyond what the padding holds are those to the other side.
        let shift =
            [0, 1].map(|k| if at[k] >= size[k] as i64 - diagonal as i64 { at[k] - size[k] as i64 } else { at[k] });
        found.push((scores[best], shift));
        for dy in -cleared..=cleared {
            for dx in -cleared..=cleared {
                let [x, y] = [(at[0] + dx).rem_euclid(size[0] as i64), (at[1] + dy).rem_euclid(size[1] as i64)];
                scores[y as usize * size[0] + x as usize] = 0.0;
            }
        }
    }
    found
}

/// The next number that has no prime factor above 5.
fn smooth(n: usize) -> usize {
    let is_smooth = |&n: &usize| {
        let mut rest = n;
        for factor in [2, 3, 5] {
            while rest.is_multiple_of(factor) {
                rest /= factor;
            }
        }
        rest == 1
    };
    (n.max(1)..).find(is_smooth).unwrap_or(n)
}

/// Transforms of planes of one size.
struct Plane {
    size: [usize; 2],
    forward: [Arc<dyn Fft<f32>>; 2],
    backward: [Arc<dyn Fft<f32>>; 2],
    turned: Vec<Complex32>,
    scratch: Vec<Complex32>,
}

impl Plane {
    fn new(size: [usize; 2]) -> Self {
        let mut planner = FftPlanner::new();
        let forward = size.map(|n| planner.plan_fft_forward(n));
        let backward = size.map(|n| planner.plan_fft_inverse(n));
        let longest = forward.iter().chain(&backward).map(|f| f.get_inplace_scratch_len()).max().unwrap_or(0);
        let turned = vec![Complex32::default(); size[0] * size[1]];
        Self { size, forward, backward, turned, scratch: vec![Complex32::default(); longest] }
    }

    fn forward(&mut self, plane: &mut [Complex32]) {
        let ffts = self.forward.clone();
        self.transform(plane, &ffts);
    }

    fn backward(&mut self, plane: &mut [Complex32]) {
        let ffts = self.backward.clone();
        self.transform(plane, &ffts);
    }

    fn transform(&mut self, plane: &mut [Complex32], ffts: &[Arc<dyn Fft<f32>>; 2]) {
        let [w, h] = self.size;
        ffts[0].process_with_scratch(plane, &mut self.scratch);
        transpose(plane, &mut self.turned, w, h);
        ffts[1].process_with_scratch(&mut self.turned, &mut self.scratch);
        transpose(&self.turned, plane, h, w);
    }
}

/// Rows become columns, a tile at a time.
fn transpose(from: &[Complex32], to: &mut [Complex32], width: usize, height: usize) {
    const TILE: usize = 32;
    for row in (0..height).step_by(TILE) {
        for column in (0..width).step_by(TILE) {
            for y in row..(row + TILE).min(height) {
                for x in column..(column + TILE).min(width) {
                    to[x * height + y] = from[y * width + x];
                }
            }
        }
    }
}
