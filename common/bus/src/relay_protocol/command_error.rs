//! Errors of commands as bytes: what a client of the relay is told is what a participant of the bus is told.

use super::text::text_bytes;
use crate::error::CommandError;
use crate::names::Daemon;

/// Code and daemon, two numbers, and a text.
pub(super) fn command_error_body(error: &CommandError) -> Vec<u8> {
    let (code, daemon, first, second, text) = match error {
        CommandError::NotServed { daemon } => (1u32, *daemon, 0, 0, ""),
        CommandError::Lost { daemon } => (2, *daemon, 0, 0, ""),
        CommandError::TooLarge { length, max } => (3, Daemon::Groundplan, *length as u64, *max as u64, ""),
        CommandError::TooMany { daemon } => (4, *daemon, 0, 0, ""),
        CommandError::NoMemory { length, free_bytes } => (5, Daemon::Groundplan, *length as u64, *free_bytes, ""),
        CommandError::Refused { daemon, reason } => (6, *daemon, 0, 0, reason.as_str()),
    };
    let mut body = Vec::from(code.to_ne_bytes());
    body.extend((daemon as u32).to_ne_bytes());
    body.extend(first.to_ne_bytes());
    body.extend(second.to_ne_bytes());
    body.extend(text_bytes(text));
    body
}

/// `None` for bytes that are none.
pub(super) fn parse_command_error(body: &[u8]) -> Option<CommandError> {
    let (code, rest) = body.split_first_chunk()?;
    let (daemon, rest) = rest.split_first_chunk()?;
    let (first, rest) = rest.split_first_chunk()?;
    let (second, text) = rest.split_first_chunk()?;
    let daemon = Daemon::from_id(u32::from_ne_bytes(*daemon))?;
    let (first, second) = (u64::from_ne_bytes(*first), u64::from_ne_bytes(*second));
    Some(match u32::from_ne_bytes(*code) {
        1 => CommandError::NotServed { daemon },
        2 => CommandError::Lost { daemon },
        3 => CommandError::TooLarge { length: usize::try_from(first).ok()?, max: usize::try_from(second).ok()? },
        4 => CommandError::TooMany { daemon },
        5 => CommandError::NoMemory { length: usize::try_from(first).ok()?, free_bytes: second },
        6 => CommandError::Refused { daemon, reason: String::from_utf8_lossy(text).into_owned() },
        _ => return None,
    })
}
