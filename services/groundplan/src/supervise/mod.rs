//! The processes of a site: its keeper and its daemons.

mod executables;
mod process;
mod running;

pub(crate) use executables::{check_versions, executable, version_of};
pub(crate) use process::{DOWN_TIMEOUT, SupervisedProcess};
pub(crate) use running::{Running, running};
