//! A daemon that asks another.

use crate::request::{Answer, Request};
use crate::service::Failure;
use bus::{Bus, CommandError, Daemon, Reply};
use std::time::{Duration, Instant};

/// A daemon that does not answer within this time is not asked further.
const PATIENCE: Duration = Duration::from_secs(30);
const LOOK: Duration = Duration::from_millis(2);

/// Asks another daemon and waits for its answer. Daemons ask in one direction only, that of the data: nobody waits for itself.
///
/// # Errors
/// Nobody serves it, it refuses, or it does not answer.
pub fn ask(bus: &Bus, daemon: Daemon, request: &Request) -> Result<Answer, Failure> {
    let client = bus.command_client(daemon)?;
    let bytes = serde_json::to_vec(request)?;
    let begun = Instant::now();
    let mut open = None;
    while begun.elapsed() < PATIENCE {
        match &open {
            None => match client.send(&bytes) {
                Ok(sent) => open = Some(sent),
                // It is just starting.
                Err(CommandError::NotServed { .. }) => {}
                Err(why) => return Err(why.into()),
            },
            Some(sent) => match sent.take()? {
                Some(Reply::Done(bytes)) => return Ok(serde_json::from_slice(&bytes)?),
                Some(Reply::Failed(text)) => return Err(format!("{daemon}: {}", String::from_utf8_lossy(&text)).into()),
                Some(Reply::Progress(_)) => continue,
                None => {}
            },
        }
        std::thread::sleep(LOOK);
    }
    Err(format!("{daemon} does not answer").into())
}
