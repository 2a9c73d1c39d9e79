//! The ifc-ingest service: publishes the site from its cache at start, and again when its files change.

use bus::{Bus, topics};
use daemon::facts::IngestFacts;
use daemon::{
    Asked, CurrentActivity, Done, Epochs, Event, Failure, IngestRequest, LatchedOutput, NoInput, Published, Reporter,
    Service, SiteConfig, StateFile, write_durably,
};
use ingest::{IngestOptions, SiteFrame, SourceFile, ingest};
use messages::{Activity, ArchiveBuffer, Checked, InputHashes, payload};
use serde::{Deserialize, Serialize};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;
use tracing::{info, warn};

/// Shares of a load that are done when the files are in memory, and when the site is made.
const FILES_READ: f64 = 0.02;
const SITE_MADE: f64 = 0.97;

/// Reads the files of a site.
pub(crate) struct IngestService {
    state: StateFile,
    cache: PathBuf,
    epochs: Epochs,
    activity: CurrentActivity,
    output: LatchedOutput<topics::Site>,
    models: Vec<PathBuf>,
    allow_boxes: bool,
    /// What the files looked like when they were read, or tried, last.
    stamps: Vec<Option<FileStamp>>,
}

/// What the cache was made from.
#[derive(Debug, Serialize, Deserialize)]
struct Loaded {
    models: Vec<PathBuf>,
    stamps: Vec<Option<FileStamp>>,
}

/// How a file looks without reading it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct FileStamp {
    length: u64,
    modified_ns: u64,
}

impl IngestService {
    /// From the configuration and the persisted state: loaded files override configured ones.
    ///
    /// # Errors
    /// State that cannot be used. A cache that cannot be used is made anew.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let state = StateFile::at(&config.state, "loaded.json")?;
        let mut epochs = Epochs::at(&config.state, "ifc-ingest-epochs.json")?;
        let cache = config.state.join("site.gpar");
        let loaded: Option<Loaded> = state.load()?;
        let (models, stamps) = loaded.map_or((config.models.clone(), Vec::new()), |l| (l.models, l.stamps));
        let mut output = LatchedOutput::new(topics::Site);
        // Without a cache everything is read anew.
        let stamps = match cached(&cache, &stamps) {
            Some(site) => {
                publish(&mut output, &mut epochs, site)?;
                stamps
            }
            None => Vec::new(),
        };
        Ok(Self { state, cache, epochs, activity, output, models, allow_boxes: config.allow_boxes, stamps })
    }

    /// Reads these files and publishes their site. A file that is broken leaves the last good site where it is.
    fn load(&mut self, models: Vec<PathBuf>, reporter: &Reporter) -> Result<Done, Failure> {
        self.activity.set(Activity::Reading);
        reporter.report("reading files", 0.0);
        let stamps: Vec<Option<FileStamp>> = models.iter().map(|path| stamp(path)).collect();
        let is_revision = models == self.models;
        self.stamps.clone_from(&stamps);
        let read = |path: &PathBuf| -> Result<SourceFile, Failure> {
            let bytes = std::fs::read(path).map_err(|e| format!("{} cannot be read: {e}", path.display()))?;
            Ok(SourceFile { path: path.clone(), bytes })
        };
        let files: Vec<SourceFile> = models.iter().map(read).collect::<Result<_, _>>()?;
        let activity = self.activity.clone();
        // A robot is localised in the frame of its site: a revision keeps it, another site has another.
        let old = self.frame();
        let options = IngestOptions {
            frame: old.filter(|_| is_revision),
            frame_of: None,
            frame_epoch: old.map_or(1, |f| f.frame_epoch.saturating_add(1)),
            places: &[],
            prefer_last: false,
            allow_boxes: self.allow_boxes,
            progress: &|progress| {
                let stage =
                    if progress.stage == ingest::Stage::Meshing { Activity::Meshing } else { Activity::Reading };
                activity.set(stage);
                reporter.report(&progress.doing(), FILES_READ + (SITE_MADE - FILES_READ) * progress.share);
            },
        };
        reporter.report("reading files", FILES_READ);
        let site = ingest(&files, &options)?;
        self.activity.set(Activity::Writing);
        reporter.report("writing the site", SITE_MADE);
        write_durably(&self.cache, site.bytes())
            .map_err(|e| format!("{} cannot be written: {e}", self.cache.display()))?;
        self.state.save(&Loaded { models: models.clone(), stamps })?;
        self.models = models;
        let site = Checked::<payload::Site>::new(site)?;
        let n_bytes = site.bytes().bytes().len();
        publish(&mut self.output, &mut self.epochs, site)?;
        reporter.report("site published", 1.0);
        info!(service = "ifc-ingest", epoch = self.output.epoch(), bytes = n_bytes, "site published");
        Ok(self.done())
    }

    fn frame(&self) -> Option<SiteFrame> {
        let site = self.output.last()?.view();
        Some(SiteFrame { map_from_world: site.map_from_world(), frame_epoch: site.head.frame_epoch })
    }

    fn done(&self) -> Done {
        self.activity.set(Activity::Published);
        Done { published: self.output.published(), ..Done::default() }
    }

    /// Reads the files again if they look different from when they were read, or tried, last.
    fn reload_if_changed(&mut self) -> Result<Done, Failure> {
        let now: Vec<Option<FileStamp>> = self.models.iter().map(|path| stamp(path)).collect();
        if self.models.is_empty() || now == self.stamps {
            if !self.output.is_pending() {
                return Ok(Done::default());
            }
            self.output.retry(&mut self.epochs)?;
            return Ok(self.done());
        }
        self.load(self.models.clone(), &Reporter::default())
    }
}

fn publish(
    output: &mut LatchedOutput<topics::Site>,
    epochs: &mut Epochs,
    site: Checked<payload::Site>,
) -> Result<(), Failure> {
    let frame_epoch = u64::from(site.view().head.frame_epoch);
    output.publish(epochs, site, frame_epoch, InputHashes::default())
}

/// The site as it was when the daemon died; a cache that is damaged or of another version is not used, and everything is read
/// anew.
fn cached(path: &Path, stamps: &[Option<FileStamp>]) -> Option<Checked<payload::Site>> {
    if stamps.is_empty() {
        return None;
    }
    let read = || -> Result<Checked<payload::Site>, Failure> {
        let mut file = std::fs::File::open(path)?;
        let mut buffer = ArchiveBuffer::zeroed(usize::try_from(file.metadata()?.len())?);
        file.read_exact(buffer.bytes_mut())?;
        Ok(Checked::new(buffer)?)
    };
    match read() {
        Ok(site) => Some(site),
        Err(why) => {
            let error = daemon::chain(why.as_ref());
            warn!(service = "ifc-ingest", path = %path.display(), error, "the cache cannot be used; files are read anew");
            None
        }
    }
}

/// `None` for a file that is not there.
fn stamp(path: &Path) -> Option<FileStamp> {
    let metadata = std::fs::metadata(path).ok()?;
    let modified = metadata.modified().ok()?.duration_since(UNIX_EPOCH).ok()?;
    Some(FileStamp { length: metadata.len(), modified_ns: u64::try_from(modified.as_nanos()).ok()? })
}

impl Service for IngestService {
    type Input = NoInput;
    type Request = IngestRequest;
    type Facts = IngestFacts;

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        self.output.attach(bus, &mut self.epochs)?;
        if self.output.last().is_some() {
            self.activity.set(Activity::Published);
        }
        Ok(())
    }

    fn handle(&mut self, event: Event<NoInput>) -> Result<Done, Failure> {
        match event {
            Event::Attached | Event::Tick | Event::Configuration(_) => self.reload_if_changed(),
            Event::Input(never) => match never {},
        }
    }

    fn answer(&mut self, request: IngestRequest, asked: &Asked) -> Result<Done<Published>, Failure> {
        let IngestRequest::Load { models } = request;
        let models = if models.is_empty() { self.models.clone() } else { models };
        Ok(self.load(models, &asked.reporter)?.answered_by_published())
    }

    fn facts(&self) -> IngestFacts {
        IngestFacts {
            models: self.models.clone(),
            site: self.output.published(),
            frame_epoch: self.frame().map_or(0, |frame| u64::from(frame.frame_epoch)),
        }
    }
}
