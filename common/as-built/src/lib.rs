//! Writes observations of a site back into its IFC model: bytes and typed observations in, bytes and a list of changes out.
//!
//! [`write`] changes single lines of a STEP file and adds lines at the end of its data; everything else stays byte for byte.
//! IFC2X3, IFC4 and IFC4X3.
//!
//! # Guarantees
//!
//! - The same input gives the same bytes: GlobalIds of what is added come from the sha256 of what they stand for, times from the
//!   observations. Ids of instances that are added are above the greatest of the file.
//! - Nothing is deleted. An absent element stays in the model, and a property set says that it is absent.
//! - Everything that is written is in the list of changes, by line, with the observations behind it, and everything that is not,
//!   with the reason.
//! - What was written before is brought up to date, and neither written nor moved twice.
//! - A text that is added is ASCII (`\X2\`), whatever the encoding of the file is; lines end as those of the file do.
//!
//! # What is written
//!
//! - A task: ActualStart, ActualFinish, StatusTime and Completion of its IfcTaskTime; of IFC2X3 of the IfcScheduleTimeControl of
//!   its IfcRelAssignsTasks, with dates as entities. What is missing of these is added. A time that several tasks share is copied
//!   first (IFC4), or not written (IFC2X3, where it has a GlobalId).
//! - An element: a property set `Groundplan_AsBuilt` with what was observed, dates, observer and the sha256 of the evidence, which
//!   `schedule` reads as reported progress; a task where no task of the model builds it.
//! - A displaced element: its placement. Its line is changed, or, where others share it, the element gets its own. Openings, what
//!   fills them and parts move along, by their placement relative to it or by their own; so does what else is placed relative
//!   to it.
//! - An additional element: an IfcBuildingElementProxy of the outline that was seen, from the floor up to the height that is known,
//!   in its storey.
//! - Owner histories of what is added and changed, by a person and an application of our own. What has none keeps none where the
//!   schema lets it have none.
//! - Files of planners ([`updated_xer`], [`updated_pmxml`]): status, actual dates, per cent and remaining duration of tasks.

mod additional;
mod change_list;
mod editor;
mod global_id;
mod observations;
mod owner_history;
mod placement;
mod planner_pmxml;
mod planner_update;
mod planner_xer;
mod property_set;
mod step_file;
mod step_text;
mod tasks;
mod units;
mod write;

pub use change_list::{ChangeList, FileEntry, LineChange, LineChangeKind, NotWritten, WrittenObservation};
pub use observations::{
    AdditionalElement, ElementFinding, ElementObservation, Observations, Provenance, TaskObservation,
};
pub use planner_pmxml::updated_pmxml;
pub use planner_update::{PlannerFileError, TaskUpdate, TaskUpdates};
pub use planner_xer::updated_xer;
pub use property_set::PROPERTY_SET;
pub use write::{AsBuilt, sha256_hex, write};

/// A model that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum AsBuiltError {
    /// Another format, a container, or two bytes for a character.
    #[error(
        "it is no IFC file in STEP (ISO-10303-21) with one byte for a character: unpack .ifczip, and export other formats as .ifc"
    )]
    NotStep,
    /// No schema.
    #[error("its header names no schema (FILE_SCHEMA)")]
    NoSchema,
    /// A schema that is not written.
    #[error("its schema is {label}: as-built models are written as IFC2X3, IFC4 or IFC4X3")]
    Schema {
        /// FILE_SCHEMA.
        label: String,
    },
    /// No end.
    #[error("it is cut off: its data has no end (ENDSEC)")]
    Cut,
    /// No ids for what is new.
    #[error("its instance #{id} leaves no room for ids of new instances: number it anew")]
    Ids {
        /// The greatest id.
        id: u64,
    },
}
