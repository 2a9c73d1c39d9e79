//! `maps.json`: what a fleet control needs to have maps and zone sets downloaded before a date, and enabled at it.

use crate::ids::map_id;
use export::{ExportFile, ExportInput, text_or_null};
use messages::{ContentId, ScheduleStateHead, plan_time};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

/// Maps and zone sets of a date, with the instant actions of VDA 5050 3.0 that bring them to a robot.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct MapsDocument {
    /// Version of this layout: 1.
    version: u32,
    /// Version of the protocol that the actions are of.
    protocol: Cow<'static, str>,
    /// Plan time; null if all elements stand regardless of dates.
    plan_time: Option<String>,
    /// When these maps and zone sets are to be enabled: the last change of the schedule at or before the plan time; null if they always
    /// hold. They may be downloaded at any time before.
    valid_from: Option<String>,
    /// When those of the next change are to be enabled; null behind the last.
    valid_until: Option<String>,
    /// One for each map storey.
    maps: Vec<DownloadableMap>,
}

/// The map of a storey and the zone set that belongs to it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub(super) struct DownloadableMap {
    /// Index of the map storey.
    storey: u32,
    /// Its name; null if it has none.
    name: Option<String>,
    /// The same at every date, in zone sets and in layouts.
    map_id: String,
    /// Of the content of the map. A robot that has this version of the map already refuses to download it again.
    map_version: String,
    /// The map: a tar of `planning`, `localization` and `keepout`, each .pgm and .yaml.
    map: DownloadableFile,
    /// Of the content of the zone set. A robot that has it already refuses to download it again.
    zone_set_id: String,
    /// The zone set.
    zone_set: DownloadableFile,
    /// Instant actions that download both, at any time before `valid_from`.
    download: [InstantAction; 2],
    /// Instant actions that enable both, in this order, at `valid_from`.
    enable: [InstantAction; 2],
}

/// A file to download.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
struct DownloadableFile {
    /// Path in the output folder.
    path: String,
    /// sha256 of the file.
    sha256: String,
    /// Its length.
    bytes: usize,
}

/// An instant action without its `actionId`, which whoever sends it gives.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
struct InstantAction {
    /// Name of the action.
    action_type: Cow<'static, str>,
    /// `NONE`, as of every instant action.
    blocking_type: Cow<'static, str>,
    /// Links are paths in the output folder: put the address of the server before them. Hashes are sha256.
    action_parameters: Vec<ActionParameter>,
}

/// A parameter of an action.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
struct ActionParameter {
    /// Its key.
    key: Cow<'static, str>,
    /// Its value.
    value: String,
}

/// Maps and zone sets of a plan time of a site in a store: as `maps.json`, but with the blobs of the store in the place of files.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct StoreMapsDocument {
    /// The site.
    site: String,
    /// Whose maps they are, as the index of the site names it.
    robot: String,
    /// When robots go on to these maps, RFC 3339 in UTC: the plan time by the civil time of the site's zone. Enable them then; download
    /// them before. Null where the plan time follows no clock: they hold as soon as the index has them.
    enable_at: Option<String>,
    /// The document of the output folder. Paths and links count from the address of the store.
    #[serde(flatten)]
    maps: MapsDocument,
}

/// Why there is no document for a store.
#[derive(Debug, thiserror::Error)]
pub enum StoreMapsError {
    /// `maps.json` is none.
    #[error("maps.json cannot be read")]
    Json(#[from] serde_json::Error),
    /// It names a file that the store does not have.
    #[error("maps.json names {0:?}, which is not among the files of the store")]
    Missing(String),
}

/// A file with what identifies its content to robots.
pub(super) struct Identified {
    pub(super) id: String,
    pub(super) file: ExportFile,
}

impl MapsDocument {
    pub(super) fn of(input: &ExportInput<'_>, maps: Vec<DownloadableMap>) -> Self {
        let ScheduleStateHead { plan_time_s, valid_from_s, valid_until_s, .. } = *input.schedule_state.head;
        let [plan_time, valid_from, valid_until] =
            [plan_time_s, valid_from_s, valid_until_s].map(|seconds| plan_time(seconds).map(|time| time.to_string()));
        Self { version: 1, protocol: "3.0.0".into(), plan_time, valid_from, valid_until, maps }
    }
}

impl StoreMapsDocument {
    /// Of the bytes of `maps.json`; `link` says where in the store the file at a path of the output folder is.
    ///
    /// # Errors
    /// Other bytes, or a file that is not there.
    pub fn of(
        maps_json: &[u8],
        site: &str,
        robot: &str,
        enable_at: Option<String>,
        link: impl Fn(&str) -> Option<String>,
    ) -> Result<Self, StoreMapsError> {
        let mut maps: MapsDocument = serde_json::from_slice(maps_json)?;
        for map in &mut maps.maps {
            for file in [&mut map.map, &mut map.zone_set] {
                let in_store = link(&file.path).ok_or_else(|| StoreMapsError::Missing(file.path.clone()))?;
                let links = map.download.iter_mut().flat_map(|action| &mut action.action_parameters);
                for parameter in links.filter(|parameter| parameter.value == file.path) {
                    parameter.value.clone_from(&in_store);
                }
                file.path = in_store;
            }
        }
        Ok(Self { site: site.to_owned(), robot: robot.to_owned(), enable_at, maps })
    }
}

impl DownloadableMap {
    pub(super) fn of(input: &ExportInput<'_>, map_storey: u32, map: &Identified, zone_set: &Identified) -> Self {
        let map_id = map_id(input.site, map_storey);
        let (map_version, zone_set_id) = (map.id.clone(), zone_set.id.clone());
        let [map, zone_set] = [map, zone_set].map(DownloadableFile::of);
        let of_map = || vec![("mapId", map_id.clone()), ("mapVersion", map_version.clone())];
        let of_set = || vec![("zoneSetId", zone_set_id.clone())];
        let with = |mut parameters: Vec<_>, keys: [&'static str; 2], file: &DownloadableFile| {
            parameters.extend(keys.into_iter().zip([file.path.clone(), file.sha256.clone()]));
            parameters
        };
        Self {
            storey: map_storey,
            name: text_or_null(input.site.text(input.site.map_storeys[map_storey as usize].name)),
            download: [
                InstantAction::of("downloadMap", with(of_map(), ["mapDownloadLink", "mapHash"], &map)),
                InstantAction::of("downloadZoneSet", with(of_set(), ["zoneSetDownloadLink", "zoneSetHash"], &zone_set)),
            ],
            enable: [InstantAction::of("enableMap", of_map()), InstantAction::of("enableZoneSet", of_set())],
            map_id,
            map_version,
            map,
            zone_set_id,
            zone_set,
        }
    }
}

impl DownloadableFile {
    fn of(Identified { file, .. }: &Identified) -> Self {
        Self { path: file.path.clone(), sha256: ContentId::of(&file.bytes).to_string(), bytes: file.bytes.len() }
    }
}

impl InstantAction {
    fn of(action_type: &'static str, parameters: Vec<(&'static str, String)>) -> Self {
        let action_parameters =
            parameters.into_iter().map(|(key, value)| ActionParameter { key: key.into(), value }).collect();
        Self { action_type: action_type.into(), blocking_type: "NONE".into(), action_parameters }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(path: &str) -> DownloadableFile {
        DownloadableFile { path: path.to_owned(), sha256: "0".repeat(64), bytes: 3 }
    }

    #[test]
    fn links_of_a_store_are_in_the_place_of_paths() {
        let [map, zone_set] = ["fleet/vda5050/00-g.map.tar", "fleet/vda5050/00-g.zoneSet.json"].map(file);
        let action = |action_type, key, value: &str| InstantAction::of(action_type, vec![(key, value.to_owned())]);
        let maps = MapsDocument {
            version: 1,
            protocol: "3.0.0".into(),
            plan_time: Some("2024-04-15T00:00:00".to_owned()),
            valid_from: None,
            valid_until: None,
            maps: vec![DownloadableMap {
                storey: 0,
                name: None,
                map_id: "g".to_owned(),
                map_version: "1".to_owned(),
                zone_set_id: "z".to_owned(),
                download: [
                    action("downloadMap", "mapDownloadLink", &map.path),
                    action("downloadZoneSet", "zoneSetDownloadLink", &zone_set.path),
                ],
                enable: [action("enableMap", "mapId", "g"), action("enableZoneSet", "zoneSetId", "z")],
                map,
                zone_set,
            }],
        };
        let text = serde_json::to_vec(&maps).unwrap();
        let link = |path: &str| path.ends_with(".tar").then(|| "tower/blobs/ab/abcd".to_owned());
        let missing = StoreMapsDocument::of(&text, "tower", "robot", None, link);
        assert!(matches!(missing, Err(StoreMapsError::Missing(path)) if path.ends_with("zoneSet.json")));
        let link = |path: &str| Some(format!("tower/blobs/{}", path.len()));
        let at = "2024-04-14T22:00:00Z".to_owned();
        let document = StoreMapsDocument::of(&text, "tower", "robot", Some(at), link).unwrap();
        let map = &document.maps.maps[0];
        assert_eq!((map.map.path.as_str(), map.zone_set.path.as_str()), ("tower/blobs/26", "tower/blobs/31"));
        let links = map.download.each_ref().map(|action| action.action_parameters[0].value.as_str());
        assert_eq!((links, &map.enable), (["tower/blobs/26", "tower/blobs/31"], &maps.maps[0].enable));
        assert!(StoreMapsDocument::of(b"{}", "tower", "robot", None, |_| None).is_err());
    }
}
