//! Waypoint planning: site, schedule state and grids in, mission plan out: space centres, scans, tours, route graph.
//!
//! [`MissionPlanOptions`] (a file like `config/waypoints.toml`) select what is planned and describe the sensor: kinds
//! of waypoints, spaces, classes, coverage or a budget, overlap, lifts, only elements built since a date.
//!
//! ```text
//! groundplan convert house.ifc -o maps --waypoints scanner.toml
//! groundplan waypoints scanner.toml                                    # the running daemon; without a file as configured
//! groundplan waypoints --space 'Office*' --changed-since 2024-05-13    # only these rooms, only what is new in them
//! ```
//!
//! # Reachability
//!
//! The robot starts at `[tour] start`; without it, on each storey in the part of the free space with the largest room area,
//! among those with a stair, ramp, lift or outer door. `31 of 156 m2 reached, 5 parts`: of the free space, indoors and
//! outdoors, 31 m2 can be reached from there; `report.json` lists all parts.
//!
//! # Waypoints
//!
//! - The centre of every open and reachable space, moved to the nearest clear place where it is blocked. The other spaces
//!   get a reason, with the GlobalId of the closed door. Of every space it is told whether the robot gets there
//!   (`SpaceAccess`), whether or not it was asked for, and what keeps the robot from the others: of all ways there the one
//!   with the fewest closed doors, blocked rooms and portals that the robot does not use.
//! - Scans that together see 99 % of the target faces of structure visible from the reachable free space, but for what is
//!   worth no scan; or, within a budget of scans or minutes, those that see most. A face is visible if it is in range, the
//!   angle of incidence is at most 70 degrees, and the line of sight crosses free cells only; `mesh_check` adds the visibility
//!   of meshes at all heights.
//! - A tour over them, and a route graph: spaces, doors and junctions along the middle of the floor, staging poses before
//!   stairs, lifts and steps between levels; stairs as a line over their treads and landings.
//!
//! `scripts/check_waypoints.py OUT` proves the exported waypoints, their coverage and the route graph anew from the files
//! alone; it shares no code with this crate.

mod input;
mod options;

mod barriers;
mod changed_elements;
mod floor_parts;
mod free_space;
mod name_check;
mod portal;
mod portals;
mod reachability;
mod sloped_slabs;
mod spaces;
mod stair_ends;
mod stair_traversal;
mod start_pose;

mod mesh_visibility;
mod scan_budget;
mod scan_choice;
mod scan_growth;
mod scan_places;
mod scan_registration;
mod scan_survey;
mod set_cover;
mod set_cover_instance;
mod space_centre;
mod tabu_search;
mod target_face;
mod visible_faces;

mod path_search;
mod place_regions;
mod random_generator;
mod tour;
mod tour_distances;

mod route_graph;
mod skeleton;

mod mission_plan_archive;
mod mission_planner;
mod steps;
mod storey_planner;
mod tour_stops;

pub use input::MissionPlanInput;
pub use mission_planner::{MissionPlanner, StoreyInstance};
pub use name_check::{UnknownName, check_names};
pub use options::{MissionPlanOptions, OptionsError, Start};
pub use set_cover::cover;
pub use set_cover_instance::SetCoverInstance;
pub use start_pose::check_start;
