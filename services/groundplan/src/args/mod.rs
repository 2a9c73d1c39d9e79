//! Groups of arguments that several commands share.

mod cloud;
mod fleet;
mod mesh_cache;
mod models;
mod octomap;
mod optional_files;
mod overwrite;
mod pose_hint;
mod recording;
mod robot;
mod schedule;
mod site;
mod world;

pub use mesh_cache::MeshCacheArgs;
pub use models::ModelArgs;
pub use optional_files::OptionalFilesArgs;
pub use overwrite::OverwriteArgs;
pub use pose_hint::PoseHintArgs;
pub use recording::RecordingArgs;
pub use robot::RobotArgs;
pub use schedule::ScheduleArgs;
pub use site::{SiteArgs, SiteOfRobotArgs};

pub(crate) use models::read_model;
pub(crate) use overwrite::report_set_aside;
pub(crate) use robot::robot_of_profile;
pub(crate) use schedule::{ScheduleInput, with_timeline};
