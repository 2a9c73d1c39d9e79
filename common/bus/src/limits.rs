//! Bounds of the bus: processes and clients on it, bytes of a sample and of a command. Who is one too many gets an error that says
//! so; nobody else notices. Bounds of single frames and of files of the bus are beside what reads them.
//!
//! | of | at most |
//! |---|---|
//! | processes of the bus's user on the bus, the keeper, the daemons and the relay among them | 64 |
//! | subscribers of a topic, of each grid too; one of them is the relay, however many clients it has | 40 |
//! | subscribers of the status stream | 40 |
//! | of these, kept for daemons and commands: guests do not take them | 12 |
//! | processes that send commands to a daemon at once | 16 |
//! | clients of each socket of the relay | 64, the last 16 of them for users who have none yet |
//! | of them, of one user | 16 |
//! | named robots of a site, because their daemons are readers of the same topics | 4 |
//! | bytes of outdated samples that clients of one user of the relay have not taken for 10 s | 256 MiB |
//!
//! Guests are robots' programs: those that join as [`Daemon::Robot`](crate::Daemon::Robot), and those of the package for Python.
//! A guest has one listener for each daemon whose topics it reads, however many these are. A program that uses the bus library alone
//! knows of no guests.
//!
//! A monitor, an `export --watch` and a robot's program are one subscriber each of the topics that they follow.

use std::time::Duration;

/// Bytes of the largest sample.
pub const MAX_SAMPLE_BYTES: usize = 8 << 30;

/// Samples of one subscriber that its owner may hold at once: one in use, one complete, one that has just come.
pub const MAX_HELD: usize = 3;

/// Bytes of the largest command and of the largest reply.
pub const MAX_COMMAND_BYTES: usize = 16 << 20;

/// Commands that a client may have open at once.
pub const MAX_OPEN: usize = 2;

/// Processes that may take part in one service: the keeper, the daemons, clients.
pub(crate) const MAX_NODES: usize = 64;

/// Places of every topic and event service that guests leave to daemons and commands; `common/python` has the same number.
pub(crate) const KEPT_PLACES: usize = 12;

/// Named robots of a site. Each has 4 daemons and 1 program, which are readers of `site` and `schedule-state`.
pub const MAX_ROBOTS: usize = 4;

/// Bytes of the name of a robot.
pub(crate) const MAX_ROBOT_NAME_BYTES: usize = 32;

/// Clients of each socket of the relay.
pub(crate) const MAX_CONNECTIONS: usize = 64;

/// Clients of one user on each socket.
pub(crate) const MAX_CONNECTIONS_OF_USER: usize = 16;

/// Of [`MAX_CONNECTIONS`], those for users who have none yet: a few users do not keep all others out.
pub(crate) const MAX_FIRST_CONNECTIONS: usize = 16;

/// Bytes of outdated samples that the clients of one user have not taken after [`TAKE_TIMEOUT`]. A client of ours takes
/// what comes within a second, however large it is.
pub(crate) const MAX_OUTDATED_BYTES: u64 = 256 << 20;

/// A client that has not taken a sample for this long is slow.
pub(crate) const TAKE_TIMEOUT: Duration = Duration::from_secs(10);

/// Readers of one topic or of the status stream.
pub(crate) const MAX_SUBSCRIBERS: usize = 40;

/// Samples of a topic that a subscriber has in hand: what its owner holds, the next one, and a look beyond.
pub(crate) const MAX_BORROWED: usize = MAX_HELD + 2;

/// Heartbeats that a reader may be behind.
pub(crate) const STATUS_BUFFER: usize = 64;

/// Clients of one daemon's commands.
pub(crate) const MAX_CLIENTS: usize = 16;

/// Replies that a client may be behind; the oldest give way, so that the last one always arrives.
pub(crate) const REPLY_BUFFER: usize = 16;
