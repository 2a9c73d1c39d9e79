//! A site from an output folder of `groundplan convert`: one date, or a folder for each change.
//!
//! Requests name a date, a storey or a hash, never a path: the paths are those that the manifests list.

mod folder;
mod map_image;

use crate::documents::{Calendar, DateDocument, SiteDocument, SiteHead};
use crate::source::{Bytes, ContentName, Source, SourceError, TileAddress, json, locked};
use crate::tiles::{LayerCells, TileGrid};
use folder::{MapFile, MapsFolder};
use map_image::MapImage;
use std::collections::{BTreeMap, VecDeque};
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock};

/// Pictures of layers that are kept decoded, in pixels: those of the storey that is looked at, and of the dates beside.
const MAX_KEPT_PIXELS: usize = 48 << 20;
/// Documents of dates that are kept, in bytes.
const MAX_KEPT_DATES: usize = 24 << 20;

/// Serves an output folder.
pub(crate) struct SiteOfFiles {
    folder: MapsFolder,
    head: SiteHead,
    tiles: TileGrid,
    site: OnceLock<Bytes>,
    calendar: OnceLock<Bytes>,
    dates: Mutex<Kept<String, Bytes>>,
    images: Mutex<Kept<ContentName, Arc<MapImage>>>,
}

impl SiteOfFiles {
    /// Of an output folder.
    ///
    /// # Errors
    /// A folder without maps, or with files that are not those of groundplan.
    pub(crate) fn open(folder: &Path) -> Result<Self, SourceError> {
        let folder = MapsFolder::open(folder)?;
        let head = folder.head();
        let tiles = head.tiles();
        Ok(Self {
            folder,
            head,
            tiles,
            site: OnceLock::new(),
            calendar: OnceLock::new(),
            dates: Mutex::new(Kept::of(MAX_KEPT_DATES)),
            images: Mutex::new(Kept::of(MAX_KEPT_PIXELS)),
        })
    }

    /// The tiles of all storeys.
    pub(crate) fn tiles(&self) -> TileGrid {
        self.tiles
    }

    /// What the manifests say of the site.
    pub(crate) fn head(&self) -> &SiteHead {
        &self.head
    }

    /// Keys of all dates, in their order.
    pub(crate) fn keys(&self) -> impl Iterator<Item = String> + use<> {
        (0..self.folder.dates.len()).map(|date| date.to_string())
    }

    /// Every layer that there is, once, with the storey that it is of.
    pub(crate) fn layers(&self) -> &BTreeMap<ContentName, MapFile> {
        &self.folder.layers
    }

    /// Every model that there is, once.
    pub(crate) fn models(&self) -> impl Iterator<Item = &ContentName> {
        self.folder.models.keys()
    }

    fn image(&self, name: &ContentName, file: &MapFile) -> Result<Arc<MapImage>, SourceError> {
        if let Some(image) = locked(&self.images).get(name) {
            return Ok(image);
        }
        let image = Arc::new(MapImage::read(&file.path, file.storey.size_cells)?);
        locked(&self.images).insert(name.clone(), Arc::clone(&image), image.n_pixels());
        Ok(image)
    }
}

impl Source for SiteOfFiles {
    fn site(&self) -> Result<Bytes, SourceError> {
        made_once(&self.site, || {
            let semantic = self.folder.dates.last().map(|date| date.semantic()).transpose()?.unwrap_or_default();
            Ok(json(&SiteDocument::of(&self.head, &self.folder.stops(), semantic)))
        })
    }

    fn calendar(&self) -> Result<Bytes, SourceError> {
        made_once(&self.calendar, || {
            let mut calendar = Calendar::default();
            for (number, date) in self.folder.dates.iter().enumerate() {
                calendar.add(number, &date.semantic()?);
            }
            Ok(json(&calendar))
        })
    }

    fn date(&self, key: &str) -> Result<Option<Bytes>, SourceError> {
        let key = key.to_owned();
        if let Some(document) = locked(&self.dates).get(&key) {
            return Ok(Some(document));
        }
        let Some(date) = key.parse().ok().and_then(|number: usize| self.folder.dates.get(number)) else {
            return Ok(None);
        };
        let document = json(&DateDocument::of(date.head(key.clone()), date.published()?));
        locked(&self.dates).insert(key, Arc::clone(&document), document.len());
        Ok(Some(document))
    }

    fn tile(&self, address: &TileAddress) -> Result<Option<Bytes>, SourceError> {
        let file = self.folder.layers.get(&address.name);
        let Some(file) = file.filter(|file| (file.storey.index, file.layer) == (address.storey, address.layer)) else {
            return Ok(None);
        };
        let image = self.image(&address.name, file)?;
        let extent = file.storey.extent();
        let cells = LayerCells {
            layer: file.layer,
            extent,
            offset: self.tiles.offset(&extent, self.head.resolution_m),
            strength: &|column, row| image.strength(file.layer, column, row),
        };
        Ok(cells.tile(&self.tiles, address.place).map(Bytes::from))
    }

    fn model(&self, name: &ContentName) -> Result<Option<Bytes>, SourceError> {
        self.folder.models.get(name).map(|path| folder::read(path).map(Bytes::from)).transpose()
    }
}

fn made_once(kept: &OnceLock<Bytes>, make: impl FnOnce() -> Result<Bytes, SourceError>) -> Result<Bytes, SourceError> {
    if let Some(bytes) = kept.get() {
        return Ok(Arc::clone(bytes));
    }
    let bytes = make()?;
    Ok(Arc::clone(kept.get_or_init(|| bytes)))
}

/// The newest of what was made, up to a size.
struct Kept<K, V> {
    max_size: usize,
    size: usize,
    entries: VecDeque<(K, V, usize)>,
}

impl<K: PartialEq, V: Clone> Kept<K, V> {
    fn of(max_size: usize) -> Self {
        Self { max_size, size: 0, entries: VecDeque::new() }
    }

    fn get(&self, key: &K) -> Option<V> {
        self.entries.iter().find(|(k, ..)| k == key).map(|(_, value, _)| value.clone())
    }

    /// Keeps a value and gives up the oldest ones; one that is larger than all may be is not kept.
    fn insert(&mut self, key: K, value: V, size: usize) {
        if size > self.max_size || self.get(&key).is_some() {
            return;
        }
        self.entries.push_back((key, value, size));
        self.size += size;
        while self.size > self.max_size {
            self.size -= self.entries.pop_front().map_or(0, |(_, _, size)| size);
        }
    }
}

#[cfg(test)]
pub(crate) mod tests;
