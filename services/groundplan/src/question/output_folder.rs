//! Output folders of `convert` in place of models: which command answers, because they hold no model.

use crate::failure::Failure;
use crate::input_document::read_document;
use serde::Deserialize;
use serde::de::IgnoredAny;
use std::path::{Path, PathBuf};

/// What of `manifest.json` is read.
#[derive(Deserialize)]
struct Made {
    sources: Vec<Source>,
    plan_time: Option<String>,
    plan_until: Option<String>,
    /// Of a folder with a folder for each date.
    dates: Option<IgnoredAny>,
}

#[derive(Deserialize)]
struct Source {
    file: String,
}

/// Refuses an output folder among models. It holds maps, but neither the bodies nor the schedule that ways, doors and later dates
/// are judged by.
///
/// # Errors
/// That it is one, and the command that answers.
pub(super) fn refuse(models: &[PathBuf], command: &[&str], date: Option<&str>) -> Result<(), Failure> {
    let Some((folder, made)) = models.iter().find_map(|model| Some((model, made_of(model)?))) else { return Ok(()) };
    let quoted = |word: &&str| if word.contains(' ') { format!("'{word}'") } else { (*word).to_owned() };
    let names = made.sources.iter().map(|source| source.file.as_str());
    let mut words: Vec<String> =
        ["groundplan"].iter().chain(command).copied().chain(names).map(|w| quoted(&w)).collect();
    // Maps of a period are those of a day here.
    let day = |at: &str| at.split('T').next().unwrap_or_default().to_owned();
    let of_maps = made.plan_time.map(|at| if made.plan_until.is_some() { day(&at) } else { at });
    let date = date.map(str::to_owned).or(of_maps).or(made.dates.map(|_| "DATE".to_owned()));
    words.extend(date.into_iter().flat_map(|date| ["--date".to_owned(), date]));
    Err(Failure::usage(format!(
        "{} holds maps, and neither the model nor the schedule that the answer is drawn from: ask the model, {}",
        folder.display(),
        words.join(" ")
    )))
}

fn made_of(folder: &Path) -> Option<Made> {
    serde_json::from_slice(&read_document(&folder.join("manifest.json")).ok()?).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_of_maps_names_the_command_that_answers() {
        let home = tempfile::tempdir().unwrap();
        let models = [home.path().to_owned()];
        assert!(refuse(&models, &["room", "G.02"], None).is_ok(), "no folder of maps");
        let manifest = |until: &str, date| {
            let text = format!(
                r#"{{"sources": [{{"file": "a b.ifc"}}], "plan_time": "2024-04-15T08:00:00", "plan_until": {until}}}"#
            );
            std::fs::write(home.path().join("manifest.json"), text).unwrap();
            refuse(&models, &["way", "Lab 3", "G.02"], date).unwrap_err().to_string()
        };
        let why = manifest("null", None);
        assert!(why.ends_with("groundplan way 'Lab 3' G.02 'a b.ifc' --date 2024-04-15T08:00:00"), "{why}");
        assert!(manifest("\"2024-04-16T00:00:00\"", None).ends_with("--date 2024-04-15"));
        assert!(manifest("null", Some("2024-06-01")).ends_with("--date 2024-06-01"));
        std::fs::write(home.path().join("manifest.json"), r#"{"sources": [], "dates": []}"#).unwrap();
        assert!(refuse(&models, &["door", "x"], None).unwrap_err().to_string().ends_with("door x --date DATE"));
    }
}
