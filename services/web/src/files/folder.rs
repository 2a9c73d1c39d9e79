//! The output folder: its manifests, and where its files are.

use crate::documents::{DateHead, DateStop, Published, SiteHead, Storey, StoreyAtDate};
use crate::source::{ContentName, SourceError};
use crate::tiles::Layer;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Component, Path, PathBuf};

/// An output folder.
pub(super) struct MapsFolder {
    /// The dates, in their order; at least one.
    pub(super) dates: Vec<DatedMaps>,
    /// Files of layers by their content.
    pub(super) layers: BTreeMap<ContentName, MapFile>,
    /// Files of models by their content.
    pub(super) models: BTreeMap<ContentName, PathBuf>,
}

/// A layer of a storey.
pub(crate) struct MapFile {
    /// The file.
    pub(super) path: PathBuf,
    /// The storey.
    pub(crate) storey: Storey,
    /// Which layer.
    pub(crate) layer: Layer,
}

/// The maps of a date.
pub(super) struct DatedMaps {
    folder: PathBuf,
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
}

/// `manifest.json`, as far as the page needs it.
#[derive(Deserialize)]
struct Manifest {
    plan_time: Option<String>,
    valid_until: Option<String>,
    storeys: Vec<StoreyOfManifest>,
    files: BTreeMap<String, String>,
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
        let path = folder.join("manifest.json");
        let manifest: Value = if path.is_file() { json_of(&path)? } else { return Err(no_maps()) };
        let dates = if manifest.get("dates").is_some() {
            let manifest: DatesManifest = parsed(&path, manifest)?;
            let folders = manifest.dates.iter().map(|date| inside(folder, &date.directory).ok_or_else(no_maps));
            folders.map(|folder| DatedMaps::open(folder?)).collect::<Result<_, _>>()?
        } else if manifest.get("storeys").is_some() {
            vec![DatedMaps::of(folder.to_owned(), &path, manifest)?]
        } else {
            Vec::new()
        };
        if dates.is_empty() {
            return Err(no_maps());
        }
        let mut maps = Self { dates, layers: BTreeMap::new(), models: BTreeMap::new() };
        for date in &maps.dates {
            for (name, file) in date.layer_files() {
                maps.layers.insert(name, file);
            }
            maps.models.extend(date.model());
        }
        Ok(maps)
    }

    /// What the manifests say of the site; the last one has all that is ever built.
    pub(super) fn head(&self) -> SiteHead {
        self.dates[self.dates.len() - 1].head_of_site.clone()
    }

    /// The dates that can be shown.
    pub(super) fn stops(&self) -> Vec<DateStop> {
        let stop = |(number, date): (usize, &DatedMaps)| DateStop {
            key: Some(number.to_string()),
            at: date.manifest.plan_time.clone(),
            until: date.manifest.valid_until.clone(),
        };
        self.dates.iter().enumerate().map(stop).collect()
    }
}

impl DatedMaps {
    fn open(folder: PathBuf) -> Result<Self, SourceError> {
        let path = folder.join("manifest.json");
        let manifest = json_of(&path)?;
        Self::of(folder, &path, manifest)
    }

    fn of(folder: PathBuf, path: &Path, manifest: Value) -> Result<Self, SourceError> {
        let wrong = |source| SourceError::Json { path: path.to_owned(), source };
        let head_of_site = SiteHead::of_manifest(&manifest).map_err(wrong)?;
        Ok(Self { manifest: parsed(path, manifest)?, folder, head_of_site })
    }

    /// The head of its document.
    pub(super) fn head(&self, key: String) -> DateHead {
        let storey = |storey: &StoreyOfManifest| StoreyAtDate {
            index: storey.storey.index,
            status: storey.status.clone(),
            layers: self.layers_of(storey).map(|(layer, _, name)| (layer.name(), name)).collect(),
        };
        DateHead {
            key,
            at: self.manifest.plan_time.clone(),
            until: self.manifest.valid_until.clone(),
            storeys: self.manifest.storeys.iter().map(storey).collect(),
            model: self.model().map(|(name, _)| name),
        }
    }

    /// `semantic.json`.
    ///
    /// # Errors
    /// See [`SourceError`].
    pub(super) fn semantic(&self) -> Result<Value, SourceError> {
        json_of(&self.folder.join("semantic.json"))
    }

    /// The documents that its own is made of.
    ///
    /// # Errors
    /// See [`SourceError`].
    pub(super) fn published(&self) -> Result<Published, SourceError> {
        Ok(Published {
            semantic: self.semantic()?,
            waypoints: json_of(&self.folder.join("waypoints.json"))?,
            site_graph: json_of(&self.folder.join("site-graph.json"))?,
            report: json_of(&self.folder.join("report.json"))?,
        })
    }

    fn layer_files(&self) -> impl Iterator<Item = (ContentName, MapFile)> {
        self.manifest.storeys.iter().flat_map(|storey| {
            self.layers_of(storey).filter_map(|(layer, path, name)| {
                let path = inside(&self.folder, &path)?;
                Some((name, MapFile { path, storey: storey.storey.clone(), layer }))
            })
        })
    }

    /// Layers of a storey that the manifest lists, with their paths and contents. Equal pictures of two layers or storeys are
    /// told apart, because they are drawn in other colours and places.
    fn layers_of(&self, storey: &StoreyOfManifest) -> impl Iterator<Item = (Layer, String, ContentName)> {
        Layer::ALL.into_iter().filter_map(|layer| {
            let file = match layer {
                Layer::Semantic => "classes.png".to_owned(),
                layer => format!("{}.pgm", layer.name()),
            };
            let path = format!("{}/{file}", storey.directory);
            let hash = self.manifest.files.get(&path)?;
            let place = format!("{}{}", layer as u8, storey.storey.index);
            let name = ContentName::of_hash(&format!("{place}{hash}"))?;
            Some((layer, path, name))
        })
    }

    fn model(&self) -> Option<(ContentName, PathBuf)> {
        const MODEL: &str = "world/site.glb";
        let name = ContentName::of_hash(self.manifest.files.get(MODEL)?)?;
        Some((name, self.folder.join(MODEL)))
    }
}

/// A path of a manifest inside its folder; `None` for one that leads out of it.
fn inside(folder: &Path, path: &str) -> Option<PathBuf> {
    let path = Path::new(path);
    path.components().all(|part| matches!(part, Component::Normal(_))).then(|| folder.join(path))
}

/// The bytes of a file.
///
/// # Errors
/// See [`SourceError`].
pub(super) fn read(path: &Path) -> Result<Vec<u8>, SourceError> {
    std::fs::read(path).map_err(|source| SourceError::Io { path: path.to_owned(), source })
}

fn json_of(path: &Path) -> Result<Value, SourceError> {
    serde_json::from_slice(&read(path)?).map_err(|source| SourceError::Json { path: path.to_owned(), source })
}

fn parsed<T: DeserializeOwned>(path: &Path, value: Value) -> Result<T, SourceError> {
    serde_json::from_value(value).map_err(|source| SourceError::Json { path: path.to_owned(), source })
}
