//! The thread that writes into the store: blobs that are new, then the index of the next epoch, then that it is the newest.

use crate::exports::{Blobs, ExportedSet, Exports, OfSite};
use crate::pieces::{Piece, RobotPieces, SetPieces, SitePieces};
use daemon::state_files::published_epoch;
use daemon::{Clock, Disk, Failure, MachineClock, ServeConfig, SiteConfig, StateFile, StateFolder, Watched, chain};
use jiff::{SignedDuration, Timestamp};
use messages::{ContentHash, ContentId, LAYOUT_VERSION};
use replica::{
    ArchiveEntry, BlobEntry, IndexClock, KeptIndex, KeyList, MAX_INDEX_BYTES, MAX_RECIPE_BYTES, PackedArchive, PlanSet,
    PublicKey, Recipe, Retention, RobotMaps, SignedIndex, SigningKey, SiteIndex, SiteName, StoreyMap, blob_folder,
    blob_list_path, blob_path, current_path, expired, index_folder, index_path, pack, signed_index,
};
use std::collections::hash_map::Entry;
use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;
use store::{Credentials, Fetched, Listed, Objects, Store};
use tracing::{info, warn};

/// A store that refuses is tried again after this long, then less and less often.
const FIRST_WAIT: Duration = Duration::from_secs(1);

/// The longest wait.
const MAX_WAIT: Duration = Duration::from_secs(60);

/// What no index names goes when it is this old: a blob is there before the index that names it.
const MIN_AGE: SignedDuration = SignedDuration::from_hours(24);

/// The past is looked through once in this many indices, and after the start.
const CLEAN_EVERY: u64 = 64;

/// A set that is to be published.
pub struct Job {
    /// What all sets have in common.
    pub site: SitePieces,
    /// The set of the present.
    pub set: SetPieces,
    /// The configuration by which later sets are drawn.
    pub config: SiteConfig,
}

/// What came of the last job.
#[derive(Debug, Clone, Default)]
pub struct Outcome {
    /// Epoch of the newest index.
    pub epoch: u64,
    /// Plan times of its sets.
    pub plan_times_s: Vec<Option<i64>>,
    /// Bytes of blobs that were not there.
    pub new_bytes: u64,
    /// Why there are no later sets, where the plan time moves.
    pub why_no_later: Option<String>,
    /// Why the job is not in the store.
    pub error: Option<String>,
    /// What an operator should know.
    pub warning: Option<String>,
}

/// Draws the sets of the next change instants after that of a job, at most so many.
pub type DrawLater = Box<dyn FnMut(&Job, usize) -> Result<Vec<SetPieces>, Failure> + Send>;

/// Opens the store of a server.
pub type OpenStore = Box<dyn FnMut() -> Result<Box<dyn Objects>, Failure> + Send>;

/// What the publisher draws, asks and writes with: others in a simulation.
pub struct Surroundings {
    /// Opens the store.
    pub open: OpenStore,
    /// Draws later sets.
    pub draw: DrawLater,
    /// The clock.
    pub clock: Box<dyn Clock>,
    /// The disk of the server.
    pub disk: Box<dyn Disk>,
}

/// Shared with the service.
#[derive(Default)]
pub struct Shared(Watched<State>);

#[derive(Default)]
struct State {
    job: Option<Job>,
    outcome: Outcome,
    /// Epoch of the index that is the newest in the store; 0 while that is not known.
    epoch: u64,
    is_stopped: bool,
}

impl Shared {
    /// Gives the thread a set; one that it has not begun is left out.
    pub fn give(&self, job: Job) {
        self.0.change(|state| state.job = Some(job));
    }

    /// Epoch of the newest index in the store, as soon as it is there; 0 before.
    pub(crate) fn epoch(&self) -> u64 {
        self.0.lock().epoch
    }

    fn is_in_store(&self, index: Option<&SiteIndex>) {
        self.0.lock().epoch = index.map_or(0, |index| index.epoch);
    }

    /// True if there is something to be done that is newer than what is under way.
    fn has_news(&self) -> bool {
        let state = self.0.lock();
        state.is_stopped || state.job.is_some()
    }

    /// What came of the last one.
    pub fn outcome(&self) -> Outcome {
        self.0.lock().outcome.clone()
    }

    /// Ends the thread.
    pub(crate) fn stop(&self) {
        self.0.change(|state| state.is_stopped = true);
    }
}

/// What writes into the store, turn by turn: the work of a thread, or of a simulation.
pub struct Publisher {
    config: ServeConfig,
    site: SiteName,
    key: SigningKey,
    /// The list of keys as its root key signed it.
    keys: String,
    shared: Arc<Shared>,
    surroundings: Surroundings,
    exports: Exports,
    store: Option<Connected>,
    state: PathBuf,
    /// That another server publishes the site, once it was noticed.
    rival: Option<String>,
    /// A job that failed, and how long it has time.
    retried: Option<Job>,
    wait: Duration,
}

/// A store, and what is in it.
struct Connected {
    site: SiteName,
    store: Box<dyn Objects>,
    /// The index that is the newest.
    newest: Option<SiteIndex>,
    /// True if robots take the newest index: it has the list of keys of this server, and nothing above it was published. Otherwise
    /// another one of the same content is for them.
    is_for_robots: bool,
    /// Recipes of the newest archives, by topic: all of them of archives in `entries`, so that their packs stay.
    recipes: HashMap<String, Arc<Recipe>>,
    /// Archives of the newest index that this process has written or found, by topic and content hash.
    entries: BTreeMap<(String, ContentHash), (ArchiveEntry, Arc<Recipe>)>,
    /// Bytes that were written since the last index.
    new_bytes: u64,
    taken: TakenEpoch,
    /// Indices since the past was looked through.
    n_since_cleaned: u64,
}

impl Surroundings {
    /// Those of this machine, with what draws.
    pub(crate) fn of_machine(config: &ServeConfig, state: &Path, draw: DrawLater) -> Self {
        let config = config.clone();
        let open = move || -> Result<Box<dyn Objects>, Failure> {
            let credentials = config.credentials.as_deref().map(Credentials::read).transpose()?;
            Ok(Box::new(Store::open(&config.store, &credentials.unwrap_or_default())?))
        };
        let (clock, disk) = (Box::new(MachineClock::of_this_boot()), Box::new(StateFolder::at(state)));
        Self { open: Box::new(open), draw, clock, disk }
    }
}

impl Publisher {
    /// What publishes a site, with its state folder.
    ///
    /// # Errors
    /// Keys that cannot be used, that others can read, or that are not those of the site.
    pub fn new(
        config: ServeConfig,
        state: &Path,
        shared: Arc<Shared>,
        surroundings: Surroundings,
    ) -> Result<Self, Failure> {
        let read = |path: &Path| {
            std::fs::read_to_string(path)
                .map_err(|why| Failure::from(format!("{} cannot be read: {why}", path.display())))
        };
        let mode = std::fs::metadata(&config.key).map_or(0, |file| file.mode());
        if mode & 0o077 != 0 {
            let key = config.key.display();
            return Err(format!("the key {key} can be read by others: chmod 600 {key}").into());
        }
        let key =
            SigningKey::from_pem(&read(&config.key)?).map_err(|why| format!("{}: {why}", config.key.display()))?;
        let keys = read(&config.keys)?;
        let in_keys = |why: String| Failure::from(format!("{}: {why}", config.keys.display()));
        let (list, _) = KeyList::parse_signed(&keys).map_err(|why| in_keys(why.to_string()))?;
        let site: SiteName = config.site.parse()?;
        if list.site != site {
            return Err(in_keys(format!("it has the keys of the site {}, [serve] names {site}", list.site)));
        }
        if !list.keys.contains(&key.public()) {
            return Err(in_keys(format!(
                "{} is not in it: sign a list that has it with `groundplan key list`",
                key.public()
            )));
        }
        let exports = Exports::new(site.clone(), config.export.clone());
        Ok(Self {
            config,
            site,
            key,
            keys,
            shared,
            surroundings,
            exports,
            store: None,
            state: state.to_owned(),
            rival: None,
            retried: None,
            wait: FIRST_WAIT,
        })
    }

    /// Publishes what it is given until it is stopped.
    pub(crate) fn run(mut self) {
        let shared = Arc::clone(&self.shared);
        loop {
            let longest = self.retried.as_ref().map(|_| self.wait);
            if shared.0.wait_while(longest, |state| !state.is_stopped && state.job.is_none()).is_stopped {
                return;
            }
            self.step();
        }
    }

    /// One turn: publishes what was given last, or tries again what failed.
    pub fn step(&mut self) {
        // A newer one goes before one that failed.
        let given = self.shared.0.lock().job.take();
        let Some(job) = given.or_else(|| self.retried.take()) else { return };
        let published = self.publish(&job);
        let mut state = self.shared.0.lock();
        match published {
            Ok(outcome) => (state.outcome, self.wait, self.retried) = (outcome, FIRST_WAIT, None),
            Err(why) => {
                let text = chain(why.as_ref());
                if why.downcast_ref::<Rival>().is_some() {
                    self.rival = Some(text.clone());
                }
                warn!(service = "site-server", error = text, "the site is not in the store");
                state.outcome.error = Some(text);
                // What is in the store is looked at again.
                self.store = None;
                (self.wait, self.retried) = ((self.wait * 2).min(MAX_WAIT), Some(job));
            }
        }
    }

    fn publish(&mut self, job: &Job) -> Result<Outcome, Failure> {
        if let Some(rival) = &self.rival {
            return Err(rival.clone().into());
        }
        let mut not_exported = self.exports.configure(&job.config).err().map(|why| chain(why.as_ref()));
        let connected = match self.store.take() {
            Some(connected) => connected,
            None => {
                let store = (self.surroundings.open)()?;
                Connected::open(store, &self.state, &self.site, &self.keys, &mut self.exports)?
            }
        };
        let connected = self.store.insert(connected);
        let exports = &mut self.exports;
        let Surroundings { draw, clock, disk, .. } = &mut self.surroundings;
        let mut means = Means { keys: &self.keys, key: &self.key, clock: &**clock, disk: &mut **disk };
        let is_wall = matches!(job.site.clock, IndexClock::Wall { .. });
        // What is due now does not wait for what is due later, unless that is there already.
        let (known, why) = connected.known_later(job);
        let mut new_bytes = connected.publish(job, known, why, &mut means, exports)?;
        self.shared.is_in_store(connected.newest.as_ref());
        let (mut later, mut why_no_later) = (Vec::new(), None);
        if is_wall {
            match draw(job, usize::from(self.config.ahead)) {
                Ok(drawn) => later = drawn,
                Err(why) => why_no_later = Some(chain(why.as_ref())),
            }
            let later = connected.sets(&later)?;
            new_bytes += connected.publish(job, later, why_no_later.clone(), &mut means, exports)?;
            self.shared.is_in_store(connected.newest.as_ref());
        }
        // Files come last: no maps of a robot wait for what others read.
        if exports.are_asked_for() {
            self.shared.0.lock().outcome = connected.outcome(new_bytes, why_no_later.as_ref(), None);
            let is_superseded = || self.shared.has_news();
            match connected.export(job, &later, exports, &is_superseded) {
                Ok(why) => {
                    not_exported = not_exported.or(why);
                    let later = connected.sets(&later)?;
                    new_bytes += connected.publish(job, later, why_no_later.clone(), &mut means, exports)?;
                    self.shared.is_in_store(connected.newest.as_ref());
                }
                // The maps are in the store; what has no room there may have some when the past is cleaned.
                Err(why) => not_exported = Some(format!("files are not exported: {}", chain(why.as_ref()))),
            }
        }
        // What was published is published, whatever becomes of the past.
        let now_ms = means.clock.now().wall_ms;
        let cleaned = connected.clean(&self.config, now_ms, exports);
        let uncleaned = cleaned.err().map(|why| format!("the past is not cleaned: {}", chain(why.as_ref())));
        Ok(connected.outcome(new_bytes, why_no_later.as_ref(), not_exported.or(uncleaned)))
    }
}

/// What an index is signed, dated and counted with.
struct Means<'a> {
    keys: &'a str,
    key: &'a SigningKey,
    clock: &'a dyn Clock,
    disk: &'a mut dyn Disk,
}

impl Connected {
    /// Looks at what a store has.
    fn open(
        store: Box<dyn Objects>,
        state: &Path,
        site: &SiteName,
        keys: &str,
        exports: &mut Exports,
    ) -> Result<Self, Failure> {
        let (list, root) = KeyList::parse_signed(keys)?;
        let newest = match store.fetch_unless(&current_path(site), None, MAX_INDEX_BYTES)? {
            Fetched::New { bytes, .. } => own("current.jsonl", &bytes, root),
            Fetched::Missing | Fetched::Unchanged => None,
        };
        let mut has_list = newest.as_ref().is_some_and(|signed| signed.keys == list);
        let newest = newest.map(|signed| signed.index);
        let mut connected = Self {
            site: site.clone(),
            store,
            newest,
            is_for_robots: false,
            recipes: HashMap::new(),
            entries: BTreeMap::new(),
            new_bytes: 0,
            taken: TakenEpoch::at(state, site)?,
            n_since_cleaned: CLEAN_EVERY,
        };
        // A server that died between the index and the word that it is the newest left one behind; a word of before may have come back.
        let listed = connected.store.list(&index_folder(site))?;
        let last = listed.iter().filter_map(|index| epoch_of(&index.path)).max();
        let known = connected.newest.as_ref().map_or(0, |index| index.epoch);
        let mut left_behind = None;
        if let Some(last) = last.filter(|last| *last > known) {
            let path = index_path(site, last);
            let left = connected.store.fetch_whole(&path, MAX_INDEX_BYTES)?;
            if let Some(signed) = own(&path, &left, root) {
                has_list = signed.keys == list;
                left_behind = Some(signed.index.clone());
                connected.newest = Some(signed.index);
                connected.store.replace(&current_path(site), &left)?;
            }
        }
        // An epoch that somebody else has written under is not written again.
        connected.taken.epoch = connected.taken.epoch.max(last.unwrap_or(0));
        let found = connected.newest.as_ref().map_or(0, |index| index.epoch);
        if connected.taken.epoch > found {
            let taken = connected.taken.epoch;
            warn!(
                service = "site-server",
                found, taken, "the store is older than what was published: epochs go on above"
            );
        }
        connected.is_for_robots = has_list && connected.taken.epoch <= found;
        connected.read_recipes()?;
        exports.take_from(connected.newest.as_ref(), &connected)?;
        // The list of its blobs comes after the index, too.
        if let Some(index) = left_behind
            && connected.store.length(&blob_list_path(site, index.epoch))?.is_none()
        {
            let list = connected.blob_list(&index, exports)?;
            connected.store.replace(&blob_list_path(site, index.epoch), &list)?;
        }
        Ok(connected)
    }

    /// What came of a job: the newest index, and so many bytes that were written for it.
    fn outcome(&self, new_bytes: u64, why_no_later: Option<&String>, warning: Option<String>) -> Outcome {
        let plan_times_s = self.newest.iter().flat_map(|index| &index.sets).map(|set| set.plan_time_s).collect();
        let epoch = self.newest.as_ref().map_or(0, |index| index.epoch);
        let warning = why_no_later.map(|why| format!("nothing is drawn ahead: {why}")).or(warning);
        Outcome { epoch, plan_times_s, new_bytes, why_no_later: why_no_later.cloned(), error: None, warning }
    }

    /// Reads the recipes of the newest index whose packs are all there: what is packed next has blocks in common with them. What is
    /// not read is packed anew, and so comes back into the store.
    fn read_recipes(&mut self) -> Result<(), Failure> {
        let Some(newest) = &self.newest else { return Ok(()) };
        let mut is_there: HashMap<ContentId, bool> = HashMap::new();
        let (mut recipes, mut entries) = (HashMap::new(), BTreeMap::new());
        for (topic, entry) in archives_of(newest) {
            let path = blob_path(&self.site, entry.recipe.id);
            let bytes = match self.store.fetch_whole(&path, MAX_RECIPE_BYTES) {
                Ok(bytes) => Some(bytes).filter(|bytes| ContentId::of(bytes) == entry.recipe.id),
                Err(why) if why.is_of_object() => None,
                Err(why) => return Err(why.into()),
            };
            let recipe = bytes.and_then(|bytes| Recipe::parse(&bytes, entry).ok());
            let mut is_whole = recipe.is_some();
            for pack in recipe.iter().flat_map(Recipe::packs) {
                let known = match is_there.entry(pack.id) {
                    Entry::Occupied(known) => *known.get(),
                    Entry::Vacant(unknown) => {
                        let length = self.store.length(&blob_path(&self.site, pack.id))?;
                        *unknown.insert(length == Some(pack.bytes))
                    }
                };
                is_whole &= known;
            }
            match recipe.filter(|_| is_whole) {
                Some(recipe) => {
                    let recipe = Arc::new(recipe);
                    entries.insert((topic.clone(), entry.content_hash), (*entry, Arc::clone(&recipe)));
                    recipes.insert(topic, recipe);
                }
                None => {
                    warn!(service = "site-server", topic, "something of it is lost in the store: it is written again")
                }
            }
        }
        (self.recipes, self.entries) = (recipes, entries);
        Ok(())
    }

    /// The sets of the newest index that are later than that of a job, of the same site and schedule, or why it has none: they are right
    /// until others are drawn.
    fn known_later(&self, job: &Job) -> (Vec<PlanSet>, Option<String>) {
        let is_of = |piece: &Piece, entry: &ArchiveEntry| entry.content_hash == piece.hash;
        let newest = self
            .newest
            .as_ref()
            .filter(|index| index.clock == job.site.clock && is_of(&job.site.site, &index.site_archive));
        // Only if the present is one of its sets: another schedule has other later ones.
        let found = newest.and_then(|index| {
            let is_present =
                |set: &PlanSet| set.plan_time_s == job.set.plan_time_s && is_of(&job.set.state, &set.schedule_state);
            Some((index, index.sets.iter().position(is_present)?))
        });
        let Some((index, place)) = found else { return (Vec::new(), None) };
        // What the store has lost of them is not named again.
        let is_whole = |set: &&PlanSet| {
            archives_of_set(set)
                .iter()
                .all(|(topic, entry)| self.entries.contains_key(&(topic.clone(), entry.content_hash)))
        };
        let later = index.sets[place + 1..].iter().take_while(is_whole).cloned().collect();
        (later, index.why_no_later.clone())
    }

    /// Writes what is new of a set and later ones, and the index of the next epoch; nothing if the newest index says the same. The
    /// answer is how many bytes were written.
    fn publish(
        &mut self,
        job: &Job,
        later: Vec<PlanSet>,
        why_no_later: Option<String>,
        means: &mut Means<'_>,
        exports: &mut Exports,
    ) -> Result<u64, Failure> {
        let (site_archive, tasks) = self.of_site(job)?;
        let mut sets: Vec<PlanSet> = std::iter::once(self.set(&job.set)?).chain(later).collect();
        let of_site = OfSite { clock: &job.site.clock, site: &site_archive, tasks: tasks.as_ref() };
        for PlanSet { schedule_state, robots, .. } in &mut sets {
            for (robot, maps) in robots {
                maps.files = exports.files_of(&of_site, schedule_state, robot, maps);
            }
        }
        let newest = self.newest.as_ref().map_or(0, |index| index.epoch);
        // Whoever writes into the store can put an index of any epoch there.
        let epoch = newest.max(self.taken.epoch).checked_add(1).ok_or("the store has an index of the last epoch")?;
        let index = SiteIndex {
            format: SiteIndex::FORMAT,
            site: self.site.clone(),
            epoch,
            published: time_of(means.clock.now().wall_ms).to_string(),
            layout_version: LAYOUT_VERSION,
            frame_epoch: job.site.frame_epoch,
            clock: job.site.clock.clone(),
            site_archive,
            tasks,
            sets,
            why_no_later,
        };
        let new_bytes = std::mem::take(&mut self.new_bytes);
        let is_same = self.newest.as_ref().filter(|_| self.is_for_robots).is_some_and(|newest| {
            SiteIndex { epoch: newest.epoch, published: newest.published.clone(), ..index.clone() } == *newest
        });
        if is_same {
            return Ok(new_bytes);
        }
        let file = signed_index(means.keys, &index, means.key)?;
        check_size("the index", &file, MAX_INDEX_BYTES)?;
        let blob_list = self.blob_list(&index, exports)?;
        let path = index_path(&self.site, epoch);
        // An epoch is never taken twice, whatever becomes of the store.
        self.taken.take(epoch, means.disk)?;
        // What was written without an answer is our own.
        if !self.store.create(&path, &file)? && self.store.fetch_whole(&path, MAX_INDEX_BYTES)? != file {
            return Err(Rival { epoch, site: self.site.clone() }.into());
        }
        self.store.replace(&blob_list_path(&self.site, epoch), &blob_list)?;
        self.store.replace(&current_path(&self.site), &file)?;

        info!(service = "site-server", epoch, sets = index.sets.len(), new_bytes, "the site is in the store");
        (self.newest, self.is_for_robots) = (Some(index), true);
        self.n_since_cleaned += 1;
        Ok(new_bytes)
    }

    /// The archives of the site as an index has them; what is new of them is written.
    fn of_site(&mut self, job: &Job) -> Result<(ArchiveEntry, Option<ArchiveEntry>), Failure> {
        let tasks = job.site.tasks.as_ref().map(|tasks| self.entry(tasks)).transpose()?;
        Ok((self.entry(&job.site.site)?, tasks))
    }

    /// Makes the files of a set and of later ones that the store does not have. The answer is why some are not made.
    fn export(
        &mut self,
        job: &Job,
        later: &[SetPieces],
        exports: &mut Exports,
        is_superseded: &dyn Fn() -> bool,
    ) -> Result<Option<String>, Failure> {
        let (site, tasks) = self.of_site(job)?;
        let of_site = OfSite { clock: &job.site.clock, site: &site, tasks: tasks.as_ref() };
        let sets = std::iter::once(self.set(&job.set)?).chain(self.sets(later)?).collect::<Vec<_>>();
        let pieces = std::iter::once(&job.set).chain(later);
        let sets: Vec<ExportedSet<'_>> = pieces.zip(&sets).collect();
        exports.make(&of_site, &job.site, &sets, &job.config, self, is_superseded)
    }

    /// Sets as an index has them; what is new of them is written.
    fn sets(&mut self, sets: &[SetPieces]) -> Result<Vec<PlanSet>, Failure> {
        sets.iter().map(|set| self.set(set)).collect()
    }

    /// A set as an index has it, without exported files; what is new of it is written.
    fn set(&mut self, set: &SetPieces) -> Result<PlanSet, Failure> {
        let mut robots = BTreeMap::new();
        for (name, maps) in &set.robots {
            robots.insert(name.clone(), self.robot_maps(maps)?);
        }
        let schedule_state = self.entry(&set.state)?;
        Ok(PlanSet { plan_time_s: set.plan_time_s, valid_until_s: set.valid_until_s, schedule_state, robots })
    }

    fn robot_maps(&mut self, maps: &RobotPieces) -> Result<RobotMaps, Failure> {
        let mut storeys = Vec::new();
        for storey in &maps.storeys {
            storeys.push(StoreyMap {
                map_storey: storey.map_storey,
                name: storey.name.clone(),
                global_id: storey.global_id.clone(),
                input_hash: storey.input_hash,
                grid: self.entry(&storey.grid)?,
            });
        }
        Ok(RobotMaps {
            grids: self.entry(&maps.grids)?,
            mission_plan: maps.mission_plan.as_ref().map(|plan| self.entry(plan)).transpose()?,
            robot_hash: maps.robot_hash,
            storeys,
            files: None,
        })
    }

    /// The entry of an archive, which is written if the store does not have it.
    fn entry(&mut self, piece: &Piece) -> Result<ArchiveEntry, Failure> {
        let key = (piece.topic.clone(), piece.hash);
        if let Some((entry, recipe)) = self.entries.get(&key) {
            // What is packed next has blocks in common with what stays, not with what goes.
            self.recipes.insert(key.0, Arc::clone(recipe));
            return Ok(*entry);
        }
        let earlier = self.recipes.get(&piece.topic).map(|recipe| &**recipe);
        let PackedArchive { recipe, packs } = pack(piece.bytes.bytes(), earlier);
        for pack in &packs {
            self.write(pack)?;
        }
        let recipe_file = recipe.to_bytes();
        check_size(&format!("the recipe of {}", piece.topic), &recipe_file, MAX_RECIPE_BYTES)?;
        self.write(&recipe_file)?;
        let (entry, recipe) = (recipe.entry(piece.hash), Arc::new(recipe));
        self.entries.insert(key, (entry, Arc::clone(&recipe)));
        self.recipes.insert(piece.topic.clone(), recipe);
        Ok(entry)
    }

    /// The file that says which blobs an index needs.
    fn blob_list(&mut self, index: &SiteIndex, exports: &mut Exports) -> Result<Vec<u8>, Failure> {
        let list = serde_json::to_vec(&self.needed(index, exports))?;
        check_size("the list of blobs", &list, MAX_INDEX_BYTES)?;
        Ok(list)
    }

    /// The blobs that an index needs.
    fn needed(&mut self, index: &SiteIndex, exports: &mut Exports) -> Vec<BlobEntry> {
        let archives: BTreeSet<ContentId> = index.archives().map(|entry| entry.id).collect();
        // What no index that may come next has is forgotten.
        self.entries.retain(|_, (entry, _)| archives.contains(&entry.id));
        let topics: BTreeSet<String> = archives_of(index).into_iter().map(|(topic, _)| topic).collect();
        self.recipes.retain(|topic, recipe| topics.contains(topic) && archives.contains(&recipe.id));
        let of_entry = |(entry, recipe): &(ArchiveEntry, Arc<Recipe>)| {
            std::iter::once(entry.recipe).chain(recipe.packs().iter().copied()).collect::<Vec<_>>()
        };
        let needed: BTreeMap<ContentId, BlobEntry> =
            self.entries.values().flat_map(of_entry).chain(exports.needed(index)).map(|blob| (blob.id, blob)).collect();
        needed.into_values().collect()
    }

    /// Removes indices of the past that are too old or too much, then blobs that none of those that stay needs.
    fn clean(&mut self, config: &ServeConfig, now_ms: i64, exports: &mut Exports) -> Result<(), Failure> {
        if self.n_since_cleaned < CLEAN_EVERY {
            return Ok(());
        }
        self.n_since_cleaned = 0;
        let now = time_of(now_ms);
        let retention = Retention {
            keep: SignedDuration::from_hours(24 * i64::from(config.keep_days)),
            max_bytes: u64::from(config.keep_gb).saturating_mul(1_000_000_000),
        };
        let blobs = self.store.list(&blob_folder(&self.site))?;
        let indices = self.store.list(&index_folder(&self.site))?;
        let is_old = |modified: Timestamp| now.duration_since(modified) > retention.keep;
        let is_much = blobs.iter().map(|blob| blob.bytes).sum::<u64>() > retention.max_bytes;
        if !is_much && !indices.iter().any(|index| is_old(index.modified)) {
            return Ok(());
        }
        let mut kept = Vec::new();
        let mut lists: BTreeMap<u64, Vec<BlobEntry>> = BTreeMap::new();
        let mut counted = BTreeSet::new();
        // From the newest on: what an older one needs beside those after it is its own.
        for index in indices.iter().rev() {
            let Some(epoch) = epoch_of(&index.path) else { continue };
            let list = match self.store.fetch_whole(&blob_list_path(&self.site, epoch), MAX_INDEX_BYTES) {
                Ok(list) => list,
                // What somebody else has put there keeps no blobs, and nothing of the past from going.
                Err(why) if why.is_of_object() => continue,
                Err(why) => return Err(why.into()),
            };
            let list: Vec<BlobEntry> = serde_json::from_slice(&list)?;
            let own_bytes = list.iter().filter(|blob| counted.insert(blob.id)).map(|blob| blob.bytes).sum();
            kept.push(KeptIndex { epoch, published: index.modified, own_bytes });
            lists.insert(epoch, list);
        }
        kept.reverse();
        let gone = expired(&kept, now, retention);
        for epoch in &gone {
            self.store.remove(&index_path(&self.site, *epoch))?;
            self.store.remove(&blob_list_path(&self.site, *epoch))?;
            lists.remove(epoch);
        }
        let newest: Vec<BlobEntry> = self.newest.clone().map(|index| self.needed(&index, exports)).unwrap_or_default();
        let needed: BTreeSet<String> =
            lists.values().flatten().chain(&newest).map(|blob| blob_path(&self.site, blob.id)).collect();
        let is_needless = |blob: &&Listed| !needed.contains(&blob.path) && now.duration_since(blob.modified) > MIN_AGE;
        let mut n_blobs = 0;
        for blob in blobs.iter().filter(is_needless) {
            self.store.remove(&blob.path)?;
            n_blobs += 1;
        }
        info!(service = "site-server", indices = gone.len(), blobs = n_blobs, "the past was cleaned");
        Ok(())
    }
}

impl Blobs for Connected {
    fn read(&self, blob: BlobEntry) -> Result<Option<Vec<u8>>, Failure> {
        match self.store.fetch_whole(&blob_path(&self.site, blob.id), blob.bytes) {
            Ok(bytes) => Ok(Some(bytes).filter(|bytes| ContentId::of(bytes) == blob.id)),
            Err(why) if why.is_of_object() => Ok(None),
            Err(why) => Err(why.into()),
        }
    }

    fn has(&self, blob: BlobEntry) -> Result<bool, Failure> {
        Ok(self.store.length(&blob_path(&self.site, blob.id))? == Some(blob.bytes))
    }

    fn write(&mut self, bytes: &[u8]) -> Result<BlobEntry, Failure> {
        let blob = BlobEntry { id: ContentId::of(bytes), bytes: bytes.len() as u64 };
        // A blob that was cut short under its name is replaced.
        if !self.has(blob)? {
            self.store.replace(&blob_path(&self.site, blob.id), bytes)?;
            self.new_bytes += blob.bytes;
        }
        Ok(blob)
    }
}

/// Another server publishes the site: this one ends its work, until somebody has decided which one it is.
#[derive(Debug, thiserror::Error)]
#[error(
    "another server has published epoch {epoch} of the site {site}: only one may; stop one of the two, and start the other again"
)]
struct Rival {
    epoch: u64,
    site: SiteName,
}

/// The highest epoch that was taken, on the disk of the server: a store that is set back, or lost, does not make epochs fall.
struct TakenEpoch {
    file: StateFile,
    epoch: u64,
}

impl TakenEpoch {
    fn at(state: &Path, site: &SiteName) -> Result<Self, Failure> {
        let file = StateFile::at(state, &published_epoch(site.as_str()))?;
        let epoch = file.load()?.unwrap_or(0);
        Ok(Self { file, epoch })
    }

    fn take(&mut self, epoch: u64, disk: &mut dyn Disk) -> Result<(), Failure> {
        disk.write(&self.file.saving(&epoch)?)?;
        self.epoch = epoch;
        Ok(())
    }
}

/// An index that the keys of this site signed; what others have put there is told, and counts for nothing.
fn own(path: &str, file: &[u8], root: PublicKey) -> Option<SignedIndex> {
    let parsed = SignedIndex::parse(file, &[root]);
    let refused =
        |why| warn!(service = "site-server", path, error = chain(&why), "it is no index of this site: it is replaced");
    parsed.map_err(refused).ok()
}

/// A time of the machine's clock; one that no calendar has is that of the epoch.
fn time_of(wall_ms: i64) -> Timestamp {
    Timestamp::from_millisecond(wall_ms).unwrap_or_default()
}

/// The epoch in the path of an index.
fn epoch_of(path: &str) -> Option<u64> {
    path.rsplit('/').next()?.strip_suffix(".jsonl")?.parse().ok()
}

/// Refuses to write what nobody would read.
fn check_size(what: &str, file: &[u8], bytes_max: u64) -> Result<(), Failure> {
    match file.len() as u64 {
        bytes if bytes > bytes_max => Err(format!("{what} has {bytes} bytes, and {bytes_max} are read at most").into()),
        _ => Ok(()),
    }
}

/// The archives of an index with their topics, a later set before an earlier one: the last recipe of a topic is that of the present.
fn archives_of(index: &SiteIndex) -> Vec<(String, &ArchiveEntry)> {
    let mut archives = vec![("site".to_owned(), &index.site_archive)];
    archives.extend(index.tasks.iter().map(|tasks| ("tasks".to_owned(), tasks)));
    archives.extend(index.sets.iter().rev().flat_map(archives_of_set));
    archives
}

/// The archives of a set with their topics.
fn archives_of_set(set: &PlanSet) -> Vec<(String, &ArchiveEntry)> {
    let mut archives = vec![("schedule-state".to_owned(), &set.schedule_state)];
    for (robot, maps) in &set.robots {
        let topic = |topic: &str| Piece::topic_of(robot, topic);
        archives.push((topic("grids"), &maps.grids));
        archives.extend(maps.mission_plan.iter().map(|plan| (topic("mission-plan"), plan)));
        archives.extend(maps.storeys.iter().map(|s| (topic(&format!("grid/{}", s.map_storey)), &s.grid)));
    }
    archives
}
