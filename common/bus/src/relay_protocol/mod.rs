//! Protocol between a relay and its clients: frames over a Unix stream socket, samples as sealed memory files.

mod command_error;
mod frame_reader;
mod frame_writer;
mod frames;
mod sealed_memory;
mod text;

pub(crate) use frame_reader::FrameReader;
pub(crate) use frame_writer::FrameWriter;
pub(crate) use frames::{FromRelay, ProtocolError, Refusal, ToRelay, max_body_from_relay, max_body_to_relay};
pub(crate) use sealed_memory::{read_sealed, seal};

/// The socket of those who may only look.
pub(crate) const VIEW_SOCKET: &str = "view.sock";

/// The socket of those who may send commands too.
pub(crate) const CONTROL_SOCKET: &str = "control.sock";
