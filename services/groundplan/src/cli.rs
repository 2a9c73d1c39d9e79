//! The command line; its help is the manual.

use crate::args::{OverwriteArgs, SiteArgs, WorldArgs};
use crate::commands::{
    actuals, align, changes, confirm, convert, date, deviations, load, robot, slam_map, states, tasks, waypoints,
};
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::{live, manual, monitor};
use clap::{Args, Parser, Subcommand};
use std::path::PathBuf;

/// Building models (IFC) into everything a robot needs to move before it has ever seen the place.
#[derive(Debug, Parser)]
#[command(name = "groundplan", version, propagate_version = true, max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Turn building models into maps per storey, semantic JSON and waypoints
    Convert(convert::Args),
    /// Tell which elements stand and which spaces may be entered at a date
    States(states::Args),
    /// List when anything changes, or what differs between two dates
    Changes(changes::Args),
    /// List the tasks of the schedule: when they are, what they act on, what is wrong with them
    Tasks(tasks::Args),
    /// Find the pose of a robot's SLAM map in the model's: of files, or of the map that the running daemon follows
    Align(align::Args),
    /// Start the daemons of a site and look after them until SIGTERM
    Up(UpArgs),
    /// Stop the daemons of a site
    Down(SiteArgs),
    /// Tell who lives and what is wrong; exit code 0 if all is well
    Status(StatusArgs),
    /// Load models into the running daemons; without any, read those again that are loaded
    Load(load::Args),
    /// Set the plan time of the running daemons, or let it move; returns when the new grids are out. Without arguments, tell it
    Date(date::Args),
    /// Give the running daemons the progress that was reported; returns when the new grids are out
    Actuals(actuals::Args),
    /// Set the robot of the running daemons; returns when the new grids are out
    Robot(robot::Args),
    /// Tell the running daemons what waypoints to plan; returns when the plan is out. Without arguments, what is configured
    Waypoints(waypoints::Args),
    /// Give the running daemons a map that the robot made, and align it; exit code 0 if accepted
    SlamMap(slam_map::Args),
    /// Tell what stands, is missing or has moved against the plan, as a robot's map shows it
    Deviations(deviations::Args),
    /// Say that the pose that waits is right, or that elements that the robot saw through are not there
    Confirm(confirm::Args),
    /// Watch the running daemons in the terminal: who lives, what is published, the maps themselves
    Monitor(MonitorArgs),
    /// Look at what is on the bus
    Topic(TopicArgs),
    /// Write the files of `convert` from the running daemons, at the plan time that they hold
    Export(ExportArgs),
    /// Tell what this machine lacks to run the daemons; exit code 0 if nothing
    Doctor(DoctorArgs),
    /// Print the completion script of a shell
    Completions(CompletionsArgs),
    /// Write manual pages into a folder
    Man(ManArgs),
    /// Create and hold the bus, and do nothing else; `up` starts it
    #[command(hide = true)]
    Keeper(KeeperArgs),
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// Bad usage or configuration, or work that failed.
    pub fn run(&self) -> Result<Outcome, Failure> {
        let judged = |(text, is_well)| Outcome { text, is_well };
        match self {
            Self::Convert(command) => command.run(),
            Self::States(command) => command.run(),
            Self::Changes(command) => command.run(),
            Self::Tasks(command) => command.run(),
            Self::Align(command) => command.run(),
            Self::SlamMap(command) => command.run(),
            Self::Deviations(command) => command.run(),
            Self::Confirm(command) => command.run(),
            Self::Up(arguments) => live::up(arguments).map(Outcome::from),
            Self::Down(arguments) => live::down(arguments).map(Outcome::from),
            Self::Status(arguments) => live::status(arguments).map(judged),
            Self::Load(command) => command.run(),
            Self::Date(command) => command.run(),
            Self::Actuals(command) => command.run(),
            Self::Robot(command) => command.run(),
            Self::Waypoints(command) => command.run(),
            Self::Monitor(arguments) => monitor::monitor(arguments).map(Outcome::from),
            Self::Topic(arguments) => live::topic(arguments).map(Outcome::from),
            Self::Export(arguments) => live::export(arguments).map(Outcome::from),
            Self::Doctor(arguments) => live::doctor(arguments).map(judged),
            Self::Completions(arguments) => manual::completions(arguments).map(Outcome::from),
            Self::Man(arguments) => manual::man(arguments).map(Outcome::from),
            Self::Keeper(arguments) => live::keeper(arguments).map(Outcome::from),
        }
    }
}

/// Arguments of `up`.
#[derive(Debug, Clone, Args)]
pub struct UpArgs {
    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `keeper`.
#[derive(Debug, Clone, Args)]
pub struct KeeperArgs {
    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,

    /// Stop when standard input ends
    #[arg(long)]
    pub with_stdin: bool,
}

/// Arguments of `status`.
#[derive(Debug, Clone, Args)]
pub struct StatusArgs {
    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `export`.
#[derive(Debug, Clone, Args)]
pub struct ExportArgs {
    /// Output folder; earlier output in it is replaced as a whole, unless files in it were added or altered since
    #[arg(value_name = "OUT")]
    pub out: PathBuf,

    /// What becomes of files of others in it.
    #[command(flatten)]
    pub overwrite: OverwriteArgs,

    /// Go on until SIGTERM: write OUT/epochs/EPOCH for every new set of maps, and let the link OUT/current name the newest
    #[arg(long)]
    pub watch: bool,

    /// Run this program after each swap of the link, with the new folder as its argument
    #[arg(long, value_name = "PROGRAM", requires = "watch")]
    pub on_change: Option<PathBuf>,

    /// Keep this many epochs
    #[arg(long, value_name = "N", default_value_t = 5, requires = "watch")]
    pub keep: usize,

    /// The world.
    #[command(flatten)]
    pub world: WorldArgs,

    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,
}

/// Arguments of `monitor`.
#[derive(Debug, Clone, Args)]
pub struct MonitorArgs {
    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,

    /// Print everything that is shown as one JSON document a line, on every change
    #[arg(long)]
    pub json: bool,

    /// Stop after this time
    #[arg(long = "for", value_name = "SECONDS")]
    pub seconds: Option<f64>,
}

/// Arguments of `doctor`.
#[derive(Debug, Clone, Args)]
pub struct DoctorArgs {
    /// The site.
    #[command(flatten)]
    pub site: SiteArgs,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `completions`.
#[derive(Debug, Clone, Args)]
pub struct CompletionsArgs {
    /// Which shell
    #[arg(value_name = "SHELL")]
    pub shell: clap_complete::Shell,
}

/// Arguments of `man`.
#[derive(Debug, Clone, Args)]
pub struct ManArgs {
    /// Where to
    #[arg(value_name = "FOLDER")]
    pub folder: PathBuf,
}

/// Arguments of `topic`.
#[derive(Debug, Clone, Args)]
pub struct TopicArgs {
    /// What to look at.
    #[command(subcommand)]
    pub command: TopicCommand,
}

/// What to look at.
#[derive(Debug, Clone, Subcommand)]
pub enum TopicCommand {
    /// List the topics that have a sample
    List {
        /// Print one JSON document on standard output and nothing else there
        #[arg(long)]
        json: bool,
        /// The site.
        #[command(flatten)]
        site: SiteArgs,
    },
    /// Print the last sample of a topic as JSON: what it is, what it was made from
    Echo {
        /// site, phase, grids, grid/00 ..
        topic: String,
        /// Go on with every sample that comes, one a line, until SIGTERM
        #[arg(long)]
        follow: bool,
        /// On one line
        #[arg(long)]
        json: bool,
        /// The site.
        #[command(flatten)]
        site: SiteArgs,
    },
    /// Measure how often samples of a topic come, how large they are, and how long they take
    Hz {
        /// site, phase, grids, grid/00 ..
        topic: String,
        /// Measure for this time [default: until SIGTERM]
        #[arg(long = "for", value_name = "SECONDS")]
        seconds: Option<f64>,
        /// Print one JSON document on standard output and nothing else there
        #[arg(long)]
        json: bool,
        /// The site.
        #[command(flatten)]
        site: SiteArgs,
    },
}
