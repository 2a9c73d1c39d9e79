//! The source of the page's documents: files, or the running daemons.

use crate::question::Question;
use crate::tiles::{Extent, Layer, TileGrid, TilePlace};
use answers::FindError;
use messages::{ContentId, ShortContentId};
use serde::Serialize;
use std::fmt;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The bytes of a document, shared by all viewers.
pub(crate) type Bytes = Arc<[u8]>;

/// A document as JSON.
pub(crate) fn json(document: &impl Serialize) -> Bytes {
    serde_json::to_vec(document).expect("keys are texts, and numbers are finite").into()
}

/// What a lock guards, also after a panic of another thread: values are replaced whole.
pub(crate) fn locked<T>(kept: &Mutex<T>) -> MutexGuard<'_, T> {
    kept.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What names a picture or a model: the same content has the same name, whatever the date, and another content another one, so that a
/// browser may keep what it has under this name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub(crate) struct ContentName(ShortContentId);

impl ContentName {
    /// The name in an address.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        text.parse().ok().map(Self)
    }

    /// Of all that a content is made of, and of this version, which makes it.
    pub(crate) fn of_parts(parts: &[&[u8]]) -> Self {
        let version = env!("CARGO_PKG_VERSION").as_bytes();
        Self(ContentId::of_parts([version].into_iter().chain(parts.iter().copied())).short())
    }

    /// Of the tiles of a layer: `cells` is a hash of its cells; their colours, and where the tiles of the site lie, are in it.
    pub(crate) fn of_tiles(layer: Layer, storey: u32, cells: &[u8], place: &TilesOfGrid<'_>) -> Self {
        let TilesOfGrid { tiles, extent, resolution_m } = place;
        let numbers = [extent.origin_m, tiles.origin_m, [*resolution_m, 0.0]].map(|pair| pair.map(f64::to_le_bytes));
        let sizes = [extent.size_cells, [tiles.size, tiles.levels], [storey, layer as u32]];
        let sizes = sizes.map(|pair| pair.map(u32::to_le_bytes));
        let colours = layer.palette().as_flattened();
        Self::of_parts(&[cells, numbers.as_flattened().as_flattened(), sizes.as_flattened().as_flattened(), colours])
    }
}

impl fmt::Display for ContentName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// Where the cells of a grid lie in the tiles of its site.
#[derive(Debug, Clone, Copy)]
pub(crate) struct TilesOfGrid<'a> {
    /// The tiles of the site.
    pub(crate) tiles: &'a TileGrid,
    /// The cells of the grid.
    pub(crate) extent: &'a Extent,
    /// Metres per cell.
    pub(crate) resolution_m: f64,
}

/// A tile of a layer of a storey.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct TileAddress {
    /// Index of the map storey.
    pub(crate) storey: u32,
    /// Which layer.
    pub(crate) layer: Layer,
    /// Its content.
    pub(crate) name: ContentName,
    /// Which tile of it.
    pub(crate) place: TilePlace,
}

/// Where documents come from. What is not there is `None`.
pub(crate) trait Source: Send + Sync {
    /// Storeys, elements, spaces and dates.
    ///
    /// # Errors
    /// See [`SourceError`].
    fn site(&self) -> Result<Bytes, SourceError>;

    /// When states change, by element and space.
    ///
    /// # Errors
    /// See [`SourceError`].
    fn calendar(&self) -> Result<Bytes, SourceError>;

    /// What holds at a date, by the key that `site` gives it.
    ///
    /// # Errors
    /// See [`SourceError`].
    fn date(&self, key: &str) -> Result<Option<Bytes>, SourceError>;

    /// The tasks of the schedule.
    ///
    /// # Errors
    /// See [`SourceError`].
    fn tasks(&self) -> Result<Bytes, SourceError>;

    /// Areas and tasks of a date, counted, by the key that `site` gives it.
    ///
    /// # Errors
    /// See [`SourceError`].
    fn summary(&self, key: &str) -> Result<Option<Bytes>, SourceError>;

    /// A picture of a layer.
    ///
    /// # Errors
    /// See [`SourceError`].
    fn tile(&self, address: &TileAddress) -> Result<Option<Bytes>, SourceError>;

    /// What stands at a date, as a binary glTF.
    ///
    /// # Errors
    /// See [`SourceError`].
    fn model(&self, name: &ContentName) -> Result<Option<Bytes>, SourceError>;

    /// The answer to a question about the site at the date that it shows.
    ///
    /// # Errors
    /// See [`SourceError`].
    fn answer(&self, question: &Question) -> Result<Bytes, SourceError>;
}

/// Why there are no documents.
#[derive(Debug, thiserror::Error)]
pub(crate) enum SourceError {
    /// A file that cannot be read.
    #[error("{} cannot be read", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file of another layout.
    #[error("{} is no such file of groundplan", path.display())]
    Json {
        /// The file.
        path: PathBuf,
        /// Why.
        source: serde_json::Error,
    },
    /// A file that is not the one that was written with the manifest.
    #[error("{} {what}: write the maps anew with groundplan convert, or copy their folder again", path.display())]
    Altered {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// A date of maps that are gone.
    #[error("the maps in {} have changed since: load the page again", folder.display())]
    Changed {
        /// The folder.
        folder: PathBuf,
    },
    /// A picture of another size or kind.
    #[error("{}: {what}", path.display())]
    Picture {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// The daemons have not published a whole set of maps.
    #[error("the daemons have no maps yet")]
    NotYet,
    /// Samples or options that cannot be used.
    #[error("the maps of the daemons cannot be shown")]
    Live(#[source] Box<dyn std::error::Error + Send + Sync>),
    /// A name in a question that stands for nothing, or for several things.
    #[error(transparent)]
    Unknown(#[from] FindError),
    /// A question that takes more than an output folder holds.
    #[error("an output folder holds no model to answer from: ask the client, {command}")]
    NotHeld {
        /// The command that answers.
        command: String,
    },
    /// A folder without maps.
    #[error("{} holds no maps: groundplan convert writes them", folder.display())]
    NoMaps {
        /// The folder.
        folder: PathBuf,
    },
}
