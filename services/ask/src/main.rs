//! Answers to questions about a running site, over HTTP and the Model Context Protocol, read-only.
//!
//! # Guarantees
//!
//! - Each question is declared once (`src/questions.rs`): its type of parameters is the tool of MCP, the resource and the path of
//!   HTTP with their schemas, so that these cannot differ. `/openapi.json` is made of them.
//! - What an answer is, is said by `answers`: of the maps that are published, or of maps of another date that are drawn for the
//!   answer with the schedule, the robot and the options in force (`site-answers`). Of other dates nothing is said where one of
//!   these is not known.
//! - Every document says what it is of: epochs, plan time, whether the maps may be used now, and when it was answered. Null is
//!   what is not known, with the reason beside it.
//! - Nothing is changed: no request is sent to a daemon, nothing is published, and no file is written but the hash of the token. A
//!   panic in an answer is that answer's alone.
//! - Texts of models and schedules go out as values of JSON alone, never in a sentence for an assistant; within bounds, without
//!   characters that control terminals or hide text (`src/bounds.rs`), below a notice that they are data.
//! - Hosts and origins are checked before anything else; elsewhere than on the machine itself a token is asked for, in a header
//!   alone (`src/guard.rs`). Requests, their bodies, names, questions at once, those that wait, the time of their turn and that of
//!   drawing have bounds (`src/desk.rs`, `src/site.rs`, `site-http`). MCP has no sessions.
//! - Samples are taken while questions are answered, and answers that maps are drawn for hold others than answers at once: these
//!   do not wait for them. One answer is drawn at a time. A rasterizer of other dates is kept for five
//!   minutes after the last such question.
//!
//! # Where
//!
//! - ask: a new question: `src/questions.rs`
//! - ask: problems and their words: `src/problem.rs`

mod arguments;
mod bounds;
mod desk;
mod document;
mod follower;
mod guard;
mod http;
mod mcp;
mod problem;
mod questions;
mod schemas;
mod service;
mod site;
mod takers;

use arguments::Arguments;
use clap::Parser;
use daemon::{Failure, SiteConfig, chain};
use desk::Desk;
use mcp::McpServer;
use service::AskService;
use site::Site;
use std::process::ExitCode;
use std::sync::Arc;

fn main() -> ExitCode {
    bus::set_commit(bus::commit!());
    let Arguments { config, with_stdin, stdio, robot_name } = Arguments::parse();
    // Maps do not wait for answers.
    daemon::in_background();
    if !stdio {
        let arguments = daemon::Arguments { config, robot_name, with_stdin };
        return daemon::run_with(&arguments, |config, _activity| AskService::new(config));
    }
    let answered = SiteConfig::read(&config).map_err(Failure::from).and_then(|config| {
        let config = config.of_robot(robot_name.or(config.ask.robot))?;
        answer_client(&config)
    });
    match answered {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("groundplan-ask: {}", chain(why.as_ref()));
            ExitCode::FAILURE
        }
    }
}

/// Answers one client of MCP over standard input and output.
fn answer_client(config: &SiteConfig) -> Result<(), Failure> {
    let log = tracing_subscriber::fmt().with_writer(std::io::stderr).with_ansi(false);
    log.with_env_filter(tracing_subscriber::EnvFilter::try_from_default_env().unwrap_or_else(|_| "error".into()))
        .init();
    let site = Arc::new(Site::of(config));
    follower::follow(config, &site)?;
    let runtime =
        tokio::runtime::Builder::new_multi_thread().worker_threads(1).max_blocking_threads(6).enable_all().build()?;
    let server = McpServer::of(Desk::of(site));
    let served = runtime.block_on(server.over_stdio());
    // A read of standard input that waits is not waited for.
    runtime.shutdown_background();
    served
}
