//! The processes of the demo: `groundplan up` for a site of its own, in a folder and on a bus that go with it.

use super::files;
use crate::failure::Failure;
use crate::supervise::{DOWN_TIMEOUT, executable};
use bus::{Bus, Daemon, DomainError, Waiter};
use daemon::{SiteConfig, StopSignal};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Where shared memory is: the folder of a bus is in memory.
const SHARED: &str = "/dev/shm";
/// A bus is there within this time, unless the machine is very busy.
const START_TIMEOUT: Duration = Duration::from_secs(60);
const POLL_INTERVAL: Duration = Duration::from_millis(10);
/// Lines of the log that are shown where the daemons do not start.
const LOG_LINES: usize = 5;

/// The daemons; they end with this process, however that ends.
pub(super) struct Processes {
    up: Child,
    /// Inputs, configuration, state and log.
    home: TempDir,
    /// Folder of the bus.
    _root: TempDir,
    config: SiteConfig,
    stop: StopSignal,
}

impl Processes {
    /// Starts them, with the page for browsers if it is wanted.
    ///
    /// # Errors
    /// No shared memory, a file system that refuses.
    pub(super) fn start(plan_time: &str, with_page: bool) -> Result<Self, Failure> {
        let stop = StopSignal::listen(false).map_err(Failure::work)?;
        let home = tempfile::Builder::new().prefix("groundplan-demo-").tempdir().map_err(Failure::work)?;
        let root = tempfile::Builder::new().prefix("gprun").tempdir_in(SHARED);
        let root =
            root.map_err(|e| Failure::work(format!("no shared memory in {SHARED}: {e}; see groundplan doctor")))?;
        let prefix = format!("{}_", root.path().file_name().unwrap_or_default().to_string_lossy());
        files::write(home.path(), plan_time, &prefix, &root.path().join("bus"))?;
        let config = SiteConfig::read(&home.path().join("site.toml")).map_err(Failure::work)?;
        let log = File::create(home.path().join("log")).map_err(Failure::work)?;
        let mut up = Command::new(executable("groundplan")?);
        up.arg("up").arg("--config").arg(&config.file).arg("--with-stdin");
        if with_page {
            up.arg("--web");
        }
        let up = up.stdin(Stdio::piped()).stdout(Stdio::null()).stderr(log).spawn().map_err(Failure::work)?;
        Ok(Self { up, home, _root: root, config, stop })
    }

    /// The configuration of the site.
    pub(super) fn config(&self) -> &SiteConfig {
        &self.config
    }

    /// A file of the demo.
    pub(super) fn file(&self, name: &str) -> PathBuf {
        self.home.path().join(name)
    }

    /// Joins the bus as soon as there is one.
    ///
    /// # Errors
    /// Daemons that do not start, with what they say.
    pub(super) fn join(&mut self) -> Result<(Bus, Waiter), Failure> {
        let domain = self.config.domain().map_err(Failure::work)?;
        let begun = Instant::now();
        loop {
            match Bus::join(&domain, Daemon::Groundplan) {
                Ok((bus, mut waiter)) => {
                    waiter.stop_on(self.stop.descriptor().map_err(Failure::work)?);
                    return Ok((bus, waiter));
                }
                Err(DomainError::NoKeeper { .. }) if begun.elapsed() < START_TIMEOUT => {}
                Err(why) => return Err(Failure::work(why)),
            }
            self.check()?;
            if self.stop.is_raised_within(POLL_INTERVAL) {
                return Err(stopped());
            }
        }
    }

    /// Refuses to go on without daemons.
    ///
    /// # Errors
    /// They have ended, with the end of their log.
    pub(super) fn check(&mut self) -> Result<(), Failure> {
        let Some(status) = self.up.try_wait().map_err(Failure::work)? else { return Ok(()) };
        let log = std::fs::read_to_string(self.file("log")).unwrap_or_default();
        let lines: Vec<&str> = log.lines().collect();
        let end = lines[lines.len().saturating_sub(LOG_LINES)..].join("\n  ");
        Err(Failure::work(format!("the daemons have ended ({status}):\n  {end}")))
    }

    /// Waits until this process is to stop.
    ///
    /// # Errors
    /// The daemons have ended before.
    pub(super) fn wait_for_stop(&mut self) -> Result<(), Failure> {
        while !self.stop.is_raised_within(POLL_INTERVAL) {
            self.check()?;
        }
        Ok(())
    }

    /// Stops the daemons; true if they have left by themselves.
    fn end(&mut self) -> bool {
        drop(self.up.stdin.take());
        let deadline = Instant::now() + DOWN_TIMEOUT;
        while Instant::now() < deadline {
            match self.up.try_wait() {
                Ok(None) => std::thread::sleep(POLL_INTERVAL),
                Ok(Some(status)) => return status.success(),
                Err(_) => return false,
            }
        }
        // Its children end with their standard input.
        let _ = self.up.kill();
        let _ = self.up.wait();
        false
    }

    /// Stops the daemons, and removes all that they had.
    ///
    /// # Errors
    /// They do not leave, or leave something in shared memory.
    pub(super) fn down(mut self) -> Result<(), Failure> {
        if !self.end() {
            return Err(Failure::work("the daemons did not leave in order"));
        }
        let prefix = self.config.bus.prefix.clone();
        let left = std::fs::read_dir(Path::new(SHARED)).map_err(Failure::work)?.flatten();
        let left = left.filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix)).count();
        if left > 0 {
            return Err(Failure::work(format!("{left} files of the bus are left in {SHARED}: {prefix}*")));
        }
        Ok(())
    }
}

impl Drop for Processes {
    fn drop(&mut self) {
        // After a failure or a stop; otherwise they have ended already.
        self.end();
    }
}

/// Somebody stops the demo.
pub(super) fn stopped() -> Failure {
    Failure::work("stopped")
}
