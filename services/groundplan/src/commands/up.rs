//! `groundplan up`: starts and supervises the processes of a site.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::run::{Outcome, Run};
use crate::site_check::refuse_unusable;
use crate::site_service::run_logged;
use crate::supervise::{Running, SupervisedProcess, check_builds};
use bus::HEARTBEAT_PERIOD;
use daemon::{SiteConfig, SiteProcess, StatusBoard, StopSignal, claim_state};
use std::time::{Duration, Instant};

/// Interval at which the processes are polled.
const POLL_INTERVAL: Duration = Duration::from_millis(100);

/// Arguments of `up`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// Also run ros-bridge, as with [ros] enabled = true in the site's configuration
    #[arg(long)]
    ros: bool,

    /// Also serve the page for browsers, as with [web] enabled = true in the site's configuration
    #[arg(long)]
    web: bool,

    /// Also answer questions over HTTP and MCP, as with [ask] enabled = true in the site's configuration
    #[arg(long)]
    ask: bool,

    /// Stop when standard input ends, so that the daemons end with the process that started this one
    #[arg(long, hide = true)]
    with_stdin: bool,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Starts the keeper and the daemons, and restarts those that die, until it is stopped.
    ///
    /// # Errors
    /// Executables that are missing or of another build, a configuration that cannot be used, a site that is up already.
    fn run(&self) -> Result<Outcome, Failure> {
        self.site.prepare()?;
        let mut config = self.site.own_config()?;
        let of_robots = config.robots.iter_mut().map(|robot| &mut robot.ros);
        std::iter::once(&mut config.ros).chain(of_robots).for_each(|ros| ros.enabled |= self.ros);
        config.web.enabled |= self.web;
        config.ask.enabled |= self.ask;
        run_site(config, self.with_stdin)
    }
}

/// Starts the processes of a site, and starts those again that die, until this one is stopped, or standard input ends if that is a reason.
///
/// # Errors
/// As those of `up`.
pub(crate) fn run_site(config: SiteConfig, with_stdin: bool) -> Result<Outcome, Failure> {
    refuse_unusable(&config)?;
    check_builds(&config)?;
    claim_state(&config.state).map_err(Failure::usage)?;
    let _running = Running::claim(&config.state)?;
    config.unused_robot_state().iter().for_each(|told| eprintln!("groundplan: {told}"));
    run_logged(&config, "up", || supervise(&config, with_stdin))
}

/// Runs the processes of a site until this one is stopped.
fn supervise(config: &SiteConfig, with_stdin: bool) -> Result<(), Failure> {
    let mut stop = StopSignal::listen(with_stdin).map_err(Failure::work)?;
    let board = StatusBoard::of_own(config);
    let mut last_look = Instant::now();
    let mut processes: Vec<SupervisedProcess> = SiteProcess::supervised(config).map(SupervisedProcess::new).collect();
    let mut ended = Ok(());
    while ended.is_ok() && !stop.is_raised_within(POLL_INTERVAL) {
        let looks = last_look.elapsed() >= HEARTBEAT_PERIOD;
        if looks {
            last_look = Instant::now();
            processes.iter_mut().for_each(|process| process.kill_if_it_hangs(&board));
        }
        ended = processes.iter_mut().try_for_each(|process| process.supervise(&config.file));
    }
    // The keeper stops last, when the bus has no participants.
    let (keeper, others) = processes.split_at_mut(1);
    for processes in [others, keeper] {
        processes.iter_mut().for_each(SupervisedProcess::close);
        processes.iter_mut().for_each(SupervisedProcess::stop);
    }
    ended
}
