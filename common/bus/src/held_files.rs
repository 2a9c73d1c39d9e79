//! Files of a generation that must stay while the keeper holds it: one that is missing, or another, was deleted from
//! outside.

use crate::error::DomainError;
use crate::file_lock::{FileIdentity, Lock};
use crate::generation::Place;
use std::fs;
use std::path::PathBuf;

/// Segments of the services, and the one that counts nodes.
const SEGMENT_SUFFIXES: [&str; 2] = [".dynamic", ".global_mgmt"];

/// Files of a generation as they were when the keeper created or opened its services.
pub(crate) struct HeldFiles {
    generation: u64,
    files: Vec<(PathBuf, FileIdentity)>,
}

impl HeldFiles {
    /// The files of a generation whose services are held; `keeper_lock` is held too.
    pub(crate) fn of(place: &Place, generation: u64, keeper_lock: &Lock) -> Result<Self, DomainError> {
        let failed = |path: &PathBuf, source| DomainError::File { path: path.clone(), source };
        let mut paths = vec![place.root().to_owned(), place.folder_of(generation), place.lock_path(generation)];
        for suffix in SEGMENT_SUFFIXES {
            paths.extend(place.segments_of(generation, suffix)?);
        }
        let services = place.folder_of(generation).join("services");
        for entry in fs::read_dir(&services).map_err(|e| failed(&services, e))? {
            paths.push(entry.map_err(|e| failed(&services, e))?.path());
        }
        // The lock that is held counts, not what is at its path.
        let lock_path = place.keeper_lock_path();
        let mut files = vec![(lock_path.clone(), keeper_lock.identity().map_err(|e| failed(&lock_path, e))?)];
        for path in paths {
            // One that goes at this moment is missed at the first look.
            let identity =
                FileIdentity::at(&path)?.ok_or_else(|| failed(&path, std::io::ErrorKind::NotFound.into()))?;
            files.push((path, identity));
        }
        Ok(Self { generation, files })
    }

    /// The first file that was deleted or replaced, or that a participant misses.
    pub(crate) fn missing(&self, place: &Place) -> Result<Option<PathBuf>, DomainError> {
        for (path, identity) in &self.files {
            if FileIdentity::at(path)? != Some(*identity) {
                return Ok(Some(path.clone()));
            }
        }
        match place.current() {
            Ok(Some(generation)) if generation == self.generation => place.take_renewal_request(self.generation),
            Err(error @ DomainError::File { .. }) => Err(error),
            _ => Ok(Some(place.current_path())),
        }
    }
}
