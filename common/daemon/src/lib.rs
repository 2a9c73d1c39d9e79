//! What all daemons share: the site's configuration, state that survives them, requests, and the loop that they live in.
//!
//! A daemon is a [`Service`]: it opens its ends of the bus, and answers to inputs, requests and its own alarm, one after the
//! other, on a thread of its own. [`run`] owns the rest: it joins the bus and every later generation of it, keeps only the
//! newest of each input while the service works, serves newcomers, beats its heart, and leaves within a second.

mod ask;
mod config;
mod config_file;
mod life;
mod log;
mod request;
mod robot_file;
mod run;
mod service;
mod state;
mod stop;
mod systemd;

pub use ask::{Patience, ask};
pub use config::{
    AlignConfig, BusConfig, ClockConfig, ConfigError, LogConfig, LogFormat, PoseHint, RobotConfig, ScheduleConfig,
    SiteConfig, WaypointConfig, WorldConfig,
};
pub use config_file::{ConfigFileError, read_parsed};
pub use request::{ActualsSource, Answer, Request};
pub use robot_file::{Robot, RobotFileError};
pub use run::{Arguments, chain, in_background, run};
pub use service::{Done, Event, Failure, Service, Stages};
pub use state::{Epochs, StateError, StateFile, write_durably};
pub use stop::{ReloadSignal, StopSignal};
pub use systemd::{alive, ready, stopping};
