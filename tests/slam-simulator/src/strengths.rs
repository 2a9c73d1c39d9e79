//! Strengths of the effects of a simulation, as they are drawn for each pair.

use crate::random_generator::RandomGenerator;
use serde::Serialize;

/// How full of furniture buildings are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Clutter {
    /// Nearly empty, as before tenants move in.
    Low,
    /// Homes and offices in use.
    Home,
    /// From empty to crowded.
    All,
}

/// A lidar that turns around.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Lidar {
    /// Beams beyond this see nothing.
    pub range_m: f64,
    /// Field of view around the direction of travel.
    pub field_of_view_deg: f64,
    /// Beams of a scan.
    pub beams: usize,
    /// Standard deviation of ranges.
    pub noise_m: f64,
    /// Share of beams without an answer.
    pub drop_out_share: f64,
}

/// Strengths of all effects of one pair.
#[derive(Debug, Clone, Serialize)]
pub struct Strengths {
    /// Walls that are missing, elsewhere or additional, for each 100 m² of floor.
    pub wall_changes_per_100_m2: f64,
    /// From 0, no furniture, to 1, no room for more.
    pub clutter: f64,
    /// Share of the length of walls that furniture stands before.
    pub furnished_wall_share: f64,
    /// Furniture within rooms.
    pub furniture_per_m2: f64,
    /// Share of openings that have a door leaf.
    pub door_leaf_share: f64,
    /// Of those: the share that is closed.
    pub closed_door_share: f64,
    /// Share of the length of walls that is glass.
    pub glass_share: f64,
    /// Share of beams that glass reflects.
    pub glass_hit_share: f64,
    /// People in sight of a scan, who walk.
    pub people_per_scan: f64,
    /// Groups of people who stand.
    pub standing_groups: usize,
    /// Things outside of the building.
    pub outdoor_objects: usize,
    /// The sensor.
    pub lidar: Lidar,
    /// Share of the reachable floor to drive to.
    pub coverage: f64,
    /// Way between two scans.
    pub scan_spacing_m: f64,
    /// Largest offset between believed and true places after the best rigid fit, of a drive that is long enough.
    pub bend_m: f64,
    /// Share of the drift that is taken back where the robot comes again to what it has mapped.
    pub loop_correction: f64,
    /// Side of a cell of the SLAM map.
    pub resolution_m: f64,
    /// Hits among the beams that came to a cell, from which it is occupied.
    pub occupied_share: f64,
    /// Share of free cells that are occupied by mistake.
    pub stray_share: f64,
    /// True if beams without an answer free the cells they passed.
    pub clears_without_hit: bool,
}

impl Strengths {
    /// An empty building as planned, and a perfect robot.
    pub fn none() -> Self {
        Self {
            wall_changes_per_100_m2: 0.0,
            clutter: 0.0,
            furnished_wall_share: 0.0,
            furniture_per_m2: 0.0,
            door_leaf_share: 0.0,
            closed_door_share: 0.0,
            glass_share: 0.0,
            glass_hit_share: 0.0,
            people_per_scan: 0.0,
            standing_groups: 0,
            outdoor_objects: 0,
            lidar: Lidar { range_m: 12.0, field_of_view_deg: 360.0, beams: 720, noise_m: 0.005, drop_out_share: 0.0 },
            coverage: 1.0,
            scan_spacing_m: 0.5,
            bend_m: 0.0,
            loop_correction: 1.0,
            resolution_m: 0.05,
            occupied_share: 0.25,
            stray_share: 0.0,
            clears_without_hit: false,
        }
    }

    /// The same with furniture: `clutter` is from 0, none, to 1, no room for more.
    #[must_use]
    pub fn with_clutter(self, clutter: f64) -> Self {
        Self {
            clutter,
            furnished_wall_share: 0.95 * libm::pow(clutter, 0.8),
            furniture_per_m2: 0.22 * clutter * clutter + 0.04 * clutter,
            ..self
        }
    }

    /// Drawn for one pair.
    pub fn drawn(random: &mut RandomGenerator, clutter: Clutter) -> Self {
        let clutter = match clutter {
            Clutter::Low => random.between(0.0, 0.2),
            Clutter::Home => random.between(0.35, 1.0),
            Clutter::All => random.between(0.0, 1.0),
        };
        let squared = |random: &mut RandomGenerator, most: f64| {
            let unit = random.unit();
            most * unit * unit
        };
        let strengths = Self {
            wall_changes_per_100_m2: squared(random, 3.0),
            door_leaf_share: random.between(0.3, 1.0),
            closed_door_share: squared(random, 0.5),
            glass_share: if random.happens(0.6) { squared(random, 0.4) } else { 0.0 },
            glass_hit_share: random.between(0.02, 0.3),
            people_per_scan: if random.happens(0.6) { squared(random, 3.0) } else { 0.0 },
            standing_groups: if random.happens(0.25) { random.count(1, 2) } else { 0 },
            outdoor_objects: random.count(0, 25),
            lidar: Lidar {
                range_m: random.one_of(&[6.0, 8.0, 10.0, 12.0, 20.0, 30.0]),
                field_of_view_deg: random.one_of(&[180.0, 240.0, 270.0, 270.0, 360.0, 360.0, 360.0]),
                beams: random.one_of(&[360, 541, 720, 720, 1080]),
                noise_m: random.between(0.005, 0.03),
                drop_out_share: squared(random, 0.1),
            },
            coverage: random.between(0.15, 1.0),
            scan_spacing_m: random.between(0.35, 0.7),
            bend_m: squared(random, 0.5),
            loop_correction: random.between(0.4, 1.0),
            resolution_m: random.one_of(&[0.02, 0.05, 0.05, 0.05, 0.05, 0.1]),
            occupied_share: random.between(0.1, 0.35),
            stray_share: if random.happens(0.5) { squared(random, 0.002) } else { 0.0 },
            clears_without_hit: random.happens(0.3),
            ..Self::none()
        };
        strengths.with_clutter(clutter)
    }
}
