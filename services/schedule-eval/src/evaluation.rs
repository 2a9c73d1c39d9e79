//! The evaluated schedule of a site: its own tasks, or those of schedule files.

use crate::schedule_files::Plans;
use bus::{CheckedSample, Topic};
use messages::{ArchiveBuffer, ArchiveError, ContentHash, OtherSite, Site, Tasks, payload};
use schedule::{EvaluateError, Overrides, Rules, Timeline, evaluate};
use tasks::LinkError;

/// The evaluated schedule of a site.
pub(crate) struct Evaluated {
    pub(crate) timeline: Timeline,
    pub(crate) update_instants_s: Vec<i64>,
    /// The archive of the tasks of schedule files; `None` without such files.
    pub(crate) tasks: Option<ArchiveBuffer>,
    pub(crate) site_hash: ContentHash,
    pub(crate) frame_epoch: u64,
    pub(crate) n_tasks: usize,
}

/// A schedule that cannot be used with a site.
#[derive(Debug, thiserror::Error)]
pub(crate) enum EvaluationError {
    #[error(transparent)]
    Link(#[from] LinkError),
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    #[error(transparent)]
    OtherSite(#[from] OtherSite),
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
}

/// Evaluates the schedule of a site, or of a candidate for one.
pub(crate) fn evaluated<T: Topic<Payload = payload::Site>>(
    site: &CheckedSample<T>,
    rules: &Rules,
    plans: &Plans,
    overrides: &Overrides,
) -> Result<Evaluated, EvaluationError> {
    let frame_epoch = site.bytes().header().frame_epoch;
    let site: Site<'_> = site.view();
    let tasks = if plans.files.is_empty() { None } else { Some(tasks_of(&site, rules, plans)?) };
    let of_files = tasks.as_ref().map(|tasks| Tasks::open(tasks.bytes())).transpose()?;
    let scheduled = of_files.as_ref().map_or(Ok(site), |tasks| site.with_tasks(tasks))?;
    let timeline = evaluate(&scheduled, rules, overrides)?;
    let (update_instants_s, n_tasks) = (timeline.update_instants_s(), scheduled.schedule.tasks.len());
    Ok(Evaluated { timeline, update_instants_s, site_hash: site.content_hash(), frame_epoch, n_tasks, tasks })
}

fn tasks_of(site: &Site<'_>, rules: &Rules, plans: &Plans) -> Result<ArchiveBuffer, LinkError> {
    let links = tasks::link(site, &plans.files, &rules.links, &plans.table)?;
    Ok(tasks::tasks_of(site, &plans.files, &rules.links, &links).finish())
}
