//! Arguments of the robot profile and the resolution of maps.

use crate::failure::Failure;
use daemon::Robot;
use grid::GridSpec;
use std::path::{Path, PathBuf};

/// For which robot, at which resolution.
#[derive(Debug, Clone, clap::Args)]
pub struct RobotArgs {
    /// Robot profile [default: 1.2 m high, 0.3 m radius, see config/robots/default.toml]
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,

    /// Metres per cell, a whole number of tenths of a millimetre from 0.001 to 1
    #[arg(long, value_name = "METRES", default_value_t = 0.05)]
    pub(crate) resolution: f64,
}

impl RobotArgs {
    /// The robot that maps are for, once it is known that its resolution is one.
    ///
    /// # Errors
    /// A profile or a resolution that cannot be used.
    pub(crate) fn robot(&self) -> Result<Robot, Failure> {
        GridSpec::cell_tenths_of(self.resolution).map_err(Failure::usage)?;
        robot_of_profile(self.robot.as_deref())
    }
}

/// The robot of a profile, or the default.
///
/// # Errors
/// A profile that cannot be used.
pub(crate) fn robot_of_profile(file: Option<&Path>) -> Result<Robot, Failure> {
    file.map_or_else(|| Ok(Robot::default()), Robot::read).map_err(Failure::usage)
}
