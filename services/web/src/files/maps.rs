//! The documents of an output folder as it was when its manifests were read.
//!
//! Requests name a date, a storey or a hash, never a path: the paths are those that the manifests list.

use super::folder::{DatedMaps, MapFile, MapsFolder};
use super::map_image::MapImage;
use crate::documents::{DateDocument, FreeCells, SiteDocument, SiteHead, SummaryDocument, TasksDocument, add_date};
use crate::kept::Kept;
use crate::question::Question;
use crate::source::{Bytes, ContentName, Source, SourceError, TileAddress, json, locked};
use crate::tiles::{Layer, LayerCells, TileGrid};
use answers::changes::Calendar;
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock};

/// Pictures of layers that are kept decoded, in pixels: those of the storey that is looked at, and of the dates beside.
const MAX_KEPT_PIXELS: usize = 48 << 20;
/// Documents of dates that are kept, in bytes.
const MAX_KEPT_DATE_BYTES: usize = 24 << 20;

/// The maps of a folder.
pub(crate) struct Maps {
    folder: MapsFolder,
    head: SiteHead,
    tiles: TileGrid,
    layers: BTreeMap<ContentName, MapFile>,
    models: BTreeMap<ContentName, String>,
    site: OnceLock<Bytes>,
    calendar: OnceLock<Bytes>,
    tasks: OnceLock<Arc<TasksDocument>>,
    dates: Mutex<Kept<usize, Bytes>>,
    summaries: Mutex<Kept<usize, Bytes>>,
    images: Mutex<Kept<ContentName, Arc<MapImage>>>,
}

impl Maps {
    /// Of an output folder, with the tasks of its schedule where they are known.
    ///
    /// # Errors
    /// A folder without maps, or with files that are not those of groundplan.
    pub(super) fn open(folder: &Path, tasks: Option<Arc<TasksDocument>>) -> Result<Self, SourceError> {
        let folder = MapsFolder::open(folder)?;
        let head = folder.head();
        let tiles = head.tiles();
        Ok(Self {
            layers: folder.layers(&tiles),
            models: folder.models(),
            folder,
            head,
            tiles,
            site: OnceLock::new(),
            calendar: OnceLock::new(),
            tasks: tasks.map(OnceLock::from).unwrap_or_default(),
            dates: Mutex::new(Kept::of(MAX_KEPT_DATE_BYTES)),
            summaries: Mutex::new(Kept::of(MAX_KEPT_DATE_BYTES)),
            images: Mutex::new(Kept::of(MAX_KEPT_PIXELS)),
        })
    }

    /// True if the manifests are still those that were read.
    pub(crate) fn is_current(&self) -> bool {
        self.folder.is_current()
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
    pub(crate) fn keys(&self) -> impl Iterator<Item = String> {
        (0..self.folder.dates.len()).map(|date| self.folder.key(date))
    }

    /// Every layer that there is, once, with the storey that it is of.
    pub(crate) fn layers(&self) -> &BTreeMap<ContentName, MapFile> {
        &self.layers
    }

    /// Every model that there is, once.
    pub(crate) fn models(&self) -> impl Iterator<Item = &ContentName> {
        self.models.keys()
    }

    /// The date with a key, and its number.
    fn dated(&self, key: &str) -> Result<Option<(usize, &DatedMaps)>, SourceError> {
        let Some((number, name)) = key.split_once('-') else { return Ok(None) };
        let Some(found) = number.parse().ok().and_then(|n: usize| Some((n, self.folder.dates.get(n)?))) else {
            return Ok(None);
        };
        if name != self.folder.name {
            return Err(SourceError::Changed { folder: self.folder.files.path().to_owned() });
        }
        Ok(Some(found))
    }

    /// The tasks that were given, or those of the elements.
    fn known_tasks(&self) -> Result<Arc<TasksDocument>, SourceError> {
        if let Some(tasks) = self.tasks.get() {
            return Ok(Arc::clone(tasks));
        }
        // The maps of the last date have all elements.
        let semantic = self.folder.dates.last().map(|date| date.semantic(&self.folder.files)).transpose()?;
        let tasks = Arc::new(TasksDocument::of_elements(&semantic.unwrap_or_default()));
        Ok(Arc::clone(self.tasks.get_or_init(|| tasks)))
    }

    fn image(&self, name: &ContentName, file: &MapFile) -> Result<Arc<MapImage>, SourceError> {
        if let Some(image) = locked(&self.images).get(name) {
            return Ok(image);
        }
        let (bytes, _) = self.folder.files.read(&file.path)?;
        let path = self.folder.files.path().join(&file.path);
        let image = Arc::new(MapImage::of(&path, &bytes, file.storey.size_cells)?);
        locked(&self.images).insert(*name, Arc::clone(&image), image.n_pixels());
        Ok(image)
    }
}

impl Source for Maps {
    fn site(&self) -> Result<Bytes, SourceError> {
        made_once(&self.site, || {
            let last = self.folder.dates.last();
            let published = last.map(|date| date.published(&self.folder.files)).transpose()?.unwrap_or_default();
            let stops = self.folder.stops();
            let document = SiteDocument::of(&self.head, &stops, published);
            let path = || self.folder.files.path().join("report.json");
            Ok(json(&document.map_err(|source| SourceError::Json { path: path(), source })?))
        })
    }

    fn calendar(&self) -> Result<Bytes, SourceError> {
        made_once(&self.calendar, || {
            let mut calendar = Calendar::default();
            for (number, date) in self.folder.dates.iter().enumerate() {
                let files = &self.folder.files;
                add_date(&mut calendar, number, &date.semantic(files)?, &date.waypoints(files)?);
            }
            Ok(json(&calendar))
        })
    }

    fn date(&self, key: &str) -> Result<Option<Bytes>, SourceError> {
        let Some((number, date)) = self.dated(key)? else { return Ok(None) };
        if let Some(document) = locked(&self.dates).get(&number) {
            return Ok(Some(document));
        }
        let published = date.published(&self.folder.files)?;
        let document = json(&DateDocument::of(self.folder.head_at(number, &self.tiles), published));
        locked(&self.dates).insert(number, Arc::clone(&document), document.len());
        Ok(Some(document))
    }

    fn tasks(&self) -> Result<Bytes, SourceError> {
        Ok(json(&*self.known_tasks()?))
    }

    fn summary(&self, key: &str) -> Result<Option<Bytes>, SourceError> {
        let Some((number, date)) = self.dated(key)? else { return Ok(None) };
        if let Some(document) = locked(&self.summaries).get(&number) {
            return Ok(Some(document));
        }
        let head = self.folder.head_at(number, &self.tiles);
        let mut free = FreeCells { resolution_m: self.head.resolution_m, ..FreeCells::default() };
        for storey in &head.storeys {
            let name = storey.layers.get(Layer::Planning.name());
            if let Some((name, file)) = name.and_then(|name| Some((name, self.layers.get(name)?))) {
                free.n_free.insert(storey.index, self.image(name, file)?.n_free());
            }
        }
        let published = date.published(&self.folder.files)?;
        let tasks = self.known_tasks()?;
        let document = json(&SummaryDocument::of(&published, &free, &tasks, head.at.as_deref()));
        locked(&self.summaries).insert(number, Arc::clone(&document), document.len());
        Ok(Some(document))
    }

    fn tile(&self, address: &TileAddress) -> Result<Option<Bytes>, SourceError> {
        let file = self.layers.get(&address.name);
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
        let path = self.models.get(name);
        path.map(|path| self.folder.files.read(path).map(|(bytes, _)| Bytes::from(bytes))).transpose()
    }

    fn answer(&self, question: &Question) -> Result<Bytes, SourceError> {
        let names = self.head.sources.as_array().into_iter().flatten().filter_map(|source| source["file"].as_str());
        Err(SourceError::NotHeld { command: question.command(&names.collect::<Vec<_>>().join(" ")) })
    }
}

fn made_once(kept: &OnceLock<Bytes>, make: impl FnOnce() -> Result<Bytes, SourceError>) -> Result<Bytes, SourceError> {
    if let Some(bytes) = kept.get() {
        return Ok(Arc::clone(bytes));
    }
    let bytes = make()?;
    Ok(Arc::clone(kept.get_or_init(|| bytes)))
}
