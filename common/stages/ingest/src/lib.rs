//! Ingestion: IFC files in, `site` archive out.
//!
//! [`ingest`] reads the files, fixes the map frame, finds which storeys can be walked, and computes once what several
//! stages need: clear widths, passages, the spaces that a door joins. The model of `ifc` ends here.
//!
//! Several files are one site. Each lies where its map conversion puts it, with units and scales applied, or where
//! [`IngestOptions::places`] puts it by hand; they lie within 100 m of another, in any order. Elements with one GlobalId and
//! different bodies are refused, or the last file counts ([`IngestOptions::prefer_last`]).
//!
//! The map frame makes the dominant wall direction parallel to the axes. It is fixed once, independent of the date, and kept
//! by later runs ([`IngestOptions::frame`]); another building has another ([`IngestOptions::frame_of`]).
//!
//! A part of a storey that lies more than 5 cm higher or lower, has 5 m2 of floor with 1.3 m of headroom, and a room on it
//! or a way to it, is a map storey of its own ("Ground floor -0.25 m"), behind those of the files' storeys.
//!
//! What cannot be meshed is replaced by its bounding box and reported. A file of which that is more than half is refused
//! without [`IngestOptions::allow_boxes`].
//!
//! # Guarantees
//!
//! - A canopy has no map: a level needs a door, stair, ramp or step that leads to it, or a room.
//! - Map storeys depend on the model alone, not on the robot: the storeys of the files from low to high, then levels split
//!   off from them from low to high.
//! - Floor is what is modelled as floor; the outline of a room is none. A room without a slab is assumed to have floor if its
//!   storey has hardly any slabs, or if nothing lies below it (`src/assumed_rooms.rs`); a storey with neither slabs nor rooms
//!   has what walls enclose, less what is open to a storey below. One warning names the rooms.
//! - Lift shafts, risers and pits, known by their names or the lift in them (`src/shafts.rs`), are on no map storey. A model
//!   without floor faces, spaces and walls has no floor (`no_floor`).
//! - What replaces a body that could not be meshed may stop a robot, but never carry one: a bounding box is no floor.
//! - What is ground is decided once (`src/ground_class.rs`): floor of maps follows from it, and the stage `ground` makes its
//!   surface from it. Terrain that is an element is also an obstacle on maps where it rises into the slab; the shape of the site
//!   or a road itself is ground alone.
//! - Terrain of 50,000 triangles, or of more than two for each cell of 5 cm, is simplified (`src/terrain.rs`): by at most a
//!   centimetre in height, and a diagnostic tells from how many triangles to how many, and how far off it is at most.
//! - Which elements touch a space is judged by boxes, on every site, because schedules also come from files that ingest does
//!   not know: so a space is blocked too often rather than too rarely.
//! - Measures of a stair that its body contradicts are replaced by those of the body, with a warning.
//!
//! # Where
//!
//! - door: openings that something else fills: `src/filled_openings.rs`
//! - door: parts: `src/door_parts.rs`
//! - door: width: `src/door_width.rs`
//! - door: without a body: `src/bodiless_doors.rs`
//! - frame of the map: `src/site_frame.rs`, `services/ifc-ingest/src/site_store.rs`, `services/ifc-ingest/src/service.rs`
//! - opening of a wall in plan: `src/openings.rs`
//! - space: elements that touch one without boundaries: `src/contacts.rs`
//! - ground: classes of elements; terrain that is none: `src/ground_class.rs`, `src/terrain.rs`
//! - stair: which measures count: `src/stairs.rs`, `common/geometry/src/treads.rs`

mod assumed_rooms;
mod attributes;
mod bodiless_doors;
mod by_global_id;
mod classify;
mod contacts;
mod diagnostics;
mod door_leaves;
mod door_parts;
mod door_width;
mod doors;
mod error;
mod federation;
mod filled_openings;
mod floor_levels;
mod floor_samples;
mod ground_class;
mod input;
mod merge;
mod meshes;
mod openings;
mod outdoors;
mod passages;
mod progress;
mod schedule_merge;
mod schedule_records;
mod shafts;
mod site_archive;
mod site_frame;
mod site_storeys;
mod spaces;
mod split_levels;
mod stairs;
mod storeys;
mod terrain;
mod terrain_faults;
mod walkable;

pub use doors::operation_is_known;
pub use error::IngestError;
pub use ground_class::{EARTH as EARTH_ENTITIES, FLOORS as FLOOR_ENTITIES};
pub use ifc::{Isolation, MeshCache, MeshCacheCounts, MeshCacheError, MeshPool, mesh_task};
pub use input::{FilePlacement, IngestOptions, MAX_MODEL_BYTES, MAX_SPACES, SourceFile};
pub use progress::{Progress, Stage};
pub use site_frame::SiteFrame;
pub use stairs::{RISER_HEIGHTS_M, SETS as STAIR_SETS, TREAD_LENGTHS_M};

use ifc::GeometryStatus;
use merge::{FileModel, Merged};
use messages::{ArchiveBuffer, SiteOutline, is_same_building};

/// Reads the files as one site and writes its archive.
///
/// # Errors
/// A file that cannot be read or has no usable unit, files that do not belong together, GlobalIds with two bodies.
pub fn ingest(files: &[SourceFile], options: &IngestOptions<'_>) -> Result<ArchiveBuffer, IngestError> {
    let mut models = Vec::with_capacity(files.len());
    let lengths: Vec<usize> = files.iter().map(|file| file.bytes.len()).collect();
    for (index, (file, span)) in files.iter().zip(progress::spans(&lengths)).enumerate() {
        let name = file.name();
        let report = |step: ifc::Progress<'_>| (options.progress)(progress::of_file(&name, span, step));
        report(ifc::Progress { stage: ifc::Stage::Reading, done: 0, total: 1, waits_for: None });
        let read_options = ifc::ReadOptions {
            pool: options.pool,
            progress: Some(&report),
            isolation: options.isolation,
            cache: options.cache,
        };
        let (model, diagnostics) =
            ifc::read(&file.bytes, &read_options).map_err(|source| IngestError::Read { file: name.clone(), source })?;
        if !options.allow_boxes {
            check_bodies(&name, &model)?;
        }
        let place = options.places.get(index).copied().flatten();
        models.push(FileModel { file, model, diagnostics, place });
    }
    (options.progress)(progress::JOINING);
    let mut merged = Merged::of(models, options.prefer_last)?;
    let n_spaces = merged.model.spaces.len();
    if n_spaces > MAX_SPACES {
        return Err(IngestError::TooManySpaces { n_spaces });
    }
    let own_frame = SiteFrame::of(&merged.model, options.frame_epoch);
    let is_of_building = |site: &SiteOutline| {
        let elements = &merged.model.elements;
        let n_shared = elements.iter().filter(|e| site.elements.contains_key(&*e.id.global_id)).count();
        is_same_building(n_shared, elements.len(), site.elements.len())
    };
    let kept = options.frame.filter(|_| options.frame_of.is_none_or(is_of_building));
    let frame = kept.unwrap_or(own_frame);
    merged.diagnostics.extend(frame.misfit(&own_frame).map(|d| (messages::NONE, d)));
    let site = site_archive::site_of(files, &merged, frame);
    // Its meshes are in the site now; with the archive there would be three copies of them.
    drop(merged);
    Ok(site.finish())
}

/// Refuses a model that the kernel could mesh little of: a map of boxes looks like one of a building.
fn check_bodies(file: &str, model: &ifc::Model) -> Result<(), IngestError> {
    let is_whole_box = |g: &ifc::Geometry| matches!(g.status, GeometryStatus::BoundingBox { .. }) && g.parts.len() == 1;
    let is_lost = |g: &ifc::Geometry| is_whole_box(g) || matches!(g.status, GeometryStatus::Failed { .. });
    let bodies = || model.elements.iter().filter(|e| e.geometry.status != GeometryStatus::None);
    let (n_lost, n_bodies) = (bodies().filter(|e| is_lost(&e.geometry)).count(), bodies().count());
    let Some(first) = bodies().find(|e| is_lost(&e.geometry)).filter(|_| 2 * n_lost > n_bodies) else { return Ok(()) };
    let why = match &first.geometry.status {
        GeometryStatus::BoundingBox { why } | GeometryStatus::Failed { why } => why.clone(),
        GeometryStatus::None | GeometryStatus::Meshed => String::new(),
    };
    Err(IngestError::MostlyBoxes {
        file: file.to_owned(),
        n_lost,
        n_bodies,
        element: format!("{} #{} {}", first.ifc_type, first.id.step_id, first.id.global_id),
        why,
    })
}
