//! Archives in shared memory: latched topics, a status stream, commands. The only crate that names iceoryx2, and the only
//! one with unsafe code.
//!
//! A [`Keeper`] creates a [`Domain`]'s services; everybody else joins as a [`Bus`], opens ends, and sleeps in its
//! [`Waiter`]. A [`Publisher`] lends memory in which an archive is written in place; a [`Subscriber`] reads it in place,
//! and gets the last one however late it comes. [`ConsistentSet`] tells a consumer which grids and which plan belong
//! together. [`Domain::in_process`] is a double with the same behaviour, without shared memory.
//!
//! ```
//! use bus::{Bus, Daemon, Domain, Keeper, Origin, Topic};
//! use messages::{InputHashes, Phase, PhaseBuilder};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let domain = Domain::in_process(1 << 20);
//! let _keeper = Keeper::start(&domain)?;
//!
//! let (producer, _waiter) = Bus::join(&domain, Daemon::ScheduleEval)?;
//! let phases = producer.publisher(Topic::Phase, 4096)?;
//! let archive = PhaseBuilder::everything_built(7, 3, 1).finish();
//! phases.publish_copy(archive.bytes(), Origin { epoch: 1, frame_epoch: 0, inputs: InputHashes::default() })?;
//!
//! let (consumer, _waiter) = Bus::join(&domain, Daemon::Rasterize)?;
//! let late = consumer.subscriber(Topic::Phase)?;
//! let sample = late.take()?.expect("the last sample is there");
//! assert_eq!(Phase::open(sample.bytes())?.n_elements(), 3);
//! # Ok(())
//! # }
//! ```

mod bell;
mod bus;
mod command;
mod consistent_set;
mod domain;
mod error;
mod generation;
mod ipc;
mod keeper;
mod latched;
mod local;
mod names;
mod signal;
mod stamp;
mod status;
mod waiter;

pub use bus::Bus;
pub use command::{Command, CommandClient, CommandServer, MAX_COMMAND_BYTES, MAX_OPEN, OpenCommand, Reply};
pub use consistent_set::{ConsistentSet, GRIDS_LATE, HEARTBEAT_PERIOD, MISSED_HEARTBEATS, NoMap, Verdict};
pub use domain::Domain;
pub use error::{CommandError, DomainError, PortError, PublishError, ReceiveError, WaitError};
pub use keeper::Keeper;
pub use latched::{Loan, MAX_HELD, MAX_SAMPLE_BYTES, Origin, Publisher, Sample, Subscriber};
pub use names::{Daemon, GridSlot, Topic};
pub use stamp::Stamp;
pub use status::{StatusReader, StatusWriter};
pub use waiter::{Nudger, Stopper, Waiter, Wake};
