//! The processes of a site: its keeper and its daemons.

mod executables;
mod process;
mod running;

pub(crate) use executables::{check_versions, executable, version_of};
pub(crate) use process::{SupervisedProcess, TIMEOUT};
pub(crate) use running::{Running, running};
