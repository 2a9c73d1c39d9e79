//! The interface of commands: arguments that run, and their outcome.

use crate::failure::Failure;

/// The outcome of a command that did not fail.
#[derive(Debug)]
pub struct Outcome {
    /// What is printed on standard output.
    pub text: String,
    /// True for exit code 0; false where the command did its work, but its result is negative.
    pub is_well: bool,
}

impl Outcome {
    /// Success without output.
    pub(crate) fn silent() -> Self {
        Self::from(String::new())
    }
}

impl From<String> for Outcome {
    fn from(text: String) -> Self {
        Self { text, is_well: true }
    }
}

/// The arguments of a command, which run it.
pub(crate) trait Run {
    /// Does the work of the command.
    ///
    /// # Errors
    /// Bad usage or configuration, or work that failed; see the command's own `run`.
    fn run(&self) -> Result<Outcome, Failure>;
}
