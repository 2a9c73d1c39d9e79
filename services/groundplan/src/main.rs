//! Entry point of the operator's client, see `groundplan --help`.

use clap::Parser;
use groundplan::cli::Cli;
use std::io::{ErrorKind, Write};
use std::process::ExitCode;

fn main() -> ExitCode {
    bus::set_commit(bus::commit!());
    daemon::run_mesh_process(ingest::mesh_task).unwrap_or_else(run)
}

fn run() -> ExitCode {
    match Cli::parse().command.run() {
        Ok(outcome) => match std::io::stdout().write_all(outcome.text.as_bytes()) {
            // The work is done; a reader that wants no more of the text, such as `head`, is no failure.
            Err(error) if error.kind() != ErrorKind::BrokenPipe => {
                eprintln!("groundplan: standard output: {error}");
                ExitCode::FAILURE
            }
            _ => ExitCode::from(outcome.exit_code),
        },
        Err(failure) => {
            eprintln!("groundplan: {failure:#}");
            failure.exit_code()
        }
    }
}
