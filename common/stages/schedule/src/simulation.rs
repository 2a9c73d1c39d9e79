//! Simulates the schedule of a site: dates of all tasks in many runs.

use crate::error::EvaluateError;
use crate::evaluate::samples;
use crate::overrides::Overrides;
use crate::probability::Probabilities;
use crate::rules::{Rules, RulesMode};
use crate::timeline::Timeline;
use messages::Site;

/// Most dates that are drawn: 8 bytes each.
const MAX_DATES: u64 = 40_000_000;

/// Why probabilities cannot be worked out.
#[derive(Debug, thiserror::Error)]
pub enum ProbabilityError {
    /// More runs of more tasks than there is room for.
    #[error(
        "{runs} runs of {n_tasks} tasks are more than {MAX_DATES} dates: set runs in [uncertainty] of the schedule rules to at \
         most {most}"
    )]
    TooMany {
        /// As the rules say.
        runs: u32,
        /// Tasks of the site.
        n_tasks: usize,
        /// How many runs there is room for.
        most: u64,
    },
    /// The published prototype knows no tasks.
    #[error("the schedule rules say mode = \"paper\", which knows no tasks and no durations: nothing varies")]
    Paper,
    /// The schedule itself cannot be evaluated.
    #[error(transparent)]
    Evaluate(#[from] EvaluateError),
}

/// Simulates the schedule of a site around the dates of its timeline, which was evaluated from the same rules and overrides.
///
/// Work on all threads of the pool it is called from.
///
/// # Errors
/// Too many runs for so many tasks, the mode of the prototype, and those of the evaluation.
pub fn probabilities<'t>(
    site: &Site<'_>,
    rules: &Rules,
    overrides: &Overrides,
    timeline: &'t Timeline,
) -> Result<Probabilities<'t>, ProbabilityError> {
    if rules.mode == RulesMode::Paper {
        return Err(ProbabilityError::Paper);
    }
    let (runs, n_tasks) = (rules.uncertainty.runs, site.schedule.tasks.len());
    if u64::from(runs) * n_tasks as u64 > MAX_DATES {
        return Err(ProbabilityError::TooMany { runs, n_tasks, most: MAX_DATES / n_tasks as u64 });
    }
    let samples = samples(site, rules, overrides, timeline)?;
    Ok(Probabilities::of(timeline, rules.uncertainty, samples))
}
