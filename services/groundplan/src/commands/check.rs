//! `groundplan check`: whether a model is fit for a robot, as text, JSON, a page and BCF topics.

use crate::failure::Failure;
use crate::question::{Answer, Question, QuestionArgs};
use crate::run::{Outcome, Run};
use answers::{Circumstances, FindError, Situation};
use bcf::BcfVersion;
use jiff::Timestamp;
use messages::Site;
use model_check::{ModelCheck, StoreyPicture, check};
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use waypoints::MissionPlanOptions;

/// Arguments of `check`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// Of what.
    #[command(flatten)]
    of: QuestionArgs,

    /// Write the check as one page that needs no other file
    #[arg(long, value_name = "FILE.html")]
    html: Option<PathBuf>,

    /// Write a BCF topic for each element: with camera, selection and a picture of the map around it
    #[arg(long, value_name = "FILE.bcfzip")]
    bcf: Option<PathBuf>,

    /// Version of the BCF file
    #[arg(long, value_name = "VERSION", requires = "bcf", default_value = "2.1", value_parser = ["2.1", "3.0"])]
    bcf_version: String,
}

const AFTER_HELP: &str = "\
What will be wrong on the robot's maps and why, element by element, the worst first: each issue with its
effect in square metres, doors and rooms, and with advice for the author of the model. Issues that change
maps come first, then what is wrong or missing in the data; what this robot cannot pass in a building that
is modelled well is apart, and no issue. All of it is listed in the JSON document, which has a schema:
config/schemas/model-check.schema.json.

Examples:
  groundplan check house.ifc
  groundplan check house.ifc structure.ifc --robot config/robots/default.toml
  groundplan check house.ifc --html house.html --bcf house.bcfzip
  groundplan check house.ifc --json | jq -r '.issues[] | .title'

Exit codes: 0 the model is fit, 1 failed, 2 bad usage or configuration, 3 there are issues that change
maps, 4 the maps of the running daemons may not be used.";

impl Run for Args {
    /// Checks the models, and writes the files that are asked for.
    ///
    /// # Errors
    /// Bad arguments, models that cannot be read, no daemons, files that cannot be written.
    fn run(&self) -> Result<Outcome, Failure> {
        let question = Checked { arguments: self, files: Mutex::default() };
        let outcome = self.of.answer(&question)?;
        for (path, bytes) in question.files.into_inner().unwrap_or_else(PoisonError::into_inner) {
            let unwritable = |e| Failure::work(format!("{} cannot be written: {e}", path.display()));
            daemon::write_durably(&path, &bytes).map_err(unwritable)?;
        }
        Ok(outcome)
    }
}

/// The question, and the files that are made of its situation beside the answer.
struct Checked<'a> {
    arguments: &'a Args,
    files: Mutex<Vec<(PathBuf, Vec<u8>)>>,
}

impl Checked<'_> {
    fn files(&self, situation: &Situation<'_>, answer: &ModelCheck) -> Vec<(PathBuf, Vec<u8>)> {
        let Args { of, html, bcf, bcf_version } = self.arguments;
        if html.is_none() && bcf.is_none() {
            return Vec::new();
        }
        let pictures = StoreyPicture::all(situation);
        let page = || model_check::page(answer, &pictures, situation.site).into_bytes();
        let container = || {
            let created = answer.circumstances.plan_time.clone().unwrap_or_else(|| changed_last(of.models()));
            let topics = model_check::topics(answer, &pictures, situation.site, &created);
            bcf::written(&topics, BcfVersion::of(bcf_version).unwrap_or_default())
        };
        let html = html.iter().map(|path| (path.clone(), page()));
        html.chain(bcf.iter().map(|path| (path.clone(), container()))).collect()
    }
}

/// When the newest of the files was changed, so that the same files give the same topics; now, without files.
fn changed_last(files: &[PathBuf]) -> String {
    let changed = |path: &PathBuf| Timestamp::try_from(path.metadata().ok()?.modified().ok()?).ok();
    let newest = files.iter().filter_map(changed).max().unwrap_or_else(Timestamp::now);
    newest.strftime("%Y-%m-%dT%H:%M:%SZ").to_string()
}

impl Question for Checked<'_> {
    type Found = ();
    type Answer = ModelCheck;

    fn command(&self) -> Vec<&str> {
        vec!["check"]
    }

    fn find(&self, _: &Site<'_>) -> Result<(), FindError> {
        Ok(())
    }

    fn options(&self, _: &Site<'_>, (): &(), options: MissionPlanOptions) -> MissionPlanOptions {
        // Whether rooms are reached is looked at all the same.
        MissionPlanOptions { scans: false, ..options }
    }

    fn depends_on_start(&self) -> bool {
        true
    }

    fn answer(&self, situation: &Situation<'_>, (): &()) -> ModelCheck {
        let answer = check(situation);
        *self.files.lock().unwrap_or_else(PoisonError::into_inner) = self.files(situation, &answer);
        answer
    }

    fn verdict(&self, situation: &Situation<'_>, (): &()) -> Option<bool> {
        Some(check(situation).fit)
    }
}

impl Answer for ModelCheck {
    fn verdict(&self) -> Option<bool> {
        Some(self.fit)
    }

    fn circumstances(&self) -> &Circumstances {
        &self.circumstances
    }

    fn text(&self) -> String {
        self.text()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn topics_of_the_same_files_have_the_same_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ifc");
        std::fs::write(&path, "x").unwrap();
        let time = changed_last(std::slice::from_ref(&path));
        assert_eq!(time, changed_last(&[path, PathBuf::from("none.ifc")]));
    }
}
