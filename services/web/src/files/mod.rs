//! A site from an output folder of `groundplan convert`: one date, or a folder for each change.
//!
//! What is served is what the manifests list, byte by byte; when the folder has changed it is read again, and what was of the
//! maps before is refused.

mod checked_folder;
mod folder;
mod map_image;
mod maps;

pub(crate) use maps::Maps;

use crate::documents::TasksDocument;
use crate::question::Question;
use crate::source::{Bytes, ContentName, Source, SourceError, TileAddress, locked};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};

/// Serves an output folder.
pub(crate) struct SiteOfFiles {
    folder: PathBuf,
    tasks: Option<Arc<TasksDocument>>,
    maps: Mutex<Arc<Maps>>,
}

impl SiteOfFiles {
    /// Of an output folder, and the tasks of its schedule.
    ///
    /// # Errors
    /// A folder without maps, or with files that are not those of groundplan.
    pub(crate) fn open(folder: &Path, tasks: Option<TasksDocument>) -> Result<Self, SourceError> {
        let tasks = tasks.map(Arc::new);
        let maps = Mutex::new(Arc::new(Maps::open(folder, tasks.clone())?));
        Ok(Self { folder: folder.to_owned(), tasks, maps })
    }

    /// The maps that are in the folder now.
    ///
    /// # Errors
    /// The folder has changed, and holds no maps that can be read.
    pub(crate) fn maps(&self) -> Result<Arc<Maps>, SourceError> {
        let mut maps = locked(&self.maps);
        if !maps.is_current() {
            *maps = Arc::new(Maps::open(&self.folder, self.tasks.clone())?);
            tracing::info!(service = "groundplan-web", folder = %self.folder.display(), "the maps have changed");
        }
        Ok(Arc::clone(&maps))
    }

    /// Answers from the maps of one moment: where they change meanwhile, from those behind.
    fn of_one_moment<T>(&self, ask: impl Fn(&Maps) -> Result<T, SourceError>) -> Result<T, SourceError> {
        let maps = self.maps()?;
        match ask(&maps) {
            Err(_) if !maps.is_current() => ask(&*self.maps()?),
            answer => answer,
        }
    }
}

impl Source for SiteOfFiles {
    fn site(&self) -> Result<Bytes, SourceError> {
        self.of_one_moment(Maps::site)
    }

    fn calendar(&self) -> Result<Bytes, SourceError> {
        self.of_one_moment(Maps::calendar)
    }

    fn date(&self, key: &str) -> Result<Option<Bytes>, SourceError> {
        self.of_one_moment(|maps| maps.date(key))
    }

    fn tasks(&self) -> Result<Bytes, SourceError> {
        self.of_one_moment(Maps::tasks)
    }

    fn summary(&self, key: &str) -> Result<Option<Bytes>, SourceError> {
        self.of_one_moment(|maps| maps.summary(key))
    }

    fn tile(&self, address: &TileAddress) -> Result<Option<Bytes>, SourceError> {
        self.of_one_moment(|maps| maps.tile(address))
    }

    fn model(&self, name: &ContentName) -> Result<Option<Bytes>, SourceError> {
        self.of_one_moment(|maps| maps.model(name))
    }

    fn answer(&self, question: &Question) -> Result<Bytes, SourceError> {
        self.of_one_moment(|maps| maps.answer(question))
    }
}

#[cfg(test)]
pub(crate) mod tests;
