//! Publishes the pose and the deviations, applies confirmed observations, and persists what must survive the daemon.

use super::AlignService;
use crate::compared_elements::compared_elements;
use crate::job::Evidence;
use crate::newest_inputs::JobInputs;
use crate::persisted_state::PersistedState;
use crate::stored_evidence;
use alignment::AlignmentSources;
use daemon::{
    ActualsSource, ConfirmedElement, Failure, FileText, NewSample, RequestTimeouts, ScheduleRequest, write_durably,
};
use deviations::AppliedObservations;
use messages::{Activity, ArchiveBuffer, Checked, ContentHash, InputHashes, PoseValidity, ScheduleStateHead, payload};
use std::sync::Arc;
use std::time::Duration;
use tracing::{info, warn};

/// Schedule evaluation answers within milliseconds, and is started again within seconds.
const TIMEOUTS: RequestTimeouts =
    RequestTimeouts { starting: Duration::from_secs(30), answer: Duration::from_secs(30) };
const RETRY_INTERVAL: Duration = Duration::from_millis(2);

impl AlignService {
    /// Publishes the current pose and what it is worth, if that differs from what is published. There is nothing to tell
    /// before there are a map and a site.
    pub(super) fn publish(&mut self) -> Result<(), Failure> {
        let (Some(map), Some(site)) = (&self.map, self.newest.site) else { return Ok(()) };
        let slam_map = map.content_hash;
        // Before the references are drawn there is no plan time; there is no pose either.
        let inputs = self.reference_inputs.unwrap_or(JobInputs {
            hashes: InputHashes { site: site.hash, ..InputHashes::default() },
            plan_time_s: ScheduleStateHead::NO_TIME,
            frame_epoch: site.frame_epoch,
        });
        let sources = AlignmentSources {
            site_hash: inputs.hashes.site,
            slam_map_hash: slam_map,
            searched_map_hash: self.searched_map_hash,
            plan_time_s: inputs.plan_time_s,
        };
        let alignment = self.last_search.archive(&self.storeys(), &self.pose_status(), sources);
        if !self.alignment.is_last(&alignment) {
            self.pending.wanted_comparison += 1;
            let hashes = InputHashes { slam_map, ..inputs.hashes };
            let archive = Arc::new(Checked::new(alignment)?);
            let sample = NewSample { archive, frame_epoch: inputs.frame_epoch, inputs: hashes };
            self.alignment.publish_for_good(&mut self.epochs, sample)?;
            self.activity.set(Activity::Published);
        }
        // The pose must survive this daemon; moves below the threshold are not written.
        if let Some(pose) = self.follower.pose().copied().filter(|pose| self.persisted.is_worth_saving(pose)) {
            let frame_epoch = self.frame_epoch();
            self.persist(|persisted| persisted.set_pose(&pose, frame_epoch))?;
        }
        self.record_withdrawal()
    }

    /// Tells in the log and in the history that the pose which was in effect is not any more, and when it is again: nothing
    /// that a robot has relied on ends or changes in silence. A map that waits for its search says nothing yet.
    fn record_withdrawal(&mut self) -> Result<(), Failure> {
        let (Some(pose), Some(validity)) = (self.follower.pose().copied(), self.validity()) else { return Ok(()) };
        let is_withdrawn = match validity {
            PoseValidity::Effective | PoseValidity::Uncertain => false,
            PoseValidity::Refused | PoseValidity::WaitsForConfirm => true,
            PoseValidity::Held if self.is_newest_map_searched() => true,
            PoseValidity::Held => self.persisted.is_withdrawn,
        };
        if is_withdrawn == self.persisted.is_withdrawn {
            return Ok(());
        }
        self.persist(|persisted| persisted.is_withdrawn = is_withdrawn)?;
        if is_withdrawn {
            let why = self.why_not_effective().unwrap_or_default();
            warn!(service = "slam-align", reason = why, "the pose is withdrawn");
            self.record_pose(None, &format!("withdrawn ({why})"), &pose);
        } else {
            info!(service = "slam-align", "the pose is in effect again");
            self.record_pose(None, "in effect again", &pose);
        }
        Ok(())
    }

    /// Publishes deviations, and applies the confirmed observations.
    pub(super) fn publish_deviations(
        &mut self,
        deviations: ArchiveBuffer,
        inputs: &JobInputs,
        slam_map: ContentHash,
    ) -> Result<(), Failure> {
        let is_news = !self.deviations.is_last(&deviations);
        let deviations = Checked::<payload::Deviations>::new(deviations)?;
        let view = deviations.view();
        let (elements, obstacles) = (view.elements.len(), view.obstacles.len());
        let Some(site) = self.samples.site().filter(|site| view.check_site(&site.view()).is_ok()) else {
            // Its generation of the bus is gone, and the site of the next one has not come yet.
            self.pending.wanted_comparison += 1;
            return Ok(());
        };
        self.compared = compared_elements(&site.view(), &view);
        let observed = self.persisted.observed.with_additions(&site.view(), &view);
        if is_news {
            let hashes = InputHashes { slam_map, ..inputs.hashes };
            let archive = Arc::new(deviations);
            let sample = NewSample { archive, frame_epoch: inputs.frame_epoch, inputs: hashes };
            self.deviations.publish_for_good(&mut self.epochs, sample)?;
            info!(service = "slam-align", elements, obstacles, "deviations published");
        }
        self.set_observed(observed, &[])
    }

    /// Applies these observations, with those that an operator has just confirmed; on disk, here and in schedule-eval, when
    /// this returns.
    pub(super) fn set_observed(
        &mut self,
        observed: AppliedObservations,
        confirmed: &[ConfirmedElement],
    ) -> Result<(), Failure> {
        let applies = self.config.apply;
        if observed.table(applies) != self.persisted.observed.table(applies)
            && let Err(why) = self.apply(&observed)
        {
            // It is tried again at the next comparison.
            self.pending.wanted_comparison += 1;
            return Err(why);
        }
        if observed == self.persisted.observed && confirmed.is_empty() {
            Ok(())
        } else {
            self.persist(|persisted| persisted.set_observed(observed, confirmed))
        }
    }

    /// Sends the observed progress to schedule-eval.
    pub(super) fn apply(&self, observed: &AppliedObservations) -> Result<(), Failure> {
        let text = observed.table(self.config.apply);
        write_durably(&self.table, text.as_bytes())?;
        let bus = self.bus.as_ref().ok_or("it is not attached to a bus")?;
        let file = Some(FileText { path: self.table.clone(), text });
        let request = ScheduleRequest::SetActuals { file, source: ActualsSource::Observed };
        let pause = || {
            std::thread::sleep(RETRY_INTERVAL);
            Ok(())
        };
        daemon::ask(bus, &request, TIMEOUTS, |_| {}, pause)?;
        info!(service = "slam-align", "observations applied");
        Ok(())
    }

    /// Takes the evidence after a look; on disk when this returns.
    pub(super) fn take_evidence(&mut self, evidence: Option<Evidence>) -> Result<(), Failure> {
        if let Some(evidence) = evidence {
            stored_evidence::write(&self.state_folder, &evidence)?;
            self.evidence = Some(Arc::new(evidence));
        }
        Ok(())
    }

    /// Changes the persisted state; on disk when this returns.
    pub(super) fn persist(&mut self, change: impl FnOnce(&mut PersistedState)) -> Result<(), Failure> {
        let mut persisted = self.persisted.clone();
        change(&mut persisted);
        self.state.save(&persisted)?;
        self.persisted = persisted;
        Ok(())
    }

    /// The newest map frame.
    pub(super) fn frame_epoch(&self) -> u64 {
        self.newest.site.map_or(0, |site| site.frame_epoch)
    }
}
