//! Maps of the robot: from the bus, from a file of a request, of the configuration, or from its copy in the state folder.

use super::AlignService;
use crate::persisted_state::StoredMap;
use crate::robot_map::RobotMap;
use bus::{CheckedSample, topics};
use daemon::Failure;
use occupancy::MapFileContent;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use tracing::{info, warn};

impl AlignService {
    /// A map from the bus; in a new generation of it the last one comes again.
    pub(super) fn handle_map_sample(&mut self, sample: &CheckedSample<topics::SlamMap>) -> Result<(), Failure> {
        let identity = [sample.bytes().header().epoch, sample.content_hash()];
        if self.last_sample_of_map == Some(identity) {
            return Ok(());
        }
        let map = RobotMap::of_archive(&sample.view())?;
        self.last_sample_of_map = Some(identity);
        self.take_map(map)
    }

    /// A newer map of the robot: followed at once, searched later.
    fn take_map(&mut self, map: RobotMap) -> Result<(), Failure> {
        let begun = Instant::now();
        self.map = Some(Arc::new(map));
        self.pending.search = true;
        self.pending.wanted_comparison += 1;
        self.follow();
        let elapsed_us = u64::try_from(begun.elapsed().as_micros()).unwrap_or(u64::MAX);
        info!(service = "slam-align", state = self.follower.state().name(), elapsed_us, "map followed");
        self.publish()
    }

    /// Takes the map of a file, and asks for a search of its pose; the number of the search. The map is on disk when this
    /// returns.
    ///
    /// # Errors
    /// A map that cannot be used or stored, no site to compare it with: the map before it stays.
    pub(super) fn read_map(&mut self, file: PathBuf) -> Result<u64, Failure> {
        self.check_inputs()?;
        let (map, content) = RobotMap::read(&file)?;
        self.store(file, &map, &content)?;
        self.take_map(map)?;
        self.ask_for_search(self.search_area())
    }

    fn store(&mut self, file: PathBuf, map: &RobotMap, content: &MapFileContent) -> Result<(), Failure> {
        let content_hash = map.content_hash;
        let stored = StoredMap { file, content_hash, configured: self.config.map.clone() };
        let written = self.maps.write(content_hash, content).map_err(Failure::from);
        let written = written
            .and_then(|()| self.persist(|persisted| (persisted.stored_map, persisted.map) = (Some(stored), None)));
        self.maps.keep_only(self.persisted.stored_map.as_ref().map(|stored| stored.content_hash));
        written
    }

    /// Reads the map of the last request or of the configuration, whichever came last; of a file that has gone since, its
    /// copy.
    pub(super) fn read_first_map(&mut self) -> Result<(), Failure> {
        let configured = self.config.map.clone();
        match (self.persisted.stored_map.clone(), self.persisted.map.clone()) {
            (Some(stored), _) if stored.configured == configured || configured.is_none() => {
                let map = if configured.as_ref() == Some(&stored.file) {
                    self.read_configured_or_copy(&stored)?
                } else {
                    self.maps.read(stored.content_hash)?
                };
                self.take_map(map)
            }
            (_, requested) => match requested.or(configured) {
                Some(file) => self.read_and_store(&file).and_then(|map| self.take_map(map)),
                None => Ok(()),
            },
        }
    }

    /// The configured map as it is now; its copy, if the file can no longer be used.
    fn read_configured_or_copy(&mut self, stored: &StoredMap) -> Result<RobotMap, Failure> {
        self.read_and_store(&stored.file).or_else(|why| {
            let error = daemon::chain(why.as_ref());
            warn!(service = "slam-align", error, "the map file cannot be read: its copy is used");
            Ok(self.maps.read(stored.content_hash)?)
        })
    }

    fn read_and_store(&mut self, file: &Path) -> Result<RobotMap, Failure> {
        let (map, content) = RobotMap::read(file)?;
        self.store(file.to_owned(), &map, &content)?;
        Ok(map)
    }
}
