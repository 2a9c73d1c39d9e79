//! Waypoint planning: site, schedule state and grids in, mission plan out: space centres, scans, tours, route graph.
//!
//! What is planned, and with which sensor, are [`PlanOptions`], a file like `config/waypoints.toml`: kinds of waypoints,
//! spaces, coverage, overlap, lifts, only what was built since a date.
//!
//! ```text
//! groundplan convert house.ifc -o maps --waypoints scanner.toml
//! groundplan waypoints scanner.toml                                    # the running daemon; without a file as configured
//! groundplan waypoints --space 'Office*' --changed-since 2024-05-13    # only these rooms, only what is new in them
//! ```
//!
//! # Reachable floor
//!
//! The robot begins where `[tour] start` says, else on each storey in the part with the most room area, of those with a
//! stair, ramp, lift or outer door. `31 of 156 m2 reached, 5 parts` says that of the floor on which the middle of the robot
//! can be, indoors and outdoors, 31 m2 hang together with that; `report.json` lists all parts.
//!
//! # Waypoints
//!
//! - A centre of every space that is open and can be reached, moved to the nearest clear place where it is blocked; the
//!   other spaces have the reason, with the GlobalId of the closed door.
//! - Scans that together see 99 % of what can be seen from anywhere the robot gets to. A face is seen if it is in range, is
//!   met at no more than 70 degrees, and a straight line leads there over free cells; `mesh_check` adds what is seen of
//!   meshes at all heights.
//! - A tour over them, and a route graph: spaces, doors and junctions along the middle of the floor, staging poses before
//!   stairs, lifts and steps between levels; stairs as a line over their treads and landings.
//!
//! `scripts/check_waypoints.py OUT` proves the exported waypoints, their coverage and the route graph anew from the files
//! alone; it shares no code with this crate.

mod input;
mod options;

mod changed;
mod climb;
mod floor_parts;
mod ground;
mod portal;
mod portals;
mod reachability;
mod sloped_slabs;
mod spaces;
mod stair_ends;
mod start_pose;
mod unknown;

mod centre;
mod face;
mod instance;
mod mesh_visibility;
mod scans;
mod set_cover;
mod tabu_search;
mod visible;

mod chance;
mod scan_overlap;
mod tour;
mod trip;
mod walk;

mod graph;
mod skeleton;

mod mission_plan;
mod plan_archive;
mod steps;
mod stops;
mod storey_plan;

pub use input::PlanInput;
pub use instance::Instance;
pub use mission_plan::{Planner, StoreyInstance};
pub use options::{OptionsError, PlanOptions, Start};
pub use set_cover::cover;
pub use start_pose::check_start;
pub use unknown::{UnknownName, check_names};
