//! The ifc-ingest service: publishes the site in force at start, and revisions of it that may take effect.
//!
//! A revision takes effect as a whole or not at all: its files are read, its schedule is evaluated with the rules and the
//! progress in force, and it is compared with the site in force; one that is refused, or that waits for an operator, changes
//! nothing.

use crate::model_files::{ModelFiles, names_of};
use crate::revision_reader::{InForce, ReadRevision, RevisionReader};
use crate::revisions::{Refused, Revisions, Waiting};
use crate::site_store::{CachedSite, SiteStore};
use bus::{Bus, topics};
use daemon::facts::{IngestFacts, ModelFile};
use daemon::{
    Asked, Caller, CurrentActivity, Done, Epochs, Event, Failure, FileStamp, FileWatch, History, HistoryEvent,
    HistoryKind, IngestAnswer, IngestRequest, LatchedOutput, NoInput, Reporter, Revision, RevisionEffect, Service,
    SiteConfig, Standing, WholeFiles, chain, stamps_of,
};
use ingest::{MAX_MODEL_BYTES, SiteFrame};
use messages::{Activity, Checked, InputHashes, SiteOutline, payload};
use std::path::PathBuf;
use std::time::{Duration, Instant};
use tracing::{info, warn};

/// Waits before a revision that found no room on disk is tried again.
const MIN_WAIT: Duration = Duration::from_secs(10);
const MAX_WAIT: Duration = Duration::from_secs(600);

/// Share of a load that is done when the revision is read and compared.
const COMPARED: f64 = 0.98;

/// Reads the files of a site.
pub(crate) struct IngestService {
    reader: RevisionReader,
    store: SiteStore,
    revisions: Revisions,
    /// Of the site in force.
    outline: Option<SiteOutline>,
    history: History,
    epochs: Epochs,
    activity: CurrentActivity,
    output: LatchedOutput<topics::Site>,
    /// Files that changed, until they are whole.
    watch: FileWatch,
    /// Files to be read as soon as the daemon is attached: the configuration names others.
    to_read: Option<Vec<PathBuf>>,
    /// Why the configuration, or the map frame, cannot be used.
    error: Option<String>,
    /// When a revision that found no room on disk is tried again, and how long that waited.
    next_try: Option<(Instant, Duration)>,
}

/// What is to become of a revision that could take effect.
#[derive(Debug, Clone, PartialEq)]
enum Intent {
    /// It is compared only.
    Compare,
    /// It takes effect, or waits for an operator.
    Load,
    /// It takes effect.
    Force,
    /// It takes effect if its files are those with these hashes; else as with `Load`.
    Confirm(Vec<[u8; 32]>),
}

impl IngestService {
    /// From the configuration and the persisted state: loaded files override configured ones until those are edited.
    ///
    /// # Errors
    /// Rules or state that cannot be used. A cache that cannot be used is made anew.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        let store = SiteStore::at(&config.state)?;
        let first = || Revisions { models: config.models.clone(), ..Revisions::default() };
        let revisions = store.revisions()?.unwrap_or_else(first);
        let cached = store.cached_site(&revisions);
        let outline = match store.outline()? {
            Some(outline) => Some(outline),
            None => cached.as_ref().map(|cached| SiteOutline::of(&cached.site.view())),
        };
        let mut service = Self {
            reader: RevisionReader::new(config, activity.clone())?,
            store,
            revisions,
            outline,
            history: History::at(&config.state),
            epochs: Epochs::at(&config.state, "ifc-ingest-epochs.json")?,
            activity,
            output: LatchedOutput::new(topics::Site),
            watch: FileWatch::new(MAX_MODEL_BYTES),
            to_read: None,
            error: None,
            next_try: None,
        };
        service.follow_configured_models(config);
        if service.to_read.is_none() {
            // What it was refused for may be mended.
            service.to_read = service.revisions.refused.as_ref().map(|refused| refused.models.clone());
        }
        match cached {
            Some(CachedSite { site, is_earlier }) => {
                service.start_with(site)?;
                if is_earlier {
                    service.revisions.seen = Some(Vec::new());
                }
            }
            // What was tried before is tried again.
            None => service.revisions.seen = Some(Vec::new()),
        }
        Ok(service)
    }

    /// Publishes the site in force, unless the frame that is kept is a later one.
    fn start_with(&mut self, site: Checked<payload::Site>) -> Result<(), Failure> {
        let frame = frame_of(&site);
        match self.frame_in_force(Some(frame)) {
            Ok(Some(kept)) if !is_same_frame(&kept, &frame) => {
                warn!(service = "ifc-ingest", "the map frame was replaced; files are read anew");
                self.revisions.seen = Some(Vec::new());
                return Ok(());
            }
            // A site of an earlier version has its frame in the cache alone.
            Ok(_) => self.store.keep_frame(&site)?,
            Err(why) => self.error = Some(chain(why.as_ref())),
        }
        self.publish(site)
    }

    /// The frame that a revision keeps: that of the file, or of the site in force.
    ///
    /// # Errors
    /// A file that cannot be used, or holds another frame under the same epoch.
    fn frame_in_force(&self, in_force: Option<SiteFrame>) -> Result<Option<SiteFrame>, Failure> {
        match (self.store.frame()?, in_force) {
            (Some(kept), Some(in_force))
                if !is_same_frame(&kept, &in_force) && kept.frame_epoch <= in_force.frame_epoch =>
            {
                Err(format!(
                    "the map frame {} is not that of the site in force: restore it, or give it a frame_epoch above {}",
                    self.store.frame_path().display(),
                    in_force.frame_epoch
                )
                .into())
            }
            (kept, in_force) => Ok(kept.or(in_force)),
        }
    }

    /// The highest epoch that a map frame of this site may have had. Earlier versions did not keep it, but every frame came with a
    /// sample.
    fn last_frame_epoch(&self) -> u32 {
        match self.revisions.frame_epoch {
            0 if !self.revisions.stamps.is_empty() => u32::try_from(self.epochs.reserved()).unwrap_or(u32::MAX - 1),
            kept => kept,
        }
    }

    /// Files that the configuration names since it was edited are to be read; what was loaded by a command counts until then.
    fn follow_configured_models(&mut self, config: &SiteConfig) {
        let configured = self.revisions.configured.replace(config.models.clone());
        let is_edited = configured.is_some_and(|before| before != config.models);
        if is_edited && config.models != self.revisions.models && !config.models.is_empty() {
            self.to_read = Some(config.models.clone());
        }
    }

    /// Waits until files are whole, and does with them as is intended.
    fn load(
        &mut self,
        models: Vec<PathBuf>,
        intent: &Intent,
        by: Option<Caller>,
        reporter: &Reporter,
    ) -> Result<Done<IngestAnswer>, Failure> {
        reporter.report("reading files", 0.0);
        let whole = self.watch.wait(&models, || reporter.report("waiting until the files are written", 0.0));
        self.load_whole(models, whole, intent, by, reporter)
    }

    /// Does with files as is intended. What cannot take effect leaves the site in force where it is.
    fn load_whole(
        &mut self,
        models: Vec<PathBuf>,
        whole: Result<WholeFiles, Failure>,
        intent: &Intent,
        by: Option<Caller>,
        reporter: &Reporter,
    ) -> Result<Done<IngestAnswer>, Failure> {
        let stamps = whole.as_ref().map_or_else(|_| stamps_of(&models), |whole| whole.stamps.clone());
        let frame = self.frame_in_force(self.frame());
        let read = whole.and_then(|whole| {
            let frame = frame?;
            let last_epoch = frame.map_or(0, |frame| frame.frame_epoch).max(self.last_frame_epoch());
            let in_force = InForce { frame, last_epoch, outline: self.outline.as_ref() };
            self.reader.read(ModelFiles::of(models.clone(), whole), in_force, reporter)
        });
        let result = match read {
            Err(why) if *intent == Intent::Compare => Err(why),
            Err(why) => {
                self.next_try = None;
                Err(self.refuse(models, &stamps, why.as_ref(), by))
            }
            Ok(revision) if *intent == Intent::Compare => {
                Ok(self.answer_of(RevisionEffect::DryRun, Some(revision.described())))
            }
            Ok(revision) if self.waits(&revision, intent) => self.wait_for_operator(&revision, by),
            Ok(revision) => self.take_effect(revision, by, reporter),
        };
        self.activity.set(if self.output.last().is_some() { Activity::Published } else { Activity::Idle });
        result
    }

    /// True if a revision needs an operator.
    fn waits(&self, revision: &ReadRevision, intent: &Intent) -> bool {
        let is_confirmed = match intent {
            Intent::Force => true,
            Intent::Confirm(sha256) => *sha256 == revision.sha256(),
            Intent::Load | Intent::Compare => false,
        };
        // The cache was lost: the files are those in force.
        let is_in_force = self.revisions.are_in_force(&revision.models, &revision.stamps);
        !(is_confirmed || is_in_force || revision.comparison.objections.is_empty())
    }

    /// Keeps why a revision cannot take effect; returns the error for who asked. Of files that a client asked for, and that are not those
    /// in force, it is the answer alone.
    fn refuse(
        &mut self,
        models: Vec<PathBuf>,
        stamps: &[Option<FileStamp>],
        why: &(dyn std::error::Error + 'static),
        by: Option<Caller>,
    ) -> Failure {
        let refused = Refused { why: chain(why), models, stamps: stamps.to_vec() };
        let is_of_site = self.revisions.is_without_site() || self.revisions.models == refused.models;
        if by.is_some() && !is_of_site {
            let names = names_of(&refused.models);
            self.record(HistoryKind::Revision, by, format!("{names} refused: {}", refused.why));
            return self.revisions.stays(&refused.why).into();
        }
        self.revisions.see(&refused.models, stamps);
        if !self.revisions.refused.as_ref().is_some_and(|before| before.is_same(&refused)) {
            self.record(HistoryKind::Revision, by, format!("{} refused: {}", names_of(&refused.models), refused.why));
        }
        self.revisions.refused = Some(refused);
        if let Err(why) = self.store.save_revisions(&self.revisions) {
            warn!(service = "ifc-ingest", error = chain(&why), "the refusal is not kept");
        }
        self.revisions.standing().error.unwrap_or_default().into()
    }

    /// Keeps a revision until an operator confirms it.
    fn wait_for_operator(
        &mut self,
        revision: &ReadRevision,
        by: Option<Caller>,
    ) -> Result<Done<IngestAnswer>, Failure> {
        let described = revision.described();
        self.revisions.see(&revision.models, &revision.stamps);
        self.revisions.waiting = Some(Waiting { sha256: revision.sha256(), revision: described.clone() });
        self.revisions.refused = None;
        self.store.save_revisions(&self.revisions)?;
        let why = described.comparison.objections.join("; ");
        self.record(HistoryKind::Revision, by, format!("{} waits: {why}", names_of(&revision.models)));
        Ok(self.answer_of(RevisionEffect::Waits, Some(described)))
    }

    /// Makes a revision the one in force.
    fn take_effect(
        &mut self,
        revision: ReadRevision,
        by: Option<Caller>,
        reporter: &Reporter,
    ) -> Result<Done<IngestAnswer>, Failure> {
        reporter.report("writing the site", COMPARED);
        let (refused, waiting) = self.revisions.unaffected_by(&revision.models, revision.site.content_hash());
        let revisions = Revisions {
            models: revision.models.clone(),
            stamps: revision.stamps.clone(),
            seen: None,
            site_hash: Some(revision.site.content_hash()),
            frame_epoch: frame_of(&revision.site).frame_epoch,
            configured: self.revisions.configured.clone(),
            setting: Some(self.revisions.setting_of(&revision.models, by.map(|by| by.uid))),
            refused,
            waiting,
        };
        let described = revision.described();
        let ReadRevision { site, outline, models, stamps, .. } = revision;
        if let Err(why) = self.store.put_in_force(&site, &outline, &revisions) {
            let wait = self.next_try.map_or(MIN_WAIT, |(_, wait)| (wait * 2).min(MAX_WAIT));
            self.next_try = Some((Instant::now() + wait, wait));
            return Err(self.refuse(models, &stamps, why.as_ref(), by));
        }
        self.next_try = None;
        let is_other_site = self.revisions.site_hash != revisions.site_hash;
        let (before, frame, n_bytes) = (self.frame(), frame_of(&site), site.bytes().bytes().len());
        let dropped = self.revisions.waiting.take().filter(|_| revisions.waiting.is_none());
        (self.revisions, self.outline) = (revisions, Some(outline));
        if is_other_site {
            self.record(HistoryKind::Revision, by, format!("{} in force", names_of(&models)));
        }
        if let Some(Waiting { revision, .. }) = dropped.filter(|dropped| dropped.revision.models != models) {
            self.record(HistoryKind::Revision, by, format!("{} no longer waits", names_of(&revision.models)));
        }
        if before.is_some_and(|before| !is_same_frame(&before, &frame)) {
            self.record(HistoryKind::Frame, by, format!("another map frame, epoch {}", frame.frame_epoch));
        }
        // It is in force: what has no room on the bus is published as soon as it has.
        match self.publish(site) {
            Ok(()) => info!(service = "ifc-ingest", epoch = self.output.epoch(), bytes = n_bytes, "site published"),
            Err(why) => warn!(service = "ifc-ingest", error = chain(why.as_ref()), "the site has no room yet"),
        }
        reporter.report("site published", 1.0);
        Ok(self.answer_of(RevisionEffect::InForce, Some(described)))
    }

    /// Forgets the revision that waits, and the one that was refused.
    fn discard(&mut self, by: Option<Caller>) -> Result<Done<IngestAnswer>, Failure> {
        let (waiting, refused) = (self.revisions.waiting.take(), self.revisions.refused.take());
        let models = waiting.as_ref().map(|w| &w.revision.models).or(refused.as_ref().map(|r| &r.models));
        let names = names_of(models.ok_or("no revision waits, and none was refused")?);
        self.store.save_revisions(&self.revisions)?;
        self.record(HistoryKind::Revision, by, format!("{names} discarded"));
        Ok(self.answer_of(RevisionEffect::Discarded, waiting.map(|waiting| waiting.revision)))
    }

    fn confirm(&mut self, asked: &Asked) -> Result<Done<IngestAnswer>, Failure> {
        let Waiting { revision, sha256 } = self.revisions.waiting.clone().ok_or("no revision waits to be confirmed")?;
        self.record(HistoryKind::Revision, Some(asked.by), format!("{} confirmed", names_of(&revision.models)));
        self.load(revision.models, &Intent::Confirm(sha256), Some(asked.by), &asked.reporter)
    }

    /// Reads the files again if they look different from when they were read last.
    fn reload_if_changed(&mut self) -> Result<Done, Failure> {
        if let Some(models) = self.to_read.take() {
            return self.load_unasked(models);
        }
        let is_due = self.next_try.is_some_and(|(at, _)| at <= Instant::now());
        if let Some(Refused { models, stamps, .. }) = &self.revisions.refused
            && (is_due || *stamps != stamps_of(models))
        {
            return self.load_once_whole(models.clone());
        }
        let now = stamps_of(&self.revisions.models);
        if self.revisions.models.is_empty() || self.revisions.are_seen(&now) {
            if !self.output.is_pending() {
                return Ok(Done::default());
            }
            self.output.retry(&mut self.epochs)?;
            self.activity.set(Activity::Published);
            return Ok(self.done());
        }
        let models = self.revisions.models.clone();
        if self.revisions.is_without_site() { self.load_unasked(models) } else { self.load_once_whole(models) }
    }

    /// Loads files that were written to, once a later look finds them as this one.
    fn load_once_whole(&mut self, models: Vec<PathBuf>) -> Result<Done, Failure> {
        let Some(whole) = self.watch.look(&models) else { return Ok(Done::default()) };
        let loaded = self.load_whole(models, whole, &Intent::Load, None, &Reporter::default());
        self.settle(loaded)
    }

    /// Loads files that no client asked for.
    fn load_unasked(&mut self, models: Vec<PathBuf>) -> Result<Done, Failure> {
        let loaded = self.load(models, &Intent::Load, None, &Reporter::default());
        self.settle(loaded)
    }

    /// What comes of a load that no client asked for stands in the status.
    fn settle(&self, loaded: Result<Done<IngestAnswer>, Failure>) -> Result<Done, Failure> {
        match loaded {
            Ok(done) => Ok(done.answered(())),
            // It is kept, and shown until it is cured.
            Err(_) if self.revisions.refused.is_some() => Ok(Done::default()),
            Err(why) => Err(why),
        }
    }

    /// Other rules, another configuration, or another try: what was refused may be right now.
    fn configure(&mut self, config: &SiteConfig) -> Result<Done, Failure> {
        self.follow_configured_models(config);
        let frame = self.frame_in_force(self.frame()).map(drop);
        let usable = self.reader.configure(config).and(frame);
        self.error = usable.err().map(|why| chain(why.as_ref()));
        match &self.revisions.refused {
            Some(refused) if self.to_read.is_none() => self.load_unasked(refused.models.clone()),
            _ => self.reload_if_changed(),
        }
    }

    fn publish(&mut self, site: Checked<payload::Site>) -> Result<(), Failure> {
        let frame_epoch = u64::from(site.view().head.frame_epoch);
        self.output.publish(&mut self.epochs, site, frame_epoch, InputHashes::default())
    }

    fn frame(&self) -> Option<SiteFrame> {
        self.output.last().map(frame_of)
    }

    /// The files, with what was read of those that are in force.
    fn model_files(&self) -> Vec<ModelFile> {
        let site = self.output.last().map(Checked::view);
        let mut sha256 = site.iter().flat_map(|site| site.sources).map(|source| export::hex(&source.sha256));
        self.revisions.models.iter().map(|path| ModelFile { path: path.clone(), sha256: sha256.next() }).collect()
    }

    fn done(&self) -> Done {
        Done { published: self.output.published(), ..Done::default() }
    }

    fn answer_of(&self, effect: RevisionEffect, revision: Option<Revision>) -> Done<IngestAnswer> {
        let site = self.output.published();
        self.done().answered(IngestAnswer { site, effect, revision })
    }

    fn record(&self, kind: HistoryKind, by: Option<Caller>, summary: String) {
        if let Err(why) = self.history.record(HistoryEvent { kind, by, summary }) {
            warn!(service = "ifc-ingest", error = chain(&why), "the history cannot be written");
        }
    }
}

fn frame_of(site: &Checked<payload::Site>) -> SiteFrame {
    let site = site.view();
    SiteFrame { map_from_world: site.map_from_world(), frame_epoch: site.head.frame_epoch }
}

fn is_same_frame(one: &SiteFrame, other: &SiteFrame) -> bool {
    let motion = |frame: &SiteFrame| (frame.map_from_world.translation_m(), frame.map_from_world.yaw_rad());
    one.frame_epoch == other.frame_epoch && motion(one) == motion(other)
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
            Event::Attached | Event::Tick => self.reload_if_changed(),
            Event::Configuration(config) => self.configure(&config),
            Event::Input(never) => match never {},
        }
    }

    fn answer(&mut self, request: IngestRequest, asked: &Asked) -> Result<Done<IngestAnswer>, Failure> {
        match request {
            IngestRequest::Load { models, dry_run, force } => {
                let models = if models.is_empty() { self.revisions.models.clone() } else { models };
                let intent = match (dry_run, force) {
                    (true, _) => Intent::Compare,
                    (false, true) => Intent::Force,
                    (false, false) => Intent::Load,
                };
                self.load(models, &intent, Some(asked.by), &asked.reporter)
            }
            IngestRequest::Confirm => self.confirm(asked),
            IngestRequest::Discard => self.discard(Some(asked.by)),
            IngestRequest::GetRevision => {
                let waiting = self.revisions.waiting.as_ref().map(|waiting| waiting.revision.clone());
                let effect = if waiting.is_some() { RevisionEffect::Waits } else { RevisionEffect::InForce };
                Ok(self.answer_of(effect, waiting))
            }
        }
    }

    fn standing(&self) -> Standing {
        let revisions = self.revisions.standing();
        let warnings: Vec<&str> = self.store.findings().chain(revisions.warning.as_deref()).collect();
        let warning = (!warnings.is_empty()).then(|| warnings.join("; "));
        Standing { error: self.error.clone().or(revisions.error), warning }
    }

    fn facts(&self) -> IngestFacts {
        IngestFacts {
            models: self.model_files(),
            site: self.output.published(),
            frame_epoch: self.frame().map_or(0, |frame| u64::from(frame.frame_epoch)),
            waiting: self.revisions.waiting.as_ref().map(|waiting| waiting.revision.clone()),
            setting: self.revisions.setting.clone(),
        }
    }
}
