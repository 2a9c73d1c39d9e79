//! `maps.json`: what a fleet control needs to have maps and zone sets downloaded before a date, and enabled at it.

use crate::ids::map_id;
use export::{ExportFile, ExportInput, text_or_null};
use messages::{ContentId, ScheduleStateHead, plan_time};
use schemars::JsonSchema;
use serde::Serialize;

/// Maps and zone sets of a date, with the instant actions of VDA 5050 3.0 that bring them to a robot.
#[derive(Debug, Serialize, JsonSchema)]
pub struct MapsDocument {
    /// Version of this layout: 1.
    version: u32,
    /// Version of the protocol that the actions are of.
    protocol: &'static str,
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
#[derive(Debug, Serialize, JsonSchema)]
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
#[derive(Debug, Serialize, JsonSchema)]
struct DownloadableFile {
    /// Path in the output folder.
    path: String,
    /// sha256 of the file.
    sha256: String,
    /// Its length.
    bytes: usize,
}

/// An instant action without its `actionId`, which whoever sends it gives.
#[derive(Debug, Serialize, JsonSchema)]
#[serde(rename_all = "camelCase")]
struct InstantAction {
    /// Name of the action.
    action_type: &'static str,
    /// `NONE`, as of every instant action.
    blocking_type: &'static str,
    /// Links are paths in the output folder: put the address of the server before them. Hashes are sha256.
    action_parameters: Vec<ActionParameter>,
}

/// A parameter of an action.
#[derive(Debug, Serialize, JsonSchema)]
struct ActionParameter {
    /// Its key.
    key: &'static str,
    /// Its value.
    value: String,
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
        Self { version: 1, protocol: "3.0.0", plan_time, valid_from, valid_until, maps }
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
        let action_parameters = parameters.into_iter().map(|(key, value)| ActionParameter { key, value }).collect();
        Self { action_type, blocking_type: "NONE", action_parameters }
    }
}
