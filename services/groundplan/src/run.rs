//! What every command is: arguments that run, and what comes of them.

use crate::failure::Failure;

/// What came of a command that did not fail.
#[derive(Debug)]
pub struct Outcome {
    /// What is printed on standard output.
    pub text: String,
    /// True for exit code 0; false where the command did its work, and its text tells of something bad.
    pub is_well: bool,
}

impl Outcome {
    /// All is well, and there is nothing to say.
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
    /// Bad usage or configuration, or work that failed; the command's own `run` says which.
    fn run(&self) -> Result<Outcome, Failure>;
}
