//! Places that tell poses apart: the robot has not seen them, can drive there, and finds a wall by one pose and none by
//! another.

use crate::alignment::AlignedPose;
use crate::decision::DecidingPlace;
use crate::features::Features;
use crate::pose::Pose;
use crate::prepared_map::{PreparedMap, between_cells};
use frames::{Map, Slam};
use grid::LineOfSight;
use occupancy::Cell;
use std::collections::VecDeque;

/// What tells poses of a SLAM map apart.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Distinction {
    /// Places where the model differs, the best first: much differs in view there, and the way is short.
    pub places: Vec<DecidingPlace>,
    /// Pairs of poses, by index, that nothing tells apart that the robot can reach.
    pub undecided: Vec<[usize; 2]>,
}

/// Poses that are compared; those beyond are left to a later search, which has fewer.
pub const MAX_COMPARED_POSES: usize = 8;

/// Side of the cells in which places are looked for, in metres.
const STEP_M: f64 = 0.1;
/// Distance that a robot keeps from walls, in metres: less than half of a narrow door.
const CLEARANCE_M: f64 = 0.25;
/// Walls nearer than this are the same, in metres: maps are distorted by so much.
const SAME_WALL_M: f64 = 0.3;
/// A gap between free cells on both sides that is no wall is a door, up to so many metres to each side.
const DOOR_REACH_M: f64 = 0.4;
/// Distance at which every lidar sees a wall, in metres.
const VIEW_M: f64 = 8.0;
/// Shorter walls that differ may be furniture or noise, in metres.
const MIN_DIFFERING_M: f64 = 0.5;
/// One view for each square of this side, in metres.
const VIEW_STEP_M: f64 = 1.0;
/// Views from which walls are looked at, those with the shortest way first.
const MAX_VIEWS: usize = 1000;
/// A way of so many metres halves what a place is worth.
const HALVING_WAY_M: f64 = 10.0;
/// Places that are told, and their distance from each other in metres.
const MAX_PLACES: usize = 3;
const PLACE_SPACING_M: f64 = 3.0;

/// The places that would decide between poses, of which those beyond [`MAX_COMPARED_POSES`] are ignored.
pub fn distinction(
    references: &[impl AsRef<PreparedMap<Map>>],
    slam: &PreparedMap<Slam>,
    poses: &[AlignedPose],
) -> Distinction {
    let poses = &poses[..poses.len().min(MAX_COMPARED_POSES)];
    let all_pairs: Vec<[usize; 2]> =
        (0..poses.len()).flat_map(|first| (first + 1..poses.len()).map(move |second| [first, second])).collect();
    let placed: Vec<PlacedReference<'_>> = poses
        .iter()
        .map(|pose| {
            let reference = references[pose.reference].as_ref();
            PlacedReference { features: &reference.features, pose: between_cells(reference, slam, &pose.map_from_slam) }
        })
        .collect();
    let Some(window) = Window::common(&placed) else {
        return Distinction { places: Vec::new(), undecided: all_pairs };
    };
    let reached = Reached::of(window, slam, &placed, &all_pairs);
    let sight = LineOfSight::new(&reached.opaque(), reached.window.width);
    let mut views: Vec<View> = reached.views().into_iter().map(|view| reached.seen_from(&sight, view)).collect();
    views.retain(|view| view.decided != 0);
    let worth = |view: &View| view.differing_m / (HALVING_WAY_M + view.way_m);
    views.sort_by(|a, b| worth(b).total_cmp(&worth(a)));
    let mut chosen: Vec<View> = Vec::new();
    for view in views {
        let is_apart = |other: &View| distance_m(other.at, view.at) >= PLACE_SPACING_M;
        if chosen.len() < MAX_PLACES && chosen.iter().all(is_apart) {
            chosen.push(view);
        }
    }
    let pairs_of = |mask: u32| bits(mask).map(|pair| all_pairs[pair]).collect::<Vec<_>>();
    let places = chosen.iter().map(|view| {
        let in_slam_m = slam.frame_from_cells().apply(view.at);
        DecidingPlace {
            in_slam_m,
            in_map_m: poses.iter().map(|pose| pose.map_from_slam.apply(in_slam_m)).collect(),
            way_m: view.way_m,
            differing_m: view.differing_m,
            decided: pairs_of(view.decided),
        }
    });
    let places: Vec<DecidingPlace> = places.collect();
    let is_decided = |pair: usize| reached.differing_m(pair) >= MIN_DIFFERING_M;
    let undecided = (0..all_pairs.len()).filter(|&pair| !is_decided(pair)).map(|pair| all_pairs[pair]).collect();
    Distinction { places, undecided }
}

/// A map of the model as the SLAM map lies in it by a pose.
struct PlacedReference<'a> {
    features: &'a Features,
    pose: Pose,
}

/// What a map of the model shows at a place.
#[derive(Clone, Copy)]
struct Look {
    /// A robot can stand there.
    is_passable: bool,
    /// A wall is nearer than a robot can come.
    is_blocked: bool,
    /// Free, and no wall is anywhere near.
    is_open: bool,
}

impl PlacedReference<'_> {
    fn look(&self, at: [f64; 2]) -> Look {
        let place = self.pose.apply(at);
        let cell = self.features.raster.at(place);
        let wall_m = self.features.nearest(place).map_or(f64::INFINITY, |(_, squared)| squared.sqrt());
        let is_way = cell == Cell::Free || (cell == Cell::Unknown && self.is_doorway(place));
        Look {
            is_passable: is_way && CLEARANCE_M <= wall_m,
            is_blocked: cell == Cell::Occupied || wall_m < CLEARANCE_M,
            is_open: cell == Cell::Free && CLEARANCE_M + SAME_WALL_M < wall_m,
        }
    }

    /// True for an unknown cell between free ones: maps for localization do not show doors.
    fn is_doorway(&self, [x, y]: [f64; 2]) -> bool {
        let is_free_towards = |dx: f64, dy: f64| {
            let steps = (DOOR_REACH_M / STEP_M) as i32;
            let at = |step: i32| [x + dx * f64::from(step) * STEP_M, y + dy * f64::from(step) * STEP_M];
            (1..=steps).any(|step| self.features.raster.at(at(step)) == Cell::Free)
        };
        [[1.0, 0.0], [0.0, 1.0], [0.7, 0.7], [0.7, -0.7]]
            .iter()
            .any(|[dx, dy]| is_free_towards(*dx, *dy) && is_free_towards(-dx, -dy))
    }
}

/// Square cells over a part of the plane, in the frame of the SLAM map's cells.
struct Window {
    corner: [f64; 2],
    width: usize,
    height: usize,
}

impl Window {
    /// The bounds of what all references show; `None` if that is nothing.
    fn common(placed: &[PlacedReference<'_>]) -> Option<Self> {
        let (mut lo, mut hi) = ([f64::NEG_INFINITY; 2], [f64::INFINITY; 2]);
        for PlacedReference { features, pose } in placed {
            let [wide, high] = [features.raster.width, features.raster.height].map(|n| n as f64 * occupancy::CELL_M);
            let corners = [[0.0, 0.0], [wide, 0.0], [0.0, high], [wide, high]].map(|p| pose.apply_inverse(p));
            for k in 0..2 {
                lo[k] = corners.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min).max(lo[k]);
                hi[k] = corners.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max).min(hi[k]);
            }
        }
        let [width, height] = [0, 1].map(|k| ((hi[k] - lo[k]) / STEP_M).max(0.0) as usize);
        (lo.iter().chain(&hi).all(|c| c.is_finite()) && width > 0 && height > 0).then_some(Self {
            corner: lo,
            width,
            height,
        })
    }

    fn middle(&self, cell: usize) -> [f64; 2] {
        let at = [cell % self.width, cell / self.width];
        [0, 1].map(|k| self.corner[k] + (at[k] as f64 + 0.5) * STEP_M)
    }

    /// The place in cells from the corner, as [`LineOfSight`] takes it.
    fn in_cells(&self, cell: usize) -> [f64; 2] {
        [(cell % self.width) as f64 + 0.5, (cell / self.width) as f64 + 0.5]
    }

    /// The cells that share a side with one.
    fn beside(&self, cell: usize) -> impl Iterator<Item = usize> + use<> {
        let (width, height, column, row) = (self.width, self.height, cell % self.width, cell / self.width);
        let left = (column > 0).then(|| cell - 1);
        let right = (column + 1 < width).then(|| cell + 1);
        let below = (row > 0).then(|| cell - width);
        let above = (row + 1 < height).then(|| cell + width);
        [left, right, below, above].into_iter().flatten()
    }
}

/// A cell beside the reached ones where a wall stands by one pose and not by another.
struct Difference {
    cell: usize,
    /// The reached cell from which it was met.
    from: usize,
    /// A bit for each pair of poses that it tells apart.
    pairs: u32,
}

/// Where the robot gets to from what it has seen, whichever pose is right.
struct Reached {
    window: Window,
    n_pairs: usize,
    /// Steps from the nearest cell that was seen free, which has 0; [`NOT_REACHED`] elsewhere.
    steps: Vec<u32>,
    /// Unseen cells that were reached, in order of steps.
    order: Vec<usize>,
    differences: Vec<Difference>,
}

const NOT_REACHED: u32 = u32::MAX;
/// Met from a cell beside it; nobody gets there whichever pose is right.
const MET: u32 = u32::MAX - 1;

impl Reached {
    fn of(window: Window, slam: &PreparedMap<Slam>, placed: &[PlacedReference<'_>], all_pairs: &[[usize; 2]]) -> Self {
        let n = window.width * window.height;
        let seen = |cell: usize| slam.features.raster.at(window.middle(cell));
        let mut steps: Vec<u32> = (0..n).map(|cell| if seen(cell) == Cell::Free { 0 } else { NOT_REACHED }).collect();
        let mut queue: VecDeque<usize> = (0..n).filter(|&cell| steps[cell] == 0).collect();
        let (mut order, mut differences) = (Vec::new(), Vec::new());
        while let Some(from) = queue.pop_front() {
            for cell in window.beside(from) {
                if steps[cell] != NOT_REACHED || seen(cell) != Cell::Unknown {
                    continue;
                }
                let looks: Vec<Look> = placed.iter().map(|reference| reference.look(window.middle(cell))).collect();
                if looks.iter().all(|look| look.is_passable) {
                    steps[cell] = steps[from] + 1;
                    order.push(cell);
                    queue.push_back(cell);
                    continue;
                }
                steps[cell] = MET;
                let differs = |[a, b]: [usize; 2]| {
                    let (a, b) = (looks[a], looks[b]);
                    (a.is_blocked && b.is_open) || (b.is_blocked && a.is_open)
                };
                let told_apart = all_pairs.iter().enumerate().filter(|(_, pair)| differs(**pair));
                let pairs = told_apart.fold(0u32, |mask, (pair, _)| mask | 1 << pair);
                if pairs != 0 {
                    differences.push(Difference { cell, from, pairs });
                }
            }
        }
        Self { window, n_pairs: all_pairs.len(), steps, order, differences }
    }

    /// True for each cell that a look does not pass.
    fn opaque(&self) -> Vec<bool> {
        self.steps.iter().map(|steps| *steps >= MET).collect()
    }

    /// Length of the walls that tell a pair of poses apart.
    fn differing_m(&self, pair: usize) -> f64 {
        self.differences.iter().filter(|difference| difference.pairs & 1 << pair != 0).count() as f64 * STEP_M
    }

    /// Unseen cells from which to look, each with the cell of the eye: the nearest of each square, and where all that differs
    /// begins behind what was seen, the difference itself.
    fn views(&self) -> Vec<[usize; 2]> {
        let side = (VIEW_STEP_M / STEP_M) as usize;
        let n_columns = self.window.width.div_ceil(side);
        let mut is_taken = vec![false; n_columns * self.window.height.div_ceil(side)];
        let of_differences = self.differences.iter().filter(|difference| self.steps[difference.from] == 0);
        let all = of_differences.map(|d| [d.cell, d.from]).chain(self.order.iter().map(|&cell| [cell, cell]));
        let square = |cell: usize| cell / self.window.width / side * n_columns + cell % self.window.width / side;
        all.filter(|[cell, _]| !std::mem::replace(&mut is_taken[square(*cell)], true)).take(MAX_VIEWS).collect()
    }

    /// What differs in view of an eye.
    fn seen_from(&self, sight: &LineOfSight, [cell, eye]: [usize; 2]) -> View {
        let from = self.window.in_cells(eye);
        let mut counts = vec![0u32; self.n_pairs];
        for difference in &self.differences {
            let to = self.window.in_cells(difference.from);
            if distance_m(from, to) * STEP_M <= VIEW_M && sight.is_clear(from, to) {
                bits(difference.pairs).for_each(|pair| counts[pair] += 1);
            }
        }
        let is_decided = |count: u32| f64::from(count) * STEP_M >= MIN_DIFFERING_M;
        let decided = (0..self.n_pairs).filter(|&pair| is_decided(counts[pair])).fold(0, |mask, pair| mask | 1 << pair);
        let total = counts.iter().sum::<u32>();
        View {
            at: self.window.middle(cell),
            way_m: f64::from(self.steps[eye]) * STEP_M,
            differing_m: f64::from(total) * STEP_M / self.n_pairs as f64,
            decided,
        }
    }
}

/// A place with what differs in view there.
struct View {
    /// In the frame of the SLAM map's cells.
    at: [f64; 2],
    way_m: f64,
    differing_m: f64,
    /// A bit for each pair of poses.
    decided: u32,
}

fn bits(mask: u32) -> impl Iterator<Item = usize> {
    (0..u32::BITS as usize).filter(move |bit| mask & 1 << bit != 0)
}

fn distance_m(a: [f64; 2], b: [f64; 2]) -> f64 {
    libm::hypot(a[0] - b[0], a[1] - b[1])
}
