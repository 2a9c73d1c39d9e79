//! `groundplan export --watch`: a folder per epoch, a link to the newest, a hook for each.
//!
//! Nothing is deleted but epochs as they were written, and the link.

use super::args::Args;
use super::sets::Sets;
use crate::args::{OverwriteArgs, report_set_aside};
use crate::failure::Failure;
use crate::run::Outcome;
use bus::{Bus, Daemon, Waiter};
use daemon::{SiteConfig, StopSignal};
use export::{OutputError, OutputFolder};
use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;
use world::WorldOptions;

const POLL_INTERVAL: Duration = Duration::from_millis(500);

/// Writes every set of maps until it is stopped; sets that come faster than they are written are left out.
///
/// # Errors
/// A folder that cannot be written. A command that fails is reported and does not stop it.
pub(super) fn follow(arguments: &Args) -> Result<Outcome, Failure> {
    let config = arguments.site.config()?;
    let world = arguments.world.options(&config.world)?;
    let domain = config.domain().map_err(Failure::usage)?;
    let mut stop = StopSignal::listen(false).map_err(Failure::work)?;
    let mut watched = Watched {
        epochs: arguments.out.join("epochs"),
        current: arguments.out.join("current"),
        keep: arguments.keep.max(1),
        world,
        on_change: arguments.on_change.clone(),
        overwrite: arguments.overwrite,
        reported: BTreeSet::new(),
    };
    watched.check_link()?;
    std::fs::create_dir_all(&watched.epochs).map_err(|e| at(&watched.epochs, &e))?;
    loop {
        // Without a bus it waits for one, and it follows every new generation.
        if let Ok((bus, mut waiter)) = Bus::join(&domain, Daemon::Groundplan) {
            waiter.stop_on(stop.descriptor().map_err(Failure::work)?);
            if follow_generation(&bus, &mut waiter, &config, &mut watched)? {
                return Ok(Outcome::silent());
            }
        }
        if stop.is_raised_within(POLL_INTERVAL) {
            return Ok(Outcome::silent());
        }
    }
}

struct Watched {
    epochs: PathBuf,
    current: PathBuf,
    keep: usize,
    world: Option<WorldOptions>,
    on_change: Option<PathBuf>,
    overwrite: OverwriteArgs,
    /// Epochs that are not deleted, because they hold foreign files; each is reported once.
    reported: BTreeSet<u64>,
}

/// Follows a generation of the bus; true if it is to stop.
fn follow_generation(
    bus: &Bus,
    waiter: &mut Waiter,
    config: &SiteConfig,
    watched: &mut Watched,
) -> Result<bool, Failure> {
    let mut sets = Sets::of(bus)?;
    let mut last = None;
    loop {
        if let Some(epoch) = sets.take()?.filter(|epoch| last != Some(*epoch)) {
            watched.write(config, &mut sets, epoch)?;
            last = Some(epoch);
        }
        let wake = waiter.wait(POLL_INTERVAL).map_err(Failure::work)?;
        if wake.stopped || wake.superseded {
            return Ok(wake.stopped);
        }
    }
}

impl Watched {
    /// The link is replaced for every epoch: what has its name must be one.
    fn check_link(&self) -> Result<(), Failure> {
        match std::fs::symlink_metadata(&self.current) {
            Ok(metadata) if !metadata.is_symlink() => Err(Failure::usage(format!(
                "{} is no link to an epoch, and is not replaced: choose another folder, or move it away",
                self.current.display()
            ))),
            _ => Ok(()),
        }
    }

    /// Writes an epoch, unless a run before this one did, and makes it the current one.
    fn write(&mut self, config: &SiteConfig, sets: &mut Sets, epoch: u64) -> Result<(), Failure> {
        let folder = self.epochs.join(epoch.to_string());
        let files = sets.files(config, self.world.as_ref())?;
        // Epochs are counted anew where the state of a site was deleted: a folder of this number may hold other maps.
        if !OutputFolder::holds(&folder, &files) {
            let place = self.overwrite.folder_at(&folder)?;
            report_set_aside(place.replace(&files).map_err(Failure::work)?);
        }
        let target = Path::new("epochs").join(epoch.to_string());
        if std::fs::read_link(&self.current).is_ok_and(|current| current == target) {
            return Ok(());
        }
        self.check_link()?;
        let beside = self.current.with_file_name(format!(".current.new-{}", std::process::id()));
        // A killed run with this process id may have left one.
        if beside.is_symlink() {
            std::fs::remove_file(&beside).map_err(|e| at(&beside, &e))?;
        }
        std::os::unix::fs::symlink(&target, &beside).map_err(|e| at(&beside, &e))?;
        std::fs::rename(&beside, &self.current).map_err(|e| at(&self.current, &e))?;
        self.forget(epoch)?;
        println_now(&folder);
        self.run(&folder);
        Ok(())
    }

    /// Deletes the oldest epochs beyond those that are kept; those with files of others stay.
    fn forget(&mut self, current: u64) -> Result<(), Failure> {
        let entries = std::fs::read_dir(&self.epochs).map_err(|e| at(&self.epochs, &e))?;
        let mut epochs: Vec<u64> = entries.filter_map(|e| e.ok()?.file_name().to_str()?.parse().ok()).collect();
        epochs.sort_unstable();
        let n_old = epochs.len().saturating_sub(self.keep);
        for epoch in epochs[..n_old].iter().filter(|epoch| **epoch != current) {
            let folder = self.epochs.join(epoch.to_string());
            let why = match OutputFolder::delete(&folder) {
                Ok(()) => continue,
                Err(OutputError::Altered { files, .. }) => format!("it holds files of others: {files}"),
                Err(error) => error.to_string(),
            };
            if self.reported.insert(*epoch) {
                eprintln!("groundplan: {} is not deleted: {why}", folder.display());
            }
        }
        Ok(())
    }

    fn run(&self, folder: &Path) {
        let Some(command) = &self.on_change else { return };
        let why = match Command::new(command).arg(folder).status() {
            Ok(status) if status.success() => return,
            Ok(status) => status.to_string(),
            Err(error) => error.to_string(),
        };
        eprintln!("groundplan: {} {}: {why}", command.display(), folder.display());
    }
}

/// A line for each epoch; a closed standard output is no error.
fn println_now(folder: &Path) {
    use std::io::Write;
    let _ = writeln!(io::stdout(), "{}", folder.display());
}

fn at(path: &Path, error: &io::Error) -> Failure {
    Failure::work(format!("{}: {error}", path.display()))
}
