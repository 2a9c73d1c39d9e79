//! iceoryx2's node of a participant: configuration, and the memory that its start needs.

use super::memory;
use crate::error::{DomainError, PortError};
use crate::generation::Place;
use iceoryx2::config::Config;
use iceoryx2::node::node_name::NodeName;
use iceoryx2::node::{Node, NodeBuilder};
use iceoryx2::prelude::{FileName, LogLevel, Path, SemanticString, set_log_level};
use iceoryx2::service::ipc_threadsafe::Service;
use iceoryx2::signal_handling_mode::SignalHandlingMode;
use std::fmt::Debug;

/// Checks that the small segments of a start can be made.
pub(super) fn require_memory() -> Result<(), DomainError> {
    let free_bytes = memory::free_bytes();
    if free_bytes < memory::RESERVE_BYTES {
        return Err(DomainError::SharedMemoryFull { free_bytes, needed_bytes: memory::RESERVE_BYTES });
    }
    Ok(())
}

/// Opening a port makes small segments, which must find room.
pub(super) fn check_memory() -> Result<(), PortError> {
    let free_bytes = memory::free_bytes();
    if free_bytes < memory::RESERVE_BYTES / 2 { Err(PortError::SharedMemoryFull { free_bytes }) } else { Ok(()) }
}

pub(super) fn refused(what: impl Into<String>, reason: impl Debug) -> DomainError {
    DomainError::Refused { what: what.into(), reason: format!("{reason:?}") }
}

/// Configuration of a generation; never the library's own search, which depends on the working directory.
fn config(place: &Place, generation: u64) -> Result<Config, DomainError> {
    // The library's words about a failure come back in its errors; alone they would appear without a context.
    set_log_level(LogLevel::Fatal);
    let mut config = Config::default();
    let folder = place.folder_of(generation);
    let folder = folder.to_str().unwrap_or_default();
    config.global.prefix = FileName::new(place.prefix_of(generation).as_bytes()).map_err(|e| refused("prefix", e))?;
    config.global.set_root_path(&Path::new(folder.as_bytes()).map_err(|e| refused("folder", e))?);
    Ok(config)
}

pub(super) fn node(place: &Place, generation: u64, name: &str) -> Result<Node<Service>, DomainError> {
    let name = format!("{name}-{}", std::process::id());
    let node = NodeBuilder::new()
        .name(&NodeName::new(&name).map_err(|e| refused("node name", e))?)
        .config(&config(place, generation)?)
        .signal_handling_mode(SignalHandlingMode::Disabled)
        .create::<Service>()
        .map_err(|e| refused("node", e))?;
    // Ports of a daemon that died would keep its successor out.
    node.try_cleanup_dead_nodes();
    Ok(node)
}
