//! Confirmations of operators: the pending pose, absent elements; taking them back, and their list.

use super::SlamAlign;
use crate::compared_elements::ComparedElement;
use crate::in_force::pose_event;
use crate::persisted_state::listed;
use daemon::facts::Pose;
use daemon::{
    Caller, Confirmations, Confirmed, ConfirmedElement, Decision, Failure, HistoryEvent, HistoryKind, ListedPose,
    MachineTime, Now,
};
use diagnostics::nearest_names_hint;
use frames::wrapped;
use jiff::Timestamp;
use messages::{Observation, PoseRecord};
use tracing::info;

/// A pose that is followed moves by less than this between a request and its repetition.
const FOLLOWED_M: f64 = 0.1;
const FOLLOWED_RAD: f64 = 0.02;

impl SlamAlign {
    /// The pending pose is right, if it is the one that the client saw.
    pub(super) fn confirm_pose(
        &self,
        decision: &mut Decision<Self>,
        seen: &ListedPose,
        by: Caller,
        now: &Now<'_, Self>,
    ) -> Result<(), Failure> {
        let next = &mut decision.next;
        let (waiting, before) = (next.follower.waiting().copied(), next.follower.pose().copied());
        let (Some(waiting), Some(before)) = (waiting, before) else {
            // The same request came before.
            let is_done =
                next.persisted.before_confirmed().is_some() && before.is_some_and(|pose| is_still_at(&pose, seen));
            return is_done.then_some(()).ok_or_else(|| "no pose waits to be confirmed".into());
        };
        if listed(&waiting) != *seen {
            return Err("another pose waits by now: see groundplan confirm --list".into());
        }
        let (confirmed, frame_epoch) = (confirmed(by, now.machine)?, next.frame_epoch());
        next.persisted_mut().confirm_pose(&waiting, &before, frame_epoch, confirmed);
        match (next.follower.confirm(next.map_hash().unwrap_or_default()), next.map.clone()) {
            (true, Some(map)) => next.find_field(&map),
            // It is of an earlier map: the newest says what it is worth.
            _ => next.follow(),
        }
        info!(service = "slam-align", map_storey = waiting.map_storey, "pose confirmed");
        decision.history.push(pose_event(Some(by), "confirmed", &waiting));
        Ok(())
    }

    /// The pose before the confirmed one comes back, if it is the one that the client saw, and the confirmed one waits again.
    pub(super) fn undo_confirmed_pose(
        &self,
        decision: &mut Decision<Self>,
        seen: &ListedPose,
        by: Caller,
    ) -> Result<(), Failure> {
        let next = &mut decision.next;
        let Some((before, _)) = next.persisted.before_confirmed() else {
            // The same request came before.
            let in_effect = next.follower.pose();
            let is_done = next.follower.waiting().is_some() && in_effect.is_some_and(|pose| is_still_at(pose, seen));
            return is_done.then_some(()).ok_or_else(|| "no confirmed pose can be taken back".into());
        };
        if listed(&before) != *seen {
            return Err("another pose was confirmed by now: see groundplan confirm --list".into());
        }
        next.persisted_mut().undo_confirmed_pose();
        next.follower.undo_confirm(before);
        next.follow();
        info!(service = "slam-align", map_storey = before.map_storey, "confirmation of the pose taken back");
        decision.history.push(pose_event(Some(by), "back, because a confirmation was taken back", &before));
        Ok(())
    }

    /// These elements are absent.
    pub(super) fn confirm_absent(
        &self,
        decision: &mut Decision<Self>,
        ids: &[String],
        by: Caller,
        now: &Now<'_, Self>,
    ) -> Result<Vec<ConfirmedElement>, Failure> {
        if self.in_force.compared.is_empty() {
            return Err("nothing was compared yet: see groundplan deviations".into());
        }
        let confirmed = Some(confirmed(by, now.machine)?);
        let elements: Vec<ConfirmedElement> = ids.iter().map(|id| self.absent_element(id)).collect::<Result<_, _>>()?;
        let elements: Vec<_> = elements.into_iter().map(|element| ConfirmedElement { confirmed, ..element }).collect();
        let observed = self.in_force.persisted.observed.with_absent(ids);
        decision.next.persisted_mut().set_observed(observed, &elements);
        decision.history.extend(absence_events(by, "confirmed to be absent", &elements));
        Ok(elements)
    }

    /// An element that the robot saw through.
    fn absent_element(&self, id: &str) -> Result<ConfirmedElement, Failure> {
        match self.in_force.compared.get(id) {
            Some(ComparedElement { element, observation: Observation::Absent }) => Ok(element.clone()),
            Some(ComparedElement { observation, .. }) => {
                Err(format!("{id} is {}: only what is absent can be confirmed", observation.name()).into())
            }
            None => {
                let nearest = nearest_names_hint(id, self.in_force.compared.keys().map(String::as_str));
                Err(format!("{id} is not among the deviations of this storey{nearest}").into())
            }
        }
    }

    /// These elements are not confirmed to be absent any more.
    pub(super) fn undo_absent(
        &self,
        decision: &mut Decision<Self>,
        ids: &[String],
        by: Caller,
    ) -> Result<Vec<ConfirmedElement>, Failure> {
        let persisted = &self.in_force.persisted;
        let element = |id: &String| {
            persisted.confirmed_element(id).ok_or_else(|| {
                let nearest = nearest_names_hint(id, persisted.observed.absent().iter().map(String::as_str));
                format!("{id} is not confirmed to be absent{nearest}")
            })
        };
        let elements: Vec<ConfirmedElement> = ids.iter().map(element).collect::<Result<_, _>>()?;
        decision.next.persisted_mut().set_observed(persisted.observed.without_absent(ids), &[]);
        decision.history.extend(absence_events(by, "no longer confirmed to be absent", &elements));
        // What was seen early counts again.
        decision.next.pending.wanted_comparison += 1;
        Ok(elements)
    }

    /// What waits, and what was confirmed.
    pub(super) fn confirmations(&self) -> Confirmations {
        let persisted = &self.in_force.persisted;
        let absent = persisted.observed.absent().iter();
        Confirmations {
            waiting: self.in_force.follower.waiting().map(listed),
            before_confirmed: persisted.before_confirmed().map(|(pose, by)| (listed(&pose), by)),
            absent: absent.filter_map(|id| persisted.confirmed_element(id)).collect(),
        }
    }
}

/// True if a pose is the one that a client saw, which is followed since.
fn is_still_at(pose: &PoseRecord, seen: &ListedPose) -> bool {
    let (now, then) = (listed(pose), seen.map_from_slam);
    let Pose { x_m, y_m, yaw_rad } = now.map_from_slam;
    let is_near = libm::hypot(x_m - then.x_m, y_m - then.y_m) <= FOLLOWED_M;
    now.storey == seen.storey && is_near && wrapped(yaw_rad - then.yaw_rad).abs() <= FOLLOWED_RAD
}

fn confirmed(by: Caller, now: MachineTime) -> Result<Confirmed, Failure> {
    Ok(Confirmed { by, at: Timestamp::from_millisecond(now.wall_ms)? })
}

fn absence_events(by: Caller, what: &str, elements: &[ConfirmedElement]) -> impl Iterator<Item = HistoryEvent> {
    elements.iter().map(move |ConfirmedElement { global_id, ifc_type, name, .. }| {
        let summary = format!("{ifc_type} {name:?} {global_id} {what}");
        HistoryEvent { kind: HistoryKind::Absence, by: Some(by), summary }
    })
}
