//! Zone sets and map downloads of VDA 5050 3.0, of each map storey.

mod areas;
mod keepout_reasons;
mod maps;
mod tar;
mod zone_set;
mod zones;

pub use maps::{MapsDocument, StoreMapsDocument, StoreMapsError};

use export::{ExportFile, ExportInput, json_text, storey_folder};
use maps::{DownloadableMap, Identified};
use messages::{ContentId, Grid};

/// The files, in `fleet/vda5050/`.
pub fn files(input: &ExportInput<'_>) -> Vec<ExportFile> {
    let mut files = Vec::new();
    let maps: Vec<DownloadableMap> = input
        .grids
        .each(|grid| {
            let [map, zone_set] = storey_files(input, grid);
            let entry = DownloadableMap::of(input, grid.head.map_storey, &map, &zone_set);
            files.extend([map.file, zone_set.file]);
            entry
        })
        .collect();
    files.push(ExportFile::new("fleet/vda5050/maps.json", json_text(&MapsDocument::of(input, maps))));
    files
}

/// The map of a storey with its version, and its zone set with its id.
fn storey_files(input: &ExportInput<'_>, grid: &Grid<'_>) -> [Identified; 2] {
    let map_storey = grid.head.map_storey;
    let folder = storey_folder(input.site, map_storey, &input.site.map_storeys[map_storey as usize]);
    let name = folder.rsplit('/').next().unwrap_or(&folder);
    let tar = tar::archive(&export::map_files(grid));
    let version = ContentId::of(&tar).short().to_string();
    let map = Identified { id: version, file: ExportFile::new(format!("fleet/vda5050/{name}.map.tar"), tar) };
    let message = zone_set::ZoneSetMessage::of(input, grid);
    let path = format!("fleet/vda5050/{name}.zoneSet.json");
    let zone_set = Identified { id: message.id().to_owned(), file: ExportFile::new(path, json_text(&message)) };
    [map, zone_set]
}
