//! Files of ifc-ingest in the state folder: the site in force, its map frame, its outline and the revisions.
//!
//! The frame and the outline are files of their own, because the cache of the site may be lost, or be of another version: a
//! robot is localised in the frame, and a revision is compared with the outline.

use crate::revisions::Revisions;
use daemon::{Failure, FileStamp, Save, StateError, StateFile, state_files};
use export::SiteFrameFile;
use ingest::SiteFrame;
use messages::{ArchiveBuffer, Checked, SiteOutline, payload};
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use tracing::warn;

/// The state of a site on disk.
pub(crate) struct SiteStore {
    revisions: StateFile,
    outline: StateFile,
    frame: StateFile,
    frame_path: PathBuf,
    cache: PathBuf,
}

impl SiteStore {
    /// The files in a state folder.
    ///
    /// # Errors
    /// The folder cannot be made.
    pub(crate) fn at(state: &Path) -> Result<Self, StateError> {
        Ok(Self {
            revisions: StateFile::at(state, state_files::REVISIONS)?,
            outline: StateFile::at(state, state_files::SITE_OUTLINE)?,
            frame: StateFile::at(state, state_files::SITE_FRAME)?,
            frame_path: state.join(state_files::SITE_FRAME),
            cache: state.join(state_files::SITE_CACHE),
        })
    }

    /// What an operator should know of the files: those that were damaged, or removed.
    pub(crate) fn findings(&self) -> impl Iterator<Item = &str> {
        [&self.revisions, &self.outline, &self.frame].into_iter().filter_map(StateFile::finding)
    }

    /// The revisions; `None` before the first.
    ///
    /// # Errors
    /// A file that cannot be used.
    pub(crate) fn revisions(&self) -> Result<Option<Revisions>, StateError> {
        self.revisions.load()
    }

    /// The revisions, to be saved.
    ///
    /// # Errors
    /// A path that is no UTF-8.
    pub(crate) fn saving_revisions(&self, revisions: &Revisions) -> Result<Save, StateError> {
        self.revisions.saving(revisions)
    }

    /// The outline of the site in force; `None` if none was kept, or it is damaged: it is made anew of the site.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn outline(&self) -> Result<Option<SiteOutline>, StateError> {
        self.outline.load_unless_damaged()
    }

    /// The map frame of the site; `None` before the first.
    ///
    /// # Errors
    /// A file that cannot be used: it is never replaced by another frame.
    pub(crate) fn frame(&self) -> Result<Option<SiteFrame>, Failure> {
        match self.frame.load::<SiteFrameFile>() {
            Ok(file) => Ok(file.map(|f| SiteFrame { map_from_world: f.motion(), frame_epoch: f.frame_epoch })),
            Err(StateError::Damaged { path, source }) => Err(format!(
                "the map frame {0} is damaged ({source}): restore it, or remove it and {0}.sealed to keep the frame of the site in \
                 force",
                path.display()
            )
            .into()),
            Err(why) => Err(why.into()),
        }
    }

    /// The file of the map frame.
    pub(crate) fn frame_path(&self) -> &Path {
        &self.frame_path
    }

    /// The frame of a site, to be saved.
    ///
    /// # Errors
    /// A frame that has no JSON.
    pub(crate) fn saving_frame(&self, site: &Checked<payload::Site>) -> Result<Save, StateError> {
        self.frame.saving(&SiteFrameFile::of(&site.view()))
    }

    /// What makes a site the one in force: until the last file is written, the one before it is.
    ///
    /// # Errors
    /// A path that is no UTF-8.
    pub(crate) fn saving(
        &self,
        site: &Arc<Checked<payload::Site>>,
        outline: &SiteOutline,
        revisions: &Revisions,
    ) -> Result<Vec<Save>, StateError> {
        let cache: Arc<dyn AsRef<[u8]> + Send + Sync> = Arc::<Checked<payload::Site>>::clone(site);
        Ok(vec![
            Save::derived(self.cache.clone(), cache),
            self.outline.saving(outline)?,
            self.saving_frame(site)?,
            self.saving_revisions(revisions)?,
        ])
    }

    /// The site in force, from its cache; one that is damaged, of another layout or of another revision is not used, and files are
    /// read anew.
    pub(crate) fn cached_site(&self, revisions: &Revisions) -> Option<Checked<payload::Site>> {
        if revisions.stamps.iter().all(Option::<FileStamp>::is_none) {
            return None;
        }
        let read = || -> Result<Checked<payload::Site>, Failure> {
            let mut file = std::fs::File::open(&self.cache)?;
            let mut buffer = ArchiveBuffer::zeroed(usize::try_from(file.metadata()?.len())?);
            file.read_exact(buffer.bytes_mut())?;
            let site = Checked::<payload::Site>::new(buffer)?;
            match revisions.site_hash {
                Some(hash) if hash != site.content_hash() => Err("it is of a revision that did not take effect".into()),
                _ => Ok(site),
            }
        };
        match read() {
            Ok(site) => Some(site),
            Err(why) => {
                let (path, error) = (self.cache.display(), daemon::chain(why.as_ref()));
                warn!(service = "ifc-ingest", %path, error, "the cache cannot be used; files are read anew");
                None
            }
        }
    }
}
