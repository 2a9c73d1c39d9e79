//! The running daemons: starting and stopping them, asking them, looking at what they publish.

mod doctor;
mod export;
mod keeper;
mod status;
mod topic;
mod up;
mod watch;

pub use doctor::doctor;
pub use export::export;
pub use keeper::keeper;
pub use status::status;
pub use topic::topic;
pub use up::{down, up};
