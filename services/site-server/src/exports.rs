//! Exported files of sets as blobs: what `groundplan export` writes at that plan time, in the formats that are asked for.
//!
//! They are made once all maps are in the store, and given up where a newer set comes meanwhile: maps of robots do not wait for them.

use crate::enabling::enable_at;
use crate::later_sets::config_of;
use crate::pieces::{RobotPieces, SetPieces, SitePieces};
use cloud::{CloudOptions, OctomapOptions};
use daemon::{ExportedFiles, Failure, SiteConfig, chain, read_parsed};
use export::ExportFile;
use fleet::FleetFormat;
use fleet::vda5050::StoreMapsDocument;
use messages::{ContentId, Grid, Grids, LAYOUT_VERSION, MissionPlan, ScheduleState, Site, Tasks};
use replica::{
    ArchiveEntry, BlobEntry, FileEntry, FileList, IndexClock, MAX_FILE_BYTES, MAX_FILE_LIST_BYTES, PlanSet, RobotFiles,
    RobotMaps, SiteIndex, SiteName, blob_path,
};
use site_files::{OptionalFiles, SiteArchives, SiteFiles, SiteFilesError};
use std::collections::{BTreeMap, BTreeSet};
use std::time::Instant;
use tracing::{info, warn};
use world::WorldOptions;

/// The file of which a store has its own form.
const VDA5050_MAPS: &str = "fleet/vda5050/maps.json";

/// Where blobs are.
pub(crate) trait Blobs {
    /// The bytes of a blob; `None` if they are not there, or are others.
    fn read(&self, blob: BlobEntry) -> Result<Option<Vec<u8>>, Failure>;
    /// True if a blob of this length is there.
    fn has(&self, blob: BlobEntry) -> Result<bool, Failure>;
    /// Writes a blob, unless it is there.
    fn write(&mut self, bytes: &[u8]) -> Result<BlobEntry, Failure>;
}

/// Exported files of the sets of a site.
pub(crate) struct Exports {
    site: SiteName,
    formats: BTreeSet<ExportedFiles>,
    /// What is made at present, and by what it is told from other options; `None` where it cannot be made.
    making: Option<(Formats, ContentId)>,
    /// By robot: footprints of one are those of no other.
    makers: BTreeMap<String, SiteFiles>,
    /// What is in the store, by what it was made of.
    known: BTreeMap<ContentId, KnownFiles>,
}

/// Options of the formats.
#[derive(Debug, Clone, PartialEq)]
struct Formats {
    formats: BTreeSet<ExportedFiles>,
    world: Option<WorldOptions>,
}

struct KnownFiles {
    entry: RobotFiles,
    /// The `grids` archive of the maps.
    grids: ContentId,
    /// The list, and what it lists.
    blobs: Vec<BlobEntry>,
    /// True if all blobs were seen in the store since it was opened.
    is_seen: bool,
}

/// What all files of an index have in common.
pub(crate) struct OfSite<'a> {
    pub(crate) clock: &'a IndexClock,
    pub(crate) site: &'a ArchiveEntry,
    pub(crate) tasks: Option<&'a ArchiveEntry>,
}

/// A set with what the index has of it.
pub(crate) type ExportedSet<'a> = (&'a SetPieces, &'a PlanSet);

/// Why the files of a set are not made.
#[derive(Debug, thiserror::Error)]
enum ExportError {
    #[error(transparent)]
    Files(#[from] SiteFilesError),
    #[error("{path} has {bytes} bytes, and a store takes {MAX_FILE_BYTES} of a file")]
    Large { path: String, bytes: usize },
    #[error("{}", chain(.0.as_ref()))]
    Other(Failure),
    /// The store cannot be written.
    #[error("{}", chain(.0.as_ref()))]
    Store(Failure),
    #[error("a newer set is to be published")]
    Superseded,
}

impl Exports {
    /// Of a site, in these formats.
    pub(crate) fn new(site: SiteName, formats: BTreeSet<ExportedFiles>) -> Self {
        Self { site, formats, making: None, makers: BTreeMap::new(), known: BTreeMap::new() }
    }

    /// True if any files are asked for.
    pub(crate) fn are_asked_for(&self) -> bool {
        !self.formats.is_empty()
    }

    /// Takes the options of a configuration.
    ///
    /// # Errors
    /// Options that cannot be read: nothing is exported with others.
    pub(crate) fn configure(&mut self, config: &SiteConfig) -> Result<(), Failure> {
        if !self.are_asked_for() {
            return Ok(());
        }
        let formats = Formats::of(&self.formats, config);
        let before = self.making.take();
        let formats = formats?;
        let version = LAYOUT_VERSION.to_le_bytes();
        let text = format!("{formats:?}");
        let made_with = ContentId::of_parts([env!("CARGO_PKG_VERSION").as_bytes(), &version, text.as_bytes()]);
        if before.is_none_or(|(_, before)| before != made_with) {
            self.makers.clear();
        }
        self.making = Some((formats, made_with));
        Ok(())
    }

    /// Takes what an index of the store has, in the place of what was known.
    ///
    /// # Errors
    /// The store cannot be read.
    pub(crate) fn take_from(&mut self, index: Option<&SiteIndex>, blobs: &dyn Blobs) -> Result<(), Failure> {
        self.known.clear();
        let Some(index) = index else { return Ok(()) };
        let of_site = OfSite { clock: &index.clock, site: &index.site_archive, tasks: index.tasks.as_ref() };
        for set in &index.sets {
            for (robot, maps) in &set.robots {
                let Some((entry, key)) = maps.files.zip(self.key(&of_site, &set.schedule_state, robot, maps)) else {
                    continue;
                };
                let list = match entry.list.bytes <= MAX_FILE_LIST_BYTES {
                    true => blobs.read(entry.list)?.and_then(|bytes| FileList::parse(&bytes).ok()),
                    false => None,
                };
                match list {
                    Some(list) => {
                        let (blobs, grids) = (blobs_of(&entry, &list), maps.grids.id);
                        let known = KnownFiles { entry, grids, blobs, is_seen: false };
                        self.known.insert(key, known);
                    }
                    None => warn!(service = "site-server", robot, "a list of exported files is lost: it is made again"),
                }
            }
        }
        Ok(())
    }

    /// The exported files of a robot's maps, if the store has them.
    pub(crate) fn files_of(
        &self,
        of_site: &OfSite<'_>,
        state: &ArchiveEntry,
        robot: &str,
        maps: &RobotMaps,
    ) -> Option<RobotFiles> {
        self.known.get(&self.key(of_site, state, robot, maps)?).map(|known| known.entry)
    }

    /// What the files of a robot's maps are made of; `None` while they cannot be made.
    fn key(&self, of_site: &OfSite<'_>, state: &ArchiveEntry, robot: &str, maps: &RobotMaps) -> Option<ContentId> {
        let (_, made_with) = self.making.as_ref()?;
        let plan = maps.mission_plan?;
        let zone = match of_site.clock {
            IndexClock::Wall { zone } => zone.as_str(),
            IndexClock::ByServer => "",
        };
        let archives = [Some(of_site.site), of_site.tasks, Some(state), Some(&maps.grids), Some(&plan)];
        let ids = archives.map(|entry| entry.map_or(&[][..], |entry| &entry.id.sha256()[..]));
        let parts = [&made_with.sha256()[..], robot.as_bytes(), zone.as_bytes()];
        Some(ContentId::of_parts(parts.into_iter().chain(ids)))
    }

    /// The blobs of the exported files of an index. What it does not have is forgotten, but for files of maps whose mission plan is on
    /// its way: with the plan of before they are the same.
    pub(crate) fn needed(&mut self, index: &SiteIndex) -> Vec<BlobEntry> {
        let maps = || index.sets.iter().flat_map(|set| set.robots.values());
        let lists: BTreeSet<ContentId> = maps().filter_map(|maps| Some(maps.files?.list.id)).collect();
        let planned = maps().filter(|maps| maps.mission_plan.is_none());
        let planned: BTreeSet<ContentId> = planned.map(|maps| maps.grids.id).collect();
        self.known.retain(|_, known| lists.contains(&known.entry.list.id) || planned.contains(&known.grids));
        self.known.values().flat_map(|known| known.blobs.iter().copied()).collect()
    }

    /// Makes the files of sets that the store does not have, each robot's of the first set first. The answer is why some are not made.
    ///
    /// # Errors
    /// The store cannot be written.
    pub(crate) fn make(
        &mut self,
        of_site: &OfSite<'_>,
        site: &SitePieces,
        sets: &[ExportedSet<'_>],
        config: &SiteConfig,
        blobs: &mut dyn Blobs,
        is_superseded: &dyn Fn() -> bool,
    ) -> Result<Option<String>, Failure> {
        let mut why_not = None;
        for (pieces, set) in sets {
            for (robot, maps) in &set.robots {
                let Some(key) = self.key(of_site, &set.schedule_state, robot, maps) else { continue };
                if self.is_known(key, blobs)? {
                    continue;
                }
                let own = config_of(config, robot)?;
                let grids = maps.grids.id;
                let of_robot = OfRobot { site, set: pieces, robot, maps: &pieces.robots[robot], grids };
                match self.make_for(&of_robot, of_site.clock, own.robot.resolution_m, blobs, is_superseded) {
                    Ok(known) => drop(self.known.insert(key, known)),
                    Err(ExportError::Superseded | ExportError::Files(SiteFilesError::NotWanted)) => return Ok(why_not),
                    Err(ExportError::Store(why)) => return Err(why),
                    Err(why) => {
                        let why = format!("files of {robot} are not exported: {}", chain(&why));
                        warn!(service = "site-server", robot, error = why, "files are not exported");
                        why_not.get_or_insert(why);
                    }
                }
            }
        }
        Ok(why_not)
    }

    /// True if all files are in the store; what it has lost is made again.
    fn is_known(&mut self, key: ContentId, blobs: &dyn Blobs) -> Result<bool, Failure> {
        let Some(known) = self.known.get_mut(&key) else { return Ok(false) };
        for blob in known.blobs.iter().filter(|_| !known.is_seen) {
            if !blobs.has(*blob)? {
                self.known.remove(&key);
                return Ok(false);
            }
        }
        known.is_seen = true;
        Ok(true)
    }

    fn make_for(
        &mut self,
        of: &OfRobot<'_>,
        clock: &IndexClock,
        resolution_m: f64,
        blobs: &mut dyn Blobs,
        is_superseded: &dyn Fn() -> bool,
    ) -> Result<KnownFiles, ExportError> {
        let Some((formats, made_with)) = &self.making else { unreachable!("there is a key") };
        let started = Instant::now();
        if !self.makers.contains_key(of.robot) {
            self.makers.insert(of.robot.to_owned(), SiteFiles::new(formats.optional().map_err(ExportError::Other)?));
        }
        let Some(maker) = self.makers.get_mut(of.robot) else { unreachable!("it was made") };
        let mut files = Vec::new();
        let mut vda5050_maps = None;
        let write = |file: ExportFile| {
            if is_superseded() {
                return Err(ExportError::Superseded);
            }
            if file.bytes.len() as u64 > MAX_FILE_BYTES {
                return Err(ExportError::Large { path: file.path, bytes: file.bytes.len() });
            }
            let BlobEntry { id, bytes } = blobs.write(&file.bytes).map_err(ExportError::Store)?;
            if file.path == VDA5050_MAPS {
                vda5050_maps = Some(file.bytes);
            }
            files.push(FileEntry { path: file.path, id, bytes });
            Ok(())
        };
        of.each_file(maker, resolution_m, &|| !is_superseded(), write)?;
        let other = |why: Failure| ExportError::Other(why);
        let list = FileList::of(files).map_err(|why| other(why.into()))?;
        let vda5050_maps = vda5050_maps
            .map(|maps_json| {
                let link = |path: &str| list.file(path).map(|file| blob_path(&self.site, file.id));
                let at = enable_at(clock, of.set.plan_time_s);
                let document = StoreMapsDocument::of(&maps_json, self.site.as_str(), of.robot, at, link);
                let document = document.map_err(|why| other(why.into()))?;
                let text = serde_json::to_vec_pretty(&document).map_err(|why| other(why.into()))?;
                blobs.write(&text).map_err(ExportError::Store)
            })
            .transpose()?;
        let entry = RobotFiles {
            list: blobs.write(&list.to_bytes()).map_err(ExportError::Store)?,
            bytes: list.bytes(),
            made_with: *made_with,
            vda5050_maps,
        };
        let elapsed_us = u64::try_from(started.elapsed().as_micros()).unwrap_or(u64::MAX);
        let (robot, n) = (of.robot, list.files().len());
        info!(service = "site-server", robot, files = n, bytes = entry.bytes, elapsed_us, "files are exported");
        Ok(KnownFiles { entry, grids: of.grids, blobs: blobs_of(&entry, &list), is_seen: true })
    }
}

/// The archives of a robot at a plan time.
struct OfRobot<'a> {
    site: &'a SitePieces,
    set: &'a SetPieces,
    robot: &'a str,
    maps: &'a RobotPieces,
    /// The `grids` archive.
    grids: ContentId,
}

impl OfRobot<'_> {
    fn each_file(
        &self,
        maker: &mut SiteFiles,
        resolution_m: f64,
        is_wanted: &dyn Fn() -> bool,
        write: impl FnMut(ExportFile) -> Result<(), ExportError>,
    ) -> Result<(), ExportError> {
        let Self { site, set, maps, .. } = *self;
        let Some(plan) = &maps.mission_plan else { unreachable!("there is a key") };
        let archive = SiteFilesError::from;
        let own = Site::open(site.site.bytes.bytes()).map_err(archive)?;
        let tasks = site.tasks.as_ref().map(|tasks| Tasks::open(tasks.bytes.bytes())).transpose().map_err(archive)?;
        let site = tasks.map_or(Ok(own), |tasks| own.with_tasks(&tasks)).map_err(SiteFilesError::from)?;
        let state = ScheduleState::open(set.state.bytes.bytes()).map_err(archive)?;
        let index = Grids::open(maps.grids.bytes.bytes()).map_err(archive)?;
        let grids = maps.storeys.iter().map(|storey| Grid::open(storey.grid.bytes.bytes()));
        let grids: Vec<Grid<'_>> = grids.collect::<Result<_, _>>().map_err(archive)?;
        let plan = MissionPlan::open(plan.bytes.bytes()).map_err(archive)?;
        let archives = SiteArchives {
            site: &site,
            schedule_state: &state,
            index: &index,
            grids: &grids,
            mission_plan: &plan,
            resolution_m,
        };
        archives.check().map_err(SiteFilesError::from)?;
        // What is to be told about a world is in its lookup.json.
        maker.each_file(&archives, is_wanted, write).map(drop)
    }
}

impl Formats {
    fn of(formats: &BTreeSet<ExportedFiles>, config: &SiteConfig) -> Result<Self, Failure> {
        let is_asked_for = |format| formats.contains(&format);
        let with_world = is_asked_for(ExportedFiles::World) || is_asked_for(ExportedFiles::Usd);
        let world = || -> Result<WorldOptions, Failure> {
            let read = |path| read_parsed("options of worlds", path, WorldOptions::parse);
            let options = config.world.options.as_deref().map_or_else(|| Ok(WorldOptions::default()), read)?;
            Ok(WorldOptions { usd: options.usd || is_asked_for(ExportedFiles::Usd), ..options })
        };
        Ok(Self { formats: formats.clone(), world: with_world.then(world).transpose()? })
    }

    fn optional(&self) -> Result<OptionalFiles, Failure> {
        let has = |format| self.formats.contains(&format);
        let fleet = [(ExportedFiles::Vda5050, FleetFormat::Vda5050), (ExportedFiles::Lif, FleetFormat::Lif)];
        Ok(OptionalFiles::new(
            self.world.clone(),
            has(ExportedFiles::Cloud).then(|| CloudOptions::of(None, &[])).transpose()?,
            has(ExportedFiles::Octomap).then(|| OctomapOptions::of(None, &[], &[])).transpose()?,
            has(ExportedFiles::Ground),
            fleet.into_iter().filter(|(asked, _)| has(*asked)).map(|(_, format)| format).collect(),
            has(ExportedFiles::OpenRmf),
        ))
    }
}

/// The blobs of exported files: their list, what it lists, and what a store has beside it.
fn blobs_of(entry: &RobotFiles, list: &FileList) -> Vec<BlobEntry> {
    let files = list.files().iter().map(FileEntry::blob);
    std::iter::once(entry.list).chain(entry.vda5050_maps).chain(files).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::ContentHash;

    fn archive(seed: &str) -> ArchiveEntry {
        let id = ContentId::of(seed.as_bytes());
        ArchiveEntry { id, content_hash: ContentHash::NONE, bytes: 1, recipe: BlobEntry { id, bytes: 2 } }
    }

    fn index(plan: Option<&str>) -> SiteIndex {
        let maps = RobotMaps {
            grids: archive("grids"),
            mission_plan: plan.map(archive),
            robot_hash: ContentHash::NONE,
            storeys: Vec::new(),
            files: None,
        };
        let set = PlanSet {
            plan_time_s: Some(5),
            valid_until_s: None,
            schedule_state: archive("state"),
            robots: BTreeMap::from([("robot".to_owned(), maps)]),
        };
        SiteIndex {
            format: SiteIndex::FORMAT,
            site: "tower".parse().unwrap(),
            epoch: 1,
            published: String::new(),
            layout_version: LAYOUT_VERSION,
            frame_epoch: 1,
            clock: IndexClock::ByServer,
            site_archive: archive("site"),
            tasks: None,
            sets: vec![set],
            why_no_later: None,
        }
    }

    /// A store in memory.
    #[derive(Default)]
    struct Memory(BTreeMap<ContentId, Vec<u8>>);

    impl Blobs for Memory {
        fn read(&self, blob: BlobEntry) -> Result<Option<Vec<u8>>, Failure> {
            Ok(self.0.get(&blob.id).cloned())
        }

        fn has(&self, blob: BlobEntry) -> Result<bool, Failure> {
            Ok(self.0.get(&blob.id).is_some_and(|bytes| bytes.len() as u64 == blob.bytes))
        }

        fn write(&mut self, bytes: &[u8]) -> Result<BlobEntry, Failure> {
            let blob = BlobEntry { id: ContentId::of(bytes), bytes: bytes.len() as u64 };
            self.0.insert(blob.id, bytes.to_vec());
            Ok(blob)
        }
    }

    fn files(exports: &Exports, index: &SiteIndex) -> Option<RobotFiles> {
        let of_site = OfSite { clock: &index.clock, site: &index.site_archive, tasks: None };
        let set = &index.sets[0];
        exports.files_of(&of_site, &set.schedule_state, "robot", &set.robots["robot"])
    }

    #[test]
    fn files_are_known_by_what_they_are_made_of_until_an_index_has_others() {
        let mut store = Memory::default();
        let file = store.write(b"wall").unwrap();
        let entry = FileEntry { path: "a.pgm".to_owned(), id: file.id, bytes: file.bytes };
        let list = store.write(&FileList::of(vec![entry]).unwrap().to_bytes()).unwrap();
        let mut exports = Exports::new("tower".parse().unwrap(), BTreeSet::from([ExportedFiles::Maps]));
        exports.configure(&SiteConfig::parse("state = \"x\"\n", std::path::Path::new("/")).unwrap()).unwrap();
        let (_, made_with) = exports.making.clone().unwrap();
        let mut newest = index(Some("plan"));
        let told = RobotFiles { list, bytes: 4, made_with, vda5050_maps: None };
        newest.sets[0].robots.get_mut("robot").unwrap().files = Some(told);
        exports.take_from(Some(&newest), &store).unwrap();
        assert_eq!(files(&exports, &newest), Some(told));
        assert_eq!(exports.needed(&newest), [list, file]);
        // A server that comes back has the maps before the plan.
        assert_eq!(files(&exports, &index(None)), None);
        exports.needed(&index(None));
        assert_eq!(files(&exports, &index(Some("plan"))), Some(told), "the same plan again");
        // Another plan, another zone: other files.
        assert_eq!(files(&exports, &index(Some("other"))), None);
        let wall = SiteIndex { clock: IndexClock::Wall { zone: "UTC".to_owned() }, ..index(Some("plan")) };
        assert_eq!(files(&exports, &wall), None);
        exports.needed(&index(Some("other")));
        assert_eq!(files(&exports, &newest), None);
        // A list that is lost is no list.
        store.0.remove(&list.id);
        exports.take_from(Some(&newest), &store).unwrap();
        assert_eq!(files(&exports, &newest), None);
    }

    #[test]
    fn what_is_lost_of_files_is_noticed_once_they_are_looked_at() {
        let mut store = Memory::default();
        let blobs = vec![store.write(b"one").unwrap(), store.write(b"two").unwrap()];
        let mut exports = Exports::new("tower".parse().unwrap(), BTreeSet::new());
        let entry = RobotFiles { list: blobs[0], bytes: 3, made_with: blobs[0].id, vda5050_maps: None };
        let key = ContentId::of(b"key");
        let known = |is_seen| KnownFiles { entry, grids: key, blobs: blobs.clone(), is_seen };
        exports.known.insert(key, known(false));
        assert!(exports.is_known(key, &store).unwrap());
        store.0.remove(&blobs[1].id);
        assert!(exports.is_known(key, &store).unwrap(), "it was seen");
        exports.known.insert(key, known(false));
        assert!(!exports.is_known(key, &store).unwrap() && !exports.known.contains_key(&key));
    }

    #[test]
    fn options_that_cannot_be_read_export_nothing() {
        let config =
            |more: &str| SiteConfig::parse(&format!("state = \"x\"\n{more}"), std::path::Path::new("/")).unwrap();
        let mut exports = Exports::new("tower".parse().unwrap(), BTreeSet::from([ExportedFiles::Usd]));
        exports.configure(&config("")).unwrap();
        let (formats, made_with) = exports.making.clone().unwrap();
        assert!(formats.world.unwrap().usd, "USD is of a world");
        assert!(exports.configure(&config("[world]\noptions = \"/none/world.toml\"\n")).is_err());
        assert!(exports.making.is_none());
        exports.configure(&config("")).unwrap();
        assert_eq!(exports.making.unwrap().1, made_with);
    }
}
