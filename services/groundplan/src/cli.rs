//! The command line: all commands. Arguments, help and work of each are in its own file.

use crate::commands::{
    actuals, align, as_built, ask, changes, check, completions, confirm, convert, date, demo, deviations, doctor, door,
    down, export, findings, fleet, follow, keeper, key, link, load, log, man, metrics, monitor, record, relay, robot,
    room, scans, serve, slam_map, states, status, tasks, topic, undo, up, view, way, waypoints,
};
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use clap::{CommandFactory, Parser, Subcommand};
use std::io::IsTerminal;
use tracing_subscriber::EnvFilter;

/// Building models (IFC) into everything a robot needs to move before it has ever seen the place.
#[derive(Debug, Parser)]
#[command(name = "groundplan", version = bus::own_build(), propagate_version = true, max_term_width = 100)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Show what groundplan does: the demo building, from the model to a robot's map, with running daemons
    Demo(demo::Args),
    /// Turn building models into maps per storey, semantic JSON and waypoints
    Convert(convert::Args),
    /// List the states of elements and spaces at a date
    States(states::Args),
    /// List when anything changes, or what differs between two dates
    Changes(changes::Args),
    /// List the tasks of the schedule: when they are, what they act on, what is wrong with them
    Tasks(tasks::Args),
    /// Find the way of this robot from a room or point to another, over storeys, or what is missing
    Way(way::Args),
    /// Show where a room is, whether this robot may enter it and when that changes, its doors, scans and tasks
    Room(room::Args),
    /// Show where a door is, whether this robot can pass it and when that changes
    Door(door::Args),
    /// Show where the robot scans in a room and what each scan sees, or why there is none
    Scans(scans::Args),
    /// List what model and schedule lack: errors, warnings, what is assumed, replaced or on no map
    Findings(findings::Args),
    /// Check whether a model is fit for a robot: what will be wrong on its maps, why, and what to mend, worst first
    Check(check::Args),
    /// Show which elements a planner's schedule works on, and what of both fits nothing; write the table that completes it
    Link(link::Args),
    /// Find the pose of a robot's SLAM map in the model's: of files, or of the map that the running daemon follows
    Align(align::Args),
    /// Start and supervise the daemons of a site until SIGTERM
    Up(up::Args),
    /// Stop the daemons of a site
    Down(down::Args),
    /// Show which daemons run and their errors; exit code 0 if all is well
    Status(status::Args),
    /// Load models into the running daemons; without any, read those again that are loaded
    Load(load::Args),
    /// Set the plan time of the running daemons, or let it move; returns when the new grids are published. Without
    /// arguments, print it
    Date(date::Args),
    /// Give the running daemons the progress that was reported; returns when the new grids are out
    Actuals(actuals::Args),
    /// Set the robot of the running daemons; returns when the new grids are out
    Robot(robot::Args),
    /// Set what waypoints the running daemons plan; returns when the mission plan is published. Without arguments, what
    /// is configured
    Waypoints(waypoints::Args),
    /// Give the running daemons a map that the robot made, and align it
    SlamMap(slam_map::Args),
    /// Compare a robot's map with the planned site: what stands, is missing or has moved
    Deviations(deviations::Args),
    /// Write what was reported, observed and confirmed back into a model, and nothing else
    AsBuilt(as_built::Args),
    /// Confirm the pose or the revision of the model that waits, or that elements are absent
    Confirm(confirm::Args),
    /// List what happened to a site: revisions, dates, progress, confirmations, with who asked for it
    Log(log::Args),
    /// Print the state of the running daemons as Prometheus text, or keep a file of it
    Metrics(metrics::Args),
    /// Take reported progress or a confirmation back
    Undo(undo::Args),
    /// Show the running daemons in the terminal: their state, topics and maps
    Monitor(monitor::Args),
    /// Record the maps of the running daemons as ROS 2 messages in an MCAP file, as they change
    Record(record::Args),
    /// Inspect topics of the bus
    Topic(topic::Args),
    /// Write the files of `convert` from the running daemons, at the plan time that they hold
    Export(export::Args),
    /// Show a site in the browser: models, maps, or the running daemons
    View(view::Args),
    /// Answer questions about a site over HTTP and the Model Context Protocol, for programs and assistants
    Ask(ask::Args),
    /// Run the daemons of a site, and give what they draw to a store, for robots on other machines
    Serve(serve::Args),
    /// Show on this robot what the server of its site has drawn
    Follow(follow::Args),
    /// Ask the server of a site how its robots are
    Fleet(fleet::Args),
    /// Make and list keys of a site for many machines
    Key(key::Args),
    /// Check that this machine can run the daemons; exit code 0 if it can
    Doctor(doctor::Args),
    /// Print the completion script of a shell
    Completions(completions::Args),
    /// Write manual pages into a folder
    Man(man::Args),
    /// Create and hold the bus, and do nothing else; `up` starts it
    #[command(hide = true)]
    Keeper(keeper::Args),
    /// Let other users than the bus's own look at the site, and send commands; `up` starts it
    #[command(hide = true)]
    Relay(relay::Args),
}

/// The log of commands that end: errors on standard error, unless `RUST_LOG` asks for more.
fn log_errors() {
    let filter = EnvFilter::try_from_default_env().unwrap_or_else(|_| "error".into());
    let lines = tracing_subscriber::fmt().with_writer(std::io::stderr).with_ansi(std::io::stderr().is_terminal());
    lines.with_env_filter(filter).init();
}

impl Command {
    /// Runs the command.
    ///
    /// # Errors
    /// Bad usage or configuration, or work that failed.
    pub fn run(&self) -> Result<Outcome, Failure> {
        let command: &dyn Run = match self {
            // These two write about the command line as a whole.
            Self::Completions(arguments) => return arguments.script(Cli::command()),
            Self::Man(arguments) => return arguments.write(Cli::command()),
            Self::Demo(arguments) => arguments,
            Self::Convert(arguments) => arguments,
            Self::States(arguments) => arguments,
            Self::Changes(arguments) => arguments,
            Self::Tasks(arguments) => arguments,
            Self::Way(arguments) => arguments,
            Self::Room(arguments) => arguments,
            Self::Door(arguments) => arguments,
            Self::Scans(arguments) => arguments,
            Self::Findings(arguments) => arguments,
            Self::Check(arguments) => arguments,
            Self::Link(arguments) => arguments,
            Self::Align(arguments) => arguments,
            Self::Up(arguments) => arguments,
            Self::Down(arguments) => arguments,
            Self::Status(arguments) => arguments,
            Self::Load(arguments) => arguments,
            Self::Date(arguments) => arguments,
            Self::Actuals(arguments) => arguments,
            Self::Robot(arguments) => arguments,
            Self::Waypoints(arguments) => arguments,
            Self::SlamMap(arguments) => arguments,
            Self::Deviations(arguments) => arguments,
            Self::AsBuilt(arguments) => arguments,
            Self::Confirm(arguments) => arguments,
            Self::Log(arguments) => arguments,
            Self::Metrics(arguments) => arguments,
            Self::Monitor(arguments) => arguments,
            Self::Record(arguments) => arguments,
            Self::Topic(arguments) => arguments,
            Self::Undo(arguments) => arguments,
            Self::Export(arguments) => arguments,
            Self::View(arguments) => arguments,
            Self::Ask(arguments) => arguments,
            Self::Serve(arguments) => arguments,
            Self::Follow(arguments) => arguments,
            Self::Fleet(arguments) => arguments,
            Self::Key(arguments) => arguments,
            Self::Doctor(arguments) => arguments,
            Self::Keeper(arguments) => arguments,
            Self::Relay(arguments) => arguments,
        };
        if !matches!(self, Self::Up(_) | Self::Serve(_) | Self::Follow(_) | Self::Keeper(_) | Self::Relay(_)) {
            log_errors();
        }
        command.run()
    }
}
