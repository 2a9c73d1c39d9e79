//! Writes every set of maps on a thread of its own: large maps take seconds, in which the rest of the watch goes on.

use super::epoch_folders::EpochFolders;
use crate::commands::export::sets::Sets;
use crate::failure::Failure;
use bus::Bus;
use daemon::SiteConfig;
use site_files::SiteFiles;
use site_view::MapsInUse;
use std::io;
use std::path::PathBuf;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, TrySendError, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Maps that could not be written are written again after this time.
const RETRY_INTERVAL: Duration = Duration::from_secs(2);
/// Results that wait to be taken; the writer waits while there are more.
const MAX_RESULTS: usize = 16;

/// Maps that were written.
pub(super) struct WrittenMaps {
    pub(super) folder: PathBuf,
    pub(super) maps: MapsInUse,
}

/// The generation of the bus that samples are taken from.
#[derive(Default)]
struct Generation {
    /// `None` while there is none.
    bus: Option<Bus>,
    /// True until the thread has seen it.
    is_new: bool,
}

/// The thread that writes.
pub(super) struct MapWriter {
    generation: Arc<Mutex<Generation>>,
    looks: SyncSender<()>,
    results: Receiver<Result<WrittenMaps, Failure>>,
    thread: JoinHandle<()>,
}

impl MapWriter {
    /// Starts the thread.
    ///
    /// # Errors
    /// The system refuses.
    pub(super) fn start(folders: EpochFolders, config: SiteConfig, files: SiteFiles) -> io::Result<Self> {
        let generation = Arc::new(Mutex::new(Generation::default()));
        // One look that waits is as good as many.
        let (looks, look) = sync_channel(1);
        let (result, results) = sync_channel(MAX_RESULTS);
        let work = Work { generation: Arc::clone(&generation), look, folders, config, files, sets: None, last: None };
        let thread = std::thread::Builder::new().name("map-writer".to_owned()).spawn(move || work.run(&result))?;
        Ok(Self { generation, looks, results, thread })
    }

    /// Takes samples from this generation of the bus from now on; from none while there is none.
    pub(super) fn follow(&self, bus: Option<&Bus>) {
        let generation = Generation { bus: bus.cloned(), is_new: true };
        *self.generation.lock().unwrap_or_else(PoisonError::into_inner) = generation;
        self.look();
    }

    /// Something may have come.
    pub(super) fn look(&self) {
        match self.looks.try_send(()) {
            Ok(()) | Err(TrySendError::Full(())) => {}
            // A thread that panicked has no results either, and that ends the watch.
            Err(TrySendError::Disconnected(())) => {}
        }
    }

    /// What was written, or why not; `None` if nothing is new.
    ///
    /// # Errors
    /// The thread has ended.
    pub(super) fn result(&self) -> Result<Option<Result<WrittenMaps, Failure>>, Failure> {
        match self.results.recv_timeout(Duration::ZERO) {
            Ok(result) => Ok(Some(result)),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => Err(Failure::work("the thread that writes maps has ended")),
        }
    }

    /// Lets it finish what it writes.
    pub(super) fn end(self) {
        let Self { looks, results, thread, .. } = self;
        drop((looks, results));
        let _ = thread.join();
    }
}

/// What the thread works with.
struct Work {
    generation: Arc<Mutex<Generation>>,
    look: Receiver<()>,
    folders: EpochFolders,
    config: SiteConfig,
    files: SiteFiles,
    sets: Option<Sets>,
    /// The epoch that is current, and where it failed when to try again.
    last: Option<(u64, Option<Instant>)>,
}

impl Work {
    fn run(mut self, results: &SyncSender<Result<WrittenMaps, Failure>>) {
        while self.look.recv().is_ok() {
            if let Some(result) = self.write_newest().transpose()
                && results.send(result).is_err()
            {
                return;
            }
        }
    }

    /// Writes the newest set if it is new; sets that come faster than they are written are left out.
    fn write_newest(&mut self) -> Result<Option<WrittenMaps>, Failure> {
        let sets = {
            let mut generation = self.generation.lock().unwrap_or_else(PoisonError::into_inner);
            if std::mem::take(&mut generation.is_new) {
                (self.sets, self.last) = (None, None);
            }
            match (&mut self.sets, &generation.bus) {
                (Some(sets), _) => sets,
                (none, Some(bus)) => none.insert(Sets::of(bus)?),
                (None, None) => return Ok(None),
            }
        };
        let Some(epoch) = sets.take()? else { return Ok(None) };
        let is_done =
            |(last, retry): (u64, Option<Instant>)| last == epoch && retry.is_none_or(|at| at > Instant::now());
        if self.last.is_some_and(is_done) {
            return Ok(None);
        }
        self.last = Some((epoch, Some(Instant::now() + RETRY_INTERVAL)));
        let files = sets.files(&self.config, &mut self.files)?;
        let folder = self.folders.write(epoch, &files)?;
        self.last = Some((epoch, None));
        let (site_hash, grids) = sets.grids()?;
        Ok(Some(WrittenMaps { folder, maps: MapsInUse { epoch, site_hash, grids } }))
    }
}
