//! Errors of a link: settings, files, a session that cannot be opened, a server that does not answer.

use std::path::PathBuf;

/// Why there is no link, or no answer.
#[derive(Debug, thiserror::Error)]
pub enum LinkError {
    /// Settings that do not fit together.
    #[error("{0}")]
    Settings(String),
    /// A file of passwords that cannot be read.
    #[error("{} cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Others than its owner may read a file of passwords.
    #[error("{} can be read by others: chmod 600 {}", path.display(), path.display())]
    Shared {
        /// The file.
        path: PathBuf,
    },
    /// A file of passwords with something else in it, which is not repeated.
    #[error("{}: {what}", path.display())]
    Passwords {
        /// The file.
        path: PathBuf,
        /// Which line, and why.
        what: String,
    },
    /// The session cannot be opened: nobody listens there, the address is taken, the other end refuses who asks.
    #[error("no link {how} {endpoints}: {source}")]
    Open {
        /// As `to` or `on`.
        how: &'static str,
        /// The endpoints.
        endpoints: String,
        /// What zenoh says.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// The session does not do what it is asked for.
    #[error("the link fails: {0}")]
    Session(Box<dyn std::error::Error + Send + Sync>),
    /// There is no server at the other end, or it was not there in time.
    #[error("no server of the site answers over the link")]
    NoAnswer,
    /// The server does not take the message.
    #[error("the server refuses: {0}")]
    Refused(String),
    /// A message that is too large to be sent.
    #[error("a message of {bytes} bytes is larger than any may be")]
    TooLarge {
        /// Its length.
        bytes: usize,
    },
}
