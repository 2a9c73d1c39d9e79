//! `groundplan completions`: the completion script of a shell.

use crate::failure::Failure;
use crate::run::Outcome;

/// Arguments of `completions`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Which shell
    #[arg(value_name = "SHELL")]
    shell: clap_complete::Shell,
}

impl Args {
    /// The script for a command line.
    ///
    /// # Errors
    /// A script that is no text.
    pub(crate) fn script(&self, mut program: clap::Command) -> Result<Outcome, Failure> {
        let mut script = Vec::new();
        clap_complete::generate(self.shell, &mut program, "groundplan", &mut script);
        String::from_utf8(script).map(Outcome::from).map_err(Failure::work)
    }
}
