//! The output folder: its manifests, and which of its files are shown as what.

use super::checked_folder::{CheckedFolder, FileStamp};
use crate::documents::{DateHead, DateStop, Published, SiteHead, Storey, StoreyAtDate};
use crate::source::{ContentName, SourceError, TilesOfGrid};
use crate::tiles::{Layer, TileGrid};
use messages::ContentId;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The file that lists the others.
const MANIFEST: &str = "manifest.json";

/// An output folder as it was when its manifests were read.
pub(super) struct MapsFolder {
    /// Its files.
    pub(super) files: CheckedFolder,
    /// The dates, in their order; at least one.
    pub(super) dates: Vec<DatedMaps>,
    /// Names these manifests: others have another one.
    pub(super) name: String,
    /// The manifests, by which it is seen that they are others.
    stamps: Vec<(PathBuf, FileStamp)>,
}

/// A layer of a storey.
pub(crate) struct MapFile {
    /// The file in the folder.
    pub(super) path: String,
    /// The storey.
    pub(crate) storey: Storey,
    /// Which layer.
    pub(crate) layer: Layer,
}

/// The maps of a date.
pub(super) struct DatedMaps {
    /// Begins the paths of its files.
    prefix: String,
    manifest: Manifest,
    head_of_site: SiteHead,
}

/// `manifest.json` of a folder for each change.
#[derive(Deserialize)]
struct DatesManifest {
    dates: Vec<DatedFolder>,
}

#[derive(Deserialize)]
struct DatedFolder {
    directory: String,
    plan_time: String,
    valid_until: Option<String>,
}

/// The sums of `manifest.json`.
#[derive(Deserialize)]
struct Sums {
    files: BTreeMap<String, String>,
}

/// `manifest.json`, as far as the page needs it.
#[derive(Deserialize)]
struct Manifest {
    plan_time: Option<String>,
    valid_until: Option<String>,
    storeys: Vec<StoreyOfManifest>,
}

#[derive(Deserialize)]
struct StoreyOfManifest {
    #[serde(flatten)]
    storey: Storey,
    status: String,
    directory: String,
}

impl MapsFolder {
    /// Reads the manifests.
    ///
    /// # Errors
    /// See [`SourceError`].
    pub(super) fn open(folder: &Path) -> Result<Self, SourceError> {
        let no_maps = || SourceError::NoMaps { folder: folder.to_owned() };
        if !folder.join(MANIFEST).exists() {
            return Err(no_maps());
        }
        let mut files = CheckedFolder::open(folder)?;
        let (bytes, stamp) = files.read_unlisted(MANIFEST)?;
        let path = folder.join(MANIFEST);
        let manifest: Value = json_of(&path, &bytes)?;
        if manifest.get("dates").is_none() && manifest.get("storeys").is_none() {
            return Err(no_maps());
        }
        files.list(parsed::<Sums>(&path, manifest.clone())?.files);
        let mut stamps = vec![(path.clone(), stamp)];
        let dates = if manifest.get("dates").is_some() {
            let manifest: DatesManifest = parsed(&path, manifest)?;
            let dated = |date| DatedMaps::open(&files, date, &mut stamps);
            manifest.dates.iter().map(dated).collect::<Result<_, _>>()?
        } else {
            vec![DatedMaps::of(String::new(), &path, manifest)?]
        };
        if dates.is_empty() {
            return Err(no_maps());
        }
        // The manifest has the sums of those of the dates.
        let name = ContentId::of(&bytes).short().to_string();
        Ok(Self { files, dates, name, stamps })
    }

    /// True if the manifests are still those that were read.
    pub(super) fn is_current(&self) -> bool {
        self.stamps.iter().all(|(path, stamp)| FileStamp::of(path) == Some(*stamp))
    }

    /// What the manifests say of the site; the last one has all that is ever built.
    pub(super) fn head(&self) -> SiteHead {
        self.dates[self.dates.len() - 1].head_of_site.clone()
    }

    /// The key of the date with this number.
    pub(super) fn key(&self, number: usize) -> String {
        format!("{number}-{}", self.name)
    }

    /// The dates that can be shown.
    pub(super) fn stops(&self) -> Vec<DateStop> {
        let stop = |(number, date): (usize, &DatedMaps)| DateStop {
            key: Some(self.key(number)),
            at: date.manifest.plan_time.clone(),
            until: date.manifest.valid_until.clone(),
        };
        self.dates.iter().enumerate().map(stop).collect()
    }

    /// Files of all layers by the names of their tiles.
    pub(super) fn layers(&self, tiles: &TileGrid) -> BTreeMap<ContentName, MapFile> {
        let of_storey = |date, storey| {
            let layers = Self::layers_of(self, date, storey, tiles);
            layers.map(|(layer, path, name)| (name, MapFile { path, storey: storey.storey.clone(), layer }))
        };
        self.dates.iter().flat_map(|date| date.manifest.storeys.iter().flat_map(move |s| of_storey(date, s))).collect()
    }

    /// Files of all models by their content.
    pub(super) fn models(&self) -> BTreeMap<ContentName, String> {
        self.dates.iter().filter_map(|date| date.model(&self.files)).collect()
    }

    /// The head of the document of a date.
    pub(super) fn head_at(&self, number: usize, tiles: &TileGrid) -> DateHead {
        let date = &self.dates[number];
        let storey = |storey: &StoreyOfManifest| StoreyAtDate {
            index: storey.storey.index,
            status: storey.status.clone(),
            layers: self.layers_of(date, storey, tiles).map(|(layer, _, name)| (layer.name(), name)).collect(),
        };
        DateHead {
            key: self.key(number),
            at: date.manifest.plan_time.clone(),
            until: date.manifest.valid_until.clone(),
            storeys: date.manifest.storeys.iter().map(storey).collect(),
            model: date.model(&self.files).map(|(name, _)| name),
        }
    }

    /// Layers of a storey that the manifest lists, with their paths and the names of their tiles.
    fn layers_of(
        &self,
        date: &DatedMaps,
        storey: &StoreyOfManifest,
        tiles: &TileGrid,
    ) -> impl Iterator<Item = (Layer, String, ContentName)> {
        Layer::ALL.into_iter().filter_map(move |layer| {
            let file = match layer {
                Layer::Semantic => "classes.png".to_owned(),
                layer => format!("{}.pgm", layer.name()),
            };
            let path = format!("{}{}/{file}", date.prefix, storey.directory);
            let sum = self.files.sum(&path)?;
            let extent = storey.storey.extent();
            let place = TilesOfGrid { tiles, extent: &extent, resolution_m: date.head_of_site.resolution_m };
            Some((layer, path, ContentName::of_tiles(layer, storey.storey.index, sum.as_bytes(), &place)))
        })
    }
}

impl DatedMaps {
    /// Reads the manifest of a date, which is of the date under which it is listed.
    fn open(
        files: &CheckedFolder,
        date: &DatedFolder,
        stamps: &mut Vec<(PathBuf, FileStamp)>,
    ) -> Result<Self, SourceError> {
        let prefix = format!("{}/", date.directory);
        let name = format!("{prefix}{MANIFEST}");
        let path = files.path().join(&name);
        let (bytes, stamp) = files.read(&name)?;
        stamps.push((path.clone(), stamp));
        let maps = Self::of(prefix, &path, json_of(&path, &bytes)?)?;
        let Manifest { plan_time, valid_until, .. } = &maps.manifest;
        if (plan_time.as_ref(), valid_until) != (Some(&date.plan_time), &date.valid_until) {
            let at = plan_time.as_deref().unwrap_or("no date");
            let what = format!("is of {at}, and is listed as of {}", date.plan_time);
            return Err(SourceError::Altered { path, what });
        }
        Ok(maps)
    }

    fn of(prefix: String, path: &Path, manifest: Value) -> Result<Self, SourceError> {
        let wrong = |source| SourceError::Json { path: path.to_owned(), source };
        let head_of_site = SiteHead::of_manifest(&manifest).map_err(wrong)?;
        Ok(Self { manifest: parsed(path, manifest)?, prefix, head_of_site })
    }

    /// `semantic.json`.
    ///
    /// # Errors
    /// See [`SourceError`].
    pub(super) fn semantic(&self, files: &CheckedFolder) -> Result<Value, SourceError> {
        self.json(files, "semantic.json")
    }

    /// `waypoints.json`.
    ///
    /// # Errors
    /// See [`SourceError`]; waypoints of another date.
    pub(super) fn waypoints(&self, files: &CheckedFolder) -> Result<Value, SourceError> {
        let waypoints = self.json(files, "waypoints.json")?;
        if waypoints["plan_time"].as_str() != self.manifest.plan_time.as_deref() {
            let path = files.path().join(format!("{}waypoints.json", self.prefix));
            return Err(SourceError::Altered { path, what: "is of another date than manifest.json".to_owned() });
        }
        Ok(waypoints)
    }

    /// The documents that its own is made of.
    ///
    /// # Errors
    /// See [`SourceError`]; waypoints of another date.
    pub(super) fn published(&self, files: &CheckedFolder) -> Result<Published, SourceError> {
        Ok(Published {
            semantic: self.semantic(files)?,
            waypoints: self.waypoints(files)?,
            site_graph: self.json(files, "site-graph.json")?,
            report: self.json(files, "report.json")?,
        })
    }

    fn json(&self, files: &CheckedFolder, name: &str) -> Result<Value, SourceError> {
        let path = format!("{}{name}", self.prefix);
        let (bytes, _) = files.read(&path)?;
        json_of(&files.path().join(&path), &bytes)
    }

    fn model(&self, files: &CheckedFolder) -> Option<(ContentName, String)> {
        let path = format!("{}world/site.glb", self.prefix);
        Some((ContentName::of_parts(&[files.sum(&path)?.as_bytes()]), path))
    }
}

fn json_of(path: &Path, bytes: &[u8]) -> Result<Value, SourceError> {
    serde_json::from_slice(bytes).map_err(|source| SourceError::Json { path: path.to_owned(), source })
}

fn parsed<T: DeserializeOwned>(path: &Path, value: Value) -> Result<T, SourceError> {
    serde_json::from_value(value).map_err(|source| SourceError::Json { path: path.to_owned(), source })
}
