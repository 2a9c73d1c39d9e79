//! Entry point of the operator's client, see `groundplan --help`.

use clap::Parser;
use groundplan::cli::{Cli, Command};
use std::io::{ErrorKind, IsTerminal, Write};
use std::process::ExitCode;

fn main() -> ExitCode {
    let command = Cli::parse().command;
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_env_filter(filter(&command))
        .init();
    match command.run() {
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

/// The filter of `RUST_LOG`; without it supervisors log their actions, and other commands are silent.
fn filter(command: &Command) -> tracing_subscriber::EnvFilter {
    let usual = if matches!(command, Command::Up(_) | Command::Keeper(_) | Command::Relay(_)) {
        "warn,groundplan=info"
    } else {
        "error"
    };
    tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| usual.into())
}
