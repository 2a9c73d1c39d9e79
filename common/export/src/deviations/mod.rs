//! Deviation files: JSON, reported progress, BCF topics, image.

mod actuals;
mod bcf;
mod document;
mod input;
mod picture;
mod topics;

pub use document::DeviationsDocument;
pub use input::DeviationExport;

use crate::input::ExportFile;
use crate::json;

/// `deviations.json`, `actuals.csv`, `deviations.bcfzip`, `deviations.png`.
pub fn deviation_files(input: &DeviationExport<'_>) -> Vec<ExportFile> {
    vec![
        ExportFile::new("deviations.json", json::text(&DeviationsDocument::of(input))),
        ExportFile::new("actuals.csv", actuals::table(input)),
        ExportFile::new("deviations.bcfzip", bcf::container(input)),
        ExportFile::new("deviations.png", picture::picture(input)),
    ]
}
