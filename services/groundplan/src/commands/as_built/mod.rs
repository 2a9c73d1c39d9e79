//! `groundplan as-built`: what was reported, observed and confirmed, written back into a model.

mod compared;
mod gathered;
mod observations;
mod output;
mod running;
mod text;

use crate::args::{ModelArgs, ScheduleArgs, ScheduleInput, SiteOfRobotArgs, read_model};
use crate::failure::Failure;
use crate::progress_line::ProgressLine;
use crate::run::{Outcome, Run};
use as_built::AsBuilt;
use gathered::Gathered;
use messages::Site;
use observations::{SiteOfModel, observations};
use output::Outputs;
use std::path::PathBuf;

/// Arguments of `as-built`.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = AFTER_HELP)]
pub struct Args {
    /// IFC file (.ifc) of the site: IFC2X3, IFC4 or IFC4X3
    #[arg(value_name = "MODEL.ifc")]
    model: PathBuf,

    /// The new file; never one that is read
    #[arg(short, long, value_name = "NEW.ifc")]
    out: PathBuf,

    /// Write the list of changes too: each line that is changed or new, the observation behind it, what was not written and why
    #[arg(long, value_name = "CHANGES.json")]
    changes: Option<PathBuf>,

    /// Replace NEW.ifc and CHANGES.json if they are there
    #[arg(long)]
    force: bool,

    /// Reported progress: a CSV table with the columns id, start, finish, as for `convert`; who gives `absent` as a start confirms
    /// it [default: with --deviations none, else that of the running daemons]
    #[arg(long, value_name = "FILE.csv")]
    actuals: Option<PathBuf>,

    /// What differs, as `groundplan deviations` writes it (deviations.json) [default: with --actuals none, else what the running
    /// daemon found]
    #[arg(long, value_name = "FILE.json")]
    deviations: Option<PathBuf>,

    /// Elements of the deviations that are absent or displaced indeed, by GlobalId, and obstacles by their number from 1 there; may
    /// be repeated. Absences that `groundplan confirm` confirmed count too
    #[arg(long, value_name = "GLOBALID|NUMBER")]
    confirm: Vec<String>,

    /// Rules of dates [default: those of the running daemons; with files see config/schedule.toml]
    #[arg(long, value_name = "FILE")]
    schedule: Option<PathBuf>,

    /// Print the list of changes on standard output and nothing else there
    #[arg(long)]
    json: bool,

    /// The site.
    #[command(flatten)]
    site: SiteOfRobotArgs,
}

const AFTER_HELP: &str = "\
All lines of the model stay byte for byte but those in the list of changes; nothing is deleted.
Progress: actual dates and completion of the tasks that it names; of elements the property set
Groundplan_AsBuilt with observer, time and sha256 of the evidence, which groundplan reads as
reported progress. A task whose elements are all reported gets their dates, one of some its
completion, and an element without a task gets one.
Absent: the element stays, and the property set says so.
Displaced: its placement is moved, with its openings, what fills them and its parts.
An obstacle: a proxy of its outline, from the floor up to the lidar's plane, since nothing is known
above that.
What nobody confirmed is listed, and neither moved nor said to be absent.
The list of changes has a schema: config/schemas/as-built.schema.json.

Examples:
  groundplan as-built house.ifc -o new.ifc
  groundplan as-built house.ifc -o new.ifc --actuals progress.csv --changes changes.json
  groundplan as-built house.ifc -o new.ifc --deviations d.json --confirm 0T8xbPmeHQFhEy1wPGGLbq

Exit codes: 0 written, 1 failed (nothing to write, no daemons), 2 bad usage or configuration.";

impl Run for Args {
    /// Writes the new model and the list of changes.
    ///
    /// # Errors
    /// A model or files that cannot be read or written, a confirmation of what is not there, nothing to write; no daemons.
    fn run(&self) -> Result<Outcome, Failure> {
        let inputs = [Some(&self.model), self.actuals.as_ref(), self.deviations.as_ref(), self.schedule.as_ref()];
        let inputs: Vec<PathBuf> = inputs.into_iter().flatten().cloned().collect();
        let outputs = Outputs::of(&self.out, self.changes.as_deref(), self.force, &inputs)?;
        let model = read_model(&self.model)?;
        let written = if self.actuals.is_some() || self.deviations.is_some() {
            self.of_files(&model)
        } else {
            self.of_running_site(&model)
        }?;
        if written.changes.observations.is_empty() {
            let why = match text::not_written(&written.changes) {
                why if why.is_empty() => ": no progress was reported, and nothing that differs is confirmed".to_owned(),
                why => why,
            };
            return Err(Failure::work(format!("nothing was written, and there is no new file{why}")));
        }
        outputs.write(&written)?;
        Ok(if self.json { Outcome::json(&written.changes)? } else { text::text(&written.changes).into() })
    }
}

impl Args {
    fn of_files(&self, model: &[u8]) -> Result<AsBuilt, Failure> {
        let schedule = ScheduleArgs::of_progress(self.schedule.clone(), self.actuals.clone());
        let (rules, actuals) = ScheduleInput::read(&schedule)?.into_rules_and_actuals();
        let mut gathered = Gathered::default();
        if let Some(path) = &self.actuals {
            gathered.add_reports(path, actuals)?;
        }
        if let Some(path) = &self.deviations {
            gathered.add_deviations(path)?;
        }
        let models = ModelArgs::new(vec![self.model.clone()], true);
        let progress = ProgressLine::new(false);
        let pool = models.pool()?;
        pool.install(|| {
            let site = models.site(&pool, None, 1, &progress)?;
            let site = Site::open(site.bytes()).map_err(Failure::work)?;
            self.write(model, &SiteOfModel { site: &site, source: 0, rules: &rules }, &gathered)
        })
    }

    fn of_running_site(&self, model: &[u8]) -> Result<AsBuilt, Failure> {
        let config = self.site.config()?;
        running::with_site(&config, model, self.schedule.as_deref(), !self.confirm.is_empty(), |site, gathered| {
            self.write(model, site, gathered)
        })
    }

    fn write(&self, model: &[u8], site: &SiteOfModel<'_>, gathered: &Gathered) -> Result<AsBuilt, Failure> {
        let observations = observations(site, gathered, &self.confirm)?;
        let names = [&self.model, &self.out].map(|path| path.file_name().unwrap_or_default().to_string_lossy());
        let written = as_built::write(model, [&names[0], &names[1]], &observations);
        written.map_err(|error| Failure::usage(format!("{}: {error}", self.model.display())))
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn what_is_written_is_what_is_read() {
        assert_eq!(as_built::PROPERTY_SET, schedule::AS_BUILT_SET);
    }
}
