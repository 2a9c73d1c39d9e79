//! Requests to daemons as types: which daemon a request is for, and what it answers.

use bus::Daemon;
use messages::ContentHash;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::fmt::Debug;

/// The requests of one daemon, as JSON on the bus. [`crate::Client`] sends them to that daemon and to no other.
///
/// A daemon that takes no requests has an enumeration without variants.
pub trait Request: Debug + Serialize + DeserializeOwned + Send + 'static {
    /// The daemon that takes them.
    const DAEMON: Daemon;

    /// What it answers after the effect is on disk.
    type Answer: Debug + Serialize + DeserializeOwned + Send + 'static;

    /// True if it does no harm, and leaves the same in force, however often it comes: [`crate::ask`] sends it once more where a daemon
    /// died before it answered. A request that depends on what is in force says what its client saw of that.
    fn may_be_sent_twice(&self) -> bool;
}

/// Bytes that are no request of the daemon that got them.
#[derive(Debug, thiserror::Error)]
#[error("this is no request of {daemon}")]
pub struct RequestError {
    /// The daemon.
    daemon: Daemon,
    /// What is wrong.
    source: serde_json::Error,
}

/// Reads a request that came to its daemon.
///
/// # Errors
/// Bytes that are none, or a request of another daemon.
pub fn parse_request<R: Request>(bytes: &[u8]) -> Result<R, RequestError> {
    serde_json::from_slice(bytes).map_err(|source| RequestError { daemon: R::DAEMON, source })
}

/// The last sample that a daemon published on its main topic; the default is none.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Published {
    /// Hash of its content.
    pub content_hash: ContentHash,
    /// Its epoch; 0 for none.
    pub epoch: u64,
}
