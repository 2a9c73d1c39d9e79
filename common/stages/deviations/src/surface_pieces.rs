//! Pieces of sides: the surfaces of one element in one square and of one direction, as one observation of the distortion.

use crate::thresholds::{DISTORTION_CELL_M, MAX_DISTORTION_M, MIN_PIECE};
use std::collections::BTreeMap;
use std::f64::consts::PI;

/// A surface found along the normal of an element's side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfaceOffset {
    pub(crate) at: [f64; 2],
    pub(crate) normal: [f64; 2],
    /// Its offset along the outward normal.
    pub(crate) offset_m: f64,
    /// First element of the wall with all of its leafs, or the element.
    pub(crate) body: u32,
}

/// A piece of a side.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfacePiece {
    /// Middle of its samples.
    pub(crate) at: [f64; 2],
    pub(crate) normal: [f64; 2],
    /// Median of the offsets.
    pub(crate) offset_m: f64,
    pub(crate) body: u32,
    pub(crate) n: usize,
}

/// Normals that differ by less than a quarter of a right angle are of one direction.
const DIRECTIONS: i32 = 16;

/// The pieces of all bodies; those of a stray sample or two are left out.
pub(crate) fn surface_pieces(offsets: impl Iterator<Item = SurfaceOffset>) -> Vec<SurfacePiece> {
    let mut groups: BTreeMap<(u32, [i32; 2], i32), Vec<SurfaceOffset>> = BTreeMap::new();
    for surface in offsets.filter(|surface| surface.offset_m.abs() <= MAX_DISTORTION_M) {
        let angle = libm::atan2(surface.normal[1], surface.normal[0]);
        let direction = (angle / (2.0 * PI) * f64::from(DIRECTIONS)).round() as i32;
        let key = (surface.body, square_of(surface.at), direction.rem_euclid(DIRECTIONS));
        groups.entry(key).or_default().push(surface);
    }
    groups.into_values().filter(|group| group.len() >= MIN_PIECE).map(piece).collect()
}

fn piece(mut group: Vec<SurfaceOffset>) -> SurfacePiece {
    group.sort_by(|a, b| a.offset_m.total_cmp(&b.offset_m));
    let n = group.len();
    let mean = |of: fn(&SurfaceOffset) -> [f64; 2]| {
        let sum = group.iter().map(of).fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
        sum.map(|c| c / n as f64)
    };
    let normal = mean(|surface| surface.normal);
    let length = libm::hypot(normal[0], normal[1]);
    SurfacePiece {
        at: mean(|surface| surface.at),
        normal: normal.map(|c| c / length),
        offset_m: group[n / 2].offset_m,
        body: group[0].body,
        n,
    }
}

pub(crate) fn square_of(at: [f64; 2]) -> [i32; 2] {
    at.map(|c| (c / DISTORTION_CELL_M).floor() as i32)
}

/// The middle of a square.
pub(crate) fn middle_of(square: [i32; 2]) -> [f64; 2] {
    square.map(|c| (f64::from(c) + 0.5) * DISTORTION_CELL_M)
}
