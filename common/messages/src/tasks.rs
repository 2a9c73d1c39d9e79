//! The `tasks` archive: the work schedule of schedule files, linked to the elements and spaces of a site.

use crate::archive::ArchiveError;
use crate::content_hash::ContentHash;
use crate::declaration::declare_archive;
use crate::diagnostic_record::DiagnosticRecord;
use crate::schedule_records::{ScheduleSourceRecord, ScheduleText};
use crate::work_schedule::{LinkTargets, WorkSchedule, WorkScheduleRecords};
use bytemuck::{Pod, Zeroable};

/// Head of the archive: one record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct TasksHead {
    /// Content hash of the site whose elements and spaces the tasks work on.
    pub site_hash: ContentHash,
    /// Number of its elements.
    pub n_elements: u32,
    /// Number of its spaces.
    pub n_spaces: u32,
    /// Number of its IfcBuildingStoreys.
    pub n_storeys: u32,
    /// Zero.
    pub reserved: u32,
}
const _: () = assert!(size_of::<TasksHead>() == 24);

declare_archive! {
    /// The tasks of schedule files, read in place; [`crate::Site::with_tasks`] puts them in the place of those of the models.
    ///
    /// All indices inside were checked when it was opened, so slicing by them does not panic.
    view Tasks;
    /// Records of a `tasks` archive to be.
    owned TasksBuilder;
    sections {
        /// The site, and the numbers of what tasks may work on.
        pub head: one(1, TasksHead),
        /// Schedule files.
        sources: many(41, ScheduleSourceRecord),
        /// The work schedule.
        schedule: group(WorkSchedule, WorkScheduleRecords),
        /// The rule that made each link.
        link_rules: many(40, ScheduleText),
        /// What is wrong with the files and links.
        diagnostics: many(19, DiagnosticRecord),
        /// All texts.
        texts: texts(2),
    }
}

impl<'a> Tasks<'a> {
    /// The work schedule.
    pub fn schedule(&self) -> WorkSchedule<'a> {
        let Self { sources, schedule, link_rules, diagnostics, texts, .. } = *self;
        WorkSchedule { texts, tasks_hash: self.content_hash(), sources, link_rules, diagnostics, ..schedule }
    }

    fn check(&self) -> Result<(), ArchiveError> {
        let TasksHead { n_elements, n_spaces, n_storeys, .. } = *self.head;
        let [elements, spaces, storeys] = [n_elements, n_spaces, n_storeys].map(|n| n as usize);
        self.schedule().check(LinkTargets { elements, spaces, storeys })?;
        let has_rules = self.link_rules.len() == self.schedule.task_links.len();
        if has_rules { Ok(()) } else { Err(ArchiveError::Index { what: "a link of the tasks" }) }
    }
}

impl TasksHead {
    /// The head of tasks that work on a site.
    pub fn of_site(site: &crate::Site<'_>) -> Self {
        Self {
            site_hash: site.content_hash(),
            n_elements: site.elements.len() as u32,
            n_spaces: site.spaces.len() as u32,
            n_storeys: site.storeys.len() as u32,
            ..Self::default()
        }
    }
}

impl Default for TasksHead {
    fn default() -> Self {
        Self::zeroed()
    }
}
