//! Compares two maps in a pose: walls, free space, and what was seen through walls.

use crate::features::Features;
use crate::pose::Pose;
use crate::random_generator::RandomGenerator;
use crate::thresholds::{MAX_MATCH_M, MIN_PRECISION, MIN_SHARE, WEIGHTS};
use crate::wall_points::WallPoint;
use messages::PoseEvidence;
use occupancy::{CELL_M, Cell, Raster};

/// Scales over which closeness is averaged, in metres: a distorted map still scores on the coarse ones.
const SCALES: [f64; 3] = [0.1, 0.25, 0.5];
/// A wall point lies on a face that is this close, with the same normal.
const ON_FACE_M: f64 = 0.1;
const SAME_DIRECTION: f64 = 0.9;
/// It lies on one exactly if the face's line is this close, and its nearest cell too.
const EXACT_M: f64 = 0.05;
const EXACT_CELL_M: f64 = 0.07;
/// More of one line says no more about where along it the robot is.
const DISTINCT_M: f64 = 0.5;
/// A wall of the reference was in sight if the robot knows this place before it to be free.
pub(crate) const IN_FRONT_M: f64 = 0.2;
/// A corner was in sight if the robot knows this place before it, into the free space, to be free.
const BEFORE_CORNER_M: f64 = 0.25;
/// The robot saw through a wall if it knows all these places to be free, before the face of the wall and behind it.
pub(crate) const THROUGH_M: [f64; 4] = [0.1, 0.0, -0.1, -0.2];
const MIN_SEEN: usize = 20;
const PRECISION_SHARE: f64 = 0.65;

/// What is compared of two maps; all of it is drawn at random.
#[derive(Clone, Copy)]
pub(crate) struct ComparedMaps<'a> {
    pub(crate) slam: &'a Features,
    pub(crate) reference: &'a Features,
    /// Drawn by weight: they are not weighted again.
    pub(crate) slam_points: &'a [WallPoint],
    pub(crate) reference_points: &'a [WallPoint],
    pub(crate) slam_cells: &'a SlamCells,
    /// True where so few wall points of the reference are looked for in the SLAM map that its nearest wall points need not
    /// be known everywhere.
    pub(crate) scans: bool,
}

/// Middles of cells of a SLAM map.
pub(crate) struct SlamCells {
    occupied: Vec<[f64; 2]>,
    free: Vec<[f64; 2]>,
    /// Length of wall and area of floor that each of them stands for.
    occupied_m: f64,
    free_m2: f64,
}

impl SlamCells {
    /// Draws so many cells of each kind at most: the same ones of the same map.
    pub(crate) fn drawn(raster: &Raster, n_occupied: usize, n_free: usize) -> Self {
        let mut random = RandomGenerator::new(2);
        let mut of = |cell: Cell, n: usize| {
            let all = CellsOfKind::of(&raster.cells, cell);
            let numbers = random.draw_evenly(all.count, n);
            let n_each = all.count as f64 / numbers.len().max(1) as f64;
            let drawn: Vec<[f64; 2]> = all.numbered(&numbers).map(|index| raster.middle(index)).collect();
            (drawn, n_each)
        };
        let ((occupied, n_occupied_each), (free, n_free_each)) =
            (of(Cell::Occupied, n_occupied), of(Cell::Free, n_free));
        Self { occupied, free, occupied_m: n_occupied_each * CELL_M, free_m2: n_free_each * CELL_M * CELL_M }
    }

    /// Every so many of them.
    pub(crate) fn thinned(&self, step: usize) -> Self {
        let some = |cells: &[[f64; 2]]| cells.iter().step_by(step).copied().collect();
        let each = step as f64;
        Self {
            occupied: some(&self.occupied),
            free: some(&self.free),
            occupied_m: each * self.occupied_m,
            free_m2: each * self.free_m2,
        }
    }
}

/// The cells of a kind, counted in blocks.
struct CellsOfKind<'a> {
    cells: &'a [Cell],
    kind: Cell,
    in_blocks: Vec<u8>,
    count: usize,
}

impl<'a> CellsOfKind<'a> {
    const BLOCK: usize = 64;

    fn of(cells: &'a [Cell], kind: Cell) -> Self {
        let count = |block: &[Cell]| block.iter().map(|cell| u8::from(*cell == kind)).sum();
        let in_blocks: Vec<u8> = cells.chunks(Self::BLOCK).map(count).collect();
        let count = in_blocks.iter().map(|n| usize::from(*n)).sum();
        Self { cells, kind, in_blocks, count }
    }

    /// Indices of those with these numbers among them, both ascending.
    fn numbered(&self, numbers: &[u32]) -> impl Iterator<Item = usize> {
        let (mut block, mut n_before) = (0, 0);
        numbers.iter().filter_map(move |&number| {
            let within = loop {
                let n_here = usize::from(*self.in_blocks.get(block)?);
                match (number as usize).checked_sub(n_before) {
                    Some(within) if within < n_here => break within,
                    _ => (block, n_before) = (block + 1, n_before + n_here),
                }
            };
            let start = block * Self::BLOCK;
            (start..self.cells.len()).filter(|&index| self.cells[index] == self.kind).nth(within)
        })
    }
}

/// What the reference has where the drawn cells and all wall points of a SLAM map lie by a pose.
#[derive(Debug, Clone, Default)]
pub(crate) struct Placed {
    pub(crate) occupied: Vec<Cell>,
    pub(crate) free: Vec<Cell>,
    /// True for wall points that lie on a face exactly.
    pub(crate) is_exact: Vec<bool>,
    pub(crate) corners: CornersInSight,
    /// Length of wall and area of floor that each cell stands for.
    pub(crate) occupied_m: f64,
    pub(crate) free_m2: f64,
}

/// Corners of the reference that were in sight of the robot.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct CornersInSight {
    /// How many were.
    pub n_seen: usize,
    /// How many of them the SLAM map has.
    pub n_found: usize,
}

impl CornersInSight {
    fn of(slam: &Features, reference: &Features, pose: &Pose) -> Self {
        let mut corners = Self::default();
        for corner in reference.corners() {
            let (sin, cos) = libm::sincos(corner.angle_rad);
            let before = [corner.at[0] + BEFORE_CORNER_M * cos, corner.at[1] + BEFORE_CORNER_M * sin];
            if slam.raster.at(pose.apply_inverse(before)) == Cell::Free {
                corners.n_seen += 1;
                corners.n_found += usize::from(slam.is_near_corner(pose.apply_inverse(corner.at)));
            }
        }
        corners
    }
}

/// The evidence for a pose.
pub(crate) fn evidence(maps: &ComparedMaps<'_>, pose: &Pose) -> PoseEvidence {
    let OnWalls { precision, distinct_m } = on_walls(maps, pose);
    let InSight { seen_m, seen_through, recall } = in_sight(maps, pose);
    let [in_walls, outside] = shares(maps.reference, pose, &maps.slam_cells.occupied);
    let [free_in_walls, free_outside] = shares(maps.reference, pose, &maps.slam_cells.free);
    let share = |share: f64| libm::log(MIN_SHARE + share);
    let log_odds = WEIGHTS.precision * libm::log(MIN_PRECISION + precision)
        + WEIGHTS.distinct * libm::log(1.0 + distinct_m)
        + WEIGHTS.distinct_share * distinct_m / maps.slam.walls_m().max(1.0).sqrt()
        + WEIGHTS.seen_through * libm::log(1.0 + seen_m * seen_through)
        + WEIGHTS.in_walls * share(in_walls)
        + WEIGHTS.outside * share(outside)
        + WEIGHTS.free_in_walls * share(free_in_walls)
        + WEIGHTS.free_outside * share(free_outside);
    PoseEvidence {
        log_odds,
        score: PRECISION_SHARE * precision + (1.0 - PRECISION_SHARE) * recall,
        precision,
        recall,
        free: 1.0 - free_in_walls - free_outside,
        seen_m,
        seen_through,
        in_walls,
        outside,
        free_in_walls,
        distinct_m,
    }
}

/// Closeness of a wall point to one of the other map, from 0 to 1.
pub(crate) fn closeness(squared: f64) -> f64 {
    SCALES.iter().map(|scale_m| libm::exp(-squared / (2.0 * scale_m * scale_m))).sum::<f64>() / SCALES.len() as f64
}

/// The walls of the SLAM map that the reference has.
struct OnWalls {
    /// Share of them.
    precision: f64,
    /// Length of those that lie on a face, of each line of faces at most [`DISTINCT_M`].
    distinct_m: f64,
}

fn on_walls(maps: &ComparedMaps<'_>, pose: &Pose) -> OnWalls {
    let mut sum = 0.0;
    let mut lines = Vec::new();
    for wall_point in maps.slam_points {
        let Some((nearest, squared)) = maps.reference.nearest(pose.apply(wall_point.at)) else { continue };
        let n = pose.rotate(wall_point.normal);
        let agreement = n[0] * nearest.normal[0] + n[1] * nearest.normal[1];
        if squared <= MAX_MATCH_M * MAX_MATCH_M && agreement > 0.0 {
            sum += closeness(squared) * agreement;
        }
        if squared <= ON_FACE_M * ON_FACE_M && agreement > SAME_DIRECTION {
            lines.push(nearest.line);
        }
    }
    lines.sort_unstable();
    let n = maps.slam_points.len().max(1) as f64;
    let drawn_m = maps.slam.walls_m() / n;
    let distinct_m = lines.chunk_by(|a, b| a == b).map(|line| (line.len() as f64 * drawn_m).min(DISTINCT_M)).sum();
    OnWalls { precision: sum / n, distinct_m }
}

/// The walls of the reference that were in sight of the robot.
struct InSight {
    seen_m: f64,
    /// Share of them that the robot saw through.
    seen_through: f64,
    /// Share of them that the SLAM map has.
    recall: f64,
}

fn in_sight(maps: &ComparedMaps<'_>, pose: &Pose) -> InSight {
    let (mut n_seen, mut n_through, mut recall) = (0usize, 0usize, 0.0);
    for wall_point in maps.reference_points {
        let is_free = |before_m: f64| {
            let place = [0, 1].map(|k| wall_point.at[k] + before_m * wall_point.normal[k]);
            maps.slam.raster.at(pose.apply_inverse(place)) == Cell::Free
        };
        if !is_free(IN_FRONT_M) {
            continue;
        }
        n_seen += 1;
        n_through += usize::from(THROUGH_M.into_iter().all(is_free));
        let place = pose.apply_inverse(wall_point.at);
        let nearest = || maps.slam.nearest(place).map(|(_, squared)| squared);
        let squared = if maps.scans { maps.slam.nearest_by_scan(place) } else { nearest() };
        recall += squared.map_or(0.0, closeness);
    }
    let n = n_seen.max(1) as f64;
    let drawn_share = maps.reference_points.len() as f64 / maps.reference.n_wall_points().max(1) as f64;
    InSight {
        seen_m: n_seen as f64 * CELL_M / drawn_share.max(f64::MIN_POSITIVE),
        seen_through: n_through as f64 / n,
        recall: if n_seen > MIN_SEEN { recall / n } else { 0.0 },
    }
}

/// What the reference has where the cells and wall points of the SLAM map lie by a pose.
pub(crate) fn placed(maps: &ComparedMaps<'_>, pose: &Pose) -> Placed {
    let cells = |places: &[[f64; 2]]| places.iter().map(|p| maps.reference.raster.at(pose.apply(*p))).collect();
    let is_exact = |wall_point: &WallPoint| {
        let (at, normal) = (pose.apply(wall_point.at), pose.rotate(wall_point.normal));
        maps.reference.nearest(at).is_some_and(|(nearest, squared)| {
            let of_normal = |v: [f64; 2]| v[0] * nearest.normal[0] + v[1] * nearest.normal[1];
            squared <= EXACT_CELL_M * EXACT_CELL_M
                && of_normal(normal) > SAME_DIRECTION
                && of_normal([at[0] - nearest.at[0], at[1] - nearest.at[1]]).abs() <= EXACT_M
        })
    };
    let SlamCells { occupied, free, occupied_m, free_m2 } = maps.slam_cells;
    Placed {
        occupied: cells(occupied),
        free: cells(free),
        is_exact: maps.slam.wall_points().iter().map(is_exact).collect(),
        corners: CornersInSight::of(maps.slam, maps.reference, pose),
        occupied_m: *occupied_m,
        free_m2: *free_m2,
    }
}

/// Shares of places that lie in walls of the reference, and where it knows nothing.
fn shares(reference: &Features, pose: &Pose, places: &[[f64; 2]]) -> [f64; 2] {
    let (mut n_walls, mut n_unknown) = (0usize, 0usize);
    for place in places {
        match reference.raster.at(pose.apply(*place)) {
            Cell::Occupied => n_walls += 1,
            Cell::Unknown => n_unknown += 1,
            Cell::Free => {}
        }
    }
    [n_walls, n_unknown].map(|n| n as f64 / places.len().max(1) as f64)
}
