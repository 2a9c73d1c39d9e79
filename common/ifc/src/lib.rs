//! IFC bytes in, model out.
//!
//! [`read`] turns the bytes of one file into a [`Model`]: storeys, elements with their body meshes, spaces, openings,
//! doors, stairs, property sets, groups and classifications. Everything is in metres in the IFC world; the file's own units end here. Imperfect
//! input gives diagnostics, an error means that nothing could be made of the file.
//!
//! The foreign crate that scans STEP and tessellates is named in the private module `kernel` alone. All other modules
//! answer one question each and work on records: `units`, `placement`, `relations`, `spatial`, `representations` ..
//!
//! Records with a GlobalId are read in the order of it: the order of a file's lines, and its ids, mean nothing.
//!
//! Dates and durations of the schedule stay the texts that they are: what they mean is configuration, not ours.

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
mod geometry;
mod georeference;
mod groups;
mod header;
mod kernel;
mod materials;
mod memberships;
mod model;
mod options;
mod other_formats;
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
mod substitutes;
#[cfg(test)]
mod testing;
mod units;
mod wide_ids;

pub use container::unpack;
pub use diagnostics::{Diagnostic, DiagnosticCode, Named, Severity};
pub use error::ReadError;
pub use kernel::{MeshPool, mesh_task};
pub use memberships::MEMBERSHIP_SETS;
pub use model::{
    Door, DoorPanel, Element, Geometry, GeometryStatus, Georeference, MapConversion, MeshPart, Model, Opening,
    Placement, Property, PropertyValue, Source, Space, SpaceBoundary, Stair, Storey,
};
pub use options::{Isolation, Progress, ReadOptions, Stage};
pub use schedule::{
    DurationType, Lag, LagValue, LinkTarget, Recurrence, RecurrenceType, Schedule, Sequence, SequenceType, Task,
    TaskLink, TaskTime, WorkCalendar, WorkControl, WorkTime,
};

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
    let (bytes, written_ids) = if wide_ids::has_wide_ids(&bytes) {
        let renumbered = wide_ids::renumbered(&bytes)?;
        (renumbered.bytes.into(), renumbered.written_ids)
    } else {
        (bytes, wide_ids::WrittenIds::default())
    };
    let file = kernel::File::scan(&bytes, header.schema, written_ids, &mut report)?;
    let model = assemble::model(&file, header.label, options, &mut report)?;
    Ok((model, report.finish()))
}
