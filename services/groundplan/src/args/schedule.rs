//! Schedule arguments: rules of dates, delays, reported progress.

use super::models::ModelArgs;
use crate::failure::Failure;
use crate::progress_line::ProgressLine;
use input_files::{MAX_CONFIGURATION_BYTES, read_regular_file, read_regular_text};
use jiff::tz::TimeZone;
use messages::{ArchiveBuffer, Site, Tasks};
use schedule::{Actual, Delay, Overrides, Probabilities, Rules, Timeline, parse_actuals};
use std::path::{Path, PathBuf};
use tasks::{LinkRules, Links, MAX_SCHEDULE_FILE_BYTES, ScheduleFile, TableLink};

/// Rules of dates, and overrides of the schedule.
#[derive(Debug, Clone, clap::Args)]
pub struct ScheduleArgs {
    /// Rules of dates, construction phases and closed spaces [default: see config/schedule.toml]
    #[arg(long, value_name = "FILE")]
    schedule: Option<PathBuf>,

    /// Schedule of the planner, in the place of that of the models: MS Project XML, Primavera XER or P6 XML, CSV, XLSX; may be
    /// repeated. [[link]] of the rules says which elements its tasks work on
    #[arg(long, value_name = "PLAN")]
    schedule_file: Vec<PathBuf>,

    /// Links of tasks with elements, which go before the rules: a CSV table with the columns global_id, task, effect, as
    /// `groundplan link --csv` writes it
    #[arg(long, value_name = "FILE.csv", requires = "schedule_file")]
    link: Option<PathBuf>,

    /// What if: delay a task and all that depends on it, by GlobalId, identification or name; may be repeated
    #[arg(long, value_name = "TASK=5d")]
    delay: Vec<String>,

    /// Reported progress, which replaces planned dates: a CSV table with the columns id, start, finish
    #[arg(long, alias = "actual", value_name = "FILE.csv")]
    actuals: Option<PathBuf>,
}

impl ScheduleArgs {
    /// Rules and reported progress alone.
    pub(crate) fn of_progress(schedule: Option<PathBuf>, actuals: Option<PathBuf>) -> Self {
        Self { schedule, actuals, schedule_file: Vec::new(), link: None, delay: Vec::new() }
    }

    /// True if dates are not those of the models and rules alone.
    pub(crate) fn changes_dates(&self) -> bool {
        !self.delay.is_empty() || self.actuals.is_some()
    }

    /// True if a planner's schedule is given.
    pub(crate) fn has_files(&self) -> bool {
        !self.schedule_file.is_empty()
    }

    /// The planner's schedules.
    pub(crate) fn files(&self) -> &[PathBuf] {
        &self.schedule_file
    }

    /// The files that are read.
    pub(crate) fn inputs(&self) -> impl Iterator<Item = &Path> {
        let single = [&self.schedule, &self.link, &self.actuals].into_iter().flatten();
        single.chain(&self.schedule_file).map(PathBuf::as_path)
    }
}

/// A file of the schedule that cannot be used.
#[derive(Debug, thiserror::Error)]
#[error("{}", path.display())]
struct FileError {
    path: PathBuf,
    source: Box<dyn std::error::Error + Send + Sync>,
}

/// Schedule arguments of the command line.
pub(crate) struct ScheduleInput {
    rules: Rules,
    overrides: Overrides,
    files: Vec<ScheduleFile>,
    table: Vec<TableLink>,
}

/// Tasks of schedule files that were linked with a site.
pub(crate) struct LinkedTasks(Option<ArchiveBuffer>);

impl LinkedTasks {
    /// The site with these tasks in the place of those of its models, or as it is without schedule files.
    ///
    /// # Errors
    /// An archive that cannot be.
    pub(crate) fn site<'a>(&'a self, site: &Site<'a>) -> Result<Site<'a>, Failure> {
        let Some(archive) = &self.0 else { return Ok(*site) };
        let tasks = Tasks::open(archive.bytes()).map_err(Failure::work)?;
        site.with_tasks(&tasks).map_err(Failure::work)
    }
}

impl ScheduleInput {
    /// Reads the files that are named.
    ///
    /// # Errors
    /// Files that cannot be read or mean nothing, delays of another form.
    pub(crate) fn read(arguments: &ScheduleArgs) -> Result<Self, Failure> {
        let rules = arguments.schedule.as_deref().map_or(Ok(Rules::default()), |path| {
            let text = read_regular_text(path, MAX_CONFIGURATION_BYTES).map_err(|e| usage(path, e.into()))?;
            Rules::parse(&text).map_err(|e| usage(path, e.into()))
        })?;
        let actuals = arguments.actuals.as_deref().map_or(Ok(Vec::new()), |path| {
            let bytes = daemon::read_progress(path).map_err(|e| usage(path, e.into()))?;
            parse_actuals(&bytes).map_err(|e| usage(path, e.into()))
        })?;
        let files = read_files(&arguments.schedule_file, &rules)?;
        let table = arguments.link.as_deref().map_or(Ok(Vec::new()), |path| {
            let bytes = read_regular_file(path, MAX_SCHEDULE_FILE_BYTES).map_err(|e| usage(path, e.into()))?;
            tasks::parse_link_table(&bytes).map_err(|e| usage(path, e.into()))
        })?;
        let delays = arguments.delay.iter().map(|text| Delay::parse(text)).collect::<Result<_, _>>();
        Ok(Self {
            files,
            table,
            rules,
            overrides: Overrides { delays: delays.map_err(Failure::usage)?, actuals, ..Overrides::default() },
        })
    }

    /// The zone of the site, for dates with an offset.
    pub(crate) fn site_zone(&self) -> Option<&TimeZone> {
        self.rules.site_zone.as_ref()
    }

    /// The same with the files of an older revision of the plan, without delays. Progress may be of tasks that it has not.
    ///
    /// # Errors
    /// Files that cannot be read.
    pub(crate) fn of_older_files(&self, paths: &[PathBuf]) -> Result<Self, Failure> {
        let actuals = self.overrides.actuals.clone();
        Ok(Self {
            files: read_files(paths, &self.rules)?,
            table: self.table.clone(),
            rules: self.rules.clone(),
            overrides: Overrides { actuals, is_of_earlier_revision: true, ..Overrides::default() },
        })
    }

    /// The rules, and the progress that was reported.
    pub(crate) fn into_rules_and_actuals(self) -> (Rules, Vec<Actual>) {
        (self.rules, self.overrides.actuals)
    }

    /// Base names of the schedule files.
    pub(crate) fn file_names(&self) -> Vec<String> {
        self.files.iter().map(|file| file.file.clone()).collect()
    }

    /// Identities of the tasks in their schedule files, in the order of the `tasks` archive.
    pub(crate) fn task_uids(&self) -> Vec<&str> {
        self.files.iter().flat_map(|file| file.plan.tasks.iter().map(|task| task.uid.as_str())).collect()
    }

    /// The schedule files.
    pub(crate) fn plans(&self) -> &[ScheduleFile] {
        &self.files
    }

    /// The rules that link their tasks.
    pub(crate) fn link_rules(&self) -> &LinkRules {
        &self.rules.links
    }

    /// Links the tasks of the schedule files with a site.
    ///
    /// # Errors
    /// Too many links.
    pub(crate) fn links(&self, site: &Site<'_>) -> Result<Links, Failure> {
        tasks::link(site, &self.files, &self.rules.links, &self.table).map_err(Failure::usage)
    }

    /// The tasks of the schedule files, linked with a site.
    ///
    /// # Errors
    /// Too many links.
    pub(crate) fn linked_tasks(&self, site: &Site<'_>) -> Result<LinkedTasks, Failure> {
        if self.files.is_empty() {
            return Ok(LinkedTasks(None));
        }
        let links = self.links(site)?;
        Ok(LinkedTasks(Some(tasks::tasks_of(site, &self.files, &self.rules.links, &links).finish())))
    }

    /// Works out the schedule of a site.
    ///
    /// # Errors
    /// Dates that can be read in two ways, or overrides of unknown tasks or elements.
    pub(crate) fn timeline(&self, site: &Site<'_>) -> Result<Timeline, Failure> {
        schedule::evaluate(site, &self.rules, &self.overrides).map_err(Failure::usage)
    }

    /// Simulates the schedule of a site around the dates of its timeline.
    ///
    /// # Errors
    /// More runs of the tasks than there is room for, rules of the prototype.
    pub(crate) fn probabilities<'t>(
        &self,
        site: &Site<'_>,
        timeline: &'t Timeline,
    ) -> Result<Probabilities<'t>, Failure> {
        schedule::probabilities(site, &self.rules, &self.overrides, timeline).map_err(Failure::usage)
    }
}

fn usage(path: &Path, source: Box<dyn std::error::Error + Send + Sync>) -> Failure {
    Failure::usage(FileError { path: path.to_owned(), source })
}

fn read_files(paths: &[PathBuf], rules: &Rules) -> Result<Vec<ScheduleFile>, Failure> {
    let file = |path: &PathBuf| {
        let bytes = read_regular_file(path, MAX_SCHEDULE_FILE_BYTES).map_err(|e| usage(path, e.into()))?;
        let name = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
        ScheduleFile::read(&name, &bytes, &rules.reading).map_err(Failure::usage)
    };
    paths.iter().map(file).collect()
}

/// Reads the models, works out their schedule, and goes on with both on the threads that were asked for.
///
/// # Errors
/// Those of reading, of the schedule, and of the work.
pub(crate) fn with_timeline<T: Send>(
    model: &ModelArgs,
    schedule: &ScheduleInput,
    work: impl FnOnce(&Site<'_>, &Timeline, &ProgressLine) -> Result<T, Failure> + Send,
) -> Result<T, Failure> {
    let progress = ProgressLine::new(false);
    let pool = model.pool()?;
    pool.install(|| {
        let site = model.site(&pool, None, 1, &progress)?;
        let site = Site::open(site.bytes()).map_err(Failure::work)?;
        let tasks = schedule.linked_tasks(&site)?;
        let site = tasks.site(&site)?;
        work(&site, &schedule.timeline(&site)?, &progress)
    })
}
