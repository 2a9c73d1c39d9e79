//! The robot that maps are made for.

use bytemuck::{Pod, Zeroable};

/// What a robot measures and can do; lengths in metres, angles in radians.
#[derive(Debug, Clone, Copy, PartialEq, Zeroable, Pod)]
#[repr(C)]
pub struct RobotProfile {
    /// Height of the body.
    pub height_m: f64,
    /// Air above the body that must be free, too.
    pub clearance_above_m: f64,
    /// Highest step the robot takes; what is lower is floor.
    pub step_height_m: f64,
    /// Radius of the circle around the body.
    pub radius_m: f64,
    /// Steepest floor.
    pub max_slope_rad: f64,
    /// Clear width of a door beyond the robot's diameter.
    pub door_margin_m: f64,
    /// Distance to keep from drop-offs.
    pub edge_margin_m: f64,
    /// Distance to keep from work in progress.
    pub work_margin_m: f64,
    /// Height of the localisation lidar above the floor.
    pub lidar_height_m: f64,
    /// Range of the lidar; 0 if not given.
    pub lidar_range_m: f64,
    /// Height of the scanning sensor above the floor.
    pub sensor_height_m: f64,
    /// Door operations it manages: bits of [`Opens`].
    pub opens: u32,
    /// 1 if it climbs stairs.
    pub climbs_stairs: u32,
}
const _: () = assert!(size_of::<RobotProfile>() == 96);

/// Kinds of door operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum Opens {
    /// Leaves on hinges; an unknown operation counts as this.
    Swing = 1,
    /// Sliding leaves.
    Sliding = 2,
    /// Folding leaves.
    Folding = 4,
    /// Revolving doors.
    Revolving = 8,
    /// Rolling up or lifting doors.
    Rolling = 16,
}

impl Opens {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Swing, Self::Sliding, Self::Folding, Self::Revolving, Self::Rolling];

    /// Its word in robot profiles and reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Swing => "swing",
            Self::Sliding => "sliding",
            Self::Folding => "folding",
            Self::Revolving => "revolving",
            Self::Rolling => "rolling",
        }
    }
}

impl RobotProfile {
    /// The profile that is used when none is given.
    pub const DEFAULT: Self = Self {
        height_m: 1.2,
        clearance_above_m: 0.05,
        step_height_m: 0.05,
        radius_m: 0.30,
        max_slope_rad: 0.1,
        door_margin_m: 0.1,
        edge_margin_m: 0.3,
        work_margin_m: 1.5,
        lidar_height_m: 0.3,
        lidar_range_m: 0.0,
        sensor_height_m: 1.2,
        opens: Opens::Swing as u32 | Opens::Sliding as u32,
        climbs_stairs: 0,
    };

    /// True if it manages this kind of door.
    pub fn opens(&self, operation: Opens) -> bool {
        self.opens & operation as u32 != 0
    }

    /// The heights above the floor in which things are obstacles.
    pub fn slab_m(&self) -> [f64; 2] {
        [self.step_height_m, self.height_m + self.clearance_above_m]
    }
}
