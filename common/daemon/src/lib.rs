//! Shared parts of all daemons: site configuration, persistent state, requests, the event loop.
//!
//! A daemon is a [`Service`]: it opens its ends of the bus, and handles inputs, requests and its own alarm, one after the
//! other, on a thread of its own. Most are [`Committed`] decisions. [`run`] owns the rest: it joins the bus and every later generation of it, keeps only the
//! newest of each input while the service works, serves late joiners, sends heartbeats, and leaves within a second.
//!
//! # Decisions
//!
//! The rules of a daemon ([`Decide`]) write and publish nothing that has to be undone. They say what is to be on disk, on the bus, in force and in the
//! history ([`Decision`]), and [`Committed`] carries it out in that order. If a step fails, those before it are undone there, and what is
//! in force stays: no rule has a way back of its own. What came as a sample and could not be committed is decided again at the next
//! look; a request is refused, and a revision is tried again after a while.
//! Disk, clock and bus are drivers: `tests/site-simulator` runs the rules of a site on others.
//!
//! # Requests
//!
//! Each daemon has a type of [`Request`]s with a type of answer. A [`Client`] of one daemon takes its requests alone; bytes
//! that are no request of a daemon get an error that names it. While a service works on a request it reports what it does
//! and the share that is done ([`Reporter`]); the loop sends that to the client, and a client that has left changes nothing.
//!
//! # State
//!
//! Every 1.x reads the state that an earlier 1.x wrote: files gain fields with defaults, and lose none. A state folder has the version that
//! wrote it ([`claim_state`]); an earlier version and another major version refuse it and leave it as it is. A file with fields
//! that this version does not know is refused by its name ([`StateError::Damaged`]), and never replaced unless it can be made anew.
//!
//! # Where
//!
//! - memory or disk full, the order in which a decision is carried out: `src/committed.rs`; of one's own samples: `src/latched_output.rs`
//! - state files, by daemon: `src/state_files.rs`; how they are written, and what becomes of damage: `src/kept_file.rs`
//! - waking: asked for by `Decision::wake_in`, done by `src/service_loop.rs`
//! - requests: those of each daemon: `src/requests/`; queue: `src/request_queue.rs`; the client's side: `src/client.rs`
//! - settings of a site: `src/config.rs`; of a command or the file: `src/setting.rs`
//! - status, health: `src/process_report.rs`, `src/status_board.rs`, `src/work_watch.rs`
//!
//! # A site
//!
//! A site has a file like `config/site.toml`: `groundplan up --config site.toml` starts and supervises its daemons, which
//! lie in the folder of the client. Plan time, reported progress, robot and loaded files are on disk before a command is
//! answered, and numbers of samples never fall. A model that changes on disk is read again; one that cannot be
//! used, or whose schedule cannot, leaves the site in force where it is, and `groundplan status` says why; one that looks like
//! another building waits for `groundplan confirm`. SIGHUP reads the configuration again, and tries again what was refused.
//!
//! The plan time stands, follows the clock of the machine in the zone of the site, or runs at a rate; it never goes back by
//! itself:
//!
//! ```text
//! groundplan date 2024-04-15T08:00:00
//! groundplan date --wall                          # needs site_zone in the schedule rules
//! groundplan date 2024-03-04 --simulate 86400     # a day a second
//! groundplan date                                 # prints it
//! groundplan actuals progress.csv                 # reported progress, columns id, start, finish; --clear takes it back
//! ```
//!
//! On the PC of a robot `sudo scripts/install` puts programs, manual pages, completions and the units of `config/systemd`
//! in place, then `systemctl enable --now groundplan.target`. `groundplan doctor` tells what a machine lacks.

mod ask_config;
mod caller;
mod client;
mod committed;
mod config;
mod config_file;
mod config_key;
mod cpu_ticks;
mod decision;
pub mod facts;
mod failure;
mod file_text;
mod fleet;
mod history;
mod input;
mod kept_file;
mod known_places;
mod latched_output;
mod log;
mod machine_time;
mod map_reports;
mod mesh_process;
mod observed_tables;
mod plan_time_clock;
mod process_report;
mod program_hash;
mod progress;
mod replaced_file;
mod reported_progress;
mod request;
mod request_queue;
mod requests;
mod robot_config;
mod robot_file;
mod robots_config;
mod ros_config;
mod ros_faults;
mod run;
mod save;
mod schedule_inputs;
mod sealed_file;
mod self_report;
mod server_config;
mod service;
mod service_loop;
mod service_thread;
mod setting;
mod site_process;
mod state;
pub mod state_files;
mod state_version;
mod status_board;
mod stop;
mod systemd;
#[cfg(test)]
mod testing;
mod watched;
mod waypoint_options;
mod web_config;
mod whole_files;
mod work_watch;

pub use ask_config::AskConfig;
pub use caller::Caller;
pub use client::{Answer, Client, ClientError, OpenRequest, RequestTimeouts, ask, ask_site};
pub use committed::{Committed, Disk, StateFolder};
pub use config::{BusConfig, ClockConfig, ConfigError, LogConfig, LogFormat, ScheduleConfig, SiteConfig, WorldConfig};
pub use config_file::{ConfigFileError, read_parsed};
pub use config_key::line_of_key;
pub use decision::{AnswerOnce, AnswerTo, Decide, Decision, Now, Occasion, OutputEnd, Outputs};
pub use failure::{Failure, chain, joined};
pub use file_text::FileText;
pub use fleet::{
    AbsentByRobot, DaemonReport, ElementObservation, FleetDocument, FleetElement, FleetRobot, MAX_FLEET_ELEMENTS,
    Observations, REPORT_INTERVAL_S, ReportAnswer, RobotPlace, RobotReport, RobotState, SILENT_AFTER_S, ToldAbsence,
    ToldByRobot, ToldObservation, fleet_elements,
};
pub use history::{History, HistoryEntry, HistoryEvent, HistoryKind, SiteHistory, parse_history};
pub use input::{Input, NoInput, not_an_input};
pub use kept_file::KeptFile;
pub use known_places::{KnownPlaces, PointInRoom};
pub use latched_output::{LatchedOutput, NewSample, OneTopic};
pub use log::{Log, LogError};
pub use machine_time::{Clock, MachineClock, MachineTime};
pub use map_reports::{hear_daemons, next_state, schedule_report};
pub use mesh_process::{in_mesh_process, run_mesh_process};
pub use observed_tables::{ObservedPair, ObservedRow, ObservedTables, progress_table};
pub use plan_time_clock::{ClockDistrust, PlanTimeClock, ReachedPlanTime, Reading};
pub use process_report::ProcessReport;
pub use program_hash::program_hash;
pub use progress::{Progress, Reporter};
pub use replaced_file::{folder_of, replace_file, write_durably};
pub use reported_progress::ReportedProgress;
pub use request::{Published, Request, RequestError, parse_request};
pub use requests::{
    ActualsSource, AlignAnswer, AlignRequest, AskRequest, ComparisonState, Confirmations, Confirmed, ConfirmedElement,
    FollowRequest, IngestAnswer, IngestRequest, ListedPose, MAX_RATE, MIN_RATE, RasterizeAnswer, RasterizeRequest,
    RateError, Revision, RevisionEffect, RosBridgeRequest, ScheduleAnswer, ScheduleRequest, ScheduleVerdict,
    SearchState, ServeRequest, WaypointAnswer, WaypointRequest, WebRequest, checked_rate,
};
pub use robot_config::{AlignConfig, NamedRobotConfig, PoseHint, PoseHintError, RobotConfig, WaypointConfig};
pub use robot_file::{Robot, RobotTextError};
pub use robots_config::RobotChoiceError;
pub use ros_config::{
    FoxgloveConfig, Nav2Config, Nav2Pause, QosConfig, RosConfig, RosOutput, RosServiceMapping, SimTimeConfig,
    full_ros_name,
};
pub use ros_faults::SimTimeError;
pub use run::{Arguments, behind_others, in_background, run, run_with};
pub use save::Save;
pub use schedule_inputs::{
    MAX_TABLE_BYTES, mend_progress, progress_in_force, read_progress, rules_in_force, saving_observed,
};
pub use server_config::{
    DecidedOnServer, ExportedFiles, FollowConfig, FollowLinkConfig, MAX_LINKED_ROBOTS, ServeConfig, ServeLinkConfig,
    UNNAMED_ROBOT,
};
pub use service::{AnswerOf, Asked, CurrentActivity, Done, Event, Service, Standing};
pub use setting::{Configured, KeptSetting, Setting, SettingInForce, SettingKey, SettingSource, check_setting};
pub use site_process::SiteProcess;
pub use state::{Epochs, StateError, StateFile};
pub use state_version::{StateVersionError, claim_state};
pub use status_board::{OutputStamp, Report, StatusBoard};
pub use stop::{ReloadSignal, StopSignal};
pub use systemd::{alive, ready, stopping};
pub use watched::Watched;
pub use waypoint_options::WaypointOptions;
pub use web_config::WebConfig;
pub use whole_files::{FileStamp, FileWatch, WholeFiles, stamps_of};
pub use work_watch::Busy;
