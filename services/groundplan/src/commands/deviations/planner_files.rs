//! `progress-NAME`: the planner's own XER or P6 XML file, with the progress of its tasks and everything else byte for byte.

use crate::failure::Failure;
use as_built::{PlannerFileError, TaskUpdate, TaskUpdates, updated_pmxml, updated_xer};
use export::{DeviationExport, ExportFile, TaskProgress};
use input_files::read_regular_file;
use std::path::{Path, PathBuf};
use tasks::MAX_SCHEDULE_FILE_BYTES;

/// The files of those schedule files that are of Primavera P6. `uids` are identities of the tasks in their files.
///
/// # Errors
/// A file that cannot be read again, or has no place for progress.
pub(super) fn planner_files(
    input: &DeviationExport<'_>,
    uids: &[&str],
    plans: &[PathBuf],
) -> Result<Vec<ExportFile>, Failure> {
    let all = TaskProgress::all(input);
    let mut files = Vec::new();
    for (source, path) in plans.iter().enumerate() {
        let of_file = all.iter().filter(|task| input.site.schedule.tasks[task.task].source as usize == source);
        let updates: TaskUpdates =
            of_file.filter_map(|task| Some((uids.get(task.task)?.to_string(), update(task)))).collect();
        let bytes =
            read_regular_file(path, MAX_SCHEDULE_FILE_BYTES).map_err(|error| failed(path, &error.to_string()))?;
        let updated: fn(&[u8], &TaskUpdates) -> Result<Vec<u8>, PlannerFileError> = match format_of(&bytes) {
            Some(Format::Xer) => updated_xer,
            Some(Format::P6Xml) => updated_pmxml,
            None => continue,
        };
        let bytes = updated(&bytes, &updates).map_err(|error| failed(path, &error.to_string()))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        // Two files of one name are in two folders.
        let name = match files.iter().any(|file: &ExportFile| file.path == format!("progress-{name}")) {
            true => format!("progress-{}-{name}", source + 1),
            false => format!("progress-{name}"),
        };
        files.push(ExportFile::new(name, bytes));
    }
    Ok(files)
}

fn failed(path: &Path, why: &str) -> Failure {
    Failure::work(format!("{}: {why}", path.display()))
}

enum Format {
    Xer,
    P6Xml,
}

/// By their first bytes, as they are read.
fn format_of(bytes: &[u8]) -> Option<Format> {
    let head = &bytes[..bytes.len().min(4096)];
    let has = |text: &[u8]| head.windows(text.len()).any(|part| part == text);
    match head {
        _ if head.starts_with(b"ERMHDR") || head.starts_with(b"\xef\xbb\xbfERMHDR") => Some(Format::Xer),
        _ if has(b"APIBusinessObjects") => Some(Format::P6Xml),
        _ => None,
    }
}

/// What was seen and reported; what the file has itself stays.
fn update(task: &TaskProgress) -> TaskUpdate {
    let date = |date: &Option<export::ProgressDate>| date.as_ref().map(|date| date.at.clone());
    TaskUpdate {
        percent: task.percent().map(|percent| percent as f64),
        start: date(&task.actual_start),
        finish: date(&task.actual_finish),
    }
}
