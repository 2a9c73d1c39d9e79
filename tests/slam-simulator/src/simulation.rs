//! One drive of a robot through one building, with the true pose of the map that it makes.

use crate::building::Contents;
use crate::plane::Vector;
use crate::random_generator::RandomGenerator;
use crate::reference::Reference;
use crate::robot::drift::{BelievedDrive, Residual, believed};
use crate::robot::lidar::Beam;
use crate::robot::slam_map::slam_map;
use crate::scanned_drive::{Pace, scanned_drive};
use crate::strengths::Strengths;
use crate::world::World;
use frames::{Map, Rigid2, Slam};
use occupancy::{Cell, OccupancyMap};
use serde::Serialize;

/// An occupied cell farther than this from all walls of the model is clutter.
const CLUTTER_M: f64 = 0.25;

/// A simulated map with the truth about it.
#[derive(Debug, Clone)]
pub struct Simulation {
    /// The map of the robot, in its frame.
    pub slam: OccupancyMap,
    /// The true pose of that frame in the frame of the model.
    pub map_from_slam: Rigid2<Map, Slam>,
    /// Mean of the free cells, in the robot's frame.
    pub centre: Vector,
    /// Middles of the wall cells of the model that a beam met, in the frame of the model.
    pub visible_walls: Vec<Vector>,
    /// Measures of the simulation.
    pub measures: Measures,
}

/// Measures of a simulation.
#[derive(Debug, Clone, Serialize)]
pub struct Measures {
    /// Share of the occupied cells that are farther than 0.25 m from all walls of the model.
    pub clutter_share: f64,
    /// Wall cells of the model that a beam met.
    pub visible_wall_cells: usize,
    /// Floor of the model.
    pub floor_m2: f64,
    /// Floor that the middle of the robot can reach.
    pub reachable_m2: f64,
    /// Share of that to which it came.
    pub covered: f64,
    /// Length of its way.
    pub way_m: f64,
    /// Number of scans.
    pub scans: usize,
    /// What no rigid motion takes away.
    #[serde(flatten)]
    pub residual: Residual,
    /// What is in the building and not in the model.
    #[serde(flatten)]
    pub contents: Contents,
}

/// A drive through the building of a model map; `None` if there is too little floor to drive on, or hardly a wall
/// to see.
pub fn simulated(reference: &Reference, strengths: &Strengths, random: &RandomGenerator) -> Option<Simulation> {
    simulated_in(World::of(&reference.grid), reference, strengths, random, |_| ())
}

/// The same in a world that is not quite that of the model map; all beams are reported.
pub(crate) fn simulated_in(
    world: World,
    reference: &Reference,
    strengths: &Strengths,
    random: &RandomGenerator,
    saw: impl FnMut(&Beam),
) -> Option<Simulation> {
    let growth = Growth { n_looks: 1, bends_back: false };
    drive_in(world, reference, strengths, random, growth, saw)?.pop()?
}

/// How a map grows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Growth {
    /// The map is looked at after so many equal parts of the way.
    pub n_looks: usize,
    /// True if a place that is known again moves what was mapped before, as SLAM with a graph of poses does.
    pub bends_back: bool,
}

/// The maps of a drive after equal parts of its way, all in one frame; the last one is of the whole way. `None` in the place of
/// a map that shows too little; the last one shows enough, or there is no drive.
pub fn simulated_growth(
    reference: &Reference,
    strengths: &Strengths,
    random: &RandomGenerator,
    growth: Growth,
) -> Option<Vec<Option<Simulation>>> {
    let looks = drive_in(World::of(&reference.grid), reference, strengths, random, growth, |_| ())?;
    looks.last()?.is_some().then_some(looks)
}

fn drive_in(
    world: World,
    reference: &Reference,
    strengths: &Strengths,
    random: &RandomGenerator,
    growth: Growth,
    saw: impl FnMut(&Beam),
) -> Option<Vec<Option<Simulation>>> {
    let scanned = scanned_drive(world, reference, strengths, Pace::OF_MAPS, random, saw)?;
    let drive = &scanned.drive;
    let ends = drive.parts(growth.n_looks);
    let believed = believed(drive, &ends, growth.bends_back, strengths, &mut random.part("drift"));
    let look = |believed: &BelievedDrive| {
        let n_scans = believed.places.len();
        let slam = slam_map(&scanned.scans[..n_scans], believed, &scanned.beams, strengths, &mut random.part("slam"));
        let visible_walls = scanned.visible_walls(reference, n_scans)?;
        let measures = Measures {
            clutter_share: clutter_share(reference, &slam, &believed.map_from_slam),
            visible_wall_cells: visible_walls.len(),
            floor_m2: reference.grid.floor_m2(),
            reachable_m2: drive.reachable_m2,
            covered: drive.covered[n_scans - 1],
            way_m: drive.way_m[n_scans - 1],
            scans: n_scans,
            residual: believed.residual.clone(),
            contents: scanned.contents.clone(),
        };
        let centre = mean_of(&slam, Cell::Free)?;
        Some(Simulation { centre, map_from_slam: believed.map_from_slam, slam, visible_walls, measures })
    };
    Some(believed.iter().map(look).collect())
}

/// Middles of all cells of one kind.
pub(crate) fn middles(map: &OccupancyMap, cell: Cell) -> impl Iterator<Item = Vector> + '_ {
    let of = |k: usize| {
        let [x, y] = [k % map.width, k / map.width].map(|c| (c as f64 + 0.5) * map.resolution_m);
        [map.origin[0] + x, map.origin[1] + y]
    };
    (0..map.cells.len()).filter(move |&k| map.cells[k] == cell).map(of)
}

fn mean_of(map: &OccupancyMap, cell: Cell) -> Option<Vector> {
    let (n, whole) = middles(map, cell).fold((0, [0.0; 2]), |(n, s), p| (n + 1, crate::plane::sum(s, p)));
    (n > 0).then(|| crate::plane::scaled(whole, 1.0 / f64::from(n)))
}

fn clutter_share(reference: &Reference, slam: &OccupancyMap, map_from_slam: &Rigid2<Map, Slam>) -> f64 {
    let is_far = |p: Vector| reference.wall_distance_m(map_from_slam.apply(p)) > CLUTTER_M;
    let (mut n, mut n_far) = (0usize, 0usize);
    for p in middles(slam, Cell::Occupied) {
        n += 1;
        n_far += usize::from(is_far(p));
    }
    n_far as f64 / n.max(1) as f64
}
