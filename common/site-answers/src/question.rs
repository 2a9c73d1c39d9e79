//! Traits of a question and its answer.

use answers::{Circumstances, FindError, Later, Situation};
use messages::Site;
use serde::Serialize;
use waypoints::MissionPlanOptions;

/// A question that has a yes or a no at every plan time.
pub trait Question: Sync {
    /// What it is about.
    type Found: Sync;
    /// Its answer.
    type Answer: Answer;

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
pub trait Answer: Serialize {
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
}
