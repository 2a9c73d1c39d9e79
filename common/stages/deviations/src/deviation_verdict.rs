//! Verdict on an observation, given the planned state.

use messages::{DeviationVerdict, ElementState, Observation};

/// Verdict on an element. Elements being built or removed may be seen or not.
pub(crate) fn deviation_verdict(observation: Observation, planned: ElementState) -> DeviationVerdict {
    match (observation, planned) {
        (Observation::Unseen, _) => DeviationVerdict::Unknown,
        (_, ElementState::BeingRemoved) => DeviationVerdict::OnPlan,
        (Observation::Displaced, ElementState::Built | ElementState::InProgress) => DeviationVerdict::Displaced,
        // A surface beside the place of an element that should not stand may be anything.
        (Observation::Displaced, ElementState::NotStarted | ElementState::Removed) => DeviationVerdict::Unknown,
        (Observation::Observed, ElementState::NotStarted) => DeviationVerdict::Early,
        (Observation::Observed, ElementState::Removed) => DeviationVerdict::Late,
        (Observation::Absent, ElementState::Built) => DeviationVerdict::Late,
        (Observation::Observed, ElementState::Built | ElementState::InProgress) => DeviationVerdict::OnPlan,
        (Observation::Absent, _) => DeviationVerdict::OnPlan,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_seen_is_never_judged_and_what_is_there_or_not_is_judged_by_the_plan() {
        use ElementState::*;
        for planned in [NotStarted, InProgress, Built, BeingRemoved, Removed] {
            assert_eq!(deviation_verdict(Observation::Unseen, planned), DeviationVerdict::Unknown);
        }
        let check = |observation, planned, expected| assert_eq!(deviation_verdict(observation, planned), expected);
        check(Observation::Observed, Built, DeviationVerdict::OnPlan);
        check(Observation::Observed, NotStarted, DeviationVerdict::Early);
        check(Observation::Observed, InProgress, DeviationVerdict::OnPlan);
        check(Observation::Observed, Removed, DeviationVerdict::Late);
        check(Observation::Observed, BeingRemoved, DeviationVerdict::OnPlan);
        check(Observation::Absent, Built, DeviationVerdict::Late);
        check(Observation::Absent, NotStarted, DeviationVerdict::OnPlan);
        check(Observation::Absent, InProgress, DeviationVerdict::OnPlan);
        check(Observation::Absent, Removed, DeviationVerdict::OnPlan);
        check(Observation::Displaced, Built, DeviationVerdict::Displaced);
        check(Observation::Displaced, InProgress, DeviationVerdict::Displaced);
        check(Observation::Displaced, BeingRemoved, DeviationVerdict::OnPlan);
    }
}
