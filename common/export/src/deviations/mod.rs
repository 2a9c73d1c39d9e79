//! What differs between model and robot's map, as files: JSON, reported progress, BCF topics, a picture.

mod actuals;
mod bcf;
mod document;
mod picture;
mod topics;

pub use document::DeviationsDocument;

use crate::{ExportFile, json};
use frames::PlanTime;
use messages::{Deviations, ElementDeviationRecord, Phase, Site};

/// Everything that these files are made from; the archives are of one site.
#[derive(Clone, Copy)]
pub struct DeviationExport<'a> {
    /// Geometry and facts.
    pub site: &'a Site<'a>,
    /// States at the plan time.
    pub phase: &'a Phase<'a>,
    /// What differs.
    pub deviations: &'a Deviations<'a>,
    /// When topics were made: the plan time, or that of the robot's map.
    pub created: PlanTime,
}

/// `deviations.json`, `actuals.csv`, `deviations.bcfzip`, `deviations.png`.
pub fn deviation_files(input: &DeviationExport<'_>) -> Vec<ExportFile> {
    vec![
        ExportFile::new("deviations.json", json::text(&DeviationsDocument::of(input))),
        ExportFile::new("actuals.csv", actuals::table(input)),
        ExportFile::new("deviations.bcfzip", bcf::container(input)),
        ExportFile::new("deviations.png", picture::picture(input)),
    ]
}

impl<'a> DeviationExport<'a> {
    /// GlobalId of an element.
    fn global_id(&self, record: &ElementDeviationRecord) -> &'a str {
        self.site.text(self.site.elements[record.element as usize].global_id)
    }

    /// Name of the map storey.
    fn storey(&self) -> &'a str {
        self.site.text(self.site.map_storeys[self.deviations.head.map_storey as usize].name)
    }
}
