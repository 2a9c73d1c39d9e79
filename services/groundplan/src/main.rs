//! The operator's client: see `groundplan --help`.

use clap::Parser;
use groundplan::align::align;
use groundplan::changes::changes;
use groundplan::cli::{Cli, Command};
use groundplan::convert::convert;
use groundplan::deviations::deviations;
use groundplan::live;
use groundplan::manual;
use groundplan::monitor;
use groundplan::states::states;
use groundplan::tasks::tasks;
use std::io::{ErrorKind, IsTerminal, Write};
use std::process::ExitCode;

fn main() -> ExitCode {
    let command = Cli::parse().command;
    tracing_subscriber::fmt()
        .with_writer(std::io::stderr)
        .with_ansi(std::io::stderr().is_terminal())
        .with_env_filter(filter(&command))
        .init();
    // `align`, `slam-map`, `status` and `doctor` say with their exit code what their text says.
    let mut is_well = true;
    let outcome = match command {
        Command::Convert(arguments) => convert(&arguments).map(|summary| summary.text()),
        Command::States(arguments) => states(&arguments),
        Command::Changes(arguments) => changes(&arguments),
        Command::Tasks(arguments) => tasks(&arguments),
        Command::Align(arguments) => align(&arguments).map(|(text, accepted)| {
            is_well = accepted;
            text
        }),
        Command::SlamMap(arguments) => live::slam_map(&arguments).map(|(text, accepted)| {
            is_well = accepted;
            text
        }),
        Command::Deviations(arguments) => deviations(&arguments),
        Command::Confirm(arguments) => live::confirm(&arguments),
        Command::Up(arguments) => live::up(&arguments),
        Command::Down(arguments) => live::down(&arguments),
        Command::Status(arguments) => live::status(&arguments).map(|(text, healthy)| {
            is_well = healthy;
            text
        }),
        Command::Load(arguments) => live::load(&arguments),
        Command::Date(arguments) => live::date(&arguments),
        Command::Actuals(arguments) => live::actuals(&arguments),
        Command::Robot(arguments) => live::robot(&arguments),
        Command::Waypoints(arguments) => live::waypoints(&arguments),
        Command::Monitor(arguments) => monitor::monitor(&arguments),
        Command::Topic(arguments) => live::topic(&arguments),
        Command::Export(arguments) => live::export(&arguments),
        Command::Doctor(arguments) => live::doctor(&arguments).map(|(text, healthy)| {
            is_well = healthy;
            text
        }),
        Command::Completions(arguments) => manual::completions(&arguments),
        Command::Man(arguments) => manual::man(&arguments),
        Command::Keeper(arguments) => live::keeper(&arguments),
    };
    match outcome {
        Ok(text) => match std::io::stdout().write_all(text.as_bytes()) {
            // The work is done; a reader that wants no more of the text, such as `head`, is no failure.
            Err(error) if error.kind() != ErrorKind::BrokenPipe => {
                eprintln!("groundplan: standard output: {error}");
                ExitCode::FAILURE
            }
            _ if is_well => ExitCode::SUCCESS,
            _ => ExitCode::FAILURE,
        },
        Err(failure) => {
            eprintln!("groundplan: {failure:#}");
            failure.exit_code()
        }
    }
}

/// What `RUST_LOG` says; otherwise supervisors tell what they do, and other commands are silent.
fn filter(command: &Command) -> tracing_subscriber::EnvFilter {
    let usual = if matches!(command, Command::Up(_) | Command::Keeper(_)) { "warn,groundplan=info" } else { "error" };
    tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| usual.into())
}
