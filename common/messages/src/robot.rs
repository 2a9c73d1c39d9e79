//! The robot profile record: measures in metres, capabilities.

use bytemuck::{Pod, Zeroable};

/// Measures and capabilities of a robot; lengths in metres, angles in radians.
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
    /// Steepest ground across the way that it drives; 0 if not given. See [`Self::terrain_slope_rad`].
    pub max_cross_slope_rad: f64,
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
    /// Door operations it manages: bits of [`DoorCapability`].
    pub opens: u32,
    /// 1 if it climbs stairs.
    pub climbs_stairs: u32,
    /// Cost of a cell on a stair, per cent of what is lethal, for a robot in whose maps stairs are floor; 0 where they are obstacles.
    pub stair_cost: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<RobotProfile>() == 112);

/// Highest riser that a robot takes that climbs stairs, and people do.
pub const MAX_RISER_M: f64 = 0.25;

/// A number that no robot has.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum RobotLimitError {
    /// Too small, too large or not a number.
    #[error("{key} is {value}, it must be from {} to {}", limits[0], limits[1])]
    Outside {
        /// Its key in a robot profile.
        key: &'static str,
        /// As given.
        value: f64,
        /// The smallest and the largest value.
        limits: [f64; 2],
    },
    /// Stairs are floor for a robot that does not climb them.
    #[error("stair_cost {stair_cost} is for a robot with climbs_stairs = true")]
    Stairs {
        /// As given.
        stair_cost: u32,
    },
    /// The robot would climb what it cannot look over.
    #[error("step_height_m {step_height_m} is not below height_m {height_m}")]
    Step {
        /// As given.
        step_height_m: f64,
        /// As given.
        height_m: f64,
    },
}

/// Kinds of door operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum DoorCapability {
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

impl DoorCapability {
    /// All kinds.
    pub const ALL: [Self; 5] = [Self::Swing, Self::Sliding, Self::Folding, Self::Revolving, Self::Rolling];

    /// Its name in robot profiles and reports.
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
        max_cross_slope_rad: 0.0,
        door_margin_m: 0.1,
        edge_margin_m: 0.3,
        work_margin_m: 1.5,
        lidar_height_m: 0.3,
        lidar_range_m: 0.0,
        sensor_height_m: 1.2,
        opens: DoorCapability::Swing as u32 | DoorCapability::Sliding as u32,
        climbs_stairs: 0,
        stair_cost: 0,
        reserved: 0,
    };

    /// Least clear width of a door that it drives through, metres: its diameter and its margin.
    pub fn needed_width_m(&self) -> f64 {
        2.0 * self.radius_m + self.door_margin_m
    }

    /// Checks that each number is one that a robot has.
    ///
    /// # Errors
    /// The first number out of its limits; a step that is as high as the robot.
    pub fn check(&self) -> Result<(), RobotLimitError> {
        let numbers = [
            ("height_m", self.height_m, [0.1, 3.0]),
            ("clearance_above_m", self.clearance_above_m, [0.0, 1.0]),
            ("step_height_m", self.step_height_m, [0.0, 0.5]),
            ("radius_m", self.radius_m, [0.01, 5.0]),
            ("max_slope_rad", self.max_slope_rad, [0.0, 1.0]),
            ("max_cross_slope_rad", self.max_cross_slope_rad, [0.0, 1.0]),
            ("door_margin_m", self.door_margin_m, [0.0, 1.0]),
            ("edge_margin_m", self.edge_margin_m, [0.0, 10.0]),
            ("work_margin_m", self.work_margin_m, [0.0, 50.0]),
            ("lidar_height_m", self.lidar_height_m, [0.01, 3.0]),
            ("lidar_range_m", self.lidar_range_m, [0.0, 1000.0]),
            ("sensor_height_m", self.sensor_height_m, [0.0, 10.0]),
            ("stair_cost", f64::from(self.stair_cost), [0.0, 90.0]),
        ];
        let outside = numbers.into_iter().find(|(_, value, [low, high])| !(low..=high).contains(&value));
        if let Some((key, value, limits)) = outside {
            return Err(RobotLimitError::Outside { key, value, limits });
        }
        if self.stair_cost > 0 && self.climbs_stairs != 1 {
            return Err(RobotLimitError::Stairs { stair_cost: self.stair_cost });
        }
        if self.step_height_m >= self.height_m {
            return Err(RobotLimitError::Step { step_height_m: self.step_height_m, height_m: self.height_m });
        }
        Ok(())
    }

    /// Steepest terrain: one drives there in every direction, so that no place may be steeper across the way than it may be. Ramps and
    /// roads lead along their slope.
    pub fn terrain_slope_rad(&self) -> f64 {
        let is_given = self.max_cross_slope_rad > 0.0;
        if is_given { self.max_slope_rad.min(self.max_cross_slope_rad) } else { self.max_slope_rad }
    }

    /// True if stairs are floor in its maps.
    pub fn drives_on_stairs(&self) -> bool {
        self.stair_cost > 0
    }

    /// True if it manages this kind of door.
    pub fn opens(&self, operation: DoorCapability) -> bool {
        self.opens & operation as u32 != 0
    }

    /// The heights above the floor in which things are obstacles.
    pub fn slab_m(&self) -> [f64; 2] {
        [self.step_height_m, self.height_m + self.clearance_above_m]
    }
}
