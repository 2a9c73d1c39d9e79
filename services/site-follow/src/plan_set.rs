//! The archives of a set as samples: read from the disk, checked, and with the headers that the drawing daemons give them.

use crate::archive_folder::ArchiveFolder;
use crate::fetcher::Followed;
use crate::outputs::FollowSample;
use bus::{GridSlot, Topic};
use daemon::{Failure, NewSample, chain};
use messages::{ArchiveBuffer, Checked, ContentHash, ContentId, Grids, GridsBuilder, InputHashes, Payload, payload};
use replica::{ArchiveEntry, PlanSet, SiteIndex};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What was published of each topic: by its name, what identifies the sample.
pub(crate) type PublishedArchives = BTreeMap<String, ContentId>;

/// An archive that cannot be shown.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SetError {
    /// It is not on the disk as the index names it.
    #[error("the archive {id} is damaged on this disk, and is fetched again: {why}")]
    Damaged {
        /// Which one.
        id: ContentId,
        /// What is wrong.
        why: String,
    },
    /// Anything else.
    #[error("{0}")]
    Other(String),
}

/// Samples of a set that are not published yet, in the order in which they are to be published, and what is published then.
pub(crate) struct SetSamples {
    pub(crate) samples: Vec<FollowSample>,
    pub(crate) published: PublishedArchives,
}

struct Reader<'a> {
    folder: &'a ArchiveFolder,
    published: &'a PublishedArchives,
    now: PublishedArchives,
    frame_epoch: u64,
    /// Hashes of archives that are published already, or are about to be.
    hashes: &'a BTreeMap<ContentId, ContentHash>,
    new_hashes: BTreeMap<ContentId, ContentHash>,
}

/// Reads what is to be published of a set. `hashes` are the content hashes of archives that were read before; those that are read
/// are added.
///
/// # Errors
/// An archive that is damaged on the disk; a robot or storey that the set does not have.
pub(crate) fn samples_of(
    index: &SiteIndex,
    set: &PlanSet,
    followed: &Followed,
    folder: &ArchiveFolder,
    published: &PublishedArchives,
    hashes: &mut BTreeMap<ContentId, ContentHash>,
) -> Result<SetSamples, SetError> {
    let other = |why: Failure| SetError::Other(chain(why.as_ref()));
    let places = followed.places(set).map_err(other)?;
    let maps = &set.robots[&followed.robot];
    let mut reader = Reader {
        folder,
        published,
        now: PublishedArchives::new(),
        frame_epoch: index.frame_epoch,
        hashes,
        new_hashes: BTreeMap::new(),
    };
    let mut samples = Vec::new();
    let site = reader.hash::<payload::Site>(&index.site_archive)?;
    if let Some(sample) = reader.new_of(bus::topics::Site, "site", &index.site_archive, InputHashes::default())? {
        samples.push(FollowSample::Site(sample));
    }
    let of_site = InputHashes { site, ..InputHashes::default() };
    match &index.tasks {
        Some(tasks) => {
            if let Some(sample) = reader.new_of(bus::topics::Tasks, "tasks", tasks, of_site)? {
                samples.push(FollowSample::Tasks(Some(sample)));
            }
        }
        None if published.contains_key("tasks") => samples.push(FollowSample::Tasks(None)),
        None => {}
    }
    let state = reader.hash::<payload::ScheduleState>(&set.schedule_state)?;
    if let Some(sample) = reader.new_of(bus::topics::ScheduleState, "schedule-state", &set.schedule_state, of_site)? {
        samples.push(FollowSample::State(sample));
    }
    let inputs = InputHashes { schedule_state: state, robot: maps.robot_hash, ..of_site };
    for (k, place) in places.iter().enumerate() {
        let storey = &maps.storeys[*place];
        let slot = GridSlot::new(k).ok_or_else(|| SetError::Other("there are more storeys than slots".to_owned()))?;
        let inputs = InputHashes { own: storey.input_hash, ..inputs };
        let name = format!("grid/{k:02}");
        let entry = &storey.grid;
        if let Some(sample) = reader.new_of(bus::topics::Grid(slot), &name, entry, inputs)? {
            samples.push(FollowSample::Grid(slot, sample));
        }
    }
    let is_whole = places.len() == maps.storeys.len();
    let grids = reader.checked::<payload::Grids>(&maps.grids)?;
    let grids = if is_whole { grids } else { cut(&grids, &places).map_err(SetError::Other)? };
    let index_hash = grids.content_hash();
    let index_id = ContentId::of(grids.bytes().bytes());
    reader.now.insert("grids".to_owned(), index_id);
    // The index comes after every grid that changed, and names the state: with another one of either it is another archive.
    if published.get("grids") != Some(&index_id) {
        let sample = NewSample { archive: Arc::new(grids), frame_epoch: index.frame_epoch, inputs };
        samples.push(FollowSample::Index(sample, places.len()));
    }
    if let Some(plan) = &maps.mission_plan {
        let inputs = InputHashes { grids: index_hash, ..inputs };
        if let Some(sample) = reader.new_of(bus::topics::MissionPlan, "mission-plan", plan, inputs)? {
            samples.push(FollowSample::MissionPlan(sample));
        }
    } else if let Some(before) = published.get("mission-plan") {
        reader.now.insert("mission-plan".to_owned(), *before);
    }
    let Reader { now, new_hashes, .. } = reader;
    hashes.extend(new_hashes);
    Ok(SetSamples { samples, published: now })
}

/// The index of these grids alone, each in the slot of its place.
fn cut(grids: &Checked<payload::Grids>, places: &[usize]) -> Result<Checked<payload::Grids>, String> {
    let Grids { head, slots, robot_name, doors, regions, robot_footprint_m, safety_rules, safety_materials, .. } =
        grids.view();
    let chosen: Option<Vec<_>> = places.iter().map(|place| slots.get(*place).copied()).collect();
    let chosen = chosen.ok_or("the index of the grids has fewer storeys than the index of the site")?;
    let cut = GridsBuilder {
        head: *head,
        slots: &chosen,
        robot_name,
        doors,
        regions,
        robot_footprint_m,
        safety_rules,
        safety_materials,
    };
    Checked::new(cut.finish()).map_err(|why| why.to_string())
}

impl Reader<'_> {
    /// What is wrong with an archive that cannot be opened: the disk, or what the server has published.
    fn unusable(&self, entry: &ArchiveEntry, why: &str) -> SetError {
        let id = entry.id;
        match self.folder.is_intact(entry) {
            true => {
                SetError::Other(format!("the archive {id} is as the server published it, and cannot be used: {why}"))
            }
            false => SetError::Damaged { id, why: why.to_owned() },
        }
    }

    fn checked<P: Payload>(&mut self, entry: &ArchiveEntry) -> Result<Checked<P>, SetError> {
        let buffer: ArchiveBuffer = self.folder.read(entry).map_err(|why| self.unusable(entry, &why.to_string()))?;
        let checked = Checked::<P>::new(buffer).map_err(|why| self.unusable(entry, &chain(&why)))?;
        // An archive that is sound can be another one: a disk may give a file for another.
        if checked.content_hash() != entry.content_hash {
            return Err(self.unusable(entry, "its content hash is not that of the index"));
        }
        self.new_hashes.insert(entry.id, checked.content_hash());
        Ok(checked)
    }

    /// The content hash of an archive.
    fn hash<P: Payload>(&mut self, entry: &ArchiveEntry) -> Result<ContentHash, SetError> {
        match self.hashes.get(&entry.id).or_else(|| self.new_hashes.get(&entry.id)) {
            Some(hash) => Ok(*hash),
            None => Ok(self.checked::<P>(entry)?.content_hash()),
        }
    }

    /// The sample of a topic, if another archive was published there.
    fn new_of<T: Topic>(
        &mut self,
        _: T,
        name: &str,
        entry: &ArchiveEntry,
        inputs: InputHashes,
    ) -> Result<Option<NewSample<T>>, SetError> {
        // A mission plan is told by its header which grids it is of, every sample which map frame it has.
        let parts: [&[u8]; 3] = [entry.id.sha256(), &inputs.grids.to_le_bytes(), &self.frame_epoch.to_le_bytes()];
        let key = ContentId::of_parts(parts);
        self.now.insert(name.to_owned(), key);
        if self.published.get(name) == Some(&key) {
            return Ok(None);
        }
        let archive = Arc::new(self.checked::<T::Payload>(entry)?);
        Ok(Some(NewSample { archive, frame_epoch: self.frame_epoch, inputs }))
    }
}
