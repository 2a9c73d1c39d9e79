//! The building as Open-RMF reads it: a building map, a site, and the navigation graph of one robot at one date.
//!
//! ```text
//! groundplan convert house.ifc -o maps --open-rmf
//! groundplan convert house.ifc -o maps --open-rmf --date 2024-04-15 --waypoints lifts.toml   # [tour] lifts = ["*"]
//! ```
//!
//! | file | content |
//! |---|---|
//! | `open-rmf/NAME.building.yaml` | the traffic editor's format, in Cartesian metres |
//! | `open-rmf/NAME.site.json` | the same in the site editor's format, version 0.1 |
//! | `open-rmf/nav_graphs/0.yaml` | the lanes as `building_map_generator nav` makes them of the building, for fleet adapters |
//!
//! NAME is the name of the first model's file. Coordinates are those of `map`, y to the left of x, in all three files; x and y of a
//! place are the same numbers. What a level, vertex, lane, door or lift is:
//!
//! - Levels are the map storeys that are written, with their name and the height of their floor; one that shares its name has its index
//!   behind it.
//! - Vertices are the places of the route graph, and where its ways bend. Centres of rooms have the room's name, cabins
//!   `LIFT on LEVEL`; no two have the same, whatever the date: rooms that share a name have their GlobalId behind it. No other vertex has
//!   a name, and none is a charger, parking spot or holding point, since no model says so. Scans are in `waypoints.json`.
//! - Lanes are the ways that this robot can take at the date, each in both directions: none leads through a closed door or room.
//! - Doors are those that hang finished in what is finished, between the ends of the opening of their moving leaves. A lane has the name
//!   of the door that it passes, so each of them needs a door adapter. Of a single leaf the first end is where it hangs, or to where it
//!   slides. Open-RMF has no type for leaves that fold, turn or rise: those, and doors of which the model says nothing, are `hinged`;
//!   `ifc_operation` is what the model says.
//! - Lifts are those by which ways lead between levels. The cabin is the box around the plan of the element, its doors are the landing
//!   doors within 1 m of its sides, which are no doors of their level; it has none where the model has none. Vertices and lanes lead
//!   into it only if the robot takes it (`lifts` of the options of waypoints).
//!
//! Not here, because Open-RMF has no place for it: ways by stairs, ramps, steps and over ground to other levels; the head of the building
//! map counts them. Walls are the middle lines of straight pieces of finished walls and curtain walls in the slab of the robot; it counts the
//! pieces that are not straight, too. Not here either are floors and models, of which Open-RMF makes simulations: `world/` is one.
//!
//! # Source
//! `rmf_building_map_tools` (level.py, building.py, lift.py, doors) and `rmf_site_format` 0.0.2 of Open-RMF, and the parser of graphs in
//! `rmf_fleet_adapter`. In Cartesian metres all of them take y as it is; in images they turn it round.
//!
//! # Where
//!
//! - Open-RMF: names: `src/names.rs`; types of doors, which lane passes one: `src/doors.rs`; cabins and landing doors: `src/lifts.rs`;
//!   walls that are lines: `src/walls.rs`

mod building;
mod building_yaml;
mod doors;
mod lifts;
mod names;
mod nav_graph;
mod site_json;
mod walls;
mod yaml;

use building::Building;
use export::{ExportFile, ExportInput, slug};

/// The files for Open-RMF, in `open-rmf/`.
pub fn files(input: &ExportInput<'_>) -> Vec<ExportFile> {
    let building = Building::of(input);
    let name = slug(&building.name, "building");
    vec![
        ExportFile::new(format!("open-rmf/{name}.building.yaml"), building_yaml::bytes(&building)),
        ExportFile::new(format!("open-rmf/{name}.site.json"), site_json::bytes(&building)),
        ExportFile::new("open-rmf/nav_graphs/0.yaml", nav_graph::bytes(&building)),
    ]
}
