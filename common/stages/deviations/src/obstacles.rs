//! Obstacles in the SLAM map that no element of the model explains.

use crate::distortion::{Distortion, DistortionField};
use crate::evidence::Evidence;
use crate::sections::Sections;
use crate::slam_view::SlamView;
use crate::surface_pieces::{middle_of, square_of};
use crate::thresholds::*;
use geometry::{FillRule, MultiPolygon, Polygon, Ring};
use messages::{DoorRecord, Observation, Site};
use occupancy::Cell;
use std::collections::BTreeMap;

/// An obstacle that is not in the model.
pub(crate) struct Obstacle {
    pub(crate) area: MultiPolygon,
    pub(crate) length_m: f64,
}

/// Inputs that explain surfaces of the SLAM map.
pub(crate) struct KnownSurfaces<'a> {
    pub(crate) sections: &'a Sections,
    /// By cut.
    pub(crate) evidence: &'a [Evidence],
    pub(crate) distortions: &'a DistortionField,
    /// Of the pose.
    pub(crate) deviation_m: f64,
    /// Lower left and upper right corner of the searched area, in `map`.
    pub(crate) bounds_m: [[f64; 2]; 2],
}

/// Obstacles from large to small, and how many occupied cells lie outside of the storey.
pub(crate) fn obstacles(site: &Site<'_>, slam: &SlamView<'_>, known: &KnownSurfaces<'_>) -> (Vec<Obstacle>, u32) {
    let mut n_outside = 0;
    let mut is_unexplained = vec![false; slam.cells.len()];
    let mut local: BTreeMap<[i32; 2], Distortion> = BTreeMap::new();
    for (index, cell) in slam.cells.iter().enumerate() {
        if *cell != Cell::Occupied || !within(slam, index, 1).any(|n| slam.cells[n] == Cell::Free) {
            continue;
        }
        let at = slam.middle(index);
        if known.is_outside(at) {
            n_outside += 1;
        } else {
            let square = square_of(at);
            let distortion = local.entry(square).or_insert_with(|| known.distortions.at(middle_of(square), None));
            is_unexplained[index] = !known.is_explained(slam, at, distortion);
        }
    }
    let mut found: Vec<Obstacle> = groups(slam, &is_unexplained)
        .into_iter()
        .filter_map(|cells| obstacle(site, slam, &is_unexplained, &cells))
        .collect();
    found.sort_by(|a, b| b.area.area_m2().total_cmp(&a.area.area_m2()));
    (found, n_outside)
}

impl KnownSurfaces<'_> {
    fn is_outside(&self, at: [f64; 2]) -> bool {
        let [min, max] = self.bounds_m;
        (0..2).any(|k| at[k] < min[k] || max[k] < at[k])
    }

    fn is_explained(&self, slam: &SlamView<'_>, seen_at: [f64; 2], distortion: &Distortion) -> bool {
        let at = [0, 1].map(|k| seen_at[k] - distortion.by_m[k]);
        let tolerance_m =
            slam.cell_m + SAME_SIDE_M + (WITHIN * distortion.worst_m()).min(self.deviation_m + OBSTACLE_DISTORTION_M);
        if self.sections.explains(at, tolerance_m) {
            return true;
        }
        let moved = self.evidence.iter().zip(0..).filter(|(e, _)| e.observation == Observation::Displaced);
        moved.into_iter().any(|(e, cut)| {
            let back = [0, 1].map(|k| at[k] - e.displacement.by_m[k]);
            self.sections.explained_by(cut, back, tolerance_m)
        })
    }
}

/// Connected groups of cells, with gaps of one cell.
fn groups(slam: &SlamView<'_>, is_unexplained: &[bool]) -> Vec<Vec<usize>> {
    let mut is_met = vec![false; is_unexplained.len()];
    let mut groups = Vec::new();
    for start in 0..is_unexplained.len() {
        if !is_unexplained[start] || is_met[start] {
            continue;
        }
        is_met[start] = true;
        let mut group = vec![start];
        let mut next = 0;
        while next < group.len() {
            for near in within(slam, group[next], 2) {
                if is_unexplained[near] && !is_met[near] {
                    is_met[near] = true;
                    group.push(near);
                }
            }
            next += 1;
        }
        groups.push(group);
    }
    groups
}

/// The obstacle of a group of cells; `None` if it is too small, or the leaf of a door.
fn obstacle(site: &Site<'_>, slam: &SlamView<'_>, is_unexplained: &[bool], cells: &[usize]) -> Option<Obstacle> {
    let area = slam.cell_m * slam.cell_m * cells.len() as f64;
    let length_m = longest(slam, cells);
    let is_large = length_m >= MIN_LENGTH_M || area >= MIN_AREA_M2;
    if cells.len() < MIN_CELLS || !is_large || is_door_leaf(site, slam, cells, length_m) {
        return None;
    }
    Some(Obstacle { area: outline(slam, is_unexplained, cells), length_m })
}

/// The longer side of the box around cells, along the axes of the SLAM map.
fn longest(slam: &SlamView<'_>, cells: &[usize]) -> f64 {
    let side = |of: &dyn Fn(usize) -> usize| {
        let (lo, hi) = cells.iter().fold((usize::MAX, 0), |(lo, hi), c| (lo.min(of(*c)), hi.max(of(*c))));
        (hi + 1 - lo) as f64 * slam.cell_m
    };
    let [wide, high] = [side(&|c| c % slam.width), side(&|c| c / slam.width)];
    wide.max(high)
}

/// True if it can be the open leaf of a door: within its swing, and not longer than its width.
fn is_door_leaf(site: &Site<'_>, slam: &SlamView<'_>, cells: &[usize], length_m: f64) -> bool {
    let within = |door: &DoorRecord, at: [f64; 2]| {
        let plan = door.passage.to_box();
        let [along, across] = plan.axis;
        let d = [0, 1].map(|k| at[k] - plan.centre[k] / f64::from(frames::TENTHS_PER_M));
        let half = plan.half.map(|h| h / f64::from(frames::TENTHS_PER_M));
        let wide_m = door.overall_width_m.max(2.0 * half[0]);
        (d[0] * along + d[1] * across).abs() <= half[0] + BESIDE_M
            && (d[1] * along - d[0] * across).abs() <= half[1] + wide_m + BESIDE_M
            && length_m <= wide_m + BESIDE_M
    };
    site.doors.iter().any(|door| cells.iter().all(|c| within(door, slam.middle(*c))))
}

/// The region of cells, gaps of a cell closed, in `map`.
fn outline(slam: &SlamView<'_>, is_unexplained: &[bool], cells: &[usize]) -> MultiPolygon {
    let mut grown: Vec<usize> = cells.iter().flat_map(|c| within(slam, *c, 1)).collect();
    grown.sort_unstable();
    grown.dedup();
    let is_inner =
        |cell: &usize| is_unexplained[*cell] || within(slam, *cell, 1).all(|n| grown.binary_search(&n).is_ok());
    let squares: Vec<Ring> = grown.iter().filter(|c| is_inner(c)).map(|c| square(slam, *c)).collect();
    // Cells are united on whole numbers, and turned into the map afterwards: what is straight stays so.
    let united = geometry::union(&squares, FillRule::NonZero);
    let turned = |ring: &Ring| -> Ring {
        let place = |p: &[i32; 2]| slam.in_map(p.map(f64::from));
        ring.iter().map(|p| place(p).map(|c| frames::tenths(c).unwrap_or(0))).collect()
    };
    let polygon = |p: &Polygon| Polygon { exterior: turned(&p.exterior), holes: p.holes.iter().map(turned).collect() };
    MultiPolygon(united.0.iter().map(polygon).collect())
}

fn square(slam: &SlamView<'_>, cell: usize) -> Ring {
    let [x, y] = [(cell % slam.width) as i32, (cell / slam.width) as i32];
    vec![[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]]
}

/// Cells up to `reach` away, itself included, as far as they lie in the map.
fn within(slam: &SlamView<'_>, cell: usize, reach: i64) -> impl Iterator<Item = usize> {
    let (width, height) = (slam.width as i64, slam.height() as i64);
    let [column, row] = [(cell % slam.width) as i64, (cell / slam.width) as i64];
    let steps = (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| [column + dx, row + dy]));
    let inside = steps.filter(move |[x, y]| 0 <= *x && *x < width && 0 <= *y && *y < height);
    inside.map(move |[x, y]| (y * width + x) as usize)
}
