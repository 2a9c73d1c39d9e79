//! Export of archives to files: maps, images, JSON, GeoJSON, CSV, BCF.
//!
//! [`files`] is a pure function to paths and bytes; [`OutputFolder`] writes them whole or not at all.
//!
//! - `manifest.json`: sources, robot, frames, storeys, sha256 of every file.
//! - `report.json`: what was counted, assumed, replaced by a box or left out; of each storey how much floor is reached,
//!   part by part; rooms on no map; closed doors, each once, on the storey on which it stands, with every reason in words
//!   and as a code; floor at other levels; where dates come from and what is wrong with them.
//! - `semantic.json`: every element and space by GlobalId, in the frame and epoch that it names: class, footprints within
//!   a tolerance that it says, when it is built and the source of its dates, doors, stairs, property sets.
//! - `waypoints.{json,csv,geojson}`: centres of open spaces that can be reached; scans with what they see; the order of the
//!   tour; the other spaces with the reason and the GlobalId of the closed door. On ground that is not level a waypoint has its normal
//!   (`up`) and the place of the sensor along it (`sensor_m`); quaternions here and in `waypoints.yaml` are turned by the yaw, then tilted.
//! - `flight.json`, if flight waypoints were asked for: places in the air with height above the ground, measured clearance and
//!   the nearest element; edges along which the clearance is kept; what became of each space at each height, with the reason.
//! - `waypoints.wgs84.geojson`: the waypoints by longitude and latitude, if the projected system of the model (EPSG code)
//!   can be computed without grid files and the shift of its datum is certain; `report.json` says otherwise why not. As
//!   exact as the published shift of its datum: metres for old national systems.
//! - `site-graph.json`: ways of all storeys: spaces with their names, doors, junctions along the middle of the floor,
//!   staging poses before stairs, lifts and steps between levels; length, clearance, rise, slope of ramps, door and class
//!   of each; stairs as a line over their treads and landings, with walked length, clear width and number of risers.
//! - `site-frame.json`: the map frame; the next run into the same folder keeps it.
//! - `storeys/*/planning.{pgm,yaml}`: 0 where an obstacle stands, 254 where there is floor and none, 205 elsewhere.
//! - `storeys/*/localization.{pgm,yaml}`: finished structure at the height of the lidar, without glass and furniture.
//! - `storeys/*/keepout.{pgm,yaml}`: Nav2 keep-out mask: 0 for drop-offs, work and closed rooms, with margins; 205
//!   elsewhere, so that the filter never makes an unknown cell free.
//! - `storeys/*/elevation.{png,yaml}`, `slope.{png,yaml}`, where the ground of a storey is not level: height of the ground in `map` in
//!   metres, and its slope in radians; a value is `offset + scale * pixel`, the pixel `none` has no ground. `relief.png` shows the
//!   slope in colours, with contour lines, for people.
//! - `storeys/*/route.geojson`: this storey's ways for Nav2's route server; stairs that lead away from it as collections of
//!   one line, which Nav2 skips.
//! - `storeys/*/waypoints.yaml`: for Nav2's waypoint panel.
//! - `storeys/*/probability.{pgm,yaml}`, if the schedule state was decided by probabilities: the probability that an obstacle
//!   is in a cell, in per cent, as a map in the mode `scale`; `probability.png` for people.
//! - `storeys/*/speed.{pgm,yaml}`, if the robot's profile has limits of speed: Nav2's speed mask, 0 without a limit, else so many
//!   steps of metres per second; `speed_filter.yaml` has the parameters of its filter info server (type 2, absolute).
//! - `storeys/*/costs.{pgm,yaml}`, if the profile has distances to keep: 1 to 90 per cent of what is lethal within them, unknown
//!   elsewhere, in the mode `raw`; a mask for a keep-out filter, which skips what is unknown.
//! - `storeys/*/safety.json`, with either: the rules, and which element each of these cells has its value from.
//! - `storeys/*/semantic.png`, `waypoints.png`, `classes.png`: for people; class ids for programs.
//!
//! In all JSON documents keys of measures end with their unit, and what there is not is null, never an empty text. Their
//! schemas are in `config/schemas`.
//!
//! # Nav2
//!
//! The planning map, the keep-out mask and the waypoints of a storey have one frame and one origin;
//! `config/nav2/params.yaml` has the parameters that they need. `groundplan export maps --watch --on-change
//! config/nav2/on-change --on-stale config/nav2/on-stale` writes a folder for every change; the first script stops the robot's goal
//! before it loads maps of its storey that changed, the second one when the maps must not be used any more.
//!
//! Maps of a storey may be used while the file `maps/fresh` has the state `fresh`, is younger than 3 s, and does not list the
//! storey in `outdated_storeys`: who reads maps asks it before each use (`config/schemas/fresh.schema.json`). Subscribers of the
//! bus ask `site_view::ConsistentSet::verdict`, which is made by the same rule.
//!
//! # Output folder
//!
//! Earlier output is replaced as a whole. A folder without a `manifest.json` of groundplan is never replaced, and one in
//! which files were added or altered since is refused with their names; with `--force` these files are moved to
//! `OUT.kept-1` beside it, and never deleted.
//!
//! # Guarantees
//!
//! - `each_file` gives each file away as soon as it is made, and `each_file_while_writing` makes the next one meanwhile, so that the
//!   output of a large site is never in memory as a whole.
//! - Of finished output only files that a manifest lists, with the content that it lists, are ever deleted; unfinished output
//!   is a folder beside it with a mark of its own, and is removed as a whole.
//! - Footprints in `semantic.json` are within a tolerance that the document says (`src/outlines.rs`): exact for doors and
//!   floors, 5 mm for structure, a third of a cell for furniture and equipment. What consists of many triangles is painted
//!   into cells finer than that, once for all copies that are turned alike, and not united: the document grows with elements,
//!   not with triangles.
//! - `earth_from_world` is in metres: the unit of the file's map and its scale are applied.
//!
//! # Where
//!
//! - colours of `semantic.png`: `src/pictures.rs`
//! - deviations: BCF topics: `src/deviations/topics.rs`; which of earlier ones are closed: `src/deviations/topic_files.rs`
//! - ground: its mesh and its document: `src/ground.rs`
//! - latitude and longitude: `src/geographic.rs`

mod assumed_rooms;
mod cell_facts;
mod coverage_curve;
mod csv;
mod deviations;
mod diagnostics;
mod door_report;
mod file_writer;
mod flight;
mod folders;
mod geographic;
mod ground;
mod image;
mod input;
mod json;
mod labels;
mod lettering;
mod manifest;
mod maps;
mod mission_plan_picture;
mod outlines;
mod output_folder;
mod painted_outline;
mod pictures;
mod probability_layer;
mod provenance;
mod reach;
mod relief;
mod relief_picture;
mod report;
mod route;
mod safety_files;
mod scan_summary;
mod schedule_report;
mod semantic;
mod semantic_geometry;
mod site_frame;
mod text;
mod transliteration;
mod waypoints;

pub use assumed_rooms::assumed_rooms;
pub use deviations::{
    DeviationExport, DeviationsDocument, ProgressDate, TaskProgress, deviation_files, deviation_files_after,
    deviation_files_in, progress_mspdi,
};
pub use door_report::{each_door, reason_text};
pub use flight::FlightDocument;
pub use folders::{storey_folder, sums};
pub use ground::{GroundDocument, ground_files};
pub use input::{ExportFile, ExportInput, ProbabilityInput};
pub use json::text as json_text;
pub use manifest::{DatedFolder, DatesManifest, Manifest, schedule_ignored, status_of, with_manifest};
pub use maps::map_files;
pub use output_folder::{FolderBeside, ForeignFilePolicy, ForeignFiles, OutputError, OutputFolder, SetAside};
pub use provenance::{link_rule, schedule_file};
pub use reach::{FloorReach, NotMapped, RoomNotMapped, spaces_not_mapped};
pub use report::Report;
pub use route::{SiteGraph, nav2_route_file};
pub use safety_files::SafetyDocument;
pub use scan_summary::ScanSummary;
pub use schedule_report::{ScheduleFindings, ScheduleReport};
pub use semantic::Semantic;
pub use site_frame::{SiteFrameError, SiteFrameFile};
pub use text::{rounded, text_or_null};
pub use transliteration::slug;
pub use waypoints::{Waypoints, nav2_poses, space_name};

use file_writer::{MakeFiles, write_while_making};
use geographic::Geographic;
use messages::{Grid, Site};
use std::collections::BTreeMap;
use std::convert::Infallible;

/// All files of an output folder, as [`each_file`] makes them.
pub fn files(input: &ExportInput<'_>, more: Vec<ExportFile>) -> Vec<ExportFile> {
    let mut files = Vec::new();
    let Ok(_) = each_file::<Infallible>(input, more, |file| {
        files.push(file);
        Ok(())
    });
    files
}

/// Calls `write` with each file of an output folder as soon as it is made: these, `more` that others made of the same input,
/// and the manifest, which lists them all. Returns the sums of all files by their path, as [`sums`] does.
///
/// # Errors
/// Those of `write`.
pub fn each_file<E>(
    input: &ExportInput<'_>,
    more: Vec<ExportFile>,
    mut write: impl FnMut(ExportFile) -> Result<(), E>,
) -> Result<BTreeMap<String, String>, E> {
    let mut sums = BTreeMap::new();
    let mut add = |file: ExportFile| {
        sums.extend(folders::sums("", std::slice::from_ref(&file)));
        write(file)
    };
    FilesOf { input, more }.make(&mut add)?;
    with_manifest_written(input, sums, write)
}

/// [`each_file`] that makes a file while the one before it is written, where there are threads for both.
///
/// # Errors
/// Those of `write`.
pub fn each_file_while_writing<E: Send>(
    input: &ExportInput<'_>,
    more: Vec<ExportFile>,
    mut write: impl FnMut(ExportFile) -> Result<(), E> + Send,
) -> Result<BTreeMap<String, String>, E> {
    let mut sums = BTreeMap::new();
    write_while_making(rayon::current_num_threads(), FilesOf { input, more }, |file| {
        sums.extend(folders::sums("", std::slice::from_ref(&file)));
        write(file)
    })?;
    with_manifest_written(input, sums, write)
}

/// Writes the manifest, which lists the others by their sums.
fn with_manifest_written<E>(
    input: &ExportInput<'_>,
    mut sums: BTreeMap<String, String>,
    mut write: impl FnMut(ExportFile) -> Result<(), E>,
) -> Result<BTreeMap<String, String>, E> {
    let manifest = ExportFile::new("manifest.json", json::text(&Manifest::of(input, sums.clone())));
    sums.extend(folders::sums("", std::slice::from_ref(&manifest)));
    write(manifest)?;
    Ok(sums)
}

/// The files of an input but for the manifest.
struct FilesOf<'f, 'a> {
    input: &'f ExportInput<'a>,
    more: Vec<ExportFile>,
}

impl MakeFiles for FilesOf<'_, '_> {
    fn make<E>(self, mut add: &mut dyn FnMut(ExportFile) -> Result<(), E>) -> Result<(), E> {
        let Self { input, more } = self;
        site_files(input, &mut add)?;
        for at in 0..input.grids.count() {
            input.grids.with(at, |grid| storey_files(input, grid, &mut add))?;
        }
        more.into_iter().try_for_each(add)
    }
}

/// The files of the whole site.
fn site_files<E>(input: &ExportInput<'_>, add: &mut impl FnMut(ExportFile) -> Result<(), E>) -> Result<(), E> {
    add(ExportFile::new("site-frame.json", json::text(&SiteFrameFile::of(input.site))))?;
    add(ExportFile::new("report.json", json::text(&Report::of(input))))?;
    add(ExportFile::new("semantic.json", json::text(&Semantic::of(input))))?;
    add(ExportFile::new("waypoints.json", json::text(&Waypoints::of(input))))?;
    add(ExportFile::new("waypoints.csv", csv::waypoints(input)))?;
    add(ExportFile::new("waypoints.geojson", json::text(&waypoints::geojson(input))))?;
    if let Some(flight) = FlightDocument::of(input) {
        add(ExportFile::new("flight.json", json::text(&flight)))?;
    }
    add(ExportFile::new("site-graph.json", json::text(&SiteGraph::of(input))))?;
    match Geographic::of(input.site) {
        Ok(geographic) => add(ExportFile::new(geographic::FILE, json::text(&geographic.geojson(input)))),
        Err(_) => Ok(()),
    }
}

/// The files of a storey.
fn storey_files<E>(
    input: &ExportInput<'_>,
    grid: &Grid<'_>,
    add: &mut impl FnMut(ExportFile) -> Result<(), E>,
) -> Result<(), E> {
    let map_storey = grid.head.map_storey;
    let folder = storey_folder(input.site, map_storey, &input.site.map_storeys[map_storey as usize]);
    maps::files(&folder, grid).try_for_each(&mut *add)?;
    relief::files(&folder, grid).try_for_each(&mut *add)?;
    relief_picture::file(&folder, input, grid).map_or(Ok(()), &mut *add)?;
    pictures::files(&folder, input, grid).try_for_each(&mut *add)?;
    if let Some(probability) = &input.probability {
        probability_layer::files(&folder, input, grid, probability).into_iter().try_for_each(&mut *add)?;
    }
    safety_files::files(&folder, input, grid).into_iter().try_for_each(&mut *add)?;
    add(ExportFile::new(format!("{folder}/waypoints.yaml"), waypoints::nav2_yaml(input, map_storey)))?;
    add(ExportFile::new(format!("{folder}/route.geojson"), nav2_route_file(input, map_storey, "map")))?;
    add(mission_plan_picture::file(&folder, input, grid))
}

/// Files beside the folders of several plan times: what they are, and the map frame that they share.
///
/// `files` has the sums of all files in these folders, see [`sums`].
pub fn dated_files(site: &Site<'_>, dates: Vec<DatedFolder>, mut files: BTreeMap<String, String>) -> Vec<ExportFile> {
    let frame = ExportFile::new("site-frame.json", json::text(&SiteFrameFile::of(site)));
    files.extend(sums("", std::slice::from_ref(&frame)));
    let manifest = DatesManifest::of(site, dates, files);
    vec![frame, ExportFile::new("manifest.json", json::text(&manifest))]
}
