//! IFC bytes in, model out.
//!
//! [`read`] turns the bytes of one file into a [`Model`]: storeys, elements with their body meshes, spaces, openings,
//! doors, stairs, property sets. Everything is in metres in the IFC world; the file's own units end here. Imperfect
//! input gives diagnostics, an error means that nothing could be made of the file.
//!
//! The foreign crate that scans STEP and tessellates is named in the private module `kernel` alone. All other modules
//! answer one question each and work on records: `units`, `placement`, `relations`, `spatial`, `representations` ..
//!
//! Dates and durations of the schedule stay the texts that they are: what they mean is configuration, not ours.

mod affine;
mod assemble;
mod boxes;
mod container;
mod doors;
mod error;
mod geometry;
mod georeference;
mod header;
mod kernel;
mod materials;
mod model;
mod placement;
mod products;
mod psets;
mod relations;
mod report;
mod representations;
mod schedule;
mod spatial;
mod stairs;
mod substitutes;
#[cfg(test)]
mod testing;
mod units;

pub use container::unpack;
pub use error::ReadError;
pub use model::{
    Diagnostic, Door, DoorPanel, Element, Geometry, GeometryStatus, Georeference, MapConversion, MeshPart, Model,
    Named, Opening, Placement, Property, PropertyValue, Severity, Source, Space, SpaceBoundary, Stair, Storey,
};
pub use schedule::{
    DurationType, Lag, LagValue, LinkTarget, Recurrence, RecurrenceType, Schedule, Sequence, SequenceType, Task,
    TaskLink, TaskTime, WorkCalendar, WorkControl, WorkTime,
};

/// How to read. Nothing here changes the result.
#[derive(Clone, Copy, Default)]
pub struct ReadOptions<'a> {
    /// Threads for meshing, with the deep stacks that it needs; 0: as many as rayon thinks right.
    pub threads: usize,
    /// Called as work advances, from any thread.
    pub progress: Option<&'a (dyn Fn(Progress) + Sync)>,
}

/// How far reading has come.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// What is being done.
    pub stage: Stage,
    /// Steps done in this stage.
    pub done: usize,
    /// Steps of this stage.
    pub total: usize,
}

/// What is being done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Records and relations; one step.
    Reading,
    /// Meshes; one step per product.
    Meshing,
}

/// Reads one file: plain STEP or a zip container, as [`unpack`] takes it.
///
/// The result depends on the bytes alone, not on threads or on the run.
///
/// # Errors
/// Nothing could be made of the file: see [`ReadError`].
pub fn read(bytes: &[u8], options: &ReadOptions<'_>) -> Result<(Model, Vec<Diagnostic>), ReadError> {
    let mut report = report::Report::default();
    let bytes = unpack(bytes)?;
    let header = header::read(&bytes, &mut report)?;
    let file = kernel::File::scan(&bytes, header.schema, &mut report)?;
    let model = assemble::model(&file, header.label, options, &mut report)?;
    Ok((model, report.finish()))
}

impl ReadOptions<'_> {
    fn report(&self, stage: Stage, done: usize, total: usize) {
        if let Some(progress) = self.progress {
            progress(Progress { stage, done, total });
        }
    }
}
