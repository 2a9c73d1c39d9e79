//! Verdict on an observation, given the planned state.

use messages::{ElementState, Judgement, Observation};

/// Verdict on an element. Elements being built or removed may be seen or not.
pub(crate) fn deviation_verdict(observation: Observation, planned: ElementState) -> Judgement {
    match (observation, planned) {
        (Observation::Unseen, _) => Judgement::Unknown,
        (_, ElementState::BeingRemoved) => Judgement::OnPlan,
        (Observation::Displaced, ElementState::Built | ElementState::InProgress) => Judgement::Displaced,
        // A surface beside the place of an element that should not stand may be anything.
        (Observation::Displaced, ElementState::NotStarted | ElementState::Removed) => Judgement::Unknown,
        (Observation::Observed, ElementState::NotStarted) => Judgement::Early,
        (Observation::Observed, ElementState::Removed) => Judgement::Late,
        (Observation::Absent, ElementState::Built) => Judgement::Late,
        (Observation::Observed, ElementState::Built | ElementState::InProgress) => Judgement::OnPlan,
        (Observation::Absent, _) => Judgement::OnPlan,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_not_seen_is_never_judged_and_what_is_there_or_not_is_judged_by_the_plan() {
        use ElementState::*;
        for planned in [NotStarted, InProgress, Built, BeingRemoved, Removed] {
            assert_eq!(deviation_verdict(Observation::Unseen, planned), Judgement::Unknown);
        }
        let check = |observation, planned, expected| assert_eq!(deviation_verdict(observation, planned), expected);
        check(Observation::Observed, Built, Judgement::OnPlan);
        check(Observation::Observed, NotStarted, Judgement::Early);
        check(Observation::Observed, InProgress, Judgement::OnPlan);
        check(Observation::Observed, Removed, Judgement::Late);
        check(Observation::Observed, BeingRemoved, Judgement::OnPlan);
        check(Observation::Absent, Built, Judgement::Late);
        check(Observation::Absent, NotStarted, Judgement::OnPlan);
        check(Observation::Absent, InProgress, Judgement::OnPlan);
        check(Observation::Absent, Removed, Judgement::OnPlan);
        check(Observation::Displaced, Built, Judgement::Displaced);
        check(Observation::Displaced, InProgress, Judgement::Displaced);
        check(Observation::Displaced, BeingRemoved, Judgement::OnPlan);
    }
}
