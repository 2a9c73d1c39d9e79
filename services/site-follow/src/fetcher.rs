//! The thread that asks the store: a new index is checked, then its archives are fetched, those of the present first.

use crate::archive_folder::ArchiveFolder;
use crate::file_folder::FileFolder;
use daemon::{Clock, Failure, FollowConfig, Watched, chain};
use jiff::tz::TimeZone;
use messages::ContentId;
use replica::{
    Acknowledged, ArchiveEntry, BlobEntry, FileList, IndexClock, MAX_FILE_LIST_BYTES, MAX_INDEX_BYTES,
    MAX_RECIPE_BYTES, PlanSet, PublicKey, Recipe, RobotFiles, SignedIndex, SiteIndex, SiteName, accept, blob_path,
    current_path, unpack_block,
};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;
use store::{Credentials, Fetched, Objects, Store, StoreError};
use tracing::{info, warn};

/// Longest wait after the store has failed several times.
const MAX_WAIT: Duration = Duration::from_secs(60);

/// What breaks off on the way is asked for so often before the next look.
const MAX_TRIES: usize = 4;

/// What the thread has found.
#[derive(Debug, Default)]
pub(crate) struct Findings {
    /// The newest index that was accepted.
    pub(crate) newest: Option<Arc<AcceptedIndex>>,
    /// When the store last answered, milliseconds since 1970 in UTC.
    pub(crate) asked_ms: Option<i64>,
    /// Bytes that are fetched for an index, and how many there are.
    pub(crate) fetching: Option<[u64; 2]>,
    /// Bytes that were fetched since the start.
    pub(crate) fetched_bytes: u64,
    /// Blocks that were put in their places since the start.
    n_blocks: u64,
    /// Why the newest index, or something of it, is not here.
    pub(crate) trouble: Option<Trouble>,
    /// What the service has on disk as acknowledged: what is older is refused.
    pub(crate) acknowledged: Option<Acknowledged>,
    /// Archives of the index that is in force, or is to be after a start: they stay until another one is.
    pub(crate) in_force: BTreeSet<ContentId>,
    /// Archives that the service found damaged.
    pub(crate) damaged: Vec<ContentId>,
    /// The server says that an index is new.
    pub(crate) is_called: bool,
    is_stopped: bool,
}

/// Why something is not here.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Trouble {
    /// In words.
    pub(crate) why: String,
    /// True if the store answered: with something wrong, or without what it should have. False if it could not be asked.
    pub(crate) is_answer: bool,
}

/// An index that was accepted.
#[derive(Debug)]
pub(crate) struct AcceptedIndex {
    /// Its file.
    pub(crate) file: Vec<u8>,
    /// What it says.
    pub(crate) signed: SignedIndex,
    /// What is acknowledged with it.
    pub(crate) acknowledged: Acknowledged,
}

/// Shared with the service.
pub(crate) type Shared = Watched<Findings>;

/// Which part of a site a robot follows.
#[derive(Debug, Clone)]
pub(crate) struct Followed {
    pub(crate) site: SiteName,
    pub(crate) roots: Vec<PublicKey>,
    /// Its name in the index.
    pub(crate) robot: String,
    /// Index, GlobalId or name of storeys; all if there is none.
    pub(crate) storeys: Vec<String>,
}

impl Followed {
    /// What a configuration says.
    ///
    /// # Errors
    /// A name of no site, a text that is no key.
    pub(crate) fn of(config: &FollowConfig) -> Result<Self, Failure> {
        let roots = config.roots.iter().map(|root| root.parse()).collect::<Result<_, _>>()?;
        let (robot, storeys) = (config.robot_in_index().to_owned(), config.storeys.clone());
        Ok(Self { site: config.site.parse()?, roots, robot, storeys })
    }

    /// Places of the storeys that are followed, among those of a robot's maps.
    ///
    /// # Errors
    /// A robot that the index does not have, a storey that it does not have.
    pub(crate) fn places(&self, set: &PlanSet) -> Result<Vec<usize>, Failure> {
        let maps = set.robots.get(&self.robot).ok_or_else(|| {
            let names: Vec<&str> = set.robots.keys().map(String::as_str).collect();
            format!("the site has no maps of the robot {:?}: it has {}", self.robot, names.join(", "))
        })?;
        if self.storeys.is_empty() {
            return Ok((0..maps.storeys.len()).collect());
        }
        let mut places = BTreeSet::new();
        for wanted in &self.storeys {
            let is_meant = |storey: &replica::StoreyMap| {
                *wanted == storey.name || *wanted == storey.global_id || *wanted == storey.map_storey.to_string()
            };
            let found: Vec<usize> = (0..maps.storeys.len()).filter(|place| is_meant(&maps.storeys[*place])).collect();
            if found.is_empty() {
                let names: Vec<&str> = maps.storeys.iter().map(|storey| storey.name.as_str()).collect();
                return Err(format!("the site has no storey {wanted:?}: it has {}", names.join(", ")).into());
            }
            places.extend(found);
        }
        Ok(places.into_iter().collect())
    }

    /// The archives of a set that this robot needs, the site among them.
    ///
    /// # Errors
    /// As [`Self::places`].
    pub(crate) fn archives<'a>(
        &self,
        index: &'a SiteIndex,
        set: &'a PlanSet,
    ) -> Result<Vec<&'a ArchiveEntry>, Failure> {
        let places = self.places(set)?;
        let maps = &set.robots[&self.robot];
        let grids = places.into_iter().map(|place| &maps.storeys[place].grid);
        let of_site = std::iter::once(&index.site_archive).chain(&index.tasks);
        Ok(of_site.chain([&set.schedule_state, &maps.grids]).chain(grids).chain(&maps.mission_plan).collect())
    }

    /// How many sets of an index are here, from the first.
    pub(crate) fn n_complete(&self, index: &SiteIndex, folder: &ArchiveFolder) -> usize {
        let is_here = |set: &&PlanSet| {
            self.archives(index, set).is_ok_and(|archives| archives.into_iter().all(|entry| folder.has(entry)))
        };
        index.sets.iter().take_while(is_here).count()
    }
}

/// What came of a look.
enum Looked {
    /// All of the newest index is here.
    Whole,
    /// Something that is due later is not, and the index is asked for again before.
    Unfinished,
}

/// Opens the store of a robot.
pub type OpenStore = Box<dyn FnMut() -> Result<Box<dyn Objects>, Failure> + Send>;

/// What asks the store, turn by turn: the work of a thread, or of a simulation.
pub struct Fetcher {
    config: FollowConfig,
    followed: Followed,
    folder: ArchiveFolder,
    /// Where exported files are put, if they are asked for.
    files: Option<Arc<FileFolder>>,
    /// Of which epoch exported files could not be fetched last, and when, by the clock since the boot.
    files_failed: Cell<Option<(u64, i64)>>,
    shared: Arc<Shared>,
    open: OpenStore,
    clock: Box<dyn Clock>,
    store: Option<Box<dyn Objects>>,
    /// ETag of the index that was accepted.
    etag: Option<String>,
    /// Looks that failed since one did not.
    n_failures: u32,
    /// True if the store answered at this look.
    has_answered: bool,
}

/// Opens the store that a configuration names.
pub(crate) fn open_store(config: &FollowConfig) -> OpenStore {
    let config = config.clone();
    Box::new(move || -> Result<Box<dyn Objects>, Failure> {
        let credentials = config.credentials.as_deref().map(Credentials::read).transpose()?;
        Ok(Box::new(Store::open_to_read(&config.store, &credentials.unwrap_or_default())?))
    })
}

impl Fetcher {
    pub(crate) fn new(
        config: FollowConfig,
        followed: Followed,
        folder: ArchiveFolder,
        files: Option<Arc<FileFolder>>,
        shared: Arc<Shared>,
        (open, clock): (OpenStore, Box<dyn Clock>),
    ) -> Self {
        Self {
            config,
            followed,
            folder,
            files,
            files_failed: Cell::new(None),
            shared,
            open,
            clock,
            store: None,
            etag: None,
            n_failures: 0,
            has_answered: false,
        }
    }

    /// What it shares with the service.
    pub(crate) fn shared(&self) -> Arc<Shared> {
        Arc::clone(&self.shared)
    }

    /// Asks until it is stopped.
    pub(crate) fn run(mut self) {
        let shared = Arc::clone(&self.shared);
        loop {
            let wait = self.step();
            let is_idle =
                |findings: &mut Findings| !findings.is_stopped && !findings.is_called && findings.damaged.is_empty();
            if shared.wait_while(Some(wait), is_idle).is_stopped {
                return;
            }
        }
    }

    /// One turn: gives up what is damaged and asks once. The answer is how long the next one has time, if nothing is found damaged
    /// until then.
    pub fn step(&mut self) -> Duration {
        let (blocks_before, damaged) = {
            let mut findings = self.shared.lock();
            findings.is_called = false;
            (findings.n_blocks, std::mem::take(&mut findings.damaged))
        };
        for id in damaged {
            self.folder.forget(id);
        }
        self.has_answered = false;
        let looked = self.look();
        let mut findings = self.shared.lock();
        if findings.n_blocks > blocks_before {
            // It goes on, if slowly: what is here is not fetched again.
            self.n_failures = 0;
        }
        let is_unfinished = matches!(looked, Ok(Looked::Unfinished));
        match looked {
            Ok(_) => (self.n_failures, findings.trouble) = (0, None),
            Err(why) => {
                let trouble = Trouble { why: chain(why.as_ref()), is_answer: self.has_answered };
                if findings.trouble.as_ref() != Some(&trouble) {
                    warn!(service = "site-follow", error = trouble.why, "what the store has is not here");
                }
                self.n_failures = self.n_failures.saturating_add(1);
                findings.trouble = Some(trouble);
            }
        }
        findings.fetching = None;
        let poll = self.poll();
        match self.n_failures {
            0 if is_unfinished => Duration::ZERO,
            0 => poll,
            // After a failure less and less often.
            n_failures => poll.saturating_mul(1 << n_failures.min(6) >> 1).min(MAX_WAIT.max(poll)),
        }
    }

    fn poll(&self) -> Duration {
        Duration::from_secs(u64::from(self.config.poll_s))
    }

    /// Asks once: for the index, then for what is not here of it.
    fn look(&mut self) -> Result<Looked, Failure> {
        if self.store.is_none() {
            self.store = Some((self.open)()?);
        }
        let Some(store) = &self.store else { unreachable!("it was opened") };
        let path = current_path(&self.followed.site);
        let fetched = tried(|| store.fetch_unless(&path, self.etag.as_deref(), MAX_INDEX_BYTES))?;
        self.has_answered = true;
        self.shared.lock().asked_ms = Some(self.clock.now().wall_ms);
        let newest = match fetched {
            Fetched::Missing => {
                let since = if self.shared.lock().newest.is_some() { "any more" } else { "yet" };
                return Err(format!("{} has no site {} {since}", store.address(), self.followed.site).into());
            }
            Fetched::Unchanged => self.shared.lock().newest.clone(),
            Fetched::New { bytes, etag } => {
                let accepted = self.accepted(bytes)?;
                self.etag = etag;
                Some(accepted)
            }
        };
        match newest {
            Some(newest) => self.complete(&newest),
            None => Ok(Looked::Whole),
        }
    }

    /// Checks an index; from here on it is the newest.
    fn accepted(&self, file: Vec<u8>) -> Result<Arc<AcceptedIndex>, Failure> {
        let mut findings = self.shared.lock();
        // What was accepted before counts too, also if it is not shown yet.
        let accepted_before = findings.newest.as_ref().map(|newest| &newest.acknowledged);
        let known = findings.acknowledged.iter().chain(accepted_before).max_by_key(|known| known.epoch);
        let (signed, acknowledged) = accept(&file, &self.followed.roots, &self.followed.site, known)?;
        if let Some(newest) = findings.newest.as_ref().filter(|newest| newest.acknowledged == acknowledged) {
            return Ok(Arc::clone(newest));
        }
        check_zone(&signed.index)?;
        let epoch = signed.index.epoch;
        let accepted = Arc::new(AcceptedIndex { file, signed, acknowledged });
        findings.newest = Some(Arc::clone(&accepted));
        info!(service = "site-follow", epoch, "a new index");
        Ok(accepted)
    }

    /// Fetches what is not here of an index, set by set. What is due later does not keep a newer index waiting.
    fn complete(&self, accepted: &AcceptedIndex) -> Result<Looked, Failure> {
        let index = &accepted.signed.index;
        let files = self.missing_files(index);
        if self.followed.n_complete(index, &self.folder) == index.sets.len() && files.is_empty() {
            if let Some(folder) = self.files.as_ref().filter(|folder| self.has_files(folder, index)) {
                folder.tell_fetched(None);
            }
            return Ok(Looked::Whole);
        }
        let (begun_ms, poll_ms) = (self.clock.now().since_boot_ms, i64::from(self.config.poll_s) * 1_000);
        let mut wanted: Vec<Vec<&ArchiveEntry>> = Vec::new();
        let mut seen = BTreeSet::new();
        for set in &index.sets {
            let archives = self.followed.archives(index, set)?;
            wanted
                .push(archives.into_iter().filter(|entry| seen.insert(entry.id) && !self.folder.has(entry)).collect());
        }
        for (place, archives) in wanted.iter().enumerate() {
            for entry in archives {
                if place > 0 && self.clock.now().since_boot_ms - begun_ms > poll_ms {
                    return Ok(Looked::Unfinished);
                }
                self.fetch_archive(entry)?;
            }
        }
        // Files come last, and a newer index goes before them: what a robot drives by does not wait for what programs beside it read, nor
        // for a disk that has no room for it.
        let mut have_failed = false;
        for (_, files) in files {
            let fetched = self.fetch_files(files, begun_ms + poll_ms);
            if matches!(fetched, Ok(Looked::Unfinished)) {
                return fetched;
            }
            let failed = fetched.err().map(|why| chain(why.as_ref()));
            if let Some(folder) = &self.files {
                folder.tell_fetched(failed.clone());
            }
            if let Some(error) = failed {
                warn!(service = "site-follow", error, "exported files are not here");
                self.files_failed.set(Some((index.epoch, self.clock.now().since_boot_ms)));
                have_failed = true;
                break;
            }
        }
        let lists = index.sets.iter().filter_map(|set| set.files_of(&self.followed.robot)).map(|files| files.list.id);
        let in_force = self.shared.lock().in_force.clone();
        let needed: BTreeSet<ContentId> = seen.into_iter().chain(lists).chain(in_force).collect();
        self.folder.retain(&needed);
        // What is here of files that are fetched again stays.
        if let Some(folder) = self.files.as_ref().filter(|folder| self.has_files(folder, index)) {
            folder.tell_fetched(None);
            folder.retain(&needed);
        }
        if !have_failed {
            info!(service = "site-follow", epoch = index.epoch, sets = index.sets.len(), "all of the index is here");
        }
        Ok(Looked::Whole)
    }

    /// True if all exported files of an index are here.
    fn has_files(&self, folder: &FileFolder, index: &SiteIndex) -> bool {
        let mut files = index.sets.iter().filter_map(|set| set.files_of(&self.followed.robot));
        files.all(|files| folder.has(files))
    }

    /// The exported files of an index that are asked for and are not here, with the places of their sets; none shortly after they failed.
    fn missing_files<'a>(&self, index: &'a SiteIndex) -> Vec<(usize, &'a RobotFiles)> {
        let Some(folder) = &self.files else { return Vec::new() };
        let (now_ms, wait_ms) = (self.clock.now().since_boot_ms, MAX_WAIT.as_millis() as i64);
        let is_for_now = |(epoch, at_ms): (u64, i64)| epoch == index.epoch && now_ms - at_ms < wait_ms;
        if self.files_failed.get().is_some_and(is_for_now) {
            return Vec::new();
        }
        let of_sets = index.sets.iter().enumerate();
        let of_sets = of_sets.filter_map(|(place, set)| Some((place, set.files_of(&self.followed.robot)?)));
        of_sets.filter(|(_, files)| !folder.has(files)).collect()
    }

    /// Fetches exported files until a time by the clock since the boot, at least one of them; what is here then stays.
    fn fetch_files(&self, files: &RobotFiles, until_ms: i64) -> Result<Looked, Failure> {
        let Some((store, folder)) = self.store.as_ref().zip(self.files.as_ref()) else {
            unreachable!("both are there")
        };
        let fetch = |blob: BlobEntry| -> Result<Vec<u8>, Failure> {
            let path = blob_path(&self.followed.site, blob.id);
            let bytes = tried(|| store.fetch_whole(&path, blob.bytes))?;
            if ContentId::of(&bytes) != blob.id {
                return Err(format!("{path} in {} is not what its name says", store.address()).into());
            }
            self.count(bytes.len() as u64);
            Ok(bytes)
        };
        if files.list.bytes > MAX_FILE_LIST_BYTES {
            return Err("a list of exported files is larger than any can be".into());
        }
        folder.make()?;
        let list = FileList::parse(&fetch(files.list)?)?;
        let (all, mut done, mut is_late) = (list.bytes(), 0, false);
        let completed = folder.complete(files.list.id, &list, |blob| {
            let is_called = self.shared.lock().is_called;
            is_late = done > 0 && (is_called || self.clock.now().since_boot_ms > until_ms);
            if is_late {
                return Err("the index is asked for again before".into());
            }
            self.shared.lock().fetching = Some([done, all]);
            let bytes = fetch(blob)?;
            done += blob.bytes;
            self.shared.lock().n_blocks += 1;
            Ok::<_, Failure>(bytes)
        });
        match completed {
            Err(_) if is_late => Ok(Looked::Unfinished),
            completed => completed.map(|()| Looked::Whole),
        }
    }

    fn fetch_archive(&self, entry: &ArchiveEntry) -> Result<(), Failure> {
        let Some(store) = &self.store else { unreachable!("it was opened") };
        if entry.recipe.bytes > MAX_RECIPE_BYTES {
            return Err("the recipe of an archive is larger than any can be".into());
        }
        let path = blob_path(&self.followed.site, entry.recipe.id);
        let recipe = tried(|| store.fetch_whole(&path, entry.recipe.bytes))?;
        if ContentId::of(&recipe) != entry.recipe.id {
            return Err(format!("{path} in {} is not what its name says", store.address()).into());
        }
        self.count(recipe.len() as u64);
        let recipe = Recipe::parse(&recipe, entry)?;
        let mut part = self.folder.begin(&recipe, &self.folder.held_blocks())?;
        let fetches = recipe.missing(|place| part.has(place));
        let all: u64 = fetches.iter().map(|fetch| fetch.range.end - fetch.range.start).sum();
        let mut done = 0;
        for fetch in fetches {
            self.shared.lock().fetching = Some([done, all]);
            let path = blob_path(&self.followed.site, fetch.pack.id);
            let bytes = tried(|| store.fetch_range(&path, fetch.range.clone(), fetch.pack.bytes))?;
            for place in &fetch.blocks {
                let (id, range) = recipe.block(*place);
                let block = unpack_block(recipe.part(&fetch, &bytes, *place), range.end - range.start, id);
                let block = block.map_err(|why| format!("{path} in {}: {why}", store.address()))?;
                part.put(*place, range, &block)?;
                self.shared.lock().n_blocks += 1;
            }
            done += bytes.len() as u64;
            self.count(bytes.len() as u64);
        }
        Ok(self.folder.finish(part, &recipe)?)
    }

    fn count(&self, bytes: u64) {
        self.shared.lock().fetched_bytes += bytes;
    }
}

/// Refuses an index whose clock nobody here can read: its maps would never end.
///
/// # Errors
/// A zone that this version does not know.
pub(crate) fn check_zone(index: &SiteIndex) -> Result<(), Failure> {
    let IndexClock::Wall { zone } = &index.clock else { return Ok(()) };
    TimeZone::get(zone)
        .map(drop)
        .map_err(|why| format!("the site's clock is in a zone that is not known here: {why}").into())
}

/// Asks again for what broke off on the way; what the store itself says is so.
fn tried<T>(mut ask: impl FnMut() -> Result<T, StoreError>) -> Result<T, StoreError> {
    let mut asked = 1;
    loop {
        match ask() {
            Err(why) if !why.is_of_object() && asked < MAX_TRIES => asked += 1,
            asked => return asked,
        }
    }
}

/// Ends the thread, with the service.
pub(crate) fn stop(shared: &Shared) {
    shared.change(|findings| findings.is_stopped = true);
}
