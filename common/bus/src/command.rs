//! Commands to a daemon: one request, any number of progress replies, one final reply.

use crate::error::CommandError;
use crate::ipc;
use crate::limits::MAX_COMMAND_BYTES;
use crate::link::{CommandTarget, Exchange};
use crate::reply_kind::ReplyKind;

/// A reply to a command.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Reply {
    /// Progress; more replies follow. A slow client gets only the last ones.
    Progress(Vec<u8>),
    /// The effect is on disk. The last reply.
    Done(Vec<u8>),
    /// There is no effect. The last reply.
    Failed(Vec<u8>),
}

impl Reply {
    /// True if no reply follows.
    pub fn is_final(&self) -> bool {
        !matches!(self, Self::Progress(_))
    }
}

fn check_length(bytes: &[u8]) -> Result<(), CommandError> {
    if bytes.len() > MAX_COMMAND_BYTES {
        return Err(CommandError::TooLarge { length: bytes.len(), max: MAX_COMMAND_BYTES });
    }
    Ok(())
}

/// The answering end of a daemon's commands. The only one.
pub struct CommandServer {
    port: ipc::Server,
}

impl CommandServer {
    pub(crate) fn new(port: ipc::Server) -> Self {
        Self { port }
    }

    /// The next command; `None` if there is none.
    ///
    /// # Errors
    /// The bus library refuses.
    pub fn take(&self) -> Result<Option<Command>, CommandError> {
        Ok(self.port.receive()?.map(|served| Command { served }))
    }
}

/// A command to be carried out. Dropped without a final reply, it is lost to the client.
pub struct Command {
    served: ipc::Served,
}

impl Command {
    /// What the client sent.
    pub fn bytes(&self) -> &[u8] {
        self.served.bytes()
    }

    /// Number of the user who sent it: the one whom the system named to the relay, or the bus's own user.
    pub fn caller_uid(&self) -> u32 {
        self.served.caller_uid()
    }

    /// True if the client no longer waits for the answer.
    pub fn is_cancelled(&self) -> bool {
        self.served.is_cancelled()
    }

    /// Tells the client how far it is. A client that is gone is no error.
    ///
    /// # Errors
    /// Too many bytes, no room in shared memory.
    pub fn progress(&self, bytes: &[u8]) -> Result<(), CommandError> {
        self.reply(ReplyKind::Progress, bytes)
    }

    /// Tells the client that the effect is on disk.
    ///
    /// # Errors
    /// As [`Command::progress`].
    pub fn done(self, bytes: &[u8]) -> Result<(), CommandError> {
        self.reply(ReplyKind::Done, bytes)
    }

    /// Tells the client why there is no effect.
    ///
    /// # Errors
    /// As [`Command::progress`].
    pub fn failed(self, bytes: &[u8]) -> Result<(), CommandError> {
        self.reply(ReplyKind::Failed, bytes)
    }

    fn reply(&self, kind: ReplyKind, bytes: &[u8]) -> Result<(), CommandError> {
        check_length(bytes)?;
        self.served.reply(kind, bytes)
    }
}

/// The asking end of a daemon's commands.
pub struct CommandClient {
    port: CommandTarget,
}

impl CommandClient {
    pub(crate) fn new(port: CommandTarget) -> Self {
        Self { port }
    }

    /// Sends a command. Its replies wake the bus's [`crate::Waiter`].
    ///
    /// # Errors
    /// The daemon is not running, too many bytes, [`crate::MAX_OPEN`] commands are open.
    pub fn send(&self, bytes: &[u8]) -> Result<OpenCommand, CommandError> {
        self.send_for(bytes, rustix::process::geteuid().as_raw())
    }

    /// Sends a command in the name of a user.
    pub(crate) fn send_for(&self, bytes: &[u8], uid: u32) -> Result<OpenCommand, CommandError> {
        check_length(bytes)?;
        Ok(OpenCommand { exchange: self.port.send(bytes, uid)? })
    }
}

/// A command that waits for its replies; dropping it cancels the command.
pub struct OpenCommand {
    exchange: Exchange,
}

impl OpenCommand {
    /// The next reply; `None` if there is none yet. Callers put a deadline on the whole.
    ///
    /// # Errors
    /// The daemon went away; seen when the keeper has cleaned up behind it.
    pub fn take(&self) -> Result<Option<Reply>, CommandError> {
        let reply = self.exchange.receive()?;
        Ok(reply.map(|(kind, bytes)| match kind {
            ReplyKind::Progress => Reply::Progress(bytes),
            ReplyKind::Done => Reply::Done(bytes),
            ReplyKind::Failed => Reply::Failed(bytes),
        }))
    }
}
