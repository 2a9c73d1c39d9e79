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
//! On ground that is not level the robot stands along its normal, that of the plane through the heights under the robot: the sensor is
//! `sensor_height_m` above the ground along it, and sees from its lowest to its highest ray from there. The yaw is the angle in plan of
//! where the robot looks; the robot is turned by it about Z, then pitched and rolled until its vertical axis is the normal.
//!
//! # Ways
//!
//! [`WayFinder`] finds the shortest or least costly way from a room or point to another, over storeys, on the cells on which this robot can
//! stand and through the portals of a mission plan; or what is in the way: closed doors, closed rooms, portals that are not
//! built or not for this robot, floor that is keep-out or too narrow.
//!
//! On ground that is not level lengths are along the slope, and climb, descent and the steepest slope are told. The ground outdoors has a
//! map of its own: the robot goes onto it where that and the map of a storey show one place (`src/ground_crossings.rs`). Rooms and scans
//! are planned on storeys alone.
//!
//! `[tour] cost` says by what ways are chosen: length, time or energy. Time is that of the length at `speed_m_s`, with `climb_s_per_m` for
//! each metre of climb, but on stairs and in lifts; energy is m g (sin s + c cos s) / efficiency for each metre of a slope s, with the coefficient of rolling
//! resistance c, and `idle_w` all the time, without recuperation. A way that is chosen by one of both takes no more of it than the
//! shortest. Legs of tours are chosen so, too, and their time and energy told; the order of a tour goes by length.
//!
//! `scripts/check_waypoints.py OUT` proves the exported waypoints, their coverage and the route graph anew from the files
//! alone; it shares no code with this crate.
//!
//! # Flight waypoints
//!
//! With [`FlightOptions`] places in the air are planned too, from bodies and not from cells: grids say where floor is and how high.
//!
//! - Distances are those from the triangles of all elements that are built, being built or being removed (doors are closed, glass counts),
//!   of terrain, and of the bodies of blocked rooms; every waypoint and every place of every edge keeps the clearance, but for the rounding
//!   of double precision. None lies within a closed body. An element whose body could not be made is kept no distance from: `flight.json`
//!   names it.
//! - Heights are above the highest ground of the storey that the cells within the clearance show: on slopes, to a cell's part of the slope.
//!   Furniture and keep-out are flown over; a place that has another floor or a roof below it is none. Ground outdoors is that of the map storey of
//!   the ground where no storey shows it as its floor, and faces of terrain and roads that are too steep for the robot.
//! - Places are tried on one lattice for all storeys. From each that is clear a waypoint over the same space at the same height is within
//!   half of the spacing, along clear steps, so that a space has a waypoint wherever a place over it is clear.
//! - Waypoints hang together, over heights and storeys, as clear steps on the lattice do: where those lead from one to a neighbour, edges
//!   do, on ways at most twice as long.
//! - At most 2 million places are tried, for which the lattice becomes coarser, and there are at most 100,000 waypoints; else none, with
//!   the diagnostic `flight_too_large`.
//!
//! # Guarantees
//!
//! - Every waypoint lies in its space, is clear by the radius of the robot, and can be reached through the doors that are
//!   passable on that date.
//! - Coverage is the share of the faces that can be seen from anywhere the robot gets to. `mesh_check` adds what the scans
//!   see of the meshes at all heights.
//! - Stairs, ramps, lifts and steps between levels are edges of the site graph. A slab is a ramp where its sloped faces end
//!   at the floor of a map storey at both ends; a roof ends at none.
//! - Scans are to see structure, unless other classes are asked for, and no two are nearer than half a metre, unless a room's
//!   share needs it. A scan that adds less than half a metre of wall is not made.
//! - Places are tried for scans once a metre, on rays from faces that are seen from none of these, and every half metre
//!   around the scans of a first plan. The cover is greedy, then a search with exchanges takes scans out, window by window,
//!   so that effort grows with the floor.
//! - Scans register in any order: each needs a share of its faces in common with those that are registered. A joining scan
//!   names a scan that does not register without it.
//! - A plan grows by the scan, or the pair of which one joins the other, that sees most of what is left and registers: this
//!   order is the coverage curve, and a budget pays for its beginning, over all storeys. A plan with as many scans sees at
//!   least what the curve says.
//! - Walking distances are those over the borders of the regions nearest to each waypoint: one search over the cells for all
//!   waypoints of a storey. Only the legs of the tour are searched one by one.
//! - Lengths of tours are compared in whole millimetres, and searches are counted in steps: a plan is a function of its
//!   input.
//! - The plan of a storey is made from its grid, the spaces and doors in it, where the robot comes onto it, and the options.
//!   It is kept while these are the same, and equals that of a fresh start.
//!
//! # Where
//!
//! - flight: distances: `src/flight/air.rs`; places and heights: `src/flight/places.rs`, `src/flight/outdoor_ground.rs`; waypoints and
//!   edges: `src/flight/choice.rs`, `src/flight/edges.rs`
//! - ground outdoors: where the robot comes onto it: `src/ground_crossings.rs`, `src/outdoor_ends.rs`
//! - reachability, over storeys too: `src/reachability.rs`, `src/portals.rs`, `src/steps.rs`
//! - scans: coverage curve, budgets: `src/scan_growth.rs`, `src/scan_budget.rs`
//! - time and energy of ways: `src/drive_cost.rs`
//! - poses on ground that is not level: `src/sensor_place.rs`
//! - scans: target faces, what a scan sees: `src/target_face.rs`, `src/visible_faces.rs`, `src/mesh_visibility.rs`
//! - scans: which are made: `src/scan_choice.rs`, `src/set_cover.rs`, `src/tabu_search.rs`, `src/scan_registration.rs`
//! - stair: levels at which it begins and ends: `src/stair_ends.rs`
//! - stair: way up, width, risers: `src/stair_traversal.rs`
//! - start of a robot that is put nowhere: `src/floor_parts.rs`
//! - tour: order of waypoints: `src/place_regions.rs`, `src/tour_distances.rs`, `src/tour.rs`

mod flight_options;
mod input;
mod options;

mod barriers;
mod changed_elements;
mod floor_parts;
mod free_space;
mod ground_crossings;
mod name_check;
mod outdoor_ends;
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
mod sensor_place;
mod set_cover;
mod set_cover_instance;
mod space_centre;
mod tabu_search;
mod target_face;
mod visible_faces;

mod drive_cost;
mod path_search;
mod place_regions;
mod random_generator;
mod tour;
mod tour_distances;
mod walked_line;
mod way_search;

mod route_graph;
mod skeleton;

mod mission_plan_archive;
mod mission_planner;
mod steps;
mod storey_planner;
mod tour_stops;

mod ways;

mod flight;

pub use barriers::portal_text;
pub use drive_cost::Driven;
pub use flight_options::FlightOptions;
pub use input::MissionPlanInput;
pub use mission_planner::{MissionPlanner, StoreyInstance};
pub use name_check::{UnknownName, check_names};
pub use options::{MissionPlanOptions, OptionsError, Start};
pub use set_cover::cover;
pub use set_cover_instance::SetCoverInstance;
pub use start_pose::check_start;
pub use ways::{FloorLeg, NoPlace, NoWay, PortalLeg, Way, WayEnd, WayFinder, WayLeg, WayObstacle};
