//! Decisions of ifc-ingest: the revision of the site that is in force, those that are refused or wait for an operator.
//!
//! A revision takes effect as a whole or not at all: its files are read, it is compared with the site in force and proposed, as a
//! candidate on the bus, to schedule-eval, which says whether it has a schedule; one that is refused, or that waits for an operator,
//! changes nothing.

use crate::in_force::{InForce, ReadFiles, frame_of, is_same_frame};
use crate::judge::{Judge, ScheduleEval};
use crate::model_files::{ModelFiles, names_of};
use crate::output::{SiteOutput, SiteSample};
use crate::proposal::{Intent, Proposal};
use crate::revision_reader::{Compared, ReadRevision, RevisionReader};
use crate::revision_verdict::{Refusal, Verdict, verdict_on};
use crate::revisions::{Refused, Revisions, Waiting};
use crate::site_store::SiteStore;
use bus::Bus;
use daemon::facts::{IngestFacts, ModelFile};
use daemon::{
    Asked, Caller, Committed, CurrentActivity, Decide, Decision, Epochs, Failure, FileWatch, HistoryEvent, HistoryKind,
    IngestAnswer, IngestRequest, MachineTime, NoInput, Now, Occasion, Revision, RevisionEffect, ScheduleVerdict,
    SiteConfig, Standing, WholeFiles, chain, joined, stamps_of, state_files,
};
use ingest::{MAX_MODEL_BYTES, SiteFrame};
use messages::{Activity, Checked, ContentId, SiteOutline};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tracing::warn;

/// Shares of a load that are done when the revision is read and compared, and when it is judged.
const PROPOSED: f64 = 0.97;
const JUDGED: f64 = 0.98;

/// Reads the files of a site.
pub struct Ingest {
    in_force: InForce,
    store: SiteStore,
    activity: CurrentActivity,
    judge: Box<dyn Judge>,
    /// What was found of the proposal.
    verdict: Option<ScheduleVerdict>,
}

/// When an operator is told that schedule-eval has not judged a revision.
const LONG_WAIT_MS: i64 = 5_000;
/// Interval of looks at a candidate.
const POLL: Duration = Duration::from_millis(10);

/// What a client is told of a revision, or why it is refused.
type Told = Result<(RevisionEffect, Option<Revision>), Failure>;

impl Ingest {
    /// The daemon on this machine, from the configuration and the persisted state: loaded files override configured ones until those are
    /// edited.
    ///
    /// # Errors
    /// Rules or state that cannot be used. A cache that cannot be used is made anew.
    pub fn start(config: &SiteConfig, activity: CurrentActivity) -> Result<Committed<Self>, Failure> {
        Self::start_judged(config, activity, Box::<ScheduleEval>::default())
    }

    /// The same with another judge.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn start_judged(
        config: &SiteConfig,
        activity: CurrentActivity,
        judge: Box<dyn Judge>,
    ) -> Result<Committed<Self>, Failure> {
        let store = SiteStore::at(&config.state)?;
        let first = || Revisions { models: config.models.clone(), ..Revisions::default() };
        let revisions = store.revisions()?.unwrap_or_else(first);
        let cached = store.cached_site(&revisions);
        let outline = match store.outline()? {
            Some(outline) => Some(outline),
            None => cached.as_ref().map(|site| SiteOutline::of(&site.view())),
        };
        let mut epochs = Epochs::at(&config.state, state_files::SITE_EPOCHS)?;
        let mut in_force = InForce {
            reader: Arc::new(RevisionReader::new(config, activity.clone())),
            revisions,
            outline: outline.map(Arc::new),
            watch: FileWatch::new(MAX_MODEL_BYTES),
            to_read: None,
            error: None,
            next_try: None,
            meshes: None,
            read: None,
            proposal: None,
        };
        in_force.follow_configured_models(config);
        if in_force.to_read.is_none() {
            // What it was refused for may be mended.
            in_force.to_read = in_force.revisions.refused.as_ref().map(|refused| refused.models.clone());
        }
        let mut output = SiteOutput::new(Epochs::at(&config.state, state_files::CANDIDATE_EPOCHS)?);
        let mut service = Self { in_force, store, activity: activity.clone(), judge, verdict: None };
        match cached {
            Some(site) if service.starts_with(&site)? => output.put(Arc::new(site), &mut epochs),
            Some(_) => {}
            // What was tried before is tried again.
            None => service.in_force.revisions.seen = Some(Vec::new()),
        }
        Ok(Committed::new(service, output, epochs, &config.state, activity))
    }

    /// True if the site in force is to be published: the frame that is kept is not a later one.
    fn starts_with(&mut self, site: &Checked<messages::payload::Site>) -> Result<bool, Failure> {
        let frame = frame_of(site);
        match self.frame_in_force(Some(frame)) {
            Ok(Some(kept)) if !is_same_frame(&kept, &frame) => {
                warn!(service = "ifc-ingest", "the map frame was replaced; files are read anew");
                self.in_force.revisions.seen = Some(Vec::new());
                return Ok(false);
            }
            // A file of the frame that was removed comes back.
            Ok(_) => self.store.saving_frame(site)?.write()?,
            Err(why) => self.in_force.error = Some(chain(why.as_ref())),
        }
        Ok(true)
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

    /// Waits until files are whole, and does with them as is intended. What a client is told, if that is known at once.
    fn load(
        &self,
        decision: &mut Decision<Self>,
        models: Vec<PathBuf>,
        intent: Intent,
        asked: Option<&Asked>,
        now: &Now<'_, Self>,
    ) -> Result<Option<Told>, Failure> {
        let reporter = asked.map(|asked| asked.reporter.clone()).unwrap_or_default();
        reporter.report("reading files", 0.0);
        let waits = || reporter.report("waiting until the files are written", 0.0);
        let whole = decision.next.watch.wait(&models, waits);
        self.load_whole(decision, models, whole, intent, asked, now)
    }

    /// Reads files and proposes them, to do with them as is intended. What cannot take effect leaves the site in force where it is.
    fn load_whole(
        &self,
        decision: &mut Decision<Self>,
        models: Vec<PathBuf>,
        whole: Result<WholeFiles, Failure>,
        intent: Intent,
        asked: Option<&Asked>,
        now: &Now<'_, Self>,
    ) -> Result<Option<Told>, Failure> {
        let stamps = whole.as_ref().map_or_else(|_| stamps_of(&models), |whole| whole.stamps.clone());
        let is_asked = asked.is_some();
        let read = ReadFiles { models: models.clone(), stamps: stamps.clone(), intent: intent.clone(), is_asked };
        decision.next.read = Some(read);
        let reporter = asked.map(|asked| asked.reporter.clone()).unwrap_or_default();
        let frame = self.frame_in_force(now.outputs.site().map(frame_of));
        let read = whole.and_then(|whole| {
            let frame = frame?;
            let last_epoch = frame.map_or(0, |frame| frame.frame_epoch).max(self.in_force.revisions.frame_epoch);
            let in_force = Compared { frame, last_epoch, outline: self.in_force.outline.as_deref() };
            decision.next.reader.read(ModelFiles::of(models.clone(), whole), in_force, &reporter)
        });
        self.activity.set(if now.outputs.site().is_some() { Activity::Published } else { Activity::Idle });
        match read {
            Ok(revision) => {
                reporter.report("evaluating the schedule", PROPOSED);
                decision.publish.push(SiteSample::Candidate(Arc::clone(&revision.site)));
                decision.next.meshes = revision.meshes;
                let (revision, since_boot_ms) = (Arc::new(revision), now.machine.since_boot_ms);
                decision.next.proposal =
                    Some(Proposal { revision, intent, asked: asked.cloned(), since_boot_ms, refused: None });
                decision.wake_in = Some(POLL);
                Ok(None)
            }
            Err(why) => {
                let refused = Refused { models, stamps, why: chain(why.as_ref()) };
                self.refuse(decision, refused, &intent, asked).map(Some)
            }
        }
    }

    /// Tells why a revision cannot take effect, and keeps what is to be kept of it.
    fn refuse(
        &self,
        decision: &mut Decision<Self>,
        refused: Refused,
        intent: &Intent,
        asked: Option<&Asked>,
    ) -> Result<Told, Failure> {
        let refusal = Refusal::of(&refused.models, intent, asked.is_some(), &self.in_force.revisions);
        if refusal == Refusal::Told {
            return Ok(Err(refused.why.into()));
        }
        decision.next.next_try = None;
        let (why, told) = decision.next.refuse(refused, refusal);
        let by = asked.map(|asked| asked.by);
        decision.history.extend(told.map(|told| HistoryEvent::new(HistoryKind::Revision, by, told)));
        decision.save.push(self.store.saving_revisions(&decision.next.revisions)?);
        Ok(Err(why))
    }

    /// Does with a proposal as the verdict is; the client that waits for it is told.
    fn look_at_proposal(
        &self,
        decision: &mut Decision<Self>,
        proposal: &Proposal,
        now: &Now<'_, Self>,
    ) -> Result<(), Failure> {
        let Proposal { revision, intent, asked, .. } = proposal;
        let (revisions, since_boot_ms) = (&self.in_force.revisions, now.machine.since_boot_ms);
        let (models, stamps) = (revision.models.clone(), revision.stamps.clone());
        let is_asked = asked.is_some();
        let read = ReadFiles { models: models.clone(), stamps: stamps.clone(), intent: intent.clone(), is_asked };
        let asked = asked.as_ref();
        let mut later = None;
        let told = match verdict_on(proposal, self.verdict.as_ref(), revisions, since_boot_ms) {
            Verdict::Open => {
                decision.wake_in = Some(POLL);
                return Ok(());
            }
            Verdict::StaysRefused => return self.reload_if_changed(decision, now),
            Verdict::Refused(why) => {
                // Other rules, files or progress may be in force one day.
                if Refusal::of(&models, intent, asked.is_some(), revisions) == Refusal::Kept {
                    let refused = Some(why.clone());
                    later = Some(Proposal { intent: Intent::Load, asked: None, refused, ..proposal.clone() });
                }
                self.refuse(decision, Refused { models, stamps, why }, intent, asked)?
            }
            Verdict::Compared => Ok((RevisionEffect::DryRun, Some(revision.described()))),
            Verdict::WaitsForOperator => Ok(self.wait_for_operator(decision, revision, asked.map(|asked| asked.by))?),
            Verdict::TakesEffect => Ok(self.take_effect(decision, revision, asked, now.outputs)?),
        };
        (decision.next.proposal, decision.next.read) = (later, Some(read));
        if let Some(asked) = asked {
            Self::tell(decision, told, asked);
        }
        Ok(())
    }

    /// Tells a client what came of its request once that is committed.
    fn tell(decision: &mut Decision<Self>, told: Told, asked: &Asked) {
        let is_published = decision.publish.iter().any(|sample| matches!(sample, SiteSample::InForce(_)));
        let reporter = is_published.then(|| asked.reporter.clone());
        decision.answer = Some(Box::new(move |_, now| {
            let (effect, revision) = told?;
            reporter.iter().for_each(|reporter| reporter.report("site published", 1.0));
            Ok(IngestAnswer { site: now.outputs.published(), effect, revision })
        }));
    }

    /// Keeps a revision until an operator confirms it.
    fn wait_for_operator(
        &self,
        decision: &mut Decision<Self>,
        revision: &ReadRevision,
        by: Option<Caller>,
    ) -> Result<(RevisionEffect, Option<Revision>), Failure> {
        let described = revision.described();
        let revisions = &mut decision.next.revisions;
        revisions.see(&revision.models, &revision.stamps);
        revisions.waiting = Some(Waiting { revision: described.clone() });
        revisions.refused = None;
        decision.save.push(self.store.saving_revisions(revisions)?);
        let why = described.comparison.objections.join("; ");
        let told = format!("{} waits: {why}", names_of(&revision.models));
        decision.history.push(HistoryEvent::new(HistoryKind::Revision, by, told));
        Ok((RevisionEffect::Waits, Some(described)))
    }

    /// Makes a revision the one in force.
    fn take_effect(
        &self,
        decision: &mut Decision<Self>,
        revision: &ReadRevision,
        asked: Option<&Asked>,
        outputs: &SiteOutput,
    ) -> Result<(RevisionEffect, Option<Revision>), Failure> {
        asked.iter().for_each(|asked| asked.reporter.report("writing the site", JUDGED));
        let by = asked.map(|asked| asked.by);
        let before = &self.in_force.revisions;
        let (refused, waiting) = before.unaffected_by(&revision.models, revision.site.content_hash());
        let frame = frame_of(&revision.site);
        let revisions = Revisions {
            models: revision.models.clone(),
            stamps: revision.stamps.clone(),
            seen: None,
            site_hash: Some(revision.site.content_hash()),
            frame_epoch: frame.frame_epoch,
            configured: decision.next.revisions.configured.clone(),
            setting: Some(before.setting_of(&revision.models, by.map(|by| by.uid))),
            refused,
            waiting,
        };
        let described = revision.described();
        let ReadRevision { site, outline, models, .. } = revision;
        decision.save.extend(self.store.saving(site, outline, &revisions)?);
        if before.site_hash != revisions.site_hash {
            decision.history.push(HistoryEvent::new(
                HistoryKind::Revision,
                by,
                format!("{} in force", names_of(models)),
            ));
        }
        let dropped = before.waiting.as_ref().filter(|_| revisions.waiting.is_none());
        if let Some(Waiting { revision }) = dropped.filter(|dropped| dropped.revision.models != *models) {
            let told = format!("{} no longer waits", names_of(&revision.models));
            decision.history.push(HistoryEvent::new(HistoryKind::Revision, by, told));
        }
        if outputs.site().is_some_and(|site| !is_same_frame(&frame_of(site), &frame)) {
            let told = format!("another map frame, epoch {}", frame.frame_epoch);
            decision.history.push(HistoryEvent::new(HistoryKind::Frame, by, told));
        }
        decision.publish.push(SiteSample::InForce(Arc::clone(site)));
        let next = &mut decision.next;
        (next.revisions, next.outline, next.next_try) = (revisions, Some(Arc::clone(outline)), None);
        Ok((RevisionEffect::InForce, Some(described)))
    }

    /// Forgets the revision that waits, and the one that was refused.
    fn discard(
        &self,
        decision: &mut Decision<Self>,
        by: Option<Caller>,
    ) -> Result<(RevisionEffect, Option<Revision>), Failure> {
        let revisions = &mut decision.next.revisions;
        let (waiting, refused) = (revisions.waiting.take(), revisions.refused.take());
        let models = waiting.as_ref().map(|w| &w.revision.models).or(refused.as_ref().map(|r| &r.models));
        let names = names_of(models.ok_or("no revision waits, and none was refused")?);
        decision.save.push(self.store.saving_revisions(revisions)?);
        decision.history.push(HistoryEvent::new(HistoryKind::Revision, by, format!("{names} discarded")));
        Ok((RevisionEffect::Discarded, waiting.map(|waiting| waiting.revision)))
    }

    /// Reads the files again if they look different from when they were read last.
    fn reload_if_changed(&self, decision: &mut Decision<Self>, now: &Now<'_, Self>) -> Result<(), Failure> {
        if let Some(models) = decision.next.to_read.take() {
            return self.load_unasked(decision, models, now);
        }
        let InForce { revisions, next_try, .. } = &self.in_force;
        let is_due = next_try.is_some_and(|next_try| next_try.is_due(now.machine));
        if let Some(Refused { models, stamps, .. }) = &revisions.refused
            && (is_due || *stamps != stamps_of(models))
        {
            return self.load_once_whole(decision, models.clone(), now);
        }
        if revisions.models.is_empty() || revisions.are_seen(&stamps_of(&revisions.models)) {
            return Ok(());
        }
        let models = revisions.models.clone();
        if revisions.is_without_site() {
            self.load_unasked(decision, models, now)
        } else {
            self.load_once_whole(decision, models, now)
        }
    }

    /// Loads files that were written to, once a later look finds them as this one.
    fn load_once_whole(
        &self,
        decision: &mut Decision<Self>,
        models: Vec<PathBuf>,
        now: &Now<'_, Self>,
    ) -> Result<(), Failure> {
        let Some(whole) = decision.next.watch.look(&models, now.machine) else { return Ok(()) };
        // What comes of it stands in the status.
        self.load_whole(decision, models, whole, Intent::Load, None, now).map(drop)
    }

    /// Loads files that no client asked for.
    fn load_unasked(
        &self,
        decision: &mut Decision<Self>,
        models: Vec<PathBuf>,
        now: &Now<'_, Self>,
    ) -> Result<(), Failure> {
        // What comes of it stands in the status.
        self.load(decision, models, Intent::Load, None, now).map(drop)
    }

    /// Another configuration, or another try: what was refused may be right now. A proposal is judged first.
    fn configure(
        &self,
        decision: &mut Decision<Self>,
        config: &SiteConfig,
        now: &Now<'_, Self>,
    ) -> Result<(), Failure> {
        let next = &mut decision.next;
        next.follow_configured_models(config);
        next.reader = Arc::new(self.in_force.reader.configured(config));
        next.error = self.frame_in_force(now.outputs.site().map(frame_of)).err().map(|why| chain(why.as_ref()));
        let refused = self.in_force.revisions.refused.as_ref().map(|refused| refused.models.clone());
        next.to_read = next.to_read.take().or(refused);
        self.look(decision, now)
    }

    /// Looks at the proposal; without one at the files.
    fn look(&self, decision: &mut Decision<Self>, now: &Now<'_, Self>) -> Result<(), Failure> {
        let Some(proposal) = &self.in_force.proposal else { return self.reload_if_changed(decision, now) };
        let looked = self.look_at_proposal(decision, proposal, now);
        match &proposal.asked {
            Some(asked) if looked.is_err() => {
                *decision = Decision::of(InForce { proposal: None, read: None, ..self.in_force.clone() });
                Self::tell(decision, looked.map(|()| (RevisionEffect::DryRun, None)), asked);
                Ok(())
            }
            _ => looked,
        }
    }

    /// Carries a request out; `decision` says what follows. What the client is told, if that is known at once.
    fn carry_out(
        &self,
        decision: &mut Decision<Self>,
        request: IngestRequest,
        asked: &Asked,
        now: &Now<'_, Self>,
    ) -> Result<Option<Told>, Failure> {
        let revisions = &self.in_force.revisions;
        match request {
            IngestRequest::Load { models, dry_run, force } => {
                let models = if models.is_empty() { revisions.models.clone() } else { models };
                let intent = match (dry_run, force) {
                    (true, _) => Intent::Compare,
                    (false, true) => Intent::Force,
                    (false, false) => Intent::Load,
                };
                self.load(decision, models, intent, Some(asked), now)
            }
            IngestRequest::Confirm { sha256 } => {
                let Some(Waiting { revision }) = revisions.waiting.clone() else {
                    let in_force = self.confirmed_before(&sha256, now.outputs);
                    return in_force.map(|()| Some(Ok((RevisionEffect::InForce, None))));
                };
                if revision.sha256 != sha256 {
                    return Err(format!(
                        "another revision waits by now, {}: see groundplan confirm --list",
                        names_of(&revision.models)
                    )
                    .into());
                }
                let told = format!("{} confirmed", names_of(&revision.models));
                decision.history.push(HistoryEvent::new(HistoryKind::Revision, Some(asked.by), told));
                self.load(decision, revision.models, Intent::Confirm(sha256), Some(asked), now)
            }
            IngestRequest::Discard => self.discard(decision, Some(asked.by)).map(|told| Some(Ok(told))),
            IngestRequest::GetRevision => {
                let waiting = revisions.waiting.as_ref().map(|waiting| waiting.revision.clone());
                let effect = if waiting.is_some() { RevisionEffect::Waits } else { RevisionEffect::InForce };
                Ok(Some(Ok((effect, waiting))))
            }
        }
    }

    /// Nothing waits: a confirmation that comes again is answered if what it names is in force.
    ///
    /// # Errors
    /// It is not.
    fn confirmed_before(&self, sha256: &[ContentId], outputs: &SiteOutput) -> Result<(), Failure> {
        let in_force = outputs.site().map(Checked::view);
        let in_force = in_force.iter().flat_map(|site| site.sources).map(|source| source.sha256);
        match in_force.eq(sha256.iter().map(|id| *id.sha256())) {
            true => Ok(()),
            false => Err("no revision waits to be confirmed".into()),
        }
    }

    /// The files, with what was read of those that are in force.
    fn model_files(&self, outputs: &SiteOutput) -> Vec<ModelFile> {
        let site = outputs.site().map(Checked::view);
        let mut sha256 =
            site.iter().flat_map(|site| site.sources).map(|source| ContentId::from_sha256(source.sha256).to_string());
        let models = &self.in_force.revisions.models;
        models.iter().map(|path| ModelFile { path: path.clone(), sha256: sha256.next() }).collect()
    }
}

impl Decide for Ingest {
    type Input = NoInput;
    type Request = IngestRequest;
    type Facts = IngestFacts;
    type InForce = InForce;
    type Outputs = SiteOutput;

    fn take(&mut self, never: NoInput) {
        match never {}
    }

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        self.judge.attach(bus);
        Ok(())
    }

    fn gather(&mut self) -> Result<(), Failure> {
        let proposed = self.in_force.proposal.as_ref().map(|proposal| proposal.revision.site.content_hash());
        self.verdict = proposed.and_then(|site_hash| self.judge.verdict(site_hash));
        if proposed.is_none() {
            self.judge.rest();
        }
        Ok(())
    }

    fn decide(&self, occasion: Occasion<'_, IngestRequest>, now: &Now<'_, Self>) -> Result<Decision<Self>, Failure> {
        let mut decision = Decision::of(InForce { read: None, ..self.in_force.clone() });
        match occasion {
            Occasion::Look => self.look(&mut decision, now)?,
            Occasion::Configuration(config) => self.configure(&mut decision, config, now)?,
            Occasion::Request(request, asked) => {
                if let Some(told) = self.carry_out(&mut decision, request, asked, now)? {
                    Self::tell(&mut decision, told, asked);
                }
            }
        }
        if decision.next.proposal.is_none() && now.outputs.has_candidate() {
            decision.publish.insert(0, SiteSample::NoCandidate);
        }
        Ok(decision)
    }

    fn become_in_force(&mut self, next: InForce) {
        self.in_force = next;
    }

    fn not_committed(&mut self, next: InForce, why: &str, machine: MachineTime) {
        self.in_force.not_committed(next, why, machine);
    }

    fn standing(&self, now: &Now<'_, Self>) -> Standing {
        let InForce { revisions, error, proposal, .. } = &self.in_force;
        let is_late =
            |p: &&Proposal| p.refused.is_none() && now.machine.since_boot_ms - p.since_boot_ms >= LONG_WAIT_MS;
        let late = proposal.as_ref().filter(is_late).map(|proposal| {
            let names = names_of(&proposal.revision.models);
            revisions.stays(&format!("schedule-eval has not said yet whether {names} has a schedule"))
        });
        let revisions = revisions.standing();
        let of_revisions = [revisions.warning.as_deref(), late.as_deref()];
        let warnings = self.store.findings().chain(of_revisions.into_iter().flatten());
        Standing { error: error.clone().or(revisions.error), warning: joined(warnings) }
    }

    fn facts(&self, now: &Now<'_, Self>) -> IngestFacts {
        let revisions = &self.in_force.revisions;
        IngestFacts {
            models: self.model_files(now.outputs),
            site: now.outputs.published(),
            frame_epoch: now.outputs.site().map_or(0, |site| u64::from(frame_of(site).frame_epoch)),
            waiting: revisions.waiting.as_ref().map(|waiting| waiting.revision.clone()),
            setting: revisions.setting.clone(),
            meshes: self.in_force.meshes,
        }
    }
}
