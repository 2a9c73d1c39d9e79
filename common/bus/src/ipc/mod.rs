//! The bus in shared memory, and the heap's memory: the only module with unsafe code.
#![expect(unsafe_code, reason = "shared memory, and calls of the allocator; every block says why it is sound")]

mod command;
mod event_port;
mod heap;
mod held_services;
mod latched;
mod membership;
mod memory;
mod node;
mod services;
mod status;
mod wire;

pub(crate) use command::{Client, Exchange, Served, Server};
pub use heap::{give_back_freed_memory, keep_freed_memory, share_heap};
pub(crate) use latched::{Memory, TopicReader, TopicSample, TopicWriter};
pub(crate) use status::{StatusSource, StatusTarget};

pub(crate) use held_services::Services;
pub(crate) use membership::Membership;
