//! The copy of a map file in the state folder: the file may go, the map stays.

use crate::robot_map::{RobotMap, RobotMapError};
use daemon::state_files::SLAM_MAP_COPIES;
use daemon::{KeptFile, Save, joined};
use messages::ContentHash;
use occupancy::{MapFileContent, OccupancyMap};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// Copies are named by the content of the map, so that the state names one that is whole. They are the files as the robot
/// saved them.
const SUFFIXES: [&str; 2] = ["image", "yaml"];

/// A map of which there is a copy.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct StoredMap {
    /// The file that it was read from.
    pub(crate) file: PathBuf,
    /// Content hash.
    pub(crate) content_hash: ContentHash,
}

impl StoredMap {
    pub(crate) fn of(file: &Path, map: &RobotMap) -> Self {
        Self { file: file.to_owned(), content_hash: map.content_hash }
    }
}

/// Copies of map files.
#[derive(Debug, Clone)]
pub(crate) struct MapStore {
    folder: PathBuf,
}

/// A copy that cannot be read.
#[derive(Debug, thiserror::Error)]
pub(crate) enum MapStoreError {
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

    /// A copy, to be saved.
    pub(crate) fn saving(&self, content_hash: ContentHash, content: MapFileContent) -> [Save; 2] {
        let [image, description] = self.files(content_hash);
        [image.saving_anew(content.image), description.saving_anew(content.description.into_bytes())]
    }

    /// Reads the copy of the map with this content, with a sentence about what of it was damaged or removed, and is mended.
    ///
    /// # Errors
    /// A copy that is missing or damaged.
    pub(crate) fn read(&self, content_hash: ContentHash) -> Result<(RobotMap, Option<String>), MapStoreError> {
        let files = self.files(content_hash);
        let bytes = |file: &KeptFile| {
            let failed = |source| MapStoreError::Read { path: file.path(), source };
            file.load().and_then(|bytes| bytes.ok_or_else(|| io::ErrorKind::NotFound.into())).map_err(failed)
        };
        let [image, description] = [bytes(&files[0])?, bytes(&files[1])?];
        let path = || files[1].path();
        let failed = |_| MapStoreError::Read { path: path(), source: io::ErrorKind::InvalidData.into() };
        let text = String::from_utf8(description).map_err(failed)?;
        let map = OccupancyMap::parse(&text, &image).map_err(RobotMapError::from).and_then(RobotMap::of);
        let map = map.map_err(|source| MapStoreError::Damaged { path: path(), source: Box::new(source) })?;
        Ok((map, joined(files.iter().filter_map(KeptFile::finding))))
    }

    /// Removes all copies but these, and what is left of a failed one.
    pub(crate) fn keep_only(&self, content_hashes: &[ContentHash]) {
        let needed: Vec<String> = content_hashes.iter().flat_map(|hash| names(*hash)).collect();
        let entries = fs::read_dir(&self.folder).into_iter().flatten().flatten();
        let entries = entries.filter_map(|entry| entry.file_name().into_string().ok());
        let stem =
            |name: &str| [".sealed", ".next"].iter().find_map(|suffix| name.strip_suffix(suffix)).map(str::to_owned);
        let copies = entries.map(|name| stem(&name).unwrap_or(name));
        let copies: BTreeSet<String> = copies.filter(|name| name.starts_with(SLAM_MAP_COPIES)).collect();
        for name in copies.into_iter().filter(|name| !needed.contains(name)) {
            // What cannot be removed is named by no state, and does no harm.
            let _ = KeptFile::at(&self.folder, name).remove();
        }
    }

    /// Image and description.
    fn files(&self, content_hash: ContentHash) -> [KeptFile; 2] {
        names(content_hash).map(|name| KeptFile::at(&self.folder, name))
    }
}

fn names(content_hash: ContentHash) -> [String; 2] {
    SUFFIXES.map(|suffix| format!("{SLAM_MAP_COPIES}{content_hash}.{suffix}"))
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
        for hash in [ContentHash::from_bits(1), map.content_hash] {
            store.saving(hash, content.clone()).iter().for_each(|save| save.write().unwrap());
        }
        fs::write(state.join("alignment.json"), "{}").unwrap();
        fs::remove_file(&yaml).unwrap();
        fs::remove_file(&image).unwrap();
        store.keep_only(&[map.content_hash]);
        let read = || store.read(map.content_hash).unwrap();
        assert!(read().0.map == map.map && read().1.is_none());
        // One flipped bit of the image would be another wall.
        let copy = state.join(&names(map.content_hash)[0]);
        let mut bytes = fs::read(&copy).unwrap();
        *bytes.last_mut().unwrap() ^= 0x80;
        fs::write(&copy, bytes).unwrap();
        let (mended, finding) = read();
        assert!(mended.map == map.map && finding.unwrap().contains("damaged"));
        assert!(read().1.is_none(), "it is mended");
        assert!(matches!(store.read(ContentHash::from_bits(1)), Err(MapStoreError::Read { .. })));
        store.keep_only(&[]);
        assert!(matches!(store.read(map.content_hash), Err(MapStoreError::Read { .. })));
        assert!(state.join("alignment.json").exists(), "only copies are removed");
    }
}
