//! IFC bytes in, model out.
//!
//! [`read`] turns the bytes of one file into a [`Model`]: storeys, elements with their body meshes, spaces, openings,
//! doors, stairs, property sets, groups and classifications. Everything is in metres in the IFC world; the file's own units end here. Imperfect
//! input gives diagnostics, an error means that nothing could be made of the file.
//!
//! The foreign crate that scans STEP and tessellates is named in the private module `kernel` alone. All other modules
//! answer one question each and work on records: `units`, `placement`, `relations`, `spatial`, `representations` ..
//!
//! [`StepFile`] gives the records themselves, for readers of other data.
//!
//! Records with a GlobalId are read in the order of it: the order of a file's lines, and its ids, mean nothing.
//!
//! Dates and durations of the schedule stay the texts that they are: what they mean is configuration, not ours.
//!
//! # Guarantees
//!
//! - An unknown unit is an error, never 1.0.
//! - Records that share a GlobalId are read by what they contain and refer to (`src/kernel/record_order.rs`), so that nothing
//!   behind depends on an exporter's order. Only triangles of elements with several openings follow ids, because they are cut
//!   in their order.
//! - What dates mean is decided in `schedule`.
//! - Ids above 32 bits are renumbered before the kernel sees them (`src/wide_ids.rs`), texts that are not UTF-8 are decoded
//!   by a guess that is told (`src/encoding.rs`). Messages name the file's own ids.
//! - The index of a file takes eight bytes a record, and the kernel makes its own while it meshes; a file of 4 GiB is
//!   refused.
//! - Bodies are meshed on a `MeshPool`, whose stacks are deep enough for the kernel; a conversion reads, draws and plans on
//!   the same threads.
//! - What cannot be meshed is drawn as its bounding box and reported. A panic of the kernel is caught and has the same
//!   effect.
//! - Openings are cut by `geometry::difference_of_solids` where the body and its openings are closed meshes
//!   (`src/own_cuts.rs`), however they overlap; the kernel cuts what has gaps, and where a difference would have some. Which
//!   way an element was cut is in its `Geometry`.
//! - What the kernel's booleans would take long for is left out and reported (`src/cut_budget.rs`): their work is counted
//!   from the records, so that the result does not depend on the machine. It is pairs of faces; triples of triangles of
//!   openings or operands that cross each other and are no parallel prisms, because the kernel computes each of their points
//!   exactly; and pairs of corners of inner bounds, because a body with many holes cuts one face into very many pieces
//!   (`src/crossing_cutters.rs`, `src/face_counts.rs`). The kernel counts its own exact predicates and gives up by that
//!   count, but not the many cheap ones, and it has no hook in their loops: therefore the estimate before it, and the process
//!   around it.
//! - With a `MeshCache` only what has changed since an earlier reading is meshed and cut, and the result is equal byte for byte to
//!   that without it. A body is known by a hash of all that the kernel makes it of (`src/kernel/content_keys.rs`): its records in
//!   the order in which they are met, placements, styles, materials, those of its types, openings, units and contexts, whatever
//!   the ids are; and it counts only in the frame of the file in which it was meshed. Bodies of which the kernel complains, and
//!   those that are costly to cut, are always made anew (`src/kernel/cached.rs`).
//! - Bodies of which nothing bounds the kernel's work (`src/bounded_items.rs`), and those whose cuts may be far more work
//!   than they are estimated, are meshed where the caller says; programs give them to a process of their own
//!   (`common/daemon/src/mesh_process.rs`), which is the program again. It answers batch by batch, so what ends it takes no
//!   other's result with it: the batch is meshed again one by one, and what overflows its stack, takes 10 s of CPU time or 3
//!   GiB there is drawn without its cuts, or, if it has none or fails again, is its bounding box (`src/kernel/request.rs`).
//!   Six of them in a file, or 60 s of CPU time for costly cuts, and the others of their kind are not tried: a limit for
//!   machines and files that the counts do not know.
//!
//! # Where
//!
//! - body: what the kernel gets in place of the file's records: `src/substitutes.rs`, `src/kernel/patch.rs`
//! - body: what is far from the origin of its product's frame, and how it is meshed there: `src/far_bodies.rs`
//! - body: when its meshes of an earlier reading are taken: `src/mesh_cache.rs`, `src/kernel/cached.rs`
//! - body: which representation of a product it is: `src/representations.rs`
//! - groups, zones, classifications of elements and spaces: `src/groups.rs`, `src/classifications.rs`, `src/memberships.rs`
//! - tasks: what the file says: `src/schedule/tasks.rs`, `src/schedule/times.rs`, `src/schedule/calendars.rs`
//! - units of a file: `src/units.rs`

mod affine;
mod assemble;
mod boolean_chain;
mod bounded_items;
mod bounding_boxes;
mod classifications;
mod container;
mod crossing_cutters;
mod cut_budget;
mod door_cuts;
mod doors;
mod encoding;
mod error;
mod face_counts;
mod far_bodies;
mod geometry;
mod georeference;
mod groups;
mod header;
mod kernel;
mod materials;
mod memberships;
mod mesh_cache;
mod mesh_parts;
mod model;
mod options;
mod other_formats;
mod own_cuts;
mod placement;
mod prism_axes;
mod product_body;
mod products;
mod property_sets;
mod relations;
mod representations;
mod schedule;
mod segments;
mod spatial;
mod stairs;
mod step_file;
mod substitutes;
mod terrain_faces;
#[cfg(test)]
mod testing;
mod units;
mod wide_ids;

pub use container::unpack;
pub use diagnostics::{Diagnostic, DiagnosticCode, Named, Severity};
pub use error::ReadError;
pub use georeference::MAP_CONVERSION_SETS;
pub use kernel::{MeshPool, Record, Value, mesh_task};
pub use memberships::MEMBERSHIP_SETS;
pub use mesh_cache::{MeshCache, MeshCacheCounts, MeshCacheError};
pub use model::{
    CutPath, Door, DoorPanel, Element, Geometry, GeometryStatus, Georeference, MapConversion, MeshPart, Model, Opening,
    Placement, Property, PropertyValue, Source, Space, SpaceBoundary, Stair, Storey, Terrain,
};
pub use options::{Isolation, Progress, ReadOptions, Stage};
pub use schedule::{
    DurationType, Lag, LagValue, LinkTarget, Recurrence, RecurrenceType, Schedule, Sequence, SequenceType, Task,
    TaskLink, TaskTime, WorkCalendar, WorkControl, WorkTime,
};
pub use step_file::StepFile;

/// Reads one file: plain STEP or a zip container, as [`unpack`] takes it.
///
/// The result depends on the bytes alone, not on threads or on the run.
///
/// # Errors
/// Nothing could be made of the file: see [`ReadError`].
pub fn read(bytes: &[u8], options: &ReadOptions<'_>) -> Result<(Model, Vec<Diagnostic>), ReadError> {
    let mut report = diagnostics::Report::default();
    let bytes = encoding::as_utf_8(unpack(bytes)?, &mut report);
    let header = header::read(&bytes, &mut report)?;
    let (bytes, written_ids) = wide_ids::narrowed(bytes)?;
    let file = kernel::File::scan(&bytes, header.schema, written_ids, &mut report)?;
    let model = assemble::model(&file, header.label, options, &mut report)?;
    Ok((model, report.finish()))
}
