//! Maps of the robot: from the bus, from a file of a request, of the configuration, or from its copy in the state folder.

use super::AlignService;
use crate::robot_map::RobotMap;
use bus::{CheckedSample, topics};
use daemon::{Caller, Failure};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;
use tracing::info;

impl AlignService {
    /// A map from the bus; in a new generation of it the last one comes again.
    pub(super) fn handle_map_sample(&mut self, sample: &CheckedSample<topics::SlamMap>) -> Result<(), Failure> {
        let identity = (sample.bytes().header().epoch, sample.content_hash());
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
    pub(super) fn read_map(&mut self, file: &Path, by: Caller) -> Result<u64, Failure> {
        self.check_inputs()?;
        let map = self.map_setting.command(file, by.uid)?;
        self.take_map(map)?;
        self.ask_for_search(self.search_area())
    }

    /// Takes the map of a file that is in force, while there is no other.
    pub(super) fn take_first_map(&mut self) -> Result<(), Failure> {
        if self.map.is_some() {
            return Ok(());
        }
        self.map_setting.map()?.map_or(Ok(()), |map| self.take_map(map))
    }

    /// Takes the map that `site.toml` names, if it is another one than before.
    pub(super) fn follow_configured_map(&mut self) -> Result<(), Failure> {
        self.map_setting.edit(&self.config)?.map_or(Ok(()), |map| self.take_map(map))
    }

    /// Takes the map that `site.toml` names, if it could not be read before.
    pub(super) fn retry_configured_map(&mut self) -> Result<(), Failure> {
        self.map_setting.retry(&self.config)?.map_or(Ok(()), |map| self.take_map(map))
    }
}
