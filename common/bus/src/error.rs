//! Error types of the bus, one per operation.

use crate::limits::MAX_ROBOTS;
use crate::names::{Daemon, TopicName};
use crate::program_build::own_build;
use crate::robot_name::RobotName;
use messages::{ArchiveError, LAYOUT_VERSION, SampleError};
use std::path::PathBuf;

/// Why a domain, its keeper or a participant cannot be set up.
#[derive(Debug, thiserror::Error)]
pub enum DomainError {
    /// The prefix would mix domains up, or is no part of a file name.
    #[error("the prefix `{prefix}` of the bus is not 1 to 15 letters and digits and an underscore")]
    Prefix {
        /// As given.
        prefix: String,
    },
    /// The folder cannot hold the bus's files.
    #[error("the folder `{}` of the bus is not an absolute path of plain text of at most {max} bytes", root.display())]
    Root {
        /// As given.
        root: PathBuf,
        /// Bytes that a socket's name leaves for it.
        max: usize,
    },
    /// The folder holds files of others, who would be kept out of it.
    #[error(
        "the folder `{}` of the bus holds `{}`, which is not the bus's: configure a folder of its own",
        root.display(),
        other.display()
    )]
    RootInUse {
        /// The folder.
        root: PathBuf,
        /// A file in it.
        other: PathBuf,
    },
    /// Two robots of one name.
    #[error("two robots have the name `{robot}`")]
    RobotTwice {
        /// The name.
        robot: RobotName,
    },
    /// More robots than there may be.
    #[error("{n_robots} robots are named, and a site can have {MAX_ROBOTS}")]
    ManyRobots {
        /// As given.
        n_robots: usize,
    },
    /// A robot that the site does not have.
    #[error("{}", no_such_robot(*robot, robots))]
    NoSuchRobot {
        /// As given.
        robot: RobotName,
        /// The names of those that it has; empty for one without a name.
        robots: String,
    },
    /// A daemon of a robot must know which.
    #[error("{daemon} is of one robot of the site, and none is named: it has {robots}")]
    NoRobotNamed {
        /// The daemon.
        daemon: Daemon,
        /// The names of the robots.
        robots: String,
    },
    /// A file of the domain cannot be read, written or locked.
    #[error("the bus's `{}` cannot be used", path.display())]
    File {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The generation file holds something else.
    #[error("`{}` does not say which generation of the bus is current", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
    },
    /// The participants speak another layout.
    #[error(
        "the bus has layout version {found}, this program has {LAYOUT_VERSION}: start all daemons from one version"
    )]
    Version {
        /// As the keeper wrote it.
        found: u32,
    },
    /// The participants were built with another bus library.
    #[error("the bus is of `{found}`, this program of `{wanted}`: start all daemons from one version")]
    Library {
        /// As the keeper wrote it.
        found: String,
        /// As this program has it.
        wanted: &'static str,
    },
    /// The keeper is of another build.
    #[error(
        "the bus is of groundplan {found}, and this program is of {}: use one build for all of a site (groundplan down, then up)",
        own_build()
    )]
    Build {
        /// As the keeper wrote it.
        found: String,
    },
    /// No keeper has created the bus.
    #[error("no keeper has created the bus in `{root}`: run `groundplan up`")]
    NoKeeper {
        /// Its folder, or the name of the double.
        root: String,
    },
    /// Only the bus's own user takes part in it.
    #[error("the bus belongs to {owner}: run this as that user")]
    Foreign {
        /// The bus's user.
        owner: String,
    },
    /// Another user's bus, without a relay.
    #[error("the bus belongs to {owner}, and its relay in `{}` cannot be used: {reason}", folder.display())]
    NoRelay {
        /// The bus's user.
        owner: String,
        /// The relay's folder.
        folder: PathBuf,
        /// What is the matter.
        reason: String,
    },
    /// Another user's bus, whose relay does not serve this one.
    #[error("the bus belongs to {owner}, and {}", access_hint(groups))]
    NoAccess {
        /// The bus's user.
        owner: String,
        /// Groups that its relay serves.
        groups: Vec<String>,
    },
    /// The folder of the relay's sockets.
    #[error("the folder `{}` of the relay is not an absolute path of at most {max} bytes", folder.display())]
    RelayFolder {
        /// As given.
        folder: PathBuf,
        /// Bytes that a socket's name leaves for it.
        max: usize,
    },
    /// There is one already.
    #[error("another relay serves `{}`", folder.display())]
    RelayRuns {
        /// Its folder.
        folder: PathBuf,
    },
    /// There is one already.
    #[error("another keeper holds the bus in `{root}`")]
    KeeperRuns {
        /// Its folder, or the name of the double.
        root: String,
    },
    /// As many processes as there may be.
    #[error(
        "{max} processes are on the bus, as many as there can be: stop one, such as a robot's program or a monitor"
    )]
    Full {
        /// How many.
        max: usize,
    },
    /// Shared memory is full.
    #[error("only {free_bytes} bytes of shared memory are free, the bus needs {needed_bytes} to start")]
    SharedMemoryFull {
        /// Bytes free.
        free_bytes: u64,
        /// Bytes needed.
        needed_bytes: u64,
    },
    /// The bus library refuses.
    #[error("{what} of the bus cannot be set up: {reason}")]
    Refused {
        /// Which part.
        what: String,
        /// Its word for it.
        reason: String,
    },
}

fn access_hint(groups: &[String]) -> String {
    match groups {
        [] => "its relay serves no group: name view_group and control_group in [relay] of the site's configuration"
            .to_owned(),
        groups => format!(
            "this user is in none of the groups that may use it ({}): `usermod -aG GROUP USER`, and log in again",
            groups.join(", ")
        ),
    }
}

fn no_such_robot(robot: RobotName, robots: &str) -> String {
    match robots {
        "" => format!("the site has no robot `{robot}`: its only robot has no name"),
        robots => format!("the site has no robot `{robot}`: it has {robots}"),
    }
}

/// What a user without the right to command is told to do.
fn control_hint(group: &str) -> String {
    if group.is_empty() {
        "no group may: name control_group in [relay] of the site's configuration".to_owned()
    } else {
        format!("commands are for the group {group}: `usermod -aG {group} USER`, and log in again")
    }
}

/// Why a publisher, subscriber, server or client cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum PortError {
    /// A topic has one producer.
    #[error("{daemon} does not publish `{topic}`, {} does", topic.producer())]
    NotTheProducer {
        /// Who asked.
        daemon: Daemon,
        /// For what.
        topic: TopicName,
    },
    /// Each robot has its own, and none is named.
    #[error("`{what}` is of one robot of the site, and none is named: it has {robots}")]
    NoRobotNamed {
        /// Which topic or command.
        what: String,
        /// The names of the robots.
        robots: String,
    },
    /// The end is for the bus's own user.
    #[error("`{what}` is for {owner} alone, to whom the bus belongs")]
    OwnerOnly {
        /// Which topic or stream.
        what: String,
        /// The bus's user.
        owner: String,
    },
    /// This user may look at the bus, and send no commands.
    #[error("the bus belongs to {owner}, and this user may look at it only: {}", control_hint(group))]
    ViewOnly {
        /// The bus's user.
        owner: String,
        /// The group that may send commands; empty if there is none.
        group: String,
    },
    /// Another process has this end.
    #[error("`{what}` is taken by another process")]
    Taken {
        /// Which topic or command.
        what: String,
    },
    /// As many as the service was made for.
    #[error(
        "`{what}` has {max} participants, as many as it can have: stop one, such as a robot's program, a monitor or an export that follows"
    )]
    Full {
        /// Which topic or command.
        what: String,
        /// How many.
        max: usize,
    },
    /// The keeper's end is not there: it died, and the next one creates it.
    #[error("`{what}` is not there at the moment: the bus is being created anew")]
    Missing {
        /// Which topic, command or event.
        what: String,
    },
    /// Shared memory is full.
    #[error("only {free_bytes} bytes of shared memory are free")]
    SharedMemoryFull {
        /// Bytes free.
        free_bytes: u64,
    },
    /// The bus library refuses.
    #[error("`{what}` cannot be opened: {reason}")]
    Refused {
        /// Which topic or command.
        what: String,
        /// Its word for it.
        reason: String,
    },
}

/// Why there is no memory for a sample, or it was not sent. The last epoch stays in place.
#[derive(Debug, thiserror::Error)]
pub enum PublishError {
    /// Larger than any sample may be.
    #[error("a sample of {length} bytes is larger than {max}")]
    TooLarge {
        /// As asked for.
        length: usize,
        /// The limit.
        max: usize,
    },
    /// Shared memory is full.
    #[error("shared memory has no room for {length} bytes, {free_bytes} are free")]
    NoMemory {
        /// As asked for.
        length: usize,
        /// Bytes free.
        free_bytes: u64,
    },
    /// The publisher has a loan that is neither published nor dropped.
    #[error("the publisher of `{topic}` has given out its only loan")]
    LoanedOut {
        /// Of which topic.
        topic: TopicName,
    },
    /// What was written is not an archive of the topic.
    #[error("what was written for `{topic}` cannot be published")]
    Archive {
        /// Of which topic.
        topic: TopicName,
        /// Why.
        source: ArchiveError,
    },
    /// Epochs never fall.
    #[error("epoch {epoch} of `{topic}` comes after epoch {last}")]
    EpochFell {
        /// Of which topic.
        topic: TopicName,
        /// As given.
        epoch: u64,
        /// As published before.
        last: u64,
    },
    /// The bus library refuses.
    #[error("a sample of `{topic}` cannot be sent: {reason}")]
    Refused {
        /// Of which topic.
        topic: TopicName,
        /// Its word for it.
        reason: String,
    },
}

/// Why a sample cannot be received. The subscriber goes on with the next one.
#[derive(Debug, thiserror::Error)]
pub enum ReceiveError {
    /// Not a sample that this program can read.
    #[error("a sample of `{topic}` cannot be read")]
    Sample {
        /// Of which topic.
        topic: TopicName,
        /// Why.
        source: SampleError,
    },
    /// Epochs never fall: the sample is left out.
    #[error("epoch {epoch} of `{topic}` came after epoch {last}")]
    EpochFell {
        /// Of which topic.
        topic: TopicName,
        /// As received.
        epoch: u64,
        /// As received before.
        last: u64,
    },
    /// The caller keeps as many samples as it may.
    #[error("{held} samples of `{topic}` are held, one must be dropped first")]
    TooManyHeld {
        /// Of which topic.
        topic: TopicName,
        /// How many.
        held: usize,
    },
    /// The bus library refuses.
    #[error("`{what}` cannot be received: {reason}")]
    Refused {
        /// Which topic or stream.
        what: String,
        /// Its word for it.
        reason: String,
    },
}

/// Why a command is not carried out, or not known to be.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// No process serves commands to it.
    #[error("{daemon} is not running")]
    NotServed {
        /// The daemon.
        daemon: Daemon,
    },
    /// It died or gave the command up before it answered.
    #[error("{daemon} went away before it answered; whether the command took effect is not known")]
    Lost {
        /// The daemon.
        daemon: Daemon,
    },
    /// Larger than any command or reply may be.
    #[error("a command or reply of {length} bytes is larger than {max}")]
    TooLarge {
        /// As given.
        length: usize,
        /// The limit.
        max: usize,
    },
    /// The client waits for as many answers as it may.
    #[error("{daemon} has as many open commands of this client as it can have")]
    TooMany {
        /// The daemon.
        daemon: Daemon,
    },
    /// Shared memory is full.
    #[error("shared memory has no room for {length} bytes, {free_bytes} are free")]
    NoMemory {
        /// As needed.
        length: usize,
        /// Bytes free.
        free_bytes: u64,
    },
    /// The bus library refuses.
    #[error("a command to {daemon} cannot be passed on: {reason}")]
    Refused {
        /// The daemon.
        daemon: Daemon,
        /// Its word for it.
        reason: String,
    },
}

/// Why waiting failed.
#[derive(Debug, thiserror::Error)]
#[error("the bus cannot be waited on")]
pub struct WaitError {
    /// Why.
    #[from]
    pub source: std::io::Error,
}
