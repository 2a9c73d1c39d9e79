//! Typed observations to be written: of tasks, of elements, and of what is no element of the model.

use crate::change_list::{FileEntry, NotWritten};
use frames::PlanTime;

/// Everything that was observed, from all sources.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Observations {
    /// Files and tables that observations come from.
    pub sources: Vec<FileEntry>,
    /// Progress of tasks.
    pub tasks: Vec<TaskObservation>,
    /// What was observed of elements; several of one element are written into one property set.
    pub elements: Vec<ElementObservation>,
    /// What stands on the site and is no element of the model.
    pub additional: Vec<AdditionalElement>,
    /// What was not written already for reasons of the caller's.
    pub not_written: Vec<NotWritten>,
}

/// Where an observation comes from.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Provenance {
    /// Place in the sources.
    pub source: usize,
    /// Row of the source, for people.
    pub row: String,
    /// Who observed, reported or confirmed it.
    pub observer: String,
    /// When, at the site.
    pub at: Option<PlanTime>,
}

/// Progress of a task of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct TaskObservation {
    /// GlobalId of the task.
    pub global_id: String,
    /// When it began; `None` leaves what the model has.
    pub start: Option<PlanTime>,
    /// When it ended; `None` leaves what the model has.
    pub finish: Option<PlanTime>,
    /// Share that is done, from 0 to 1; `None` if it is not known. A task that ended is done.
    pub completion: Option<f64>,
    /// Where this comes from.
    pub provenance: Provenance,
}

/// What was observed of an element of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct ElementObservation {
    /// GlobalId of the element.
    pub global_id: String,
    /// What.
    pub what: ElementFinding,
    /// Where this comes from.
    pub provenance: Provenance,
}

/// What was observed of an element.
#[derive(Debug, Clone, PartialEq)]
pub enum ElementFinding {
    /// Work on it began, or ended.
    Progress {
        /// When it began, if that is known.
        start: Option<PlanTime>,
        /// When it ended; `None` while work goes on.
        finish: Option<PlanTime>,
        /// True if no task of the model builds it: a task is added.
        needs_task: bool,
    },
    /// It is not there. It stays in the model.
    Absent,
    /// It stands beside its place, and is moved.
    Displaced {
        /// How far, in the world of the file, in metres.
        by_m: [f64; 2],
        /// Standard deviation of that, in metres.
        deviation_m: f64,
    },
}

/// What stands on the site and is no element of the model.
#[derive(Debug, Clone, PartialEq)]
pub struct AdditionalElement {
    /// Rings in the world of the file, in metres: exteriors counter-clockwise, holes clockwise.
    pub rings_m: Vec<Vec<[f64; 2]>>,
    /// Height in the world where it begins, in metres: the floor.
    pub bottom_z_m: f64,
    /// Height in the world up to which it is known, in metres.
    pub top_z_m: f64,
    /// GlobalId of the storey that it stands on.
    pub storey: String,
    /// Where this comes from.
    pub provenance: Provenance,
}
