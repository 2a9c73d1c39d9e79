//! The schedule state that planning uses under uncertainty.

use super::elements::ElementProbability;
use super::probabilities::Probabilities;
use crate::timeline::Period;
use messages::{ElementState, ScheduleStateBuilder, ScheduleStateHead, SpaceState, SpaceStateRecord, TextList};

/// Reason of spaces that are blocked because it is not certain enough that they are open.
pub const UNCERTAIN: &str = "uncertain";

impl Probabilities<'_> {
    /// The schedule state at an instant or over a period in which only what is certain enough counts.
    ///
    /// An element that is there with more than `obstacle_above` is an obstacle, and one that stands with more than
    /// `floor_above` is built and carries floor; one that is only an obstacle is in progress. A space that is open with less
    /// than `open_above` is blocked, for the planned reasons or because it is `uncertain`. Planned states stay those of the plan. It has no
    /// validity: probabilities change at any time.
    pub fn schedule_state(&self, period: Period) -> ScheduleStateBuilder {
        let rules = &self.uncertainty;
        let mut builder = self.timeline.schedule_state(period);
        builder.head.valid_from_s = ScheduleStateHead::NO_TIME;
        builder.head.valid_until_s = ScheduleStateHead::NO_TIME;
        for (state, probability) in builder.effective.iter_mut().zip(self.elements(period)) {
            *state = certain_state(state.get(), probability, rules.obstacle_above, rules.floor_above).into();
        }
        let open = SpaceStateRecord {
            state: SpaceState::Open.into(),
            reserved: 0,
            reasons: TextList::default(),
            closes_at_s: ScheduleStateHead::NO_TIME,
        };
        for (space, probability) in builder.spaces.iter_mut().zip(self.spaces_open(period)) {
            let is_blocked = space.state == SpaceState::Blocked;
            if probability < rules.open_above && !is_blocked {
                let reasons = builder.texts.add_list([UNCERTAIN]);
                *space = SpaceStateRecord { state: SpaceState::Blocked.into(), reasons, ..open };
            } else if probability >= rules.open_above && is_blocked {
                *space = open;
            }
        }
        builder
    }
}

/// The state that counts for planning; the timeline's own where it is certain enough.
fn certain_state(
    state: ElementState,
    probability: ElementProbability,
    obstacle_above: f64,
    floor_above: f64,
) -> ElementState {
    let ElementProbability { stands, there, removed } = probability;
    let (is_obstacle, is_built) = (there > obstacle_above, stands > floor_above);
    let is_it =
        |s: ElementState| s.is_obstacle() == (is_obstacle || is_built) && (s == ElementState::Built) == is_built;
    match () {
        () if is_it(state) => state,
        () if is_built => ElementState::Built,
        () if is_obstacle => ElementState::InProgress,
        () if removed > 1.0 - there - removed => ElementState::Removed,
        () => ElementState::NotStarted,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_certain_enough_is_floor_or_absent() {
        use ElementState::*;
        let state = |state, stands, there, removed| {
            certain_state(state, ElementProbability { stands, there, removed }, 0.05, 0.95)
        };
        assert_eq!(state(NotStarted, 0.0, 0.05, 0.0), NotStarted);
        assert_eq!(state(NotStarted, 0.0, 0.06, 0.0), InProgress);
        assert_eq!(state(Built, 0.95, 1.0, 0.0), InProgress);
        assert_eq!(state(InProgress, 0.96, 1.0, 0.0), Built);
        assert_eq!(state(BeingRemoved, 0.5, 0.9, 0.1), BeingRemoved);
        assert_eq!(state(BeingRemoved, 0.0, 0.04, 0.96), Removed);
        assert_eq!(state(InProgress, 0.0, 0.04, 0.0), NotStarted);
    }
}
