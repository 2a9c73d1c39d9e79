//! Starting and supervising the daemons of a site, and stopping them.

use crate::args::SiteArgs;
use crate::cli::UpArgs;
use crate::failure::Failure;
use bus::Daemon;
use daemon::StopSignal;
use rustix::process::{Pid, Signal, kill_process, test_kill_process};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// How often the daemons are looked after.
const LOOK: Duration = Duration::from_millis(100);
/// A daemon that died is started again after this time; each further death doubles it.
const FIRST_BACK_OFF: Duration = Duration::from_millis(200);
const LONGEST_BACK_OFF: Duration = Duration::from_secs(10);
/// A daemon that lived this long has recovered.
const RECOVERED: Duration = Duration::from_secs(10);
/// Daemons that do not leave by themselves within this time are killed.
const PATIENCE: Duration = Duration::from_secs(3);

/// A process that is kept alive.
struct Kept {
    name: &'static str,
    child: Option<Child>,
    started: Instant,
    back_off: Duration,
    restarts: u32,
}

/// Starts the keeper and the daemons, and starts again whoever dies, until it is told to stop.
///
/// # Errors
/// Executables that are missing or of another version, a configuration that cannot be used, a site that is up already.
pub fn up(arguments: &UpArgs) -> Result<String, Failure> {
    arguments.site.prepare()?;
    let config = arguments.site.config()?;
    let path = arguments.site.path();
    check_versions()?;
    let mut stop = StopSignal::listen(false).map_err(Failure::work)?;
    let _running = Running::claim(&config.state)?;
    let mut keeper = Kept::new("groundplan");
    let mut daemons = Daemon::SUPERVISED.map(|daemon| Kept::new(daemon.name()));
    while !stop.is_raised_within(LOOK) {
        keeper.keep(&path)?;
        for daemon in &mut daemons {
            daemon.keep(&path)?;
        }
    }
    // The bus goes when nobody is on it any more.
    daemons.iter_mut().for_each(Kept::close);
    daemons.iter_mut().for_each(Kept::stop);
    keeper.close();
    keeper.stop();
    Ok(String::new())
}

impl Kept {
    fn new(name: &'static str) -> Self {
        Self { name, child: None, started: Instant::now(), back_off: Duration::ZERO, restarts: 0 }
    }

    /// Starts it if it does not run, not too often.
    fn keep(&mut self, config: &Path) -> Result<(), Failure> {
        if let Some(child) = &mut self.child {
            match child.try_wait().map_err(Failure::work)? {
                None => {
                    if self.started.elapsed() >= RECOVERED {
                        self.back_off = Duration::ZERO;
                    }
                    return Ok(());
                }
                // A configuration that cannot be used does not get better by trying again.
                Some(status) if status.code() == Some(2) => {
                    return Err(Failure::usage(format!("{} cannot use {}", self.name, config.display())));
                }
                Some(status) => {
                    self.back_off = (self.back_off * 2).clamp(FIRST_BACK_OFF, LONGEST_BACK_OFF);
                    self.restarts += 1;
                    warn!(service = self.name, %status, restarts = self.restarts, "died; it is started again");
                    (self.child, self.started) = (None, Instant::now());
                }
            }
        }
        if self.restarts > 0 && self.started.elapsed() < self.back_off {
            return Ok(());
        }
        let mut command = Command::new(executable(self.name)?);
        if self.name == "groundplan" {
            command.arg("keeper");
        }
        command.arg("--config").arg(config).arg("--with-stdin").stdin(Stdio::piped());
        let child = command.spawn().map_err(|e| Failure::work(format!("{} cannot be started: {e}", self.name)))?;
        info!(service = self.name, process_id = child.id(), "started");
        (self.child, self.started) = (Some(child), Instant::now());
        Ok(())
    }

    /// Its standard input ends: it leaves.
    fn close(&mut self) {
        if let Some(child) = &mut self.child {
            drop(child.stdin.take());
        }
    }

    fn stop(&mut self) {
        let Some(child) = &mut self.child else { return };
        let deadline = Instant::now() + PATIENCE;
        while child.try_wait().is_ok_and(|status| status.is_none()) {
            if Instant::now() >= deadline {
                warn!(service = self.name, "does not leave; it is killed");
                // It may be gone at this moment, and that is as good.
                let _ = child.kill();
                let _ = child.wait();
                return;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
    }
}

/// An executable beside this one.
pub(super) fn executable(name: &str) -> Result<PathBuf, Failure> {
    let own = std::env::current_exe().map_err(Failure::work)?;
    let path = own.with_file_name(name);
    if path.is_file() {
        Ok(path)
    } else {
        Err(Failure::work(format!("{} is missing: install all of groundplan", path.display())))
    }
}

/// The version of an executable, as it tells it.
pub(super) fn version_of(path: &Path) -> Result<String, Failure> {
    let output = Command::new(path).arg("--version").output();
    let output = output.map_err(|e| Failure::work(format!("{} cannot be run: {e}", path.display())))?;
    let text = String::from_utf8_lossy(&output.stdout);
    Ok(text.split_whitespace().last().unwrap_or_default().to_owned())
}

fn check_versions() -> Result<(), Failure> {
    let own = env!("CARGO_PKG_VERSION");
    for name in Daemon::SUPERVISED.map(Daemon::name) {
        let path = executable(name)?;
        let version = version_of(&path)?;
        if version != own {
            return Err(Failure::work(format!(
                "{} is of version {version:?}, this is {own}: install one version",
                path.display()
            )));
        }
    }
    Ok(())
}

/// The file that says which process keeps a site up; removed with this value.
struct Running(PathBuf);

impl Running {
    fn claim(state: &Path) -> Result<Self, Failure> {
        std::fs::create_dir_all(state).map_err(|e| Failure::work(format!("{}: {e}", state.display())))?;
        if let Some(pid) = running(state) {
            return Err(Failure::work(format!("the site is up already: process {}", pid.as_raw_nonzero())));
        }
        let path = state.join("up.pid");
        daemon::write_durably(&path, std::process::id().to_string().as_bytes()).map_err(Failure::work)?;
        Ok(Self(path))
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // What is left names a process that is gone, and is not taken seriously.
        let _ = std::fs::remove_file(&self.0);
    }
}

/// The process that keeps a site up.
pub(super) fn running(state: &Path) -> Option<Pid> {
    let pid: i32 = std::fs::read_to_string(state.join("up.pid")).ok()?.trim().parse().ok()?;
    let is_ours = std::fs::read_to_string(format!("/proc/{pid}/comm")).is_ok_and(|name| name.trim() == "groundplan");
    Pid::from_raw(pid).filter(|pid| is_ours && test_kill_process(*pid).is_ok())
}

/// Stops the daemons of a site; returns when they are gone.
///
/// # Errors
/// A site that is not up, or does not go down.
pub fn down(arguments: &SiteArgs) -> Result<String, Failure> {
    let config = arguments.config()?;
    let pid = running(&config.state).ok_or_else(|| Failure::work("the site is not up"))?;
    kill_process(pid, Signal::TERM).map_err(Failure::work)?;
    let deadline = Instant::now() + 3 * PATIENCE;
    while running(&config.state).is_some() {
        if Instant::now() >= deadline {
            return Err(Failure::work(format!("process {} does not leave", pid.as_raw_nonzero())));
        }
        std::thread::sleep(LOOK);
    }
    Ok(String::new())
}
