//! `groundplan check`: whether a model is fit for a robot, as text, JSON, a page and BCF topics.

use crate::args::read_model;
use crate::failure::Failure;
use crate::output_file::OutputFile;
use crate::question::{AnswerText, QuestionArgs};
use crate::run::{Outcome, Run};
use answers::{Circumstances, FindError, Situation};
use bcf::BcfVersion;
use ids::{Ids, IdsReport, Scope};
use input_files::{MAX_CONFIGURATION_BYTES, read_regular_file};
use jiff::Timestamp;
use messages::{Site, WaypointKind};
use model_check::{ModelCheck, StoreyPicture, check};
use schemars::JsonSchema;
use serde::Serialize;
use site_answers::{Answer, Question};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
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

    /// Check the models against requirements of the project, too, an IDS file; `groundplan` stands for those of maps
    #[arg(long, value_name = "FILE.ids")]
    ids: Vec<PathBuf>,
}

/// Stands for the shipped file of requirements.
const SHIPPED_IDS: &str = "groundplan";

const AFTER_HELP: &str = "\
What will be wrong on the robot's maps and why, element by element, the worst first: each issue with its
effect in square metres, doors and rooms, and with advice for the author of the model. Issues that change
maps come first, then what is wrong or missing in the data; what this robot cannot pass in a building that
is modelled well is apart, and no issue. All of it is listed in the JSON document, which has a schema:
config/schemas/model-check.schema.json.
Requirements in IDS 1.0 (--ids) are those of a project, or the ones in config/ids/groundplan.ids, which authors
load into their own tools; what fails is in text and JSON, not on the page and in BCF. A requirement for
another release of IFC than the model's is told as not checked.

Examples:
  groundplan check house.ifc
  groundplan check house.ifc structure.ifc --robot config/robots/default.toml
  groundplan check house.ifc --html house.html --bcf house.bcfzip
  groundplan check house.ifc --ids groundplan --ids project.ids
  groundplan check house.ifc --json | jq -r '.issues[] | .title'

Exit codes: 0 the model is fit, 1 failed, 2 bad usage or configuration, 3 there are issues that change
maps, or requirements that are not met, 4 the maps of the running daemons may not be used.";

impl Run for Args {
    /// Checks the models, and writes the files that are asked for.
    ///
    /// # Errors
    /// Bad arguments, models that cannot be read, no daemons, files that cannot be written.
    fn run(&self) -> Result<Outcome, Failure> {
        let inputs: Vec<PathBuf> =
            self.of.inputs().chain(self.ids.iter().map(PathBuf::as_path)).map(Path::to_owned).collect();
        let [html, bcf] = [("--html", &self.html), ("--bcf", &self.bcf)]
            .map(|(option, path)| path.as_deref().map(|path| OutputFile::of(option, path, &inputs)).transpose());
        let (html, bcf) = (html?, bcf?);
        if html.is_some() && html == bcf {
            return Err(Failure::usage("--html and --bcf name one file"));
        }
        let question = Checked { arguments: self, files: Mutex::default(), ids: self.ids_reports()? };
        let outcome = self.of.answer(&question, &["check"])?;
        let files = question.files.into_inner().unwrap_or_else(PoisonError::into_inner);
        for (file, bytes) in [(html, files.html), (bcf, files.bcf)] {
            if let Some((file, bytes)) = file.zip(bytes) {
                file.write(&bytes)?;
            }
        }
        Ok(outcome)
    }
}

impl Args {
    /// Each model against each file of requirements; `None` without any.
    fn ids_reports(&self) -> Result<Option<Vec<IdsCheck>>, Failure> {
        if self.ids.is_empty() {
            return Ok(None);
        }
        if self.of.models().is_empty() {
            return Err(Failure::usage("--ids needs the model files: a running site does not keep them"));
        }
        let mut reports = Vec::new();
        for file in &self.ids {
            let bytes = match file.as_os_str() == SHIPPED_IDS {
                true => ids::GROUNDPLAN.as_bytes().to_vec(),
                false => read_regular_file(file, MAX_CONFIGURATION_BYTES)
                    .map_err(|why| Failure::usage(format!("{} cannot be read: {why}", file.display())))?,
            };
            let requirements = Ids::read(&bytes).map_err(|why| Failure::usage(format!("{}: {why}", file.display())))?;
            for model in self.of.models() {
                let report = ids::check(&requirements, &read_model(model)?, Scope::OfRelease);
                let report = report.map_err(|why| Failure::work(format!("{}: {why}", model.display())))?;
                reports.push(IdsCheck { model: name_of(model), requirements: name_of(file), report });
            }
        }
        Ok(Some(reports))
    }
}

fn name_of(path: &Path) -> String {
    path.display().to_string()
}

/// The document: what is wrong on maps, and which requirements are not met.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub(crate) struct CheckDocument {
    /// The model as a robot's maps have it.
    #[serde(flatten)]
    check: ModelCheck,
    /// Each model against each file of requirements; null without any.
    ids: Option<Vec<IdsCheck>>,
}

/// A model against a file of requirements.
#[derive(Debug, Clone, Serialize, JsonSchema)]
struct IdsCheck {
    /// The model.
    model: String,
    /// The IDS file.
    requirements: String,
    /// What is met and what is not.
    report: IdsReport,
}

impl CheckDocument {
    /// True if no issue changes maps, and no requirement that was checked fails.
    fn is_fit(&self) -> bool {
        self.check.fit && self.ids.iter().flatten().all(|ids| ids.report.passed)
    }
}

/// What is written beside the answer.
#[derive(Debug, Default)]
struct Files {
    html: Option<Vec<u8>>,
    bcf: Option<Vec<u8>>,
}

/// The question, and the files that are made of its situation beside the answer.
struct Checked<'a> {
    arguments: &'a Args,
    files: Mutex<Files>,
    ids: Option<Vec<IdsCheck>>,
}

impl Checked<'_> {
    fn files(&self, situation: &Situation<'_>, answer: &ModelCheck) -> Files {
        let Args { of, html, bcf, bcf_version, .. } = self.arguments;
        if html.is_none() && bcf.is_none() {
            return Files::default();
        }
        let pictures = StoreyPicture::all(situation);
        let page = || model_check::page(answer, &pictures, situation.site).into_bytes();
        let container = || {
            let created = answer.circumstances.plan_time.clone().unwrap_or_else(|| changed_last(of.models()));
            let topics = model_check::topics(answer, &pictures, situation.site, &created);
            bcf::written(&topics, BcfVersion::of(bcf_version).unwrap_or_default())
        };
        Files { html: html.as_ref().map(|_| page()), bcf: bcf.as_ref().map(|_| container()) }
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
    type Answer = CheckDocument;

    fn find(&self, _: &Site<'_>) -> Result<(), FindError> {
        Ok(())
    }

    fn options(&self, _: &Site<'_>, (): &(), options: MissionPlanOptions) -> MissionPlanOptions {
        // Whether rooms are reached is looked at all the same.
        let kinds: BTreeSet<_> = options.kinds.into_iter().filter(|kind| *kind != WaypointKind::Scan).collect();
        MissionPlanOptions { kinds, ..options }
    }

    fn depends_on_start(&self) -> bool {
        true
    }

    fn answer(&self, situation: &Situation<'_>, (): &()) -> CheckDocument {
        let check = check(situation);
        *self.files.lock().unwrap_or_else(PoisonError::into_inner) = self.files(situation, &check);
        CheckDocument { check, ids: self.ids.clone() }
    }

    fn verdict(&self, situation: &Situation<'_>, (): &()) -> Option<bool> {
        Some(check(situation).fit)
    }
}

impl Answer for CheckDocument {
    fn verdict(&self) -> Option<bool> {
        Some(self.is_fit())
    }

    fn circumstances(&self) -> &Circumstances {
        &self.check.circumstances
    }
}

impl AnswerText for CheckDocument {
    fn text(&self) -> String {
        let ids = self.ids.iter().flatten();
        let ids = ids.map(|ids| format!("\n{} against {}\n{}", ids.model, ids.requirements, ids.report.text()));
        std::iter::once(self.check.text()).chain(ids).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped_schema::assert_shipped_schema;

    #[test]
    fn the_shipped_schema_is_that_of_the_document() {
        assert_shipped_schema("model-check", &schemars::schema_for!(CheckDocument));
    }

    #[test]
    fn topics_of_the_same_files_have_the_same_time() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.ifc");
        std::fs::write(&path, "x").unwrap();
        let time = changed_last(std::slice::from_ref(&path));
        assert_eq!(time, changed_last(&[path, PathBuf::from("none.ifc")]));
    }
}
