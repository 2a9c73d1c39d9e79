//! The interface of commands: arguments that run, and their outcome.

use crate::failure::Failure;
use serde::Serialize;

/// The outcome of a command that did not fail.
#[derive(Debug)]
pub struct Outcome {
    /// What is printed on standard output.
    pub text: String,
    /// 0, or another where the command did its work, but its result is negative; the help of the command lists them.
    pub exit_code: u8,
}

impl Outcome {
    /// Success without output.
    pub(crate) fn silent() -> Self {
        Self::from(String::new())
    }

    /// This document, and nothing else.
    ///
    /// # Errors
    /// It cannot be written as JSON.
    pub(crate) fn json(document: &impl Serialize) -> Result<Self, Failure> {
        Ok(Self::from(serde_json::to_string(document).map_err(Failure::work)? + "\n"))
    }

    /// This output; the exit code is 0 if all is well, and 1 otherwise.
    pub(crate) fn judged(text: String, is_well: bool) -> Self {
        Self { text, exit_code: u8::from(!is_well) }
    }
}

impl From<String> for Outcome {
    fn from(text: String) -> Self {
        Self { text, exit_code: 0 }
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
