//! The command line for others: completions of shells, manual pages.

use crate::cli::{Cli, CompletionsArgs, ManArgs};
use crate::failure::Failure;
use clap::CommandFactory;

/// The completion script of a shell.
///
/// # Errors
/// None; the shape is that of all commands.
pub fn completions(arguments: &CompletionsArgs) -> Result<String, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(arguments.shell, &mut Cli::command(), "groundplan", &mut script);
    String::from_utf8(script).map_err(Failure::work)
}

/// Writes a manual page for the program and each of its commands.
///
/// # Errors
/// A folder that cannot be written.
pub fn man(arguments: &ManArgs) -> Result<String, Failure> {
    let at = |e: std::io::Error| Failure::work(format!("{}: {e}", arguments.folder.display()));
    std::fs::create_dir_all(&arguments.folder).map_err(at)?;
    clap_mangen::generate_to(Cli::command(), &arguments.folder).map_err(at)?;
    Ok(String::new())
}
