//! Traits of a question and its answer, and the outcome of a command whose result is an answer.

use crate::failure::Failure;
use crate::run::Outcome;
use answers::{Circumstances, FindError, Later, Situation};
use messages::Site;
use serde::Serialize;
use waypoints::MissionPlanOptions;

/// Exit code of an answer that is no.
const NO: u8 = 3;
/// Exit code of an answer of maps that may not be used.
const MAPS_NOT_USABLE: u8 = 4;

/// A question that has a yes or a no at every plan time.
pub(crate) trait Question: Sync {
    /// What it is about.
    type Found: Sync;
    /// Its answer.
    type Answer: Answer;

    /// The command that asks it, with what it is about.
    fn command(&self) -> Vec<&str>;

    /// Finds what it is about in a site.
    ///
    /// # Errors
    /// Names that stand for nothing, or for several things.
    fn find(&self, site: &Site<'_>) -> Result<Self::Found, FindError>;

    /// The options of the mission plan that the answer needs.
    fn options(&self, site: &Site<'_>, found: &Self::Found, options: MissionPlanOptions) -> MissionPlanOptions;

    /// True if the answer depends on where the robot starts.
    fn depends_on_start(&self) -> bool;

    /// The answer in a situation.
    fn answer(&self, situation: &Situation<'_>, found: &Self::Found) -> Self::Answer;

    /// Yes or no in a situation; `None` if that is not known.
    fn verdict(&self, situation: &Situation<'_>, found: &Self::Found) -> Option<bool>;
}

/// An answer of a question.
pub(crate) trait Answer: Serialize {
    /// Yes or no; `None` if that is not known.
    fn verdict(&self) -> Option<bool>;

    /// True if it matters when the answer changes.
    fn wants_later(&self) -> bool {
        false
    }

    /// Sets when the answer changes, if that matters.
    fn set_changes(&mut self, _changes: Later) {}

    /// What it is made of.
    fn circumstances(&self) -> &Circumstances;

    /// For people.
    fn text(&self) -> String;
}

/// The outcome of a command whose result is an answer.
///
/// # Errors
/// An answer that cannot be written as JSON.
pub(super) fn outcome_of(answer: &impl Answer, json: bool) -> Result<Outcome, Failure> {
    let outcome = if json { Outcome::json(answer)? } else { Outcome::from(answer.text()) };
    let exit_code = match answer.verdict() {
        _ if !answer.circumstances().may_be_used() => MAPS_NOT_USABLE,
        Some(true) => 0,
        Some(false) | None => NO,
    };
    Ok(Outcome { exit_code, ..outcome })
}
