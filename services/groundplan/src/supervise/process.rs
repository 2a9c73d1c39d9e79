//! A process that is restarted when it dies.

use super::executables::executable;
use crate::failure::Failure;
use daemon::{SiteProcess, StatusBoard};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// A process that died is started again after this time; each further death doubles it.
const MIN_BACK_OFF: Duration = Duration::from_millis(200);
const MAX_BACK_OFF: Duration = Duration::from_secs(10);
/// A process that lived this long has recovered.
const RECOVERED: Duration = Duration::from_secs(10);
/// A process that has not reported for this time hangs: it is killed and started again. As WatchdogSec of the units.
const WATCHDOG: Duration = Duration::from_secs(10);
/// So many looks in a row must find the report too old: where all processes stood still, they get time to report.
const MIN_LATE: u32 = 3;
/// Processes that do not leave by themselves within this time are killed.
const TIMEOUT: Duration = Duration::from_secs(3);
/// The same for the keeper, which removes the bus: what a killed one leaves stays in memory until the next start.
const KEEPER_TIMEOUT: Duration = Duration::from_secs(15);
/// A site is down within this time.
pub(crate) const DOWN_TIMEOUT: Duration = Duration::from_secs(30);

/// A supervised process.
pub(crate) struct SupervisedProcess {
    process: SiteProcess,
    child: Option<Child>,
    started: Instant,
    back_off: Duration,
    restarts: u32,
    /// True if it has lived: what it could use then may be half edited now.
    has_lived: bool,
    /// Looks in a row that found its report too old.
    n_late: u32,
}

impl SupervisedProcess {
    /// A process that has not been started.
    pub(crate) fn new(process: SiteProcess) -> Self {
        Self {
            process,
            child: None,
            started: Instant::now(),
            back_off: Duration::ZERO,
            restarts: 0,
            has_lived: false,
            n_late: 0,
        }
    }

    /// Starts it if it does not run, not too often.
    ///
    /// # Errors
    /// A process that cannot be started, or that cannot use the configuration at its first start.
    pub(crate) fn supervise(&mut self, config: &Path) -> Result<(), Failure> {
        let service = self.process.to_string();
        if let Some(child) = &mut self.child {
            match child.try_wait().map_err(Failure::work)? {
                None => {
                    if self.started.elapsed() >= RECOVERED {
                        (self.back_off, self.has_lived) = (Duration::ZERO, true);
                    }
                    return Ok(());
                }
                // A configuration that cannot be used does not get better by trying again.
                Some(status) if status.code() == Some(2) && !self.has_lived => {
                    return Err(Failure::usage(format!("{service} cannot use {}", config.display())));
                }
                Some(status) => {
                    self.back_off = (self.back_off * 2).clamp(MIN_BACK_OFF, MAX_BACK_OFF);
                    self.restarts += 1;
                    warn!(service = service.as_str(), %status, restarts = self.restarts, "died; it is started again");
                    (self.child, self.started) = (None, Instant::now());
                }
            }
        }
        if self.restarts > 0 && self.started.elapsed() < self.back_off {
            return Ok(());
        }
        let mut command = match self.process.daemon() {
            Some(daemon) => Command::new(executable(daemon.name())?),
            None => {
                let mut command = Command::new(executable("groundplan")?);
                command.arg(&service);
                command
            }
        };
        if let Some(robot) = self.process.robot() {
            command.arg("--robot-name").arg(robot.as_str());
        }
        command.arg("--config").arg(config).arg("--with-stdin").stdin(Stdio::piped());
        let child = command.spawn().map_err(|e| Failure::work(format!("{service} cannot be started: {e}")))?;
        info!(service = service.as_str(), process_id = child.id(), "started");
        (self.child, self.started) = (Some(child), Instant::now());
        Ok(())
    }

    /// Kills it if it hangs: its process lives, and its last report on the board is too old. To be called once a second.
    pub(crate) fn kill_if_it_hangs(&mut self, board: &StatusBoard) {
        let Some(child) = &mut self.child else { return };
        let Some(report) = board.report::<serde::de::IgnoredAny>(self.process) else { return };
        // A report of a process before this one says nothing about it.
        self.n_late = if report.process_id == child.id() && report.age() >= WATCHDOG { self.n_late + 1 } else { 0 };
        if self.n_late >= MIN_LATE {
            warn!(service = %self.process, silent_s = report.age().as_secs(), "hangs; it is killed");
            // It may be gone at this moment, and that is as good.
            let _ = child.kill();
        }
    }

    /// Its standard input ends: it leaves.
    pub(crate) fn close(&mut self) {
        if let Some(child) = &mut self.child {
            drop(child.stdin.take());
        }
    }

    /// Waits until it has left, and kills it if it does not.
    pub(crate) fn stop(&mut self) {
        let Some(child) = &mut self.child else { return };
        let deadline = Instant::now() + if self.process == SiteProcess::Keeper { KEEPER_TIMEOUT } else { TIMEOUT };
        while child.try_wait().is_ok_and(|status| status.is_none()) {
            if Instant::now() >= deadline {
                warn!(service = %self.process, "does not leave; it is killed");
                // It may be gone at this moment, and that is as good.
                let _ = child.kill();
                let _ = child.wait();
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}
