//! `groundplan export --watch`: a folder per epoch, a link to the newest, a file that says whether it may be used, a hook for
//! each.

mod epoch_folders;
mod fresh_file;
mod hooks;
mod subscriptions;
mod writer;

use super::args::Args;
use crate::failure::Failure;
use crate::run::Outcome;
use crate::wait::Expectation;
use bus::{Bus, Daemon, HEARTBEAT_PERIOD, Stamp, Waiter};
use daemon::StopSignal;
use epoch_folders::EpochFolders;
use fresh_file::FreshFile;
use hooks::{Hooks, Occasion};
use jiff::Timestamp;
use site_files::SiteFiles;
use site_view::{Freshness, MapState, Staleness, Storeys};
use std::collections::BTreeSet;
use std::io;
use std::path::PathBuf;
use std::time::{Duration, Instant};
use subscriptions::Subscriptions;
use writer::{MapWriter, WrittenMaps};

/// Programs that end, and clocks that run out, are seen after this time.
const TICK: Duration = Duration::from_millis(200);

/// Writes every set of maps until it is stopped.
///
/// # Errors
/// A configuration or a folder that cannot be used at the start. What fails later is reported and tried again.
pub(super) fn watch(arguments: &Args) -> Result<Outcome, Failure> {
    let config = arguments.site.config()?;
    let files = SiteFiles::new(arguments.optional_files.options(&config.world)?);
    let domain = config.domain().map_err(Failure::usage)?;
    let mut stop = StopSignal::listen(false).map_err(Failure::work)?;
    let folders = EpochFolders::at(&arguments.out, arguments.overwrite)?;
    let mut watch = Watch {
        fresh_file: FreshFile::beside(folders.link()),
        writer: MapWriter::start(folders.clone(), config.clone(), files).map_err(Failure::work)?,
        folders,
        keep: arguments.keep.max(1),
        reported: BTreeSet::new(),
        freshness: Freshness::default(),
        folder: None,
        board_read: None,
        expectation: Expectation::of(&config, Daemon::WaypointGen),
        write_error: None,
        state: MapState::Unknown,
        file_written: None,
        reported_error: None,
        hooks: Hooks::new(arguments.on_change.clone(), arguments.on_stale.clone()),
    };
    daemon::ready("waits for maps");
    loop {
        // Without a bus it waits for one, and it follows every new generation.
        let lost = match Bus::join(&domain, Daemon::Groundplan) {
            Ok((bus, mut waiter)) => {
                waiter.stop_on(stop.descriptor().map_err(Failure::work)?);
                match watch.follow_generation(&bus, &mut waiter)? {
                    Left::Stopped => return watch.end(),
                    Left::Bus(why) => why,
                }
            }
            Err(why) => Failure::work(why),
        };
        watch.writer.follow(None);
        watch.freshness.left(format!("{lost:#}"));
        watch.tick()?;
        if stop.is_raised_within(TICK) {
            return watch.end();
        }
    }
}

/// Why a generation of the bus is not followed any more.
enum Left {
    Stopped,
    Bus(Failure),
}

struct Watch {
    folders: EpochFolders,
    writer: MapWriter,
    keep: usize,
    /// Epochs that are not deleted, and were reported.
    reported: BTreeSet<u64>,
    freshness: Freshness,
    /// The maps that were written last.
    folder: Option<PathBuf>,
    board_read: Option<Stamp>,
    /// The maps of the daemons.
    expectation: Expectation,
    /// Why the last maps were not written.
    write_error: Option<String>,
    /// What was known last.
    state: MapState,
    fresh_file: FreshFile,
    file_written: Option<Stamp>,
    /// The last error, which is reported once.
    reported_error: Option<String>,
    hooks: Hooks,
}

impl Watch {
    /// Follows a generation of the bus until it is over, or the watch is stopped.
    fn follow_generation(&mut self, bus: &Bus, waiter: &mut Waiter) -> Result<Left, Failure> {
        let subscriptions = match Subscriptions::to(bus) {
            Ok(subscriptions) => subscriptions,
            Err(why) => return Ok(Left::Bus(why)),
        };
        self.freshness.joined(Stamp::now());
        self.writer.follow(Some(bus));
        loop {
            if let Err(why) = subscriptions.take(&mut self.freshness) {
                return Ok(Left::Bus(why));
            }
            self.writer.look();
            self.tick()?;
            let wake = waiter.wait(TICK).map_err(Failure::work)?;
            if wake.stopped {
                return Ok(Left::Stopped);
            }
            if wake.superseded {
                return Ok(Left::Bus(Failure::work("the bus is created anew, or went down")));
            }
        }
    }

    /// Brings file and hooks to what is known.
    fn tick(&mut self) -> Result<(), Failure> {
        while let Some(result) = self.writer.result()? {
            match result {
                Ok(WrittenMaps { folder, maps }) => {
                    self.freshness.on_maps(maps);
                    self.folder = Some(folder);
                    (self.write_error, self.reported_error) = (None, None);
                }
                Err(why) => {
                    self.report(format!("{why:#}"));
                    self.write_error = Some(format!("{why:#}"));
                }
            }
        }
        let now = Stamp::now();
        self.read_board(now);
        let state = self.freshness.state(now, Timestamp::now().as_millisecond());
        self.write_file(now, &state);
        if let Some(occasion) = self.occasion(now, &state) {
            self.hooks.set(occasion);
        }
        if state != MapState::Unknown {
            self.state = state;
        }
        self.hooks.tick(Instant::now());
        Ok(())
    }

    /// Takes what the daemons say about themselves, once a second.
    fn read_board(&mut self, now: Stamp) {
        if self.board_read.is_some_and(|at| now.since(at) < HEARTBEAT_PERIOD) {
            return;
        }
        self.board_read = Some(now);
        let board = self.expectation.board().ok();
        // Without a report the last one counts: heartbeats tell whether its daemon lives.
        if let Some(next) = board.and_then(daemon::next_state) {
            self.freshness.set_next_state(next);
        }
        self.freshness.set_obstacle(self.write_error.clone().or_else(|| self.expectation.reason()));
    }

    /// What the hooks are run for; `None` while it is unknown.
    fn occasion(&self, now: Stamp, state: &MapState) -> Option<Occasion> {
        match state {
            MapState::Unknown => None,
            MapState::Stale { reason } => {
                Some(Occasion::Stale(Staleness { reason: reason.clone(), storeys: Storeys::All }))
            }
            MapState::Fresh { .. } => Some(match self.freshness.late_storeys(now) {
                Some(staleness) => Occasion::Stale(staleness),
                None => Occasion::Maps { folder: self.folder.clone()? },
            }),
        }
    }

    /// Replaces the file once a second, and at once when something changed.
    fn write_file(&mut self, now: Stamp, state: &MapState) {
        let is_due = self.file_written.is_none_or(|at| now.since(at) >= HEARTBEAT_PERIOD);
        if !is_due && *state == self.state {
            return;
        }
        let words = match state {
            MapState::Fresh { .. } => "fresh",
            MapState::Unknown => "it is unknown whether the maps are fresh",
            MapState::Stale { reason } => reason,
        };
        daemon::alive(words);
        self.file_written = Some(now);
        if let Err(why) = self.fresh_file.write(&self.freshness, state) {
            self.report(format!("the file `fresh` cannot be written: {why}"));
        }
        self.forget();
    }

    /// Deletes old epochs that no program uses.
    fn forget(&mut self) {
        let Some(current) = self.folder.as_deref() else { return };
        let in_use: Vec<_> = self.hooks.folders().chain([current]).collect();
        if let Err(why) = self.folders.forget(self.keep, &in_use, &mut self.reported) {
            self.report(format!("{why:#}"));
        }
    }

    fn report(&mut self, error: String) {
        if self.reported_error.as_ref() != Some(&error) {
            eprintln!("groundplan: {error}");
            self.reported_error = Some(error);
        }
    }

    /// Nobody checks the maps any more.
    fn end(mut self) -> Result<Outcome, Failure> {
        daemon::stopping();
        let reason = "groundplan export --watch was stopped".to_owned();
        let written = self.fresh_file.write(&self.freshness, &MapState::Stale { reason });
        self.hooks.end();
        self.writer.end();
        written.map_err(|why: io::Error| Failure::work(format!("the file `fresh` cannot be written: {why}")))?;
        Ok(Outcome::silent())
    }
}
