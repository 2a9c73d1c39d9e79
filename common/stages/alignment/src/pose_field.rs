//! The pose of a SLAM map from place to place, what it is worth there, and for which part of the map one pose holds.

use crate::map_parts::MapParts;
use crate::part_poses::{PartPose, part_poses};
use crate::prepared_map::{PreparedMap, between_cells};
use frames::{Map, PoseCovariance, Rigid2, Slam, wrapped};
use geometry::{FillRule, MultiPolygon, Polygon, Ring, union};
use messages::{NONE, part_at};
use nalgebra::{Matrix3, Vector3};
use occupancy::{CELL_M, Cell, Raster};
use std::cmp::Reverse;

/// Side of the blocks by which places are found in the field and outlines are drawn, in cells: half a metre.
const BLOCK_CELLS: usize = 10;
pub(crate) const BLOCK_M: f64 = BLOCK_CELLS as f64 * CELL_M;

/// The pose of a part of a SLAM map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalPose {
    /// The middle of the part in the SLAM map, in metres.
    pub about_m: [f64; 2],
    /// Its pose.
    pub map_from_slam: Rigid2<Map, Slam>,
    /// Of where `about_m` lies in the model's map and of yaw.
    pub covariance: PoseCovariance,
    /// Area of its floor.
    pub area_m2: f64,
    /// Length of its walls, and of those that the model has there: by weight, so that furniture counts little.
    pub walls_m: f64,
    /// See `walls_m`.
    pub explained_m: f64,
    /// True if these walls, or the model's that were in sight, bear the pose out; else the parts around foretell it.
    pub is_borne_out: bool,
}

impl LocalPose {
    /// How far a pose of the whole map puts the part from where it lies, in metres.
    fn off_m(&self, whole: &Rigid2<Map, Slam>) -> f64 {
        let (at, by_whole) = (self.map_from_slam.apply(self.about_m), whole.apply(self.about_m));
        libm::hypot(at[0] - by_whole[0], at[1] - by_whole[1])
    }

    /// The mean square of the error of a pose of the whole map here: of x, y and yaw.
    fn error_of(&self, whole: &Rigid2<Map, Slam>) -> Matrix3<f64> {
        let (at, by_whole) = (self.map_from_slam.apply(self.about_m), whole.apply(self.about_m));
        let turn_rad = wrapped(self.map_from_slam.yaw_rad() - whole.yaw_rad());
        let off = Vector3::new(at[0] - by_whole[0], at[1] - by_whole[1], turn_rad);
        Matrix3::from(self.covariance.rows()).transpose() + off * off.transpose()
    }
}

fn covariance(matrix: &Matrix3<f64>) -> PoseCovariance {
    PoseCovariance::from_rows(matrix.transpose().into())
}

/// The poses of all parts of a SLAM map.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseField {
    /// One for each part.
    pub parts: Vec<LocalPose>,
    pub(crate) blocks: Blocks,
}

/// The part of each block of a SLAM map.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Blocks {
    /// Pose of the lower left corner of the blocks in the SLAM map.
    pub(crate) slam_from_blocks: [f64; 3],
    pub(crate) width: usize,
    /// The part that most cells of the block belong to; [`NONE`] without floor.
    pub(crate) of_block: Vec<u32>,
}

/// For which part of a SLAM map a pose holds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PoseExtent {
    /// Outline of that part in the SLAM map: exterior and holes of each piece, in metres.
    pub outline_m: Vec<Vec<Vec<[f64; 2]>>>,
    /// Its share of the map's walls and of its floor.
    pub walls_share: f64,
    /// See `walls_share`.
    pub area_share: f64,
    /// Of the parts that are known: how far the pose puts one from where it lies, at most, in metres.
    pub largest_off_m: f64,
    /// Share of the floor of which is not known how far off the pose is.
    pub unknown_share: f64,
}

/// A pose holds where it is off by no more than this, in metres.
pub const HOLDS_M: f64 = 0.15;
/// A part of which the place is known less well than this is unknown, in metres.
const KNOWN_M: f64 = 0.1;

impl PoseField {
    /// From a pose of the whole map; empty if the SLAM map has no free cells.
    pub fn of(reference: &PreparedMap<Map>, slam: &PreparedMap<Slam>, map_from_slam: &Rigid2<Map, Slam>) -> Self {
        let map = MapParts::of(&slam.features);
        let whole = between_cells(reference, slam, map_from_slam);
        let found = part_poses(&reference.features, &slam.features, &map, &whole);
        // Parts that no link leads to are small pieces far from everything.
        let mut numbers = vec![None; found.len()];
        let mut parts = Vec::new();
        for (k, PartPose { placed, explained }) in
            found.iter().enumerate().filter_map(|(k, part)| Some((k, part.as_ref()?)))
        {
            numbers[k] = Some(parts.len() as u32);
            parts.push(LocalPose {
                about_m: slam.frame_from_cells().apply(map.parts[k].centre),
                map_from_slam: &(reference.frame_from_cells() * &placed.pose) * &slam.frame_from_cells().inverse(),
                covariance: covariance(&placed.covariance).turned(reference.frame_from_cells()),
                area_m2: map.parts[k].n_cells as f64 * CELL_M * CELL_M,
                walls_m: explained.walls_m,
                explained_m: explained.explained_m,
                is_borne_out: explained.is_borne_out,
            });
        }
        let of_cell = |index: usize| map.of_cell(index).and_then(|part| numbers[part]);
        let blocks = Blocks::of(&slam.features.raster, slam.frame_from_cells().x_y_yaw(), of_cell);
        Self { parts, blocks }
    }

    /// The pose of the SLAM map around a place in it, in metres, with the covariance of where that place lies; `None` where
    /// the map shows no floor.
    pub fn at(&self, in_slam_m: [f64; 2]) -> Option<LocalPose> {
        let part = self.parts[self.blocks.part_at(in_slam_m)?];
        let (at, about) = (part.map_from_slam.apply(in_slam_m), part.map_from_slam.apply(part.about_m));
        let covariance = part.covariance.transported([at[0] - about[0], at[1] - about[1]]);
        Some(LocalPose { about_m: in_slam_m, covariance, ..part })
    }

    /// The covariance of where a pose of the whole map puts a place, in metres, and of its yaw: how well the place is known, and how far
    /// off the pose is there. `None` where the map shows no floor.
    pub fn covariance_at(&self, in_slam_m: [f64; 2], whole: &Rigid2<Map, Slam>) -> Option<PoseCovariance> {
        self.at(in_slam_m).map(|local| covariance(&local.error_of(whole)))
    }

    /// The covariance of a pose of the whole map that covers all of it: how far any place of the map lies from where the pose puts
    /// it, on average over its floor. `None` of a map without floor.
    pub fn covariance_of(&self, whole: &Rigid2<Map, Slam>) -> Option<PoseCovariance> {
        let area_m2: f64 = self.parts.iter().map(|part| part.area_m2).sum();
        let sum: Matrix3<f64> = self.parts.iter().map(|part| part.error_of(whole) * (part.area_m2 / area_m2)).sum();
        (!self.parts.is_empty()).then(|| covariance(&sum))
    }

    /// For which part of the map a pose of the whole holds.
    pub fn extent_of(&self, whole: &Rigid2<Map, Slam>) -> PoseExtent {
        let is_known = |part: &LocalPose| part.covariance.worst_m() <= KNOWN_M;
        let holds = |part: &LocalPose| is_known(part) && part.off_m(whole) <= HOLDS_M;
        let share = |of: &dyn Fn(&LocalPose) -> f64, is_in: &dyn Fn(&LocalPose) -> bool| {
            let all: f64 = self.parts.iter().map(of).sum();
            // Of none it is 0, which as a sum would be a negative one.
            let inside = self.parts.iter().filter(|part| is_in(part)).map(of).fold(0.0, |sum, of_part| sum + of_part);
            inside / all.max(f64::MIN_POSITIVE)
        };
        let held: Vec<bool> = self.parts.iter().map(holds).collect();
        PoseExtent {
            outline_m: self.blocks.outline_m(&held),
            walls_share: share(&|part| part.walls_m, &holds),
            area_share: share(&|part| part.area_m2, &holds),
            largest_off_m: self.parts.iter().filter(|p| is_known(p)).map(|p| p.off_m(whole)).fold(0.0, f64::max),
            unknown_share: share(&|part| part.area_m2, &|part| !is_known(part)),
        }
    }
}

impl Blocks {
    fn of(raster: &Raster, slam_from_cells: [f64; 3], of_cell: impl Fn(usize) -> Option<u32>) -> Self {
        let (width, height) = (raster.width.div_ceil(BLOCK_CELLS), raster.height.div_ceil(BLOCK_CELLS));
        let most_frequent = |block: usize| {
            let (column, row) = (block % width * BLOCK_CELLS, block / width * BLOCK_CELLS);
            let rows = row..(row + BLOCK_CELLS).min(raster.height);
            let columns = column..(column + BLOCK_CELLS).min(raster.width);
            let cells = rows.flat_map(|row| columns.clone().map(move |column| row * raster.width + column));
            let free = cells.filter(|index| raster.cells[*index] == Cell::Free);
            let mut parts: Vec<u32> = free.filter_map(&of_cell).collect();
            parts.sort_unstable();
            parts.chunk_by(|a, b| a == b).max_by_key(|same| (same.len(), Reverse(same[0]))).map_or(NONE, |same| same[0])
        };
        let of_block = (0..width * height).map(most_frequent).collect();
        Self { slam_from_blocks: slam_from_cells, width, of_block }
    }

    /// The part of a place, or the nearest one beside it.
    fn part_at(&self, in_slam_m: [f64; 2]) -> Option<usize> {
        let in_blocks = self.slam_from_blocks().apply_inverse(in_slam_m).map(|c| c / BLOCK_M);
        part_at(&self.of_block, self.width, in_blocks, BLOCK_M)
    }

    fn slam_from_blocks(&self) -> Rigid2<Slam, ()> {
        Rigid2::of_x_y_yaw(self.slam_from_blocks)
    }

    /// Outline of the blocks whose part is in, in the SLAM map.
    fn outline_m(&self, is_in: &[bool]) -> Vec<Vec<Vec<[f64; 2]>>> {
        let height = self.of_block.len().checked_div(self.width).unwrap_or(0);
        let holds = |column: usize, row: usize| {
            is_in.get(self.of_block[row * self.width + column] as usize).copied().unwrap_or(false)
        };
        let mut rows: Vec<Ring> = Vec::new();
        for row in 0..height {
            let mut column = 0;
            while column < self.width {
                let end = (column..self.width).find(|c| !holds(*c, row)).unwrap_or(self.width);
                if column < end {
                    let [left, right, low, high] = [column, end, row, row + 1].map(|n| n as i32);
                    rows.push(vec![[left, low], [right, low], [right, high], [left, high]]);
                }
                column = end + 1;
            }
        }
        let MultiPolygon(pieces) = union(&rows, FillRule::NonZero);
        let slam_from_blocks = self.slam_from_blocks();
        let placed = |ring: &Ring| -> Vec<[f64; 2]> {
            ring.iter().map(|corner| slam_from_blocks.apply(corner.map(|c| f64::from(c) * BLOCK_M))).collect()
        };
        let rings = |piece: &Polygon| piece.rings().map(placed).collect();
        pieces.iter().map(rings).collect()
    }
}
