//! Rooms, stairs and lifts of the maps of a folder that `convert` wrote, from its `semantic.json`.

use crate::failure::Failure;
use crate::input_document::read_document;
use alignment::{Portal, Room, SitePlaces, joined};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

/// The places of a reference, with the floors of its storeys; none of a single map, no rooms without `semantic.json`.
///
/// # Errors
/// A file that cannot be read.
pub(super) fn site_places(reference: &Path, floors: impl Iterator<Item = (u32, f64)>) -> Result<SitePlaces, Failure> {
    let floors = floors.collect();
    let path = reference.join("semantic.json");
    let unusable = |why: String| Failure::usage(format!("{}: {why}", path.display()));
    let bytes = match read_document(&path) {
        Err(error) if [ErrorKind::NotFound, ErrorKind::NotADirectory].contains(&error.kind()) => {
            return Ok(SitePlaces { floors, ..SitePlaces::default() });
        }
        read => read.map_err(|error| unusable(error.to_string()))?,
    };
    let semantic: Semantic = serde_json::from_slice(&bytes).map_err(|error| unusable(error.to_string()))?;
    let portals = portals(&semantic.elements);
    Ok(SitePlaces { rooms: semantic.spaces.into_iter().filter_map(room).collect(), floors, portals })
}

fn room((global_id, space): (String, Space)) -> Option<Room> {
    let map_storey = space.storey.filter(|_| !space.metadata_only)?;
    Some(Room {
        global_id,
        name: space.name.unwrap_or_default(),
        long_name: space.long_name.unwrap_or_default(),
        map_storey,
        area_m2: space.area_m2,
        rings_m: space.polygon_m.into_iter().flatten().collect(),
    })
}

/// Stairs, ramps and lifts; the body of a whole is that of its parts.
fn portals(elements: &BTreeMap<String, Element>) -> Vec<Portal> {
    let mut bounds: BTreeMap<&str, [[f64; 3]; 2]> = BTreeMap::new();
    for (global_id, element) in elements {
        let Some(Aabb { min, max }) = element.aabb_m else { continue };
        for of in [Some(global_id), element.attributes.part_of.as_ref()].into_iter().flatten() {
            let both = bounds.get(of.as_str()).map_or([min, max], |earlier| joined(*earlier, [min, max]));
            bounds.insert(of, both);
        }
    }
    let portal = |(global_id, element): (&String, &Element)| {
        let is_lift = element.r#type == "IfcTransportElement";
        let is_portal = is_lift || ["stair", "ramp"].contains(&element.class.as_str());
        let bounds_m = *bounds.get(global_id.as_str()).filter(|_| is_portal)?;
        let name = element.name.clone().unwrap_or_default();
        Some(Portal { global_id: global_id.clone(), name, is_lift, bounds_m })
    };
    elements.iter().filter_map(portal).collect()
}

#[derive(Deserialize)]
struct Semantic {
    elements: BTreeMap<String, Element>,
    spaces: BTreeMap<String, Space>,
}

#[derive(Deserialize)]
struct Element {
    r#type: String,
    class: String,
    name: Option<String>,
    aabb_m: Option<Aabb>,
    attributes: Attributes,
}

#[derive(Deserialize, Clone, Copy)]
struct Aabb {
    min: [f64; 3],
    max: [f64; 3],
}

#[derive(Deserialize)]
struct Attributes {
    part_of: Option<String>,
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
