//! Deviation files: JSON, reported progress, BCF topics, image.

mod actuals;
mod bcf;
mod document;
mod input;
mod picture;
mod progress;
mod progress_mspdi;
mod topics;

pub use document::DeviationsDocument;
pub use input::DeviationExport;
pub use progress::{ProgressDate, TaskProgress};

use crate::input::ExportFile;
use crate::json;

/// `deviations.json`, `actuals.csv`, `deviations.bcfzip`, `deviations.png`; with schedule files also `progress.csv`.
pub fn deviation_files(input: &DeviationExport<'_>) -> Vec<ExportFile> {
    let progress = TaskProgress::all(input);
    let progress = (!progress.is_empty()).then(|| ExportFile::new("progress.csv", progress::table(input, &progress)));
    let files = [
        ExportFile::new("deviations.json", json::text(&DeviationsDocument::of(input))),
        ExportFile::new("actuals.csv", actuals::table(input)),
        ExportFile::new("deviations.bcfzip", bcf::container(input)),
        ExportFile::new("deviations.png", picture::picture(input)),
    ];
    files.into_iter().chain(progress).collect()
}

/// `progress.xml` for the first schedule file, `progress-2.xml` .. for the others: the tasks whose identities in the file (`uids`,
/// in the order of the tasks) are numbers, as those of MS Project and Primavera are.
pub fn progress_mspdi(input: &DeviationExport<'_>, uids: &[&str]) -> Vec<ExportFile> {
    let all = TaskProgress::all(input);
    let file = |source: usize| {
        let of_file = all.iter().filter(|progress| input.site.schedule.tasks[progress.task].source as usize == source);
        let with_uid = |progress: &'_ TaskProgress| uids.get(progress.task).and_then(|uid| uid.parse().ok());
        let tasks: Vec<(u32, &TaskProgress)> =
            of_file.filter_map(|progress| Some((with_uid(progress)?, progress))).collect();
        let name = if source == 0 { "progress.xml".to_owned() } else { format!("progress-{}.xml", source + 1) };
        (!tasks.is_empty()).then(|| ExportFile::new(name, progress_mspdi::document(input, &tasks)))
    };
    (0..input.site.schedule.sources.len()).filter_map(file).collect()
}
