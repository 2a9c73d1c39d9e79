//! The operator's client: see `groundplan --help`.

use clap::Parser;
use groundplan::changes::changes;
use groundplan::cli::{Cli, Command};
use groundplan::convert::convert;
use groundplan::states::states;
use std::io::{ErrorKind, IsTerminal, Write};
use std::process::ExitCode;

fn main() -> ExitCode {
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_env_filter(tracing_subscriber::EnvFilter::from_default_env())
        .init();
    let outcome = match Cli::parse().command {
        Command::Convert(arguments) => convert(&arguments).map(|summary| summary.text()),
        Command::States(arguments) => states(&arguments),
        Command::Changes(arguments) => changes(&arguments),
    };
    match outcome {
        Ok(text) => match std::io::stdout().write_all(text.as_bytes()) {
            // The work is done; a reader that wants no more of the text, such as `head`, is no failure.
            Err(error) if error.kind() != ErrorKind::BrokenPipe => {
                eprintln!("groundplan: standard output: {error}");
                ExitCode::FAILURE
            }
            _ => ExitCode::SUCCESS,
        },
        Err(failure) => {
            eprintln!("groundplan: {failure:#}");
            failure.exit_code()
        }
    }
}
