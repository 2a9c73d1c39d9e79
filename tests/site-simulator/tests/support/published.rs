//! The record of what a server has published, as its store saw it, and the judge of what robots show of it, without the rules of either.

use crate::drawn::{ROBOT, drawn};
use crate::seeds::Violation;
use daemon::Published;
use messages::ContentHash;
use replica::{
    ArchiveEntry, IndexClock, PlanSet, Recipe, SignedIndex, SiteIndex, SiteName, blob_folder, blob_path, current_path,
    index_folder, index_path,
};
use site_server::pieces::{Piece, SetPieces};
use site_simulator::simulated_store::{SimulatedStore, StoreChange};
use site_view::SiteSet;
use std::collections::{BTreeMap, BTreeSet};

/// What the server is to publish: a date of a revision.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Wanted {
    pub(crate) revision: usize,
    pub(crate) place: usize,
    pub(crate) clock: IndexClock,
    /// False while the mission plan is planned.
    pub(crate) has_plan: bool,
}

impl Wanted {
    /// The set that is to be published.
    pub(crate) fn set(&self) -> SetPieces {
        let mut set = drawn().revisions[self.revision].sets[self.place].clone();
        if !self.has_plan {
            set.robots.values_mut().for_each(|maps| maps.mission_plan = None);
        }
        set
    }
}

/// An index that the server has published.
pub(crate) struct PublishedIndex {
    pub(crate) file: Vec<u8>,
    pub(crate) index: SiteIndex,
    /// Number of its list of keys.
    pub(crate) list: u64,
}

/// What became of an object in the store that nobody wrote.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Damage {
    /// It is not there, or shorter, since the server has looked at its store.
    Lost,
    /// The same, and the server has looked since.
    KnownLost,
    /// Its bytes are others, as many as before.
    Wrong,
}

/// What the server has published.
pub(crate) struct Record {
    site: SiteName,
    pub(crate) indices: BTreeMap<u64, PublishedIndex>,
    /// Highest epoch that was taken.
    pub(crate) taken: u64,
    /// Epoch of the index that the store says is the newest, if it is one of the server.
    pub(crate) current: u64,
    present: BTreeSet<String>,
    pub(crate) damaged: BTreeMap<String, Damage>,
}

impl Record {
    pub(crate) fn new() -> Self {
        Self {
            site: "tower".parse().unwrap(),
            indices: BTreeMap::new(),
            taken: 0,
            current: 0,
            present: BTreeSet::new(),
            damaged: BTreeMap::new(),
        }
    }

    pub(crate) fn current_path(&self) -> String {
        current_path(&self.site)
    }

    /// The blobs that are there.
    pub(crate) fn blobs(&self) -> Vec<String> {
        let folder = blob_folder(&self.site);
        self.present.iter().filter(|path| path.starts_with(&folder)).cloned().collect()
    }

    /// The server looks at its store anew.
    pub(crate) fn server_starts(&mut self) {
        for damage in self.damaged.values_mut().filter(|damage| **damage == Damage::Lost) {
            *damage = Damage::KnownLost;
        }
    }

    /// Something happened to an object.
    pub(crate) fn is_damaged(&mut self, path: &str, damage: Damage) {
        self.damaged.insert(path.to_owned(), damage);
    }

    /// The store has other objects than the server wrote there last.
    pub(crate) fn is_set_back(&mut self, present: BTreeSet<String>, damaged: BTreeMap<String, Damage>, current: u64) {
        let lost: Vec<String> = self.present.difference(&present).cloned().collect();
        // What the server knew of it may have been mended since.
        let unknown = |damage| if damage == Damage::KnownLost { Damage::Lost } else { damage };
        self.damaged = damaged.into_iter().map(|(path, damage)| (path, unknown(damage))).collect();
        lost.iter().for_each(|path| self.is_damaged(path, Damage::Lost));
        (self.present, self.current) = (present, current);
    }

    /// Takes what the server has changed: each step is what it promises.
    pub(crate) fn take(&mut self, store: &SimulatedStore, wanted: &Wanted) -> Result<(), Violation> {
        for change in store.changes() {
            match change {
                StoreChange::Written(path, bytes) => {
                    self.damaged.remove(&path);
                    if path.starts_with(&index_folder(&self.site)) {
                        self.take_index(store, &path, &bytes, wanted)?;
                    } else if path == self.current_path() {
                        self.take_current(&bytes)?;
                    }
                    self.present.insert(path);
                }
                StoreChange::Removed(path) => {
                    let needed = self.indices.get(&self.current).map(|of| self.needed(store, &of.index));
                    if needed.is_some_and(|needed| needed.contains(&path)) {
                        return Err(format!("{path} is removed, and the newest index needs it"));
                    }
                    self.present.remove(&path);
                }
            }
        }
        Ok(())
    }

    /// Paths of the blobs that an index needs, as far as its recipes can be read.
    pub(crate) fn needed(&self, store: &SimulatedStore, index: &SiteIndex) -> BTreeSet<String> {
        let mut needed = BTreeSet::new();
        for entry in index.archives() {
            let path = blob_path(&self.site, entry.recipe.id);
            let recipe = store.object(&path).and_then(|bytes| Recipe::parse(&bytes, entry).ok());
            let packs = recipe.iter().flat_map(Recipe::packs).map(|pack| blob_path(&self.site, pack.id));
            needed.extend(packs);
            needed.insert(path);
        }
        needed
    }

    fn take_index(
        &mut self,
        store: &SimulatedStore,
        path: &str,
        bytes: &[u8],
        wanted: &Wanted,
    ) -> Result<(), Violation> {
        let signed = SignedIndex::parse(bytes, &[drawn().keys.root]).map_err(|why| daemon::chain(&why))?;
        let epoch = signed.index.epoch;
        if path != index_path(&self.site, epoch) {
            return Err(format!("the index of epoch {epoch} is at {path}"));
        }
        if let Some(known) = self.indices.get(&epoch).filter(|known| known.file != bytes) {
            return Err(format!("epoch {epoch} is used twice: {:?}, {:?}", known.index.sets[0], signed.index.sets[0]));
        }
        if epoch <= self.taken && !self.indices.contains_key(&epoch) {
            return Err(format!("epochs fall: {epoch} after {}", self.taken));
        }
        for blob in self.needed(store, &signed.index) {
            let is_there = match self.damaged.get(&blob) {
                Some(Damage::Lost | Damage::Wrong) => true,
                Some(Damage::KnownLost) => false,
                None => self.present.contains(&blob),
            };
            if !is_there {
                return Err(format!("the index of epoch {epoch} names {blob}, which is not there"));
            }
        }
        is_drawn(&signed.index, wanted)?;
        self.taken = self.taken.max(epoch);
        let published = PublishedIndex { file: bytes.to_vec(), index: signed.index, list: signed.keys.number };
        self.indices.insert(epoch, published);
        Ok(())
    }

    /// Epoch of the index that is this file; `None` for one that the server has not published.
    pub(crate) fn epoch_of(&self, file: &[u8]) -> Option<u64> {
        self.indices.iter().find(|(_, known)| known.file == file).map(|(epoch, _)| *epoch)
    }

    fn take_current(&mut self, bytes: &[u8]) -> Result<(), Violation> {
        let Some(epoch) = self.epoch_of(bytes) else {
            return Err("what is said to be the newest index was not published as one".to_owned());
        };
        if epoch < self.current {
            return Err(format!("the newest index falls from epoch {} to {epoch}", self.current));
        }
        self.current = epoch;
        Ok(())
    }

    /// The indices of which a set of samples is, with the places of its plan time in each.
    pub(crate) fn indices_of(&self, set: &SiteSet<'_>, storeys: &[usize]) -> Vec<(u64, usize)> {
        let places = self.indices.iter().flat_map(|(epoch, known)| {
            let places = known.index.sets.iter().enumerate();
            places.filter(|(_, plan)| is_of(set, &known.index, plan, storeys)).map(|(place, _)| (*epoch, place))
        });
        places.collect()
    }
}

/// The content of an index is what was drawn, from the date that is wanted on.
fn is_drawn(index: &SiteIndex, wanted: &Wanted) -> Result<(), Violation> {
    let revision = &drawn().revisions[wanted.revision];
    let is = |entry: &ArchiveEntry, piece: &Piece| {
        entry.content_hash == piece.hash && entry.id == messages::ContentId::of(piece.bytes.bytes())
    };
    if !is(&index.site_archive, &revision.site.site) || index.clock != wanted.clock {
        return Err(format!("the index of epoch {} is of another site or clock than {wanted:?}", index.epoch));
    }
    for (k, plan) in index.sets.iter().enumerate() {
        let expected = match k {
            0 => wanted.set(),
            _ => revision.sets.get(wanted.place + k).cloned().ok_or("an index has more dates than the site")?,
        };
        let (maps, drawn) = (&plan.robots[ROBOT], &expected.robots[ROBOT]);
        let is_plan = match (&maps.mission_plan, &drawn.mission_plan) {
            (Some(entry), Some(piece)) => is(entry, piece),
            (None, None) => true,
            _ => false,
        };
        let grids = maps.storeys.iter().zip(&drawn.storeys);
        let is_so = (plan.plan_time_s, plan.valid_until_s) == (expected.plan_time_s, expected.valid_until_s)
            && is(&plan.schedule_state, &expected.state)
            && is(&maps.grids, &drawn.grids)
            && is_plan
            && maps.robot_hash == drawn.robot_hash
            && maps.storeys.len() == drawn.storeys.len()
            && grids.into_iter().all(|(map, drawn)| {
                is(&map.grid, &drawn.grid) && (map.map_storey, map.input_hash) == (drawn.map_storey, drawn.input_hash)
            });
        if !is_so {
            return Err(format!("set {k} of the index of epoch {} is not what was drawn for {wanted:?}", index.epoch));
        }
    }
    Ok(())
}

/// True if a set of samples is this one of an index, as a robot shows it that follows these storeys.
fn is_of(set: &SiteSet<'_>, index: &SiteIndex, plan: &PlanSet, storeys: &[usize]) -> bool {
    let maps = &plan.robots[ROBOT];
    let named: Vec<&replica::StoreyMap> = storeys.iter().map(|place| &maps.storeys[*place]).collect();
    let is_whole = storeys.len() == maps.storeys.len();
    let header = set.index.bytes().header();
    let grids = set.grids.iter().zip(&named);
    let plan_of_set: Option<ContentHash> = set.mission_plan.map(|plan| plan.content_hash());
    set.site.content_hash() == index.site_archive.content_hash
        && set.site.bytes().header().frame_epoch == index.frame_epoch
        && set.state.content_hash() == plan.schedule_state.content_hash
        && set.grids.len() == named.len()
        && grids.into_iter().all(|(grid, map)| grid.content_hash() == map.grid.content_hash)
        && (!is_whole || set.index.content_hash() == maps.grids.content_hash)
        && header.inputs.schedule_state == plan.schedule_state.content_hash
        && header.inputs.site == index.site_archive.content_hash
        && header.inputs.robot == maps.robot_hash
        // While a plan is planned, one of the same grids stays.
        && maps.mission_plan.is_none_or(|entry| plan_of_set.is_none_or(|plan| plan == entry.content_hash))
}

/// What identifies the plan time of a set that a robot says that it shows.
pub(crate) fn shown_set<'a>(index: &'a SiteIndex, state: &Published) -> Option<&'a PlanSet> {
    index.sets.iter().find(|set| set.schedule_state.content_hash == state.content_hash)
}
