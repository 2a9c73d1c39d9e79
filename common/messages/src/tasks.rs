//! The `tasks` archive: the work schedule of schedule files, linked to the elements and spaces of a site.

use crate::archive::{Archive, ArchiveBuffer, ArchiveError, ArchiveKind, SectionList};
use crate::archive_writer::ArchiveWriter;
use crate::diagnostic_record::DiagnosticRecord;
use crate::payload;
use crate::schedule_records::{ScheduleSourceRecord, ScheduleText};
use crate::site_records::section;
use crate::text_pool::TextPool;
use crate::work_schedule::{LinkTargets, WorkSchedule};
use crate::work_schedule_records::WorkScheduleRecords;
use bytemuck::{Pod, Zeroable};

/// Head of the archive: one record.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Zeroable, Pod)]
#[repr(C)]
pub struct TasksHead {
    /// Content hash of the site whose elements and spaces the tasks work on.
    pub site_hash: u64,
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

/// The tasks of schedule files, read in place; [`crate::Site::with_tasks`] puts them in the place of those of the models.
///
/// All indices inside were checked when it was opened, so slicing by them does not panic.
#[derive(Debug, Clone, Copy)]
pub struct Tasks<'a> {
    archive: Archive<'a>,
    /// The site, and the numbers of what tasks may work on.
    pub head: &'a TasksHead,
    /// The work schedule.
    pub schedule: WorkSchedule<'a>,
}

impl<'a> Tasks<'a> {
    /// Validates and views an archive.
    ///
    /// # Errors
    /// Bytes that are no whole tasks archive, or records that point outside their sections.
    pub fn open(bytes: &'a [u8]) -> Result<Self, ArchiveError> {
        let tasks = Self::of(Archive::open(bytes, ArchiveKind::Tasks)?)?;
        let TasksHead { n_elements, n_spaces, n_storeys, .. } = *tasks.head;
        let [elements, spaces, storeys] = [n_elements, n_spaces, n_storeys].map(|n| n as usize);
        tasks.schedule.check(LinkTargets { elements, spaces, storeys })?;
        let has_rules = tasks.schedule.link_rules.len() == tasks.schedule.task_links.len();
        if has_rules { Ok(tasks) } else { Err(ArchiveError::Index { what: "a link of the tasks" }) }
    }

    /// The sections of an archive, without validation of their records.
    pub(crate) fn of(archive: Archive<'a>) -> Result<Self, ArchiveError> {
        Ok(Self { archive, head: archive.record(section::HEAD)?, schedule: WorkSchedule::of_files(archive)? })
    }

    /// Hash of the content.
    pub fn content_hash(&self) -> u64 {
        self.archive.content_hash()
    }
}

/// Records of a `tasks` archive to be.
#[derive(Debug, Default)]
#[expect(missing_docs, reason = "the fields are those of `Tasks` and `WorkSchedule`")]
pub struct TasksBuilder {
    pub texts: TextPool,
    pub head: TasksHead,
    pub sources: Vec<ScheduleSourceRecord>,
    pub schedule: WorkScheduleRecords,
    /// The rule that made each link.
    pub link_rules: Vec<ScheduleText>,
    pub diagnostics: Vec<DiagnosticRecord>,
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

impl TasksBuilder {
    /// Writes the archive into the heap.
    pub fn finish(&self) -> ArchiveBuffer {
        self.to_buffer()
    }

    fn sections(&self) -> SectionList<'_> {
        let mut list = SectionList::default();
        list.add(section::HEAD, std::slice::from_ref(&self.head));
        list.add(section::SCHEDULE_SOURCES, &self.sources);
        self.schedule.add_to(&mut list);
        list.add(section::LINK_RULES, &self.link_rules);
        list.add(section::DIAGNOSTICS, &self.diagnostics);
        list.add(section::STRINGS, self.texts.bytes());
        list
    }
}

impl ArchiveWriter for TasksBuilder {
    type Payload = payload::Tasks;

    fn length(&self) -> usize {
        self.sections().length()
    }

    fn write(&self, out: &mut [u8]) -> u64 {
        self.sections().write(out, ArchiveKind::Tasks)
    }
}
