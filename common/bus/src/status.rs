//! The status stream: heartbeats of all daemons.

use crate::error::ReceiveError;
use crate::link::{StatusSource, StatusTarget};
use crate::names::Daemon;
use crate::stamp::Stamp;
use messages::StatusRecord;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

/// Heartbeats come this often.
pub const HEARTBEAT_PERIOD: Duration = Duration::from_secs(1);

/// The sending end.
pub struct StatusWriter {
    daemon: Daemon,
    port: StatusTarget,
    sequence: AtomicU64,
}

impl StatusWriter {
    pub(crate) fn new(daemon: Daemon, port: StatusTarget) -> Self {
        Self { daemon, port, sequence: AtomicU64::new(0) }
    }

    /// Sends a heartbeat; daemon, process, sequence and stamp are filled in. False if shared memory had no room for it.
    pub fn send(&self, record: StatusRecord) -> bool {
        let record = StatusRecord {
            daemon: self.daemon as u32,
            process_id: std::process::id(),
            sequence: self.sequence.fetch_add(1, Ordering::Relaxed) + 1,
            stamp_ns: Stamp::now().0,
            ..record
        };
        self.port.send(record)
    }
}

/// The receiving end; a late one gets what is sent from now on. Who falls behind loses the oldest.
pub struct StatusReader {
    /// Streams of daemons that have nothing in common.
    ports: Vec<StatusSource>,
}

impl StatusReader {
    pub(crate) fn new(ports: Vec<StatusSource>) -> Self {
        Self { ports }
    }

    /// The next heartbeat; `None` if there is none.
    ///
    /// # Errors
    /// The bus library refuses.
    pub fn take(&self) -> Result<Option<StatusRecord>, ReceiveError> {
        for port in &self.ports {
            if let Some(record) = port.receive()? {
                return Ok(Some(record));
            }
        }
        Ok(None)
    }
}
