//! The copy of a map file in the state folder: the file may go, the map stays.

use crate::robot_map::{RobotMap, RobotMapError};
use daemon::write_durably;
use occupancy::{MapFileContent, OccupancyMap};
use serde::{Deserialize, Serialize};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Copies are named by the content of the map, so that the state names one that is whole. They are the files as the robot
/// saved them, which every version of this program reads.
const PREFIX: &str = "slam-map-";
const SUFFIXES: [&str; 2] = ["image", "yaml"];

/// A map of which there is a copy.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct StoredMap {
    /// The file that it was read from.
    pub(crate) file: PathBuf,
    /// Content hash.
    pub(crate) content_hash: u64,
}

/// Copies of map files.
#[derive(Debug)]
pub(crate) struct MapStore {
    folder: PathBuf,
}

/// A copy that cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum MapStoreError {
    #[error("the copy of the robot's map {} cannot be written", path.display())]
    Write { path: PathBuf, source: io::Error },
    #[error("the copy of the robot's map {} cannot be read: give the map again with groundplan slam-map", path.display())]
    Read { path: PathBuf, source: io::Error },
    #[error("the copy of the robot's map {} is damaged: give the map again with groundplan slam-map", path.display())]
    Damaged { path: PathBuf, source: Box<RobotMapError> },
}

impl MapStore {
    /// The copies in a state folder.
    pub(crate) fn at(state: &Path) -> Self {
        Self { folder: state.to_owned() }
    }

    /// Writes a copy; on disk when this returns.
    ///
    /// # Errors
    /// The file system refuses.
    pub(crate) fn write(&self, content_hash: u64, content: &MapFileContent) -> Result<(), MapStoreError> {
        let [image, description] = self.paths(content_hash);
        fs::create_dir_all(&self.folder)
            .map_err(|source| MapStoreError::Write { path: self.folder.clone(), source })?;
        for (path, bytes) in [(image, &content.image[..]), (description, content.description.as_bytes())] {
            write_durably(&path, bytes).map_err(|source| MapStoreError::Write { path, source })?;
        }
        Ok(())
    }

    /// Reads the copy of the map with this content.
    ///
    /// # Errors
    /// A copy that is missing or damaged.
    pub(crate) fn read(&self, content_hash: u64) -> Result<RobotMap, MapStoreError> {
        let [image, description] = self.paths(content_hash);
        let bytes = fs::read(&image).map_err(|source| MapStoreError::Read { path: image, source })?;
        let path = || description.clone();
        let text = fs::read_to_string(&description).map_err(|source| MapStoreError::Read { path: path(), source })?;
        let map = OccupancyMap::parse(&text, &bytes).map_err(RobotMapError::from).and_then(RobotMap::of);
        map.map_err(|source| MapStoreError::Damaged { path: path(), source: Box::new(source) })
    }

    /// Removes all copies but these, and what is left of a failed one.
    pub(crate) fn keep_only(&self, content_hashes: &[u64]) {
        let copies: Vec<PathBuf> = content_hashes.iter().flat_map(|hash| self.paths(*hash)).collect();
        let is_needed = |path: &PathBuf| copies.contains(path);
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let is_copy = |path: &PathBuf| {
            path.file_name().and_then(|name| name.to_str()).is_some_and(|name| name.starts_with(PREFIX))
        };
        for path in entries.map(|entry| entry.path()).filter(|path| is_copy(path) && !is_needed(path)) {
            // What cannot be removed is named by no state, and does no harm.
            let _ = fs::remove_file(path);
        }
    }

    /// Image and description.
    fn paths(&self, content_hash: u64) -> [PathBuf; 2] {
        SUFFIXES.map(|suffix| self.folder.join(format!("{PREFIX}{content_hash:016x}.{suffix}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_copy_outlives_the_files_of_the_robot_and_the_copy_before_it() {
        let home = tempfile::tempdir().unwrap();
        let state = home.path().join("state");
        fs::create_dir(&state).unwrap();
        let (yaml, image) = (home.path().join("robot.yaml"), home.path().join("robot.pgm"));
        fs::write(&yaml, "image: robot.pgm\nresolution: 0.05\norigin: [1.0, 2.0, 0.5]\n").unwrap();
        fs::write(&image, b"P5\n3 2\n255\n\x00\xfe\xcd\xfe\xfe\x00").unwrap();
        let store = MapStore::at(&state);
        let (map, content) = RobotMap::read(&yaml).unwrap();
        store.write(1, &content).unwrap();
        store.write(map.content_hash, &content).unwrap();
        fs::write(state.join("alignment.json"), "{}").unwrap();
        fs::remove_file(&yaml).unwrap();
        fs::remove_file(&image).unwrap();
        store.keep_only(&[map.content_hash]);
        assert_eq!(store.read(map.content_hash).unwrap().map, map.map);
        assert!(matches!(store.read(1), Err(MapStoreError::Read { .. })));
        store.keep_only(&[]);
        assert!(matches!(store.read(map.content_hash), Err(MapStoreError::Read { .. })));
        assert!(state.join("alignment.json").exists(), "only copies are removed");
    }

    #[test]
    fn nothing_of_a_copy_that_cannot_be_written_stays() {
        let home = tempfile::tempdir().unwrap();
        let content = MapFileContent { description: String::new(), image: vec![0; 4] };
        let store = MapStore::at(home.path());
        fs::create_dir(home.path().join("slam-map-0000000000000007.yaml")).unwrap();
        assert!(matches!(store.write(7, &content), Err(MapStoreError::Write { .. })));
        fs::remove_dir(home.path().join("slam-map-0000000000000007.yaml")).unwrap();
        store.keep_only(&[]);
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 0);
    }
}
