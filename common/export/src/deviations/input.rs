//! Inputs of the deviation files.

use frames::PlanTime;
use messages::{Deviations, ElementDeviationRecord, ScheduleState, Site};

/// Everything that these files are made from; the archives are of one site.
#[derive(Clone, Copy)]
pub struct DeviationExport<'a> {
    /// Geometry and facts.
    pub site: &'a Site<'a>,
    /// States at the plan time.
    pub schedule_state: &'a ScheduleState<'a>,
    /// What differs.
    pub deviations: &'a Deviations<'a>,
    /// When topics were made: the plan time, or that of the robot's map.
    pub created: PlanTime,
}

impl<'a> DeviationExport<'a> {
    /// GlobalId of an element.
    pub(super) fn global_id(&self, record: &ElementDeviationRecord) -> &'a str {
        self.site.text(self.site.elements[record.element as usize].global_id)
    }

    /// Name of the map storey.
    pub(super) fn storey(&self) -> &'a str {
        self.site.text(self.site.map_storeys[self.deviations.head.map_storey as usize].name)
    }
}
