//! The `zoneSet` message of a map storey.

use super::zones::{Zone, zones};
use crate::ids::map_id;
use export::{ExportInput, json_text};
use messages::{ContentId, Grid};
use serde::Serialize;

/// The message, with the keys of the format.
#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct ZoneSetMessage {
    /// Set by whoever sends it, as the next three.
    header_id: u32,
    timestamp: &'static str,
    version: &'static str,
    manufacturer: &'static str,
    serial_number: &'static str,
    zone_set: ZoneSet,
}

#[derive(Debug, Serialize)]
#[serde(rename_all = "camelCase")]
struct ZoneSet {
    map_id: String,
    zone_set_id: String,
    zone_set_descriptor: String,
    zones: Vec<Zone>,
}

impl ZoneSetMessage {
    pub(super) fn of(input: &ExportInput<'_>, grid: &Grid<'_>) -> Self {
        let map_storey = grid.head.map_storey;
        let mut zone_set = ZoneSet {
            map_id: map_id(input.site, map_storey),
            zone_set_id: String::new(),
            zone_set_descriptor: input.site.text(input.site.map_storeys[map_storey as usize].name).to_owned(),
            zones: zones(input, grid),
        };
        // Of all that it says: the same id is the same set.
        zone_set.zone_set_id = ContentId::of(&json_text(&zone_set)).short().to_string();
        Self {
            header_id: 0,
            timestamp: "1970-01-01T00:00:00.000Z",
            version: "3.0.0",
            manufacturer: "",
            serial_number: "",
            zone_set,
        }
    }

    /// Id of the set.
    pub(super) fn id(&self) -> &str {
        &self.zone_set.zone_set_id
    }
}
