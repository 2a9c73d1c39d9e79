//! Errors of commands and their exit codes.

use std::error::Error;
use std::fmt;
use std::process::ExitCode;

/// A command that did not succeed. `{:#}` prints the chain of causes.
#[derive(Debug)]
pub enum Failure {
    /// Bad usage or configuration: exit code 2.
    Usage(Box<dyn Error + Send + Sync>),
    /// The work failed: exit code 1.
    Work(Box<dyn Error + Send + Sync>),
}

impl Failure {
    /// 2 for bad usage or configuration, 1 otherwise.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.code())
    }

    /// The same as a number.
    pub(crate) fn code(&self) -> u8 {
        match self {
            Self::Usage(_) => 2,
            Self::Work(_) => 1,
        }
    }

    /// Bad usage or configuration.
    pub fn usage(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::Usage(error.into())
    }

    /// Failed work.
    pub fn work(error: impl Into<Box<dyn Error + Send + Sync>>) -> Self {
        Self::Work(error.into())
    }
}

impl From<messages::ArchiveError> for Failure {
    fn from(why: messages::ArchiveError) -> Self {
        Self::work(why)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (Self::Usage(error) | Self::Work(error)) = self;
        write!(f, "{error}")?;
        let mut cause = error.source();
        while let (true, Some(error)) = (f.alternate(), cause) {
            write!(f, ": {error}")?;
            cause = error.source();
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_chain_is_printed_on_demand() {
        let number = "x".parse::<i32>().unwrap_err();
        let failure = Failure::work(std::io::Error::other(number));
        assert_eq!(failure.to_string(), "invalid digit found in string");
        assert!(format!("{failure:#}").starts_with("invalid digit"));
    }
}
