//! Confirmations of operators: the pending pose, absent elements; taking them back, and their list.

use super::AlignService;
use crate::compared_elements::ComparedElement;
use crate::persisted_state::listed;
use daemon::{Caller, Confirmations, Confirmed, ConfirmedElement, Failure, HistoryEvent, HistoryKind, Published};
use diagnostics::nearest_names_hint;
use jiff::Timestamp;
use messages::{ContentHash, Observation, PoseRecord};
use tracing::{info, warn};

impl AlignService {
    /// The pending pose is right.
    pub(super) fn confirm_pose(&mut self, by: Caller) -> Result<Published, Failure> {
        let (waiting, before) = (self.follower.waiting().copied(), self.follower.pose().copied());
        let (Some(waiting), Some(before)) = (waiting, before) else {
            return Err("no pose waits to be confirmed".into());
        };
        let confirmed = Confirmed { by, at: Timestamp::now() };
        let frame_epoch = self.frame_epoch();
        self.persist(|persisted| persisted.confirm_pose(&waiting, &before, frame_epoch, confirmed))?;
        let map_hash = self.map.as_ref().map_or(ContentHash::NONE, |map| map.content_hash);
        match (self.follower.confirm(map_hash), self.map.clone()) {
            (true, Some(map)) => self.find_field(&map),
            // It is of an earlier map: the newest says what it is worth.
            _ => self.follow(),
        }
        info!(service = "slam-align", map_storey = waiting.map_storey, "pose confirmed");
        self.record_pose(Some(by), "confirmed", &waiting);
        self.publish()?;
        Ok(self.alignment.published())
    }

    /// The pose before the confirmed one comes back, and that one waits again.
    pub(super) fn undo_confirmed_pose(&mut self, by: Caller) -> Result<Published, Failure> {
        let (before, _) = self.persisted.before_confirmed().ok_or("no confirmed pose can be taken back")?;
        self.persist(|persisted| persisted.undo_confirmed_pose())?;
        self.follower.undo_confirm(before);
        self.follow();
        info!(service = "slam-align", map_storey = before.map_storey, "confirmation of the pose taken back");
        self.record_pose(Some(by), "back, because a confirmation was taken back", &before);
        self.publish()?;
        Ok(self.alignment.published())
    }

    /// These elements are absent.
    pub(super) fn confirm_absent(&mut self, ids: &[String], by: Caller) -> Result<Vec<ConfirmedElement>, Failure> {
        if self.compared.is_empty() {
            return Err("nothing was compared yet: see groundplan deviations".into());
        }
        let confirmed = Some(Confirmed { by, at: Timestamp::now() });
        let elements: Vec<ConfirmedElement> = ids.iter().map(|id| self.absent_element(id)).collect::<Result<_, _>>()?;
        let elements: Vec<_> = elements.into_iter().map(|element| ConfirmedElement { confirmed, ..element }).collect();
        self.set_observed(self.persisted.observed.with_absent(ids), &elements)?;
        self.record_absence(by, "confirmed to be absent", &elements);
        Ok(elements)
    }

    /// An element that the robot saw through.
    fn absent_element(&self, id: &str) -> Result<ConfirmedElement, Failure> {
        match self.compared.get(id) {
            Some(ComparedElement { element, observation: Observation::Absent }) => Ok(element.clone()),
            Some(ComparedElement { observation, .. }) => {
                Err(format!("{id} is {}: only what is absent can be confirmed", observation.name()).into())
            }
            None => {
                let nearest = nearest_names_hint(id, self.compared.keys().map(String::as_str));
                Err(format!("{id} is not among the deviations of this storey{nearest}").into())
            }
        }
    }

    /// These elements are not confirmed to be absent any more.
    pub(super) fn undo_absent(&mut self, ids: &[String], by: Caller) -> Result<Vec<ConfirmedElement>, Failure> {
        let element = |id: &String| {
            let element = self.persisted.confirmed_element(id);
            element.ok_or_else(|| {
                let nearest = nearest_names_hint(id, self.persisted.observed.absent().iter().map(String::as_str));
                format!("{id} is not confirmed to be absent{nearest}")
            })
        };
        let elements: Vec<ConfirmedElement> = ids.iter().map(element).collect::<Result<_, _>>()?;
        self.set_observed(self.persisted.observed.without_absent(ids), &[])?;
        self.record_absence(by, "no longer confirmed to be absent", &elements);
        // What was seen early counts again.
        self.pending.wanted_comparison += 1;
        Ok(elements)
    }

    /// What waits, and what was confirmed.
    pub(super) fn confirmations(&self) -> Confirmations {
        let absent = self.persisted.observed.absent().iter();
        Confirmations {
            waiting: self.follower.waiting().map(listed),
            before_confirmed: self.persisted.before_confirmed().map(|(pose, by)| (listed(&pose), by)),
            absent: absent.filter_map(|id| self.persisted.confirmed_element(id)).collect(),
        }
    }

    /// Records a pose in the history.
    pub(super) fn record_pose(&self, by: Option<Caller>, what: &str, pose: &PoseRecord) {
        let [x_m, y_m, yaw_rad] = pose.map_from_slam;
        let place = format!("x {x_m:.2} m, y {y_m:.2} m, yaw {:.2} degrees", yaw_rad.to_degrees());
        let summary = format!("pose of the SLAM map {what}: storey {} at {place}", pose.map_storey);
        self.record(HistoryEvent { kind: HistoryKind::Pose, by, summary });
    }

    fn record_absence(&self, by: Caller, what: &str, elements: &[ConfirmedElement]) {
        for ConfirmedElement { global_id, ifc_type, name, .. } in elements {
            let summary = format!("{ifc_type} {name:?} {global_id} {what}");
            self.record(HistoryEvent { kind: HistoryKind::Absence, by: Some(by), summary });
        }
    }

    fn record(&self, event: HistoryEvent) {
        if let Err(why) = self.history.record(event) {
            warn!(service = "slam-align", error = daemon::chain(&why), "the history cannot be written");
        }
    }
}
