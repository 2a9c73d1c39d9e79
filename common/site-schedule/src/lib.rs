//! The schedule in force of a running site, for those who say what will be: the page, questions, and a server that draws ahead.
//!
//! schedule-eval publishes the state of one instant. What else its schedule says is evaluated here once more, from the rules and the
//! progress in the state folder, and counts only where it gives the state that is published, byte for byte: while files are changing
//! nothing is said of another schedule. On a robot that follows a server the rules and the progress are elsewhere.

use daemon::{Failure, SiteConfig, progress_in_force, rules_in_force};
use jiff::tz::TimeZone;
use messages::{ArchiveError, ScheduleState, Site};
use schedule::{Actual, EvaluateError, Overrides, Rules, Timeline, evaluate, parse_actuals};

/// The schedule in force.
#[derive(Debug)]
pub struct ScheduleInForce {
    /// All of its instants.
    pub timeline: Timeline,
    /// The zone of the site; `None` if its rules name none.
    pub site_zone: Option<TimeZone>,
    /// The same schedule as if nothing had been reported or observed; `None` if nothing was.
    pub planned: Option<Timeline>,
    /// What people reported.
    pub reported: Vec<Actual>,
    /// What robots observed.
    pub observed: Vec<Actual>,
}

/// Why the schedule in force is not known here.
#[derive(Debug, thiserror::Error)]
pub enum UnknownSchedule {
    /// Rules or progress cannot be read.
    #[error(transparent)]
    Files(Failure),
    /// It cannot be evaluated.
    #[error(transparent)]
    Evaluation(#[from] EvaluateError),
    /// What is published cannot be read.
    #[error(transparent)]
    Archive(#[from] ArchiveError),
    /// The robot follows a server, which has the rules and the progress.
    #[error("the rules and the progress of the schedule are on the server of the site {site}")]
    OnServer {
        /// Its name.
        site: String,
    },
    /// What is evaluated here is something else than what is published.
    #[error("the schedule that is evaluated here is not the one in force: its files or progress are changing")]
    Changing,
}

/// Evaluates the schedule of a site, with the tasks of schedule files, of which this is the state that is published.
///
/// # Errors
/// See [`UnknownSchedule`].
pub fn schedule_in_force(
    config: &SiteConfig,
    site: &Site<'_>,
    published: &ScheduleState<'_>,
) -> Result<ScheduleInForce, UnknownSchedule> {
    if let Some(follow) = &config.follow {
        return Err(UnknownSchedule::OnServer { site: follow.site.clone() });
    }
    let rules = rules_in_force(config, Rules::parse).map_err(UnknownSchedule::Files)?;
    let progress = progress_in_force(config, parse_actuals).map_err(|why| UnknownSchedule::Files(why.into()))?;
    let overrides = Overrides::in_force(progress);
    let timeline = evaluate(site, &rules, &overrides)?;
    let at_s = published.head.plan_time().map(|at| at.civil_seconds());
    let same = timeline.schedule_state_at(at_s).finish();
    if ScheduleState::open(same.bytes())?.content_hash() != published.content_hash() {
        return Err(UnknownSchedule::Changing);
    }
    let Overrides { actuals: reported, observed, .. } = overrides;
    let is_as_planned = reported.is_empty() && observed.is_empty();
    let planned = (!is_as_planned).then(|| evaluate(site, &rules, &Overrides::default())).transpose()?;
    Ok(ScheduleInForce { timeline, site_zone: rules.site_zone, planned, reported, observed })
}
