//! A store of objects in memory: what its users see of it over links that fail, and all that they changed, in its order.

use crate::{DiskFaults, SimulatedClock, mortal};
use daemon::Clock;
use jiff::Timestamp;
use messages::ContentId;
use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::sync::{Arc, Mutex};
use store::{Fetched, Listed, Objects, StoreError};

/// Objects by their paths.
pub type StoredObjects = BTreeMap<String, StoredObject>;

/// An object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct StoredObject {
    /// What it holds.
    pub bytes: Arc<[u8]>,
    /// When it was written, milliseconds since 1970 in UTC.
    pub modified_ms: i64,
    /// Its ETag.
    pub etag: u64,
}

/// A change of a store over a link.
#[derive(Debug, Clone)]
pub enum StoreChange {
    /// An object was written.
    Written(String, Arc<[u8]>),
    /// An object was removed.
    Removed(String),
}

/// A store. Clones are the same one.
#[derive(Clone)]
pub struct SimulatedStore {
    state: Arc<Mutex<StoreState>>,
    clock: SimulatedClock,
}

#[derive(Default)]
struct StoreState {
    objects: StoredObjects,
    n_written: u64,
    changes: Vec<StoreChange>,
}

/// What happens on the link of a user.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct LinkFaults {
    /// Nothing is answered.
    pub is_away: bool,
    /// After so many calls, so many break off.
    pub breaks_off: Option<(u32, u32)>,
    /// The write after so many takes effect, and its answer is lost.
    pub loses_answer: Option<u32>,
    /// The fetch after so many brings bytes of which one is another.
    pub garbles: Option<u32>,
    /// Each call takes so long.
    pub slow_ms: i64,
    /// What somebody on the way gives for an object.
    pub forged: BTreeMap<String, Vec<u8>>,
    /// Of the calls from here on, those in which something else happens in the meantime, bit by bit.
    pub meantime: u64,
}

/// What happens in the middle of a call.
pub type Meantime = Arc<dyn Fn() + Send + Sync>;

/// The end of a user.
#[derive(Clone)]
pub struct StoreLink {
    /// The store.
    pub store: SimulatedStore,
    /// What happens on the link.
    pub faults: Arc<Mutex<LinkFaults>>,
    /// What its process dies of: a write into the store is one.
    pub deaths: Arc<Mutex<DiskFaults>>,
    /// What happens in the middle of calls.
    pub meantime: Option<Meantime>,
}

impl SimulatedStore {
    /// An empty store.
    pub fn new(clock: SimulatedClock) -> Self {
        Self { state: Arc::default(), clock }
    }

    /// What changed over links since this was asked last.
    pub fn changes(&self) -> Vec<StoreChange> {
        std::mem::take(&mut self.state.lock().unwrap().changes)
    }

    /// All objects.
    pub fn objects(&self) -> StoredObjects {
        self.state.lock().unwrap().objects.clone()
    }

    /// An object.
    pub fn object(&self, path: &str) -> Option<Arc<[u8]>> {
        self.state.lock().unwrap().objects.get(path).map(|object| Arc::clone(&object.bytes))
    }

    /// The store is set back to what it had.
    pub fn set_back(&self, objects: StoredObjects) {
        self.state.lock().unwrap().objects = objects;
    }

    /// Something else than its users puts bytes there, or takes them away.
    pub fn tamper(&self, path: &str, bytes: Option<Vec<u8>>) {
        let mut state = self.state.lock().unwrap();
        match bytes {
            Some(bytes) => state.put(path, &bytes, self.clock.now().wall_ms),
            None => drop(state.objects.remove(path)),
        }
    }
}

impl StoreState {
    fn put(&mut self, path: &str, bytes: &[u8], modified_ms: i64) {
        self.n_written += 1;
        let object = StoredObject { bytes: bytes.into(), modified_ms, etag: self.n_written };
        self.objects.insert(path.to_owned(), object);
    }
}

/// Counts down; true once.
fn is_now(left: &mut Option<u32>) -> bool {
    let is_now = *left == Some(0);
    *left = left.and_then(|left| left.checked_sub(1));
    is_now
}

impl StoreLink {
    fn unreachable() -> StoreError {
        StoreError::Thread { source: io::ErrorKind::ConnectionReset.into() }
    }

    /// A call begins; it may not come through.
    fn call(&self) -> Result<(), StoreError> {
        let mut faults = self.faults.lock().unwrap();
        let is_interrupted = faults.meantime & 1 == 1;
        faults.meantime >>= 1;
        let mut is_lost = faults.is_away;
        match &mut faults.breaks_off {
            Some((0, 0)) => faults.breaks_off = None,
            Some((0, n)) => {
                *n -= 1;
                is_lost = true;
            }
            Some((after, _)) => *after -= 1,
            None => {}
        }
        self.store.clock.pass(faults.slow_ms);
        drop(faults);
        if let Some(meantime) = self.meantime.as_ref().filter(|_| is_interrupted) {
            meantime();
        }
        if is_lost { Err(Self::unreachable()) } else { Ok(()) }
    }

    /// A call that changes something.
    fn change<T>(&self, act: impl FnOnce(&mut StoreState) -> T) -> Result<T, StoreError> {
        self.call()?;
        let changed: Result<T, StoreError> = mortal(&self.deaths, || Ok(act(&mut self.store.state.lock().unwrap())));
        let changed = changed?;
        if is_now(&mut self.faults.lock().unwrap().loses_answer) { Err(Self::unreachable()) } else { Ok(changed) }
    }

    /// What comes over the link, with its ETag.
    fn fetched(&self, path: &str) -> Result<Option<(Vec<u8>, String)>, StoreError> {
        self.call()?;
        let mut faults = self.faults.lock().unwrap();
        if let Some(forged) = faults.forged.get(path) {
            return Ok(Some((forged.clone(), format!("forged {}", ContentId::of(forged)))));
        }
        let state = self.store.state.lock().unwrap();
        let Some(object) = state.objects.get(path) else { return Ok(None) };
        let (mut bytes, etag) = (object.bytes.to_vec(), object.etag);
        if !bytes.is_empty() && is_now(&mut faults.garbles) {
            let place = bytes.len() / 2;
            bytes[place] ^= 1;
            // Who changes bytes has another ETag for them.
            return Ok(Some((bytes, format!("garbled {etag}"))));
        }
        Ok(Some((bytes, etag.to_string())))
    }

    fn put(&self, state: &mut StoreState, path: &str, bytes: &[u8]) {
        state.put(path, bytes, self.store.clock.now().wall_ms);
        state.changes.push(StoreChange::Written(path.to_owned(), bytes.into()));
    }
}

impl Objects for StoreLink {
    fn address(&self) -> &str {
        "memory"
    }

    fn fetch_unless(&self, path: &str, etag: Option<&str>, max_bytes: u64) -> Result<Fetched, StoreError> {
        Ok(match self.fetched(path)? {
            None => Fetched::Missing,
            Some((_, found)) if etag == Some(found.as_str()) => Fetched::Unchanged,
            Some((bytes, _)) if bytes.len() as u64 > max_bytes => {
                return Err(StoreError::TooLarge { path: path.to_owned(), max_bytes });
            }
            Some((bytes, etag)) => Fetched::New { bytes, etag: Some(etag) },
        })
    }

    fn fetch_whole(&self, path: &str, max_bytes: u64) -> Result<Vec<u8>, StoreError> {
        match self.fetch_unless(path, None, max_bytes)? {
            Fetched::New { bytes, .. } => Ok(bytes),
            Fetched::Unchanged | Fetched::Missing => {
                Err(StoreError::Missing { path: path.to_owned(), address: self.address().to_owned() })
            }
        }
    }

    fn fetch_range(&self, path: &str, range: Range<u64>, _: u64) -> Result<Vec<u8>, StoreError> {
        let whole = self.fetch_whole(path, u64::MAX)?;
        let part = whole.get(range.start as usize..range.end as usize);
        part.map(<[u8]>::to_vec).ok_or_else(|| StoreError::Short { path: path.to_owned() })
    }

    fn create(&self, path: &str, bytes: &[u8]) -> Result<bool, StoreError> {
        self.change(|state| {
            let is_new = !state.objects.contains_key(path);
            if is_new {
                self.put(state, path, bytes);
            }
            is_new
        })
    }

    fn replace(&self, path: &str, bytes: &[u8]) -> Result<(), StoreError> {
        self.change(|state| self.put(state, path, bytes))
    }

    fn length(&self, path: &str) -> Result<Option<u64>, StoreError> {
        self.call()?;
        Ok(self.store.object(path).map(|bytes| bytes.len() as u64))
    }

    fn list(&self, folder: &str) -> Result<Vec<Listed>, StoreError> {
        self.call()?;
        let prefix = format!("{folder}/");
        let listed = |(path, object): (&String, &StoredObject)| Listed {
            path: path.clone(),
            bytes: object.bytes.len() as u64,
            modified: Timestamp::from_millisecond(object.modified_ms).unwrap(),
        };
        let state = self.store.state.lock().unwrap();
        Ok(state.objects.iter().filter(|(path, _)| path.starts_with(&prefix)).map(listed).collect())
    }

    fn remove(&self, path: &str) -> Result<(), StoreError> {
        self.change(|state| {
            if state.objects.remove(path).is_some() {
                state.changes.push(StoreChange::Removed(path.to_owned()));
            }
        })
    }
}
