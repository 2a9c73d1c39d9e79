//! Requests of clients on the side of the loop: read, refused or queued; progress and answers go back to the client.

use crate::caller::Caller;
use crate::progress::Reporter;
use crate::request::{Request, parse_request};
use crate::service::Asked;
use bus::{Command, CommandError, CommandServer, Waker};
use std::collections::VecDeque;
use tracing::debug;

/// Requests that wait while the service works; more are refused.
const MAX_WAITING: usize = 16;

/// The requests of a daemon.
pub(crate) struct RequestQueue<R> {
    waiting: VecDeque<(Command, R)>,
    /// The request that the service works on, or has not answered yet.
    current: Option<Current>,
}

struct Current {
    command: Command,
    reporter: Reporter,
}

impl<R: Request> RequestQueue<R> {
    /// No requests.
    pub(crate) fn new() -> Self {
        Self { waiting: VecDeque::new(), current: None }
    }

    /// Forgets all requests: their generation of the bus is gone.
    pub(crate) fn clear(&mut self) {
        self.waiting.clear();
        self.current = None;
    }

    /// Takes the next command; false if there is none. Bytes that are no request of this daemon get an error.
    ///
    /// # Errors
    /// The bus refuses.
    pub(crate) fn take(&mut self, server: &CommandServer) -> Result<bool, CommandError> {
        let Some(command) = server.take()? else { return Ok(false) };
        match parse_request::<R>(command.bytes()) {
            Ok(request) if self.waiting.len() < MAX_WAITING => self.waiting.push_back((command, request)),
            Ok(_) => command.failed(b"too many requests wait already")?,
            Err(why) => command.failed(crate::chain(&why).as_bytes())?,
        }
        Ok(true)
    }

    /// The next request for the idle service, who sent it, and where the service reports its progress; none while a client waits for
    /// what the last one comes to.
    pub(crate) fn next(&mut self, waker: &Waker) -> Option<(R, Asked)> {
        if self.current.is_some() {
            return None;
        }
        let (command, request) = self.waiting.pop_front()?;
        let reporter = Reporter::new(waker.clone());
        let by = Caller { uid: command.caller_uid() };
        self.current = Some(Current { command, reporter: reporter.clone() });
        Some((request, Asked { by, reporter }))
    }

    /// Sends what the service reported since the last time. Progress that cannot be sent is left out; only the answer
    /// matters.
    pub(crate) fn send_progress(&self) {
        let Some(Current { command, reporter }) = &self.current else { return };
        let Some(progress) = reporter.take() else { return };
        let sent = serde_json::to_vec(&progress).map(|bytes| command.progress(&bytes));
        if let Ok(Err(why)) = sent {
            debug!(error = crate::chain(&why), "progress is not sent");
        }
    }

    /// Answers the request that the service worked on, if its client is still there.
    ///
    /// # Errors
    /// The bus refuses.
    pub(crate) fn finish(&mut self, answer: Result<&[u8], &str>) -> Result<(), CommandError> {
        if answer.is_ok() {
            self.send_progress();
        }
        let Some(Current { command, .. }) = self.current.take() else { return Ok(()) };
        match answer {
            Ok(answer) => command.done(answer),
            Err(why) => command.failed(why.as_bytes()),
        }
    }
}
