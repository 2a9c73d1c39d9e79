//! Entry point of a daemon process: command line, configuration, log.

use crate::config::SiteConfig;
use crate::failure::{Failure, chain};
use crate::log::Log;
use crate::request::Request;
use crate::service::{CurrentActivity, Service};
use crate::service_loop::{Reload, ServiceLoop};
use crate::state::StateError;
use crate::state_version::{StateVersionError, claim_state};
use crate::stop::{ReloadSignal, StopSignal};
use bus::{Daemon, RobotName};
use clap::{CommandFactory, FromArgMatches, Parser};
use std::path::PathBuf;
use std::process::ExitCode;
use tracing::error;

/// A daemon of groundplan: `groundplan up` starts it. It stops on SIGTERM.
#[derive(Debug, Clone, Parser)]
#[command(version = bus::own_build())]
pub struct Arguments {
    /// Configuration of the site, see config/site.toml
    #[arg(long, value_name = "FILE")]
    pub config: PathBuf,

    /// The robot whose daemon this is, of a site with several
    #[arg(long, value_name = "NAME")]
    pub robot_name: Option<RobotName>,

    /// Stop when standard input ends, so that the daemon ends with the process that started it
    #[arg(long)]
    pub with_stdin: bool,
}

/// Lowers the priority of this process: for daemons whose results are not needed within milliseconds. Called before any
/// thread is started, because threads inherit it. Where others keep all cores busy it has a seventieth of one.
pub fn in_background() {
    lower_priority(19);
}

/// The same for work that somebody waits for: it has a tenth of a core that others keep busy.
pub fn behind_others() {
    lower_priority(10);
}

fn lower_priority(niceness: i32) {
    // Lowering the priority is always allowed.
    let _ = rustix::process::nice(niceness);
}

/// Runs the daemon of a service until it is stopped, as a program that was built from a commit: exit code 0; 1 if it cannot go on, 2 for a configuration or
/// state that cannot be used.
pub fn run<S: Service + 'static>(
    commit: Option<&str>,
    make: impl FnOnce(&SiteConfig, CurrentActivity) -> Result<S, Failure>,
) -> ExitCode {
    bus::set_commit(commit);
    run_with(&arguments(S::Request::DAEMON), make)
}

/// The same with a command line that was parsed.
pub fn run_with<S: Service + 'static>(
    arguments: &Arguments,
    make: impl FnOnce(&SiteConfig, CurrentActivity) -> Result<S, Failure>,
) -> ExitCode {
    let daemon = S::Request::DAEMON;
    let unusable = |why: &(dyn std::error::Error + 'static)| {
        // There is no log yet.
        eprintln!("{daemon}: {}", chain(why));
        ExitCode::from(2)
    };
    let site = match SiteConfig::read(&arguments.config) {
        Ok(site) => site,
        Err(why) => return unusable(&why),
    };
    let config = match own_config(daemon, &site, arguments.robot_name) {
        Ok(config) => config,
        Err(why) => return unusable(why.as_ref()),
    };
    let log = match Log::start_for(&config.log, config.robot_name) {
        Ok(log) => log,
        Err(why) => return unusable(&why),
    };
    let activity = CurrentActivity::default();
    let made = claim_state(&config.state).map_err(Failure::from).and_then(|()| make(&config, activity.clone()));
    let service = match made {
        Ok(service) => service,
        Err(why) => {
            let configuration = arguments.config.display();
            error!(service = daemon.name(), %configuration, error = chain(why.as_ref()), "cannot start with this");
            return exit_code_of_start(&why);
        }
    };
    match run_daemon(arguments, config, log, service, activity) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            error!(service = daemon.name(), error = chain(failure.as_ref()), "cannot go on");
            ExitCode::FAILURE
        }
    }
}

/// The configuration of a daemon: of one robot for daemons of which each robot has its own.
fn own_config(daemon: Daemon, site: &SiteConfig, robot: Option<RobotName>) -> Result<SiteConfig, Failure> {
    if daemon.draws() && site.follow.is_some() {
        return Err(
            "[follow]: this robot shows what the server of its site has drawn, and nothing is drawn here".into()
        );
    }
    match (daemon, robot) {
        // Page and answers are of one robot.
        (Daemon::Web, _) => Ok(site.of_robot(robot.or(site.web.robot))?),
        (Daemon::Ask, _) => Ok(site.of_robot(robot.or(site.ask.robot))?),
        _ if daemon.is_of_robot() => Ok(site.of_robot(robot)?),
        (_, Some(_)) => Err("--robot-name: this daemon is there once for all robots of a site".into()),
        (_, None) => Ok(site.clone()),
    }
}

/// 2 where another start would end in the same way until somebody mends configuration or state; 1 for a file system that
/// refuses, which may be away or full for a time.
fn exit_code_of_start(why: &Failure) -> ExitCode {
    let of_version = why.downcast_ref().and_then(|why| match why {
        StateVersionError::State(why) => Some(why),
        StateVersionError::Newer { .. } | StateVersionError::OtherLayout { .. } => None,
    });
    match why.downcast_ref().or(of_version) {
        Some(StateError::Io { .. }) => ExitCode::FAILURE,
        _ => ExitCode::from(2),
    }
}

/// The command line of a daemon, under its own name.
fn arguments(daemon: Daemon) -> Arguments {
    let matches = Arguments::command().name(daemon.name()).get_matches();
    Arguments::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
}

fn run_daemon<S: Service + 'static>(
    arguments: &Arguments,
    config: SiteConfig,
    log: Log,
    service: S,
    activity: CurrentActivity,
) -> Result<(), Failure> {
    let domain = config.domain()?;
    let stop = StopSignal::listen(arguments.with_stdin)?;
    let reload = Reload { signal: ReloadSignal::listen()?, path: arguments.config.clone(), config, log };
    let mut service_loop = ServiceLoop::of(service, activity, reload)?;
    // A busy service is not waited for: it replaces files whole.
    service_loop.run_until_stopped(&domain, stop)
}
