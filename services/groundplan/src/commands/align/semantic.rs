//! Rooms of the maps of a folder that `convert` wrote, from its `semantic.json`.

use crate::failure::Failure;
use alignment::Room;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

/// The rooms of a reference; none of a single map, or of a folder without `semantic.json`.
///
/// # Errors
/// A file that cannot be read.
pub(super) fn rooms(reference: &Path) -> Result<Vec<Room>, Failure> {
    let path = reference.join("semantic.json");
    let unusable = |why: String| Failure::usage(format!("{}: {why}", path.display()));
    let bytes = match std::fs::read(&path) {
        Err(error) if [ErrorKind::NotFound, ErrorKind::NotADirectory].contains(&error.kind()) => return Ok(Vec::new()),
        read => read.map_err(|error| unusable(error.to_string()))?,
    };
    let semantic: Semantic = serde_json::from_slice(&bytes).map_err(|error| unusable(error.to_string()))?;
    let room = |(global_id, space): (String, Space)| {
        let map_storey = space.storey.filter(|_| !space.metadata_only)?;
        Some(Room {
            global_id,
            name: space.name.unwrap_or_default(),
            long_name: space.long_name.unwrap_or_default(),
            map_storey,
            area_m2: space.area_m2,
            rings_m: space.polygon_m.into_iter().flatten().collect(),
        })
    };
    Ok(semantic.spaces.into_iter().filter_map(room).collect())
}

#[derive(Deserialize)]
struct Semantic {
    spaces: BTreeMap<String, Space>,
}

#[derive(Deserialize)]
struct Space {
    name: Option<String>,
    long_name: Option<String>,
    #[serde(default)]
    metadata_only: bool,
    storey: Option<u32>,
    area_m2: f64,
    polygon_m: Vec<Vec<Vec<[f64; 2]>>>,
}
