//! The processes of a site: its keeper and its daemons.

mod executables;
mod process;
mod running;

pub(crate) use executables::{check_builds, executable, executable_of_own_build};
pub(crate) use process::{DOWN_TIMEOUT, SupervisedProcess};
pub(crate) use running::{Running, running};
