//! Deviation files: JSON, reported progress, BCF topics, image.

mod actuals;
mod document;
mod input;
mod picture;
mod progress;
mod progress_mspdi;
mod topic_files;
mod topics;

pub use document::DeviationsDocument;
pub use input::DeviationExport;
pub use progress::{ProgressDate, TaskProgress};

use crate::input::ExportFile;
use crate::json;
use bcf::{BcfError, BcfVersion, Container};

/// `deviations.json`, `actuals.csv`, `deviations.bcfzip`, `deviations.png`; with schedule files also `progress.csv`.
pub fn deviation_files(input: &DeviationExport<'_>) -> Vec<ExportFile> {
    files_with(input, topic_files::container(input, BcfVersion::default()))
}

/// The same with topics in a version of BCF.
pub fn deviation_files_in(input: &DeviationExport<'_>, version: BcfVersion) -> Vec<ExportFile> {
    files_with(input, topic_files::container(input, version))
}

/// The same with the topics of an earlier comparison: those of elements that are as planned now are closed, with a comment, and none
/// is lost.
///
/// # Errors
/// A topic of the earlier container whose markup cannot be changed.
pub fn deviation_files_after(input: &DeviationExport<'_>, earlier: Container) -> Result<Vec<ExportFile>, BcfError> {
    Ok(files_with(input, topic_files::updated(input, earlier)?))
}

fn files_with(input: &DeviationExport<'_>, topics: Vec<u8>) -> Vec<ExportFile> {
    let progress = TaskProgress::all(input);
    let progress = (!progress.is_empty()).then(|| ExportFile::new("progress.csv", progress::table(input, &progress)));
    let files = [
        ExportFile::new("deviations.json", json::text(&DeviationsDocument::of(input))),
        ExportFile::new("actuals.csv", actuals::table(input)),
        ExportFile::new("deviations.bcfzip", topics),
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
