//! The decisions of site-follow: the set of maps that is shown, and the index that it is from.

use crate::archive_folder::{ArchiveDisk, ArchiveFolder, MachineDisk};
use crate::fetcher::{AcceptedIndex, Fetcher, Followed, OpenStore, Shared, Trouble, check_zone, open_store, stop};
use crate::file_folder::FileFolder;
use crate::outputs::{FollowOutputs, FollowSample};
use crate::plan_set::{PublishedArchives, SetError, SetSamples, samples_of};
use crate::teller::{Teller, ToTell, link_settings};
use bus::Bus;
use daemon::facts::{FollowFacts, ScheduleFacts};
use daemon::{
    Clock, Committed, CurrentActivity, Decide, Decision, Epochs, Failure, FollowConfig, FollowRequest, HistoryEvent,
    HistoryKind, KeptFile, MAX_TABLE_BYTES, MachineClock, MachineTime, NoInput, Now, Occasion, PlanTimeClock,
    ReachedPlanTime, Reading, SiteConfig, Standing, StateFile, chain, joined, state_files,
};
use jiff::tz::TimeZone;
use messages::{ContentHash, ContentId, plan_time};
use replica::{Acknowledged, IndexClock, PlanSet, SiteIndex, accept};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tracing::warn;

/// While something is fetched, this often is looked for what has come.
const LOOK_INTERVAL: Duration = Duration::from_millis(100);

/// A reading of the clock is on disk at least this often.
const KEEP_CLOCK_MS: i64 = 3_600_000;

/// A store that was not reached for so many looks is told.
const LATE_LOOKS: i64 = 4;

/// What the daemon asks the store with, and what is under its archives: others in a simulation.
pub struct Surroundings {
    /// Opens the store.
    pub open: OpenStore,
    /// The clock of what asks the store.
    pub clock: Box<dyn Clock>,
    /// The disk of the archives.
    pub disk: Arc<dyn ArchiveDisk>,
}

/// Shows what the server of a site has drawn.
pub struct SiteFollow {
    config: FollowConfig,
    followed: Followed,
    synchronised_while: Option<PathBuf>,
    folder: ArchiveFolder,
    /// Where exported files are shown, if they are asked for.
    files: Option<Arc<FileFolder>>,
    shared: Arc<Shared>,
    in_force: InForce,
    /// The newest index that was accepted, if it is not the one in force.
    newest: Option<Arc<AcceptedIndex>>,
    /// What an operator should know of the state that was found at the start.
    finding: Option<String>,
    state_file: StateFile,
    index_file: KeptFile,
    /// Content hashes of archives that were read: what the disk has under a name does not change.
    hashes: Mutex<BTreeMap<ContentId, ContentHash>>,
    /// Why the last decision could not show what is due.
    trouble: Mutex<Option<SetError>>,
    to_tell: Arc<ToTell>,
    observed_file: KeptFile,
}

/// What a decision changes.
#[derive(Clone, Default)]
pub struct InForce {
    /// The index that is shown.
    index: Option<Arc<SiteIndex>>,
    kept: Kept,
    /// Which of its sets.
    shown: Option<usize>,
    published: PublishedArchives,
    /// The table of progress that the robot observed.
    observed: Option<Arc<str>>,
}

/// What survives the daemon beside the index itself.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept {
    acknowledged: Option<Acknowledged>,
    /// The zone of the clock, and how far the plan time got in it.
    reached: Option<(String, ReachedPlanTime)>,
}

impl SiteFollow {
    /// The daemon on this machine, with what it showed last, and the thread that asks the store.
    ///
    /// # Errors
    /// A configuration or state that cannot be used.
    pub fn start(config: &SiteConfig, activity: CurrentActivity) -> Result<Committed<Self>, Failure> {
        let follow = config.follow.as_ref().ok_or("the configuration has no [follow]: nothing is followed")?;
        let (open, clock) = (open_store(follow), Box::new(MachineClock::of_this_boot()));
        let surroundings = Surroundings { open, clock, disk: Arc::new(MachineDisk) };
        let (service, fetcher, to_tell) = Self::parts(config, activity, surroundings)?;
        if let Some(link) = &follow.link {
            let settings = link_settings(follow, link);
            // What can be known of it now is not found out later, in a thread.
            settings.check()?;
            let fetched = fetcher.shared();
            let teller = Teller::new(config.clone(), settings, to_tell, move || {
                fetched.change(|findings| findings.is_called = true)
            });
            std::thread::Builder::new().name("site-follow-tell".to_owned()).spawn(|| {
                daemon::in_background();
                teller.run();
            })?;
        }
        std::thread::Builder::new().name("site-follow-get".to_owned()).spawn(|| {
            // What is shown goes before what will be.
            daemon::in_background();
            fetcher.run();
        })?;
        Ok(service)
    }

    /// The daemon with what it showed last, and what asks the store, which its caller lets run beside it.
    ///
    /// # Errors
    /// As [`Self::start`].
    pub fn within(
        config: &SiteConfig,
        activity: CurrentActivity,
        surroundings: Surroundings,
    ) -> Result<(Committed<Self>, Fetcher), Failure> {
        Self::parts(config, activity, surroundings).map(|(service, fetcher, _)| (service, fetcher))
    }

    /// The same, with what is told to the server.
    fn parts(
        config: &SiteConfig,
        activity: CurrentActivity,
        surroundings: Surroundings,
    ) -> Result<(Committed<Self>, Fetcher, Arc<ToTell>), Failure> {
        let follow = config.follow.clone().ok_or("the configuration has no [follow]: nothing is followed")?;
        let followed = Followed::of(&follow)?;
        let Surroundings { open, clock, disk } = surroundings;
        let folder = ArchiveFolder::at(&config.state, disk)?;
        let files = follow.files.as_deref().map(|folder| Arc::new(FileFolder::at(folder)));
        let state_file = StateFile::at(&config.state, state_files::FOLLOWED)?;
        let index_file = KeptFile::at(&config.state, state_files::FOLLOWED_INDEX);
        let kept: Kept = state_file.load()?.unwrap_or_default();
        let shared = Arc::new(Shared::default());
        let mut finding = state_file.finding().map(str::to_owned);
        let newest = match index_file.load() {
            Ok(file) => file.and_then(|file| shown_before(file, &followed, &kept)),
            Err(why) => {
                // It is fetched again.
                finding.get_or_insert(format!("what was shown last cannot be read: {why}"));
                None
            }
        };
        let mut findings = shared.lock();
        findings.acknowledged = kept.acknowledged.clone().filter(|known| known.site == followed.site);
        findings.newest.clone_from(&newest);
        findings.in_force = newest.iter().flat_map(|accepted| archive_ids(&followed, &accepted.signed.index)).collect();
        drop(findings);
        let observed_file = KeptFile::at(&config.state, state_files::OBSERVED_BY_FOLLOWER);
        let observed = || -> Result<Option<Arc<str>>, Failure> {
            Ok(observed_file.load()?.map(String::from_utf8).transpose()?.map(Arc::from))
        };
        let observed = observed().unwrap_or_else(|why| {
            // Maps do not wait for what the robot has to tell.
            let why = chain(why.as_ref());
            finding.get_or_insert(format!("what the robot observed last cannot be read, and is not told: {why}"));
            None
        });
        let to_tell = Arc::new(ToTell::default());
        to_tell.set_progress(observed.clone());
        let fetcher = Fetcher::new(
            follow.clone(),
            followed.clone(),
            folder.clone(),
            files.clone(),
            Arc::clone(&shared),
            (open, clock),
        );
        let service = Self {
            config: follow,
            followed,
            synchronised_while: config.clock.synchronised_while.clone(),
            folder,
            files,
            shared,
            in_force: InForce { kept, observed, ..InForce::default() },
            newest,
            finding,
            state_file,
            index_file,
            hashes: Mutex::default(),
            trouble: Mutex::default(),
            to_tell: Arc::clone(&to_tell),
            observed_file,
        };
        let epochs = Epochs::at(&config.state, state_files::FOLLOW_EPOCHS)?;
        Ok((Committed::new(service, FollowOutputs::default(), epochs, &config.state, activity), fetcher, to_tell))
    }

    /// The plan time of the robot's clock, if the index says that it follows one.
    fn read_clock(&self, index: &SiteIndex, kept: &Kept, machine: MachineTime) -> Option<(String, TimeZone, Reading)> {
        let IndexClock::Wall { zone: name } = &index.clock else { return None };
        // A name that the program does not have was refused with the index.
        let zone = TimeZone::get(name).ok()?;
        let reached = kept.reached.as_ref().filter(|(of, _)| of == name).map(|(_, reached)| *reached);
        let synchronised = self.synchronised_while.as_deref().is_none_or(|path| path.exists());
        let clock = PlanTimeClock::Wall { reached: reached.unwrap_or_default() };
        Some((name.clone(), zone.clone(), clock.read(machine, &zone, synchronised)))
    }

    /// When the set after the one that is shown is due, by the machine's clock.
    fn next_update_ms(&self, machine: MachineTime) -> Option<i64> {
        let index = self.in_force.index.as_ref()?;
        let (_, zone, reading) = self.read_clock(index, &self.in_force.kept, machine)?;
        if reading.distrust.is_some() {
            return None;
        }
        let set = self.shown_set()?;
        let next_s = set.valid_until_s?;
        let clock = PlanTimeClock::Wall { reached: ReachedPlanTime::default() };
        Some(machine.wall_ms.saturating_add(clock.until_ms(next_s, machine.wall_ms, &zone)?))
    }

    /// What the server does not hear of this robot, and why.
    fn unheard(&self) -> Option<String> {
        let has_rows = |table: &Arc<str>| table.lines().filter(|line| !line.trim().is_empty()).nth(1).is_some();
        match &self.config.link {
            Some(_) => self.to_tell.error().map(|why| format!("the server does not hear this robot: {why}")),
            None => self.in_force.observed.as_ref().filter(|table| has_rows(table)).map(|_| {
                "what the robot observed changes no maps: without [follow.link] the server is not told".to_owned()
            }),
        }
    }

    fn shown_set(&self) -> Option<&PlanSet> {
        self.in_force.index.as_ref()?.sets.get(self.in_force.shown?)
    }

    /// Shows the exported files of the set that is shown, once they are here.
    fn show_files(&self) {
        if let Some((folder, set)) = self.files.as_ref().zip(self.shown_set()) {
            folder.show(set.files_of(&self.followed.robot));
        }
    }

    /// Keeps a reading of a clock that goes on, so that standstill of the machine later is told from a clock that was set.
    fn keep_clock(
        &self,
        decision: &mut Decision<Self>,
        clock: Option<(String, TimeZone, Reading)>,
        machine: MachineTime,
    ) -> Result<(), Failure> {
        let Some((zone, _, reading)) = clock.filter(|(_, _, reading)| reading.distrust.is_none()) else {
            return Ok(());
        };
        let last_ms = self.in_force.kept.reached.as_ref().map_or(0, |(_, reached)| reached.machine.wall_ms);
        if machine.wall_ms.saturating_sub(last_ms) > KEEP_CLOCK_MS {
            decision.next.kept.reached = Some((zone, ReachedPlanTime { plan_time_s: reading.plan_time_s, machine }));
            decision.save.push(self.state_file.saving(&decision.next.kept)?);
        }
        Ok(())
    }

    /// Shows the set of the newest index that is due, if another one is shown.
    fn show(&self, decision: &mut Decision<Self>, machine: MachineTime) -> Result<(), Failure> {
        let newest = self.newest.as_ref().map(|accepted| {
            (&accepted.signed.index, self.followed.n_complete(&accepted.signed.index, &self.folder), Some(accepted))
        });
        let newest = newest.filter(|(_, n_complete, _)| *n_complete > 0);
        let in_force = self.in_force.index.as_deref();
        let Some((index, n_complete, accepted)) =
            newest.or_else(|| in_force.map(|index| (index, self.followed.n_complete(index, &self.folder), None)))
        else {
            return Ok(());
        };
        let clock = self.read_clock(index, &self.in_force.kept, machine);
        let now_s = clock.as_ref().and_then(|(_, _, reading)| reading.plan_time_s);
        let choice = index.choose(now_s);
        let place = choice.place.min(n_complete.saturating_sub(1));
        if accepted.is_none() && self.in_force.shown == Some(place) || n_complete == 0 {
            return self.keep_clock(decision, clock, machine);
        }
        // What is due is not here yet, and what is here is of before what is shown: that stays.
        let set = &index.sets[place];
        if place < choice.place && self.shown_set().is_some_and(|shown| set.plan_time_s < shown.plan_time_s) {
            return self.keep_clock(decision, clock, machine);
        }
        let mut hashes = self.hashes.lock().unwrap_or_else(PoisonError::into_inner);
        let samples = samples_of(index, set, &self.followed, &self.folder, &self.in_force.published, &mut hashes);
        drop(hashes);
        let mut trouble = self.trouble.lock().unwrap_or_else(PoisonError::into_inner);
        let SetSamples { samples, published } = match samples {
            Ok(samples) => {
                *trouble = None;
                samples
            }
            Err(why) => {
                // It is told as long as it is so.
                *trouble = Some(why);
                return Ok(());
            }
        };
        drop(trouble);
        let next = &mut decision.next;
        if let Some((zone, _, reading)) = clock
            && reading.distrust.is_none()
        {
            // How far the plan time got is on disk before what is shown of it: a map does not go back because a process died.
            let reached = ReachedPlanTime { plan_time_s: reading.plan_time_s.max(set.plan_time_s), machine };
            next.kept.reached = Some((zone, reached));
        }
        if let Some(accepted) = accepted {
            next.kept.acknowledged = Some(accepted.acknowledged.clone());
            decision.save.push(self.index_file.saving(accepted.file.clone()));
            let epoch = index.epoch;
            let summary = format!("index {epoch} of {} from {}", index.site, self.config.store);
            decision.history.push(HistoryEvent { kind: HistoryKind::Index, by: None, summary });
        }
        decision.save.push(self.state_file.saving(&next.kept)?);
        (next.index, next.shown, next.published) = (Some(Arc::new(index.clone())), Some(place), published);
        if let Some(folder) = self.files.as_ref().filter(|_| !samples.is_empty()) {
            let files = set.files_of(&self.followed.robot).copied();
            decision.publish.push(FollowSample::Files(Arc::clone(folder), files));
        }
        decision.publish.extend(samples);
        Ok(())
    }
}

impl Decide for SiteFollow {
    type Input = NoInput;
    type Request = FollowRequest;
    type Facts = FollowFacts;
    type InForce = InForce;
    type Outputs = FollowOutputs;

    fn take(&mut self, input: NoInput) {
        match input {}
    }

    fn attach(&mut self, bus: &Bus) -> Result<(), Failure> {
        self.to_tell.attach(bus);
        Ok(())
    }

    fn gather(&mut self) -> Result<(), Failure> {
        self.show_files();
        let damaged = match &*self.trouble.lock().unwrap_or_else(PoisonError::into_inner) {
            Some(SetError::Damaged { id, .. }) => Some(*id),
            _ => None,
        };
        if let Some(id) = damaged.filter(|id| !self.shared.lock().damaged.contains(id)) {
            self.shared.change(|findings| findings.damaged.push(id));
        }
        let findings = self.shared.lock();
        let in_force = self.in_force.kept.acknowledged.as_ref().filter(|_| self.in_force.index.is_some());
        let newest = findings.newest.as_ref().filter(|newest| in_force != Some(&newest.acknowledged));
        // What was shown before the start counts until something is in force, also where a newer index is not here yet.
        let is_here = |index: &SiteIndex| self.followed.n_complete(index, &self.folder) > 0;
        if self.in_force.index.is_some() || newest.is_some_and(|newest| is_here(&newest.signed.index)) {
            self.newest = newest.cloned();
        }
        Ok(())
    }

    fn decide(&self, occasion: Occasion<'_, FollowRequest>, now: &Now<'_, Self>) -> Result<Decision<Self>, Failure> {
        let mut decision = Decision::of(self.in_force.clone());
        match occasion {
            Occasion::Look => self.show(&mut decision, now.machine)?,
            Occasion::Configuration(config) if config.follow.as_ref() != Some(&self.config) => {
                return Err("[follow] cannot change while site-follow runs: restart it".into());
            }
            Occasion::Configuration(_) => {}
            Occasion::Request(FollowRequest::SetObserved { table }, _) => {
                if table.text.len() as u64 > MAX_TABLE_BYTES {
                    return Err("the table of observed progress is larger than any can be".into());
                }
                decision.save.push(self.observed_file.saving(table.text.clone().into_bytes()));
                decision.next.observed = Some(table.text.into());
                return Ok(decision.answered(|_, _| ()));
            }
        }
        let is_fetching = self.shared.lock().fetching.is_some();
        let due_in = self.next_update_ms(now.machine).map(|at_ms| at_ms.saturating_sub(now.machine.wall_ms));
        // What is late is looked for with each heartbeat.
        let due_in = due_in.and_then(|ms| u64::try_from(ms).ok()).filter(|ms| *ms > 0).map(Duration::from_millis);
        decision.wake_in = due_in.into_iter().chain(is_fetching.then_some(LOOK_INTERVAL)).min();
        Ok(decision)
    }

    fn become_in_force(&mut self, next: InForce) {
        if self.in_force.observed != next.observed {
            self.to_tell.set_progress(next.observed.clone());
        }
        self.in_force = next;
        self.newest = None;
        self.show_files();
        let mut findings = self.shared.lock();
        findings.acknowledged = self.in_force.kept.acknowledged.clone();
        findings.in_force = self.in_force.index.iter().flat_map(|index| archive_ids(&self.followed, index)).collect();
    }

    fn standing(&self, now: &Now<'_, Self>) -> Standing {
        let findings = self.shared.lock();
        let silent_ms = findings.asked_ms.map(|at_ms| now.machine.wall_ms.saturating_sub(at_ms));
        let late_ms = LATE_LOOKS * i64::from(self.config.poll_s) * 1_000;
        let is_late = silent_ms.is_none_or(|ms| ms > late_ms);
        let distrust =
            self.in_force.index.as_ref().and_then(|index| self.read_clock(index, &self.in_force.kept, now.machine));
        let distrust = distrust.and_then(|(_, _, reading)| reading.distrust).map(|why| why.to_string());
        let shown = self.shown_set().map(|set| match set.valid_until_s.and_then(plan_time) {
            Some(until) => format!("what is shown is valid until {until}"),
            None => "what is shown has no end of validity".to_owned(),
        });
        let own = self.trouble.lock().unwrap_or_else(PoisonError::into_inner).as_ref().map(ToString::to_string);
        let files = self.files.as_ref().and_then(|folder| folder.trouble());
        let (mut error, mut warning) = (own, self.finding.clone().or(files));
        if let Some(Trouble { why, is_answer }) = findings.trouble.clone() {
            let told = shown.map_or(why.clone(), |shown| format!("{why}; {shown}"));
            // A store that cannot be asked for a moment is no error: what is shown stays.
            match is_answer || is_late {
                true => error = joined(error.into_iter().chain([told])),
                false => warning = joined(warning.into_iter().chain([told])),
            }
        }
        Standing { error, warning: joined(warning.into_iter().chain(distrust).chain(self.unheard())) }
    }

    fn facts(&self, now: &Now<'_, Self>) -> FollowFacts {
        let findings = self.shared.lock();
        let index = self.in_force.index.as_ref();
        let set = self.shown_set();
        let clock = index.and_then(|index| self.read_clock(index, &self.in_force.kept, now.machine));
        let shown = self.in_force.shown.unwrap_or(0);
        let later = index.map_or(&[][..], |index| &index.sets[..]).iter().skip(shown + 1);
        let n_here = index.map_or(0, |index| self.followed.n_complete(index, &self.folder)).saturating_sub(shown + 1);
        FollowFacts {
            store: self.config.store.clone(),
            site: self.config.site.clone(),
            epoch: index.map_or(0, |index| index.epoch),
            newest_epoch: findings.newest.as_ref().map_or(0, |newest| newest.acknowledged.epoch),
            published: index.map(|index| index.published.clone()),
            asked_ms: findings.asked_ms,
            fetching: findings.fetching,
            fetched_bytes: findings.fetched_bytes,
            maps: now.outputs.maps(),
            mission_plan: now.outputs.mission_plan(),
            later_s: later.take(n_here).filter_map(|set| set.plan_time_s).collect(),
            schedule: ScheduleFacts {
                state: now.outputs.state(),
                site_hash: now.outputs.site(),
                state_plan_time_s: set.and_then(|set| set.plan_time_s),
                due_plan_time_s: set.and_then(|set| set.plan_time_s),
                plan_time_s: clock
                    .as_ref()
                    .and_then(|(_, _, reading)| reading.plan_time_s)
                    .or(set.and_then(|set| set.plan_time_s)),
                clock: match index.map(|index| &index.clock) {
                    Some(IndexClock::Wall { .. }) => "wall clock".to_owned(),
                    Some(IndexClock::ByServer) => "moved by the server".to_owned(),
                    None => String::new(),
                },
                is_wall_clock: clock.is_some(),
                valid_until_s: set.and_then(|set| set.valid_until_s),
                next_update_ms: self.next_update_ms(now.machine),
                clock_distrust: clock.as_ref().and_then(|(_, _, reading)| reading.distrust).map(|why| why.to_string()),
                site_zone: clock.map(|(name, _, _)| name),
                ..ScheduleFacts::default()
            },
        }
    }
}

/// What was shown before the start, if it may be believed: of the disk no more than of the store.
fn shown_before(file: Vec<u8>, followed: &Followed, kept: &Kept) -> Option<Arc<AcceptedIndex>> {
    let accepted = accept(&file, &followed.roots, &followed.site, kept.acknowledged.as_ref()).map_err(Failure::from);
    let accepted = accepted.and_then(|(signed, acknowledged)| {
        check_zone(&signed.index)?;
        Ok(Arc::new(AcceptedIndex { file, signed, acknowledged }))
    });
    match accepted {
        Ok(accepted) => Some(accepted),
        Err(why) => {
            let error = chain(why.as_ref());
            warn!(service = "site-follow", error, "what was shown last is not shown again");
            None
        }
    }
}

/// The archives of an index that a robot needs, of all of its sets, and the lists of exported files.
fn archive_ids(followed: &Followed, index: &SiteIndex) -> BTreeSet<ContentId> {
    let of_set = |set: &PlanSet| {
        let archives = followed.archives(index, set).unwrap_or_default();
        let files = set.files_of(&followed.robot).map(|files| files.list.id);
        archives.into_iter().map(|entry| entry.id).chain(files).collect::<Vec<_>>()
    };
    index.sets.iter().flat_map(of_set).collect()
}

impl Drop for SiteFollow {
    fn drop(&mut self) {
        stop(&self.shared);
        self.to_tell.stop();
    }
}
