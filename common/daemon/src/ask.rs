//! Client side of requests: sends one to a daemon and waits for its response, with timeouts.

use crate::failure::Failure;
use crate::request::{Answer, Request};
use bus::{Bus, CommandError, Daemon, OpenCommand, Reply};
use std::time::{Duration, Instant};

/// How long a daemon is waited for.
#[derive(Debug, Clone, Copy)]
pub struct Patience {
    /// While it is just starting.
    pub starting: Duration,
    /// In all.
    pub answer: Duration,
}

/// Asks a daemon and waits for its answer; `pause` waits for a moment between two looks. Daemons ask each other in one direction
/// only, that of the data: nobody waits for itself.
///
/// # Errors
/// Nobody serves it, it refuses, or it does not answer.
pub fn ask(
    bus: &Bus,
    daemon: Daemon,
    request: &Request,
    patience: Patience,
    mut pause: impl FnMut() -> Result<(), Failure>,
) -> Result<Answer, Failure> {
    let client = bus.command_client(daemon)?;
    let bytes = serde_json::to_vec(request)?;
    let begun = Instant::now();
    let open: OpenCommand = loop {
        match client.send(&bytes) {
            Ok(open) => break open,
            Err(CommandError::NotServed { .. }) if begun.elapsed() < patience.starting => pause()?,
            Err(why) => return Err(why.into()),
        }
    };
    loop {
        match open.take()? {
            Some(Reply::Done(bytes)) => return Ok(serde_json::from_slice(&bytes)?),
            Some(Reply::Failed(text)) => return Err(format!("{daemon}: {}", String::from_utf8_lossy(&text)).into()),
            Some(Reply::Progress(_)) => {}
            None if begun.elapsed() > patience.answer => return Err(format!("{daemon} does not answer").into()),
            None => pause()?,
        }
    }
}
