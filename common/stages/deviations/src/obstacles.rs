//! Obstacles in the SLAM map that no element of the model explains.

use crate::bend::Bends;
use crate::evidence::Evidence;
use crate::sections::Sections;
use crate::slam_view::SlamView;
use crate::thresholds::*;
use geometry::{FillRule, MultiPolygon, Polygon, Ring};
use messages::{DoorRecord, Observation, Site};
use occupancy::Cell;

/// Something that is not in the model.
pub(crate) struct Obstacle {
    pub(crate) area: MultiPolygon,
    pub(crate) length_m: f64,
}

/// What explains a surface beside the elements in their places.
pub(crate) struct Explained<'a> {
    pub(crate) sections: &'a Sections,
    /// By cut.
    pub(crate) evidence: &'a [Evidence],
    pub(crate) bends: &'a Bends,
    /// Of the pose.
    pub(crate) deviation_m: f64,
    /// Lower left and upper right corner of where obstacles are looked for, in `map`.
    pub(crate) bounds_m: [[f64; 2]; 2],
}

/// Obstacles from large to small, and how many occupied cells lie outside of the storey.
pub(crate) fn obstacles(site: &Site<'_>, slam: &SlamView, explained: &Explained<'_>) -> (Vec<Obstacle>, u32) {
    let mut n_outside = 0;
    let mut is_strange = vec![false; slam.cells.len()];
    for (index, cell) in slam.cells.iter().enumerate() {
        if *cell != Cell::Occupied || !within(slam, index, 1).any(|n| slam.cells[n] == Cell::Free) {
            continue;
        }
        let at = slam.middle(index);
        if explained.is_outside(at) {
            n_outside += 1;
        } else {
            is_strange[index] = !explained.is_explained(slam, at);
        }
    }
    let mut found: Vec<Obstacle> =
        groups(slam, &is_strange).into_iter().filter_map(|cells| obstacle(site, slam, &is_strange, &cells)).collect();
    found.sort_by(|a, b| b.area.area_m2().total_cmp(&a.area.area_m2()));
    (found, n_outside)
}

impl Explained<'_> {
    fn is_outside(&self, at: [f64; 2]) -> bool {
        let [min, max] = self.bounds_m;
        (0..2).any(|k| at[k] < min[k] || max[k] < at[k])
    }

    fn is_explained(&self, slam: &SlamView, seen_at: [f64; 2]) -> bool {
        let bend = self.bends.at(seen_at, None);
        let at = [0, 1].map(|k| seen_at[k] - bend.by_m[k]);
        let tolerance_m = slam.cell_m + SAME_SIDE_M + bend.worst_m().min(self.deviation_m + BENT_M);
        if self.sections.explains(at, tolerance_m) {
            return true;
        }
        let moved = self.evidence.iter().zip(0..).filter(|(e, _)| e.observation == Observation::Displaced);
        moved.into_iter().any(|(e, cut)| {
            let back = [0, 1].map(|k| at[k] - e.shift.by_m[k]);
            self.sections.explained_by(cut, back, tolerance_m)
        })
    }
}

/// Cells of things that hang together, gaps of a cell included.
fn groups(slam: &SlamView, is_strange: &[bool]) -> Vec<Vec<usize>> {
    let mut is_met = vec![false; is_strange.len()];
    let mut groups = Vec::new();
    for start in 0..is_strange.len() {
        if !is_strange[start] || is_met[start] {
            continue;
        }
        is_met[start] = true;
        let mut group = vec![start];
        let mut next = 0;
        while next < group.len() {
            for near in within(slam, group[next], 2) {
                if is_strange[near] && !is_met[near] {
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
fn obstacle(site: &Site<'_>, slam: &SlamView, is_strange: &[bool], cells: &[usize]) -> Option<Obstacle> {
    let area = slam.cell_m * slam.cell_m * cells.len() as f64;
    let length_m = longest(slam, cells);
    let is_large = length_m >= LEAST_LENGTH_M || area >= LEAST_AREA_M2;
    if cells.len() < LEAST_CELLS || !is_large || is_leaf(site, slam, cells, length_m) {
        return None;
    }
    Some(Obstacle { area: outline(slam, is_strange, cells), length_m })
}

/// The longer side of the box around cells, along the axes of the SLAM map.
fn longest(slam: &SlamView, cells: &[usize]) -> f64 {
    let side = |of: &dyn Fn(usize) -> usize| {
        let (lo, hi) = cells.iter().fold((usize::MAX, 0), |(lo, hi), c| (lo.min(of(*c)), hi.max(of(*c))));
        (hi + 1 - lo) as f64 * slam.cell_m
    };
    let [wide, high] = [side(&|c| c % slam.width), side(&|c| c / slam.width)];
    wide.max(high)
}

/// True if a door's open leaf can be all of it: within its swing, and no longer than it is wide.
fn is_leaf(site: &Site<'_>, slam: &SlamView, cells: &[usize], length_m: f64) -> bool {
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
fn outline(slam: &SlamView, is_strange: &[bool], cells: &[usize]) -> MultiPolygon {
    let mut grown: Vec<usize> = cells.iter().flat_map(|c| within(slam, *c, 1)).collect();
    grown.sort_unstable();
    grown.dedup();
    let is_inner = |cell: &usize| is_strange[*cell] || within(slam, *cell, 1).all(|n| grown.binary_search(&n).is_ok());
    let squares: Vec<Ring> = grown.iter().filter(|c| is_inner(c)).map(|c| square(slam, *c)).collect();
    // Cells are united on whole numbers, and turned into the map afterwards: what is straight stays so.
    let united = geometry::union(&squares, FillRule::NonZero);
    let turned = |ring: &Ring| -> Ring {
        let place = |p: &[i32; 2]| slam.map_from_cells.apply(p.map(|c| f64::from(c) * slam.cell_m));
        ring.iter().map(|p| place(p).map(|c| frames::tenths(c).unwrap_or(0))).collect()
    };
    let polygon = |p: &Polygon| Polygon { exterior: turned(&p.exterior), holes: p.holes.iter().map(turned).collect() };
    MultiPolygon(united.0.iter().map(polygon).collect())
}

fn square(slam: &SlamView, cell: usize) -> Ring {
    let [x, y] = [(cell % slam.width) as i32, (cell / slam.width) as i32];
    vec![[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]]
}

/// Cells up to `reach` away, itself included, as far as they lie in the map.
fn within(slam: &SlamView, cell: usize, reach: i64) -> impl Iterator<Item = usize> {
    let (width, height) = (slam.width as i64, slam.height() as i64);
    let [column, row] = [(cell % slam.width) as i64, (cell / slam.width) as i64];
    let steps = (-reach..=reach).flat_map(move |dy| (-reach..=reach).map(move |dx| [column + dx, row + dy]));
    let inside = steps.filter(move |[x, y]| 0 <= *x && *x < width && 0 <= *y && *y < height);
    inside.map(move |[x, y]| (y * width + x) as usize)
}
