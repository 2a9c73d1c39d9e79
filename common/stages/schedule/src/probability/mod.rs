//! Probabilities of states: the schedule simulated many times with drawn durations.
//!
//! Each run draws a duration for every task, from the three-point durations of the work schedule where it has them, else
//! from the planned one times the factors of [`Uncertainty`], and follows the sequences forward with their lags and calendars.
//! A task with written dates starts when they say, or later where a predecessor pushes it beyond its float; a computed one
//! starts when schedule and predecessors allow, also earlier. Finished tasks do not vary; those that are begun vary in the
//! part that is not complete, and are not pushed. Durations of different tasks are independent.
//!
//! Dates of properties, construction phases, rules and elements' own reports do not vary.
//!
//! A run depends on seed, tasks and rules alone: the same on every machine, with any number of threads. The probability of a
//! state is the share of runs that have it; with 2000 runs its standard error is at most 0.011.
//!
//! # Source
//! Three-point durations: Malcolm, Roseboom, Clark and Fazar, "Application of a Technique for Research and Development
//! Program Evaluation", Operations Research 7, 1959 (PERT). Simulation, because PERT's critical path finishes too early
//! where paths meet: Van Slyke, "Monte Carlo Methods and the PERT Problem", Operations Research 11, 1963.

mod elements;
mod network;
mod samples;
mod spaces;
mod three_point;
mod thresholds;
mod uncertainty;

pub use elements::ElementProbability;
pub(crate) use network::Network;
pub(crate) use samples::Samples;
pub use spaces::SafeDay;
pub use thresholds::UNCERTAIN;
pub use uncertainty::Uncertainty;

use crate::error::EvaluateError;
use crate::overrides::Overrides;
use crate::rules::{Rules, RulesMode};
use crate::timeline::Timeline;
use elements::ElementGroups;
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

/// Dates of all tasks in many runs, and what they make of elements and spaces.
pub struct Probabilities<'t> {
    timeline: &'t Timeline,
    uncertainty: Uncertainty,
    samples: Samples,
    groups: ElementGroups,
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
    let samples = crate::evaluate::samples(site, rules, overrides, timeline)?;
    Ok(Probabilities { timeline, uncertainty: rules.uncertainty, samples, groups: ElementGroups::of(timeline) })
}

impl Probabilities<'_> {
    /// The rules that they were worked out by.
    pub fn uncertainty(&self) -> &Uncertainty {
        &self.uncertainty
    }
}
