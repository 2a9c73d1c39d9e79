//! Archives in shared memory: latched topics, a status stream, commands. The only crate that names iceoryx2, and the only
//! one with unsafe code.
//!
//! A [`Keeper`] creates a [`Domain`]'s services; all other processes join as a [`Bus`], open ports, and wait in its
//! [`Waiter`]. A [`Publisher`] lends memory in which an archive is written in place, or copies one that is in the heap;
//! a [`Subscriber`] reads it in place, and gets the last one when it joins late. Tests that simulate a site have an
//! [`InProcessBus`].
//!
//! Other programs attach as subscribers: the example `read_grid` in Rust, `scripts/python_subscriber.py` with the iceoryx2 wheel
//! and numpy; both read grids in place. For people:
//!
//! ```text
//! groundplan topic list                # topics that have a sample, with producer, epoch and age
//! groundplan topic echo grids          # the index of the grids with its hashes
//! groundplan topic hz grid/00          # how often samples come, and how long they take
//! ```
//!
//! ```
//! use bus::{Bus, Daemon, Domain, Keeper, Origin, topics};
//! use messages::{ContentHash, InputHashes, ScheduleStateBuilder};
//! use std::time::Duration;
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let root = tempfile::Builder::new().prefix("bus").tempdir_in("/dev/shm")?;
//! # let (prefix, root) = (format!("gd{:x}_", std::process::id()), root.path());
//! let domain = Domain::shared(&prefix, root)?;
//! let _keeper = Keeper::start(&domain)?;
//!
//! let (producer, mut waiter) = Bus::join(&domain, Daemon::ScheduleEval)?;
//! let schedule_states = producer.publisher(topics::ScheduleState, 4096)?;
//! schedule_states.publish(&ScheduleStateBuilder::everything_built(ContentHash::from_bits(7), 3, 1), Origin { epoch: 1, frame_epoch: 0, inputs: InputHashes::default() })?;
//!
//! let (consumer, _waiter) = Bus::join(&domain, Daemon::Rasterize)?;
//! let late = consumer.subscriber(topics::ScheduleState)?;
//! // The producer's waiter delivers the last sample to late joiners.
//! waiter.wait(Duration::from_secs(1))?;
//! let sample = late.take()?.expect("the last sample is there");
//! assert_eq!(sample.check()?.view().n_elements(), 3);
//! # Ok(())
//! # }
//! ```
//!
//! # Guarantees
//!
//! - One keeper creates all services of the bus; every other process only opens them. A creation that was killed leads to a
//!   new generation, and is not repaired; nor is a bus of which a segment, the folder or a file in it was deleted or
//!   replaced.
//! - The bus is for the user alone who owns its folder (mode 0700); no segment is for anybody else. `Bus::join` of another
//!   user, root included, goes through the relay and creates nothing in the bus; ports have the same types either way.
//! - Participants of a bus are of the build of its keeper (`src/program_build.rs` says which builds are the same): others are
//!   refused, and a keeper of another build makes a new generation, so that those that are there are refused, too.
//! - The relay knows who sends a command from the system, not from the client, and passes the user's number on with it. It
//!   holds one copy of the newest sample of each topic that is followed, sealed against changes, and one frame for each
//!   client; a slow client misses samples and holds up nobody.
//! - A topic has one publisher. Its epoch never falls, also across restarts; a late joiner gets the last sample.
//! - The memory of a sample does not change while it is held, also if its publisher dies.
//! - A sample that finds no memory is refused at once, with the bytes that it wants and that are free (`ipc/memory.rs`); the memory of a
//!   topic grows with its samples, at least to the double each time (`ipc/latched.rs`). The bus never waits.
//! - Samples of different topics come in any order; those of one state of the site are a `SiteSet`, and every consumer asks
//!   for it instead of comparing hashes.
//! - Every sample is read in place; clients of the relay read a copy. The index of the grids is also written in place; all
//!   else is built in the heap and copied once: site, schedule state, mission plan, alignment and deviations are compared
//!   with what was published last and published again in the next generation, and the rasterizer keeps its grids to redraw
//!   only what differs. Memory that it is lent for a grid holds an earlier sample of it: it writes only the cells that
//!   differ.
//!
//! # Where
//!
//! - bus: what a relay and its clients say to each other: `src/relay_protocol/frames.rs`

mod accounts;
mod bounded_queue;
mod bus;
mod chain;
mod command;
mod domain;
mod error;
mod file_lock;
#[cfg(test)]
mod foreign_files;
mod generation;
mod held_files;
mod in_process;
mod ipc;
mod keeper;
mod latched;
mod limits;
mod link;
mod names;
mod program_build;
mod relay;
mod relay_access;
mod relay_link;
mod relay_protocol;
mod reply_kind;
mod report_kind;
mod robot_name;
mod segments;
mod signal;
mod stamp;
mod status;
pub mod topics;
mod waiter;
mod wakeup;

pub use accounts::names_of_users;
pub use bus::{Bus, relayed_report};
pub use chain::chain;
pub use command::{Command, CommandClient, CommandServer, OpenCommand, Reply};
pub use domain::Domain;
pub use error::{CommandError, DomainError, PortError, PublishError, ReceiveError, WaitError};
pub use in_process::{DeathAtLoan, InProcessBus};
pub use ipc::{give_back_freed_memory, keep_freed_memory, share_heap};
pub use keeper::Keeper;
pub use latched::{CheckedSample, Loan, Origin, Publisher, RawSample, RawSubscriber, Sample, Sent, Subscriber};
pub use limits::{MAX_COMMAND_BYTES, MAX_HELD, MAX_OPEN, MAX_ROBOTS, MAX_SAMPLE_BYTES};
pub use names::{Daemon, GridSlot, TopicName};
pub use program_build::{is_same_build, own_build, set_commit};
pub use relay::{Relay, RelayEvent, RelayOptions};
pub use report_kind::ReportKind;
pub use robot_name::{RobotName, RobotNameError, names_of_robots};
pub use stamp::Stamp;
pub use status::{HEARTBEAT_PERIOD, StatusReader, StatusWriter};
pub use topics::Topic;
pub use waiter::{Stopper, Waiter, Wake, Waker};
