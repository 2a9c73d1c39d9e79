//! Publishes the pose and the deviations, applies confirmed observations, and persists what must survive the daemon.

use super::AlignService;
use crate::persisted_state::PersistedState;
use crate::reference_inputs::ReferenceInputs;
use alignment::{AlignmentSources, PoseStatus};
use daemon::{ActualsSource, Failure, RequestTimeouts, ScheduleRequest, write_durably};
use deviations::AppliedObservations;
use messages::{Activity, ArchiveBuffer, Checked, InputHashes, PoseRecord, payload};
use std::time::Duration;
use tracing::info;

/// Schedule evaluation answers within milliseconds, and is started again within seconds.
const TIMEOUTS: RequestTimeouts =
    RequestTimeouts { starting: Duration::from_secs(30), answer: Duration::from_secs(30) };
const RETRY_INTERVAL: Duration = Duration::from_millis(2);

impl AlignService {
    /// Publishes the current pose, if it differs from the published one.
    pub(super) fn publish(&mut self) -> Result<(), Failure> {
        let Some(map) = self.map.as_ref().filter(|_| !self.references.is_empty()) else { return Ok(()) };
        let sources = AlignmentSources {
            site_hash: self.reference_inputs.inputs.site,
            slam_map_hash: map.content_hash,
            searched_map_hash: self.searched_map_hash,
            plan_time_s: self.reference_inputs.plan_time_s,
        };
        let pose = self.follower.pose().copied();
        let pose_status = PoseStatus { pose, state: self.follower.state(), waiting: self.follower.waiting().copied() };
        let alignment = self.last_search.archive(&self.storeys(), &pose_status, sources);
        if !self.alignment.is_last(&alignment) {
            self.pending.compare = true;
            let (frame_epoch, inputs) = self.origin();
            self.alignment.publish(&mut self.epochs, Checked::new(alignment)?, frame_epoch, inputs)?;
            self.activity.set(Activity::Published);
        }
        // The pose must survive this daemon; moves below the threshold are not written.
        if let Some(pose) = pose.filter(|pose| self.persisted.is_worth_saving(pose)) {
            self.persist_pose(&pose)?;
        }
        Ok(())
    }

    /// Publishes deviations, and applies the confirmed observations.
    pub(super) fn publish_deviations(&mut self, deviations: ArchiveBuffer) -> Result<(), Failure> {
        let is_news = !self.deviations.is_last(&deviations);
        let deviations = Checked::<payload::Deviations>::new(deviations)?;
        let view = deviations.view();
        let (elements, obstacles) = (view.elements.len(), view.obstacles.len());
        let observed = match self.samples.site() {
            Some(site) if view.check_site(&site.view()).is_ok() => {
                self.persisted.observed.with_additions(&site.view(), &view)
            }
            // A newer site has come meanwhile, and is compared next.
            _ => return Ok(()),
        };
        if is_news {
            let (frame_epoch, inputs) = self.origin();
            self.deviations.publish(&mut self.epochs, deviations, frame_epoch, inputs)?;
            info!(service = "slam-align", elements, obstacles, "deviations published");
        }
        self.set_observed(observed)
    }

    /// Applies these observations; on disk, here and in schedule-eval, when this returns.
    pub(super) fn set_observed(&mut self, observed: AppliedObservations) -> Result<(), Failure> {
        let applies = self.config.apply;
        if observed.table(applies) != self.persisted.observed.table(applies)
            && let Err(why) = self.apply(&observed)
        {
            // It is tried again at the next comparison.
            self.pending.compare = true;
            return Err(why);
        }
        if observed == self.persisted.observed {
            Ok(())
        } else {
            self.persist(|persisted| persisted.observed = observed)
        }
    }

    /// Sends the observed progress to schedule-eval.
    pub(super) fn apply(&self, observed: &AppliedObservations) -> Result<(), Failure> {
        write_durably(&self.table, observed.table(self.config.apply).as_bytes())?;
        let bus = self.bus.as_ref().ok_or("it is not attached to a bus")?;
        let request = ScheduleRequest::SetActuals { file: Some(self.table.clone()), source: ActualsSource::Observed };
        let pause = || {
            std::thread::sleep(RETRY_INTERVAL);
            Ok(())
        };
        daemon::ask(bus, &request, TIMEOUTS, |_| {}, pause)?;
        info!(service = "slam-align", "observations applied");
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

    pub(super) fn persist_pose(&mut self, pose: &PoseRecord) -> Result<(), Failure> {
        let frame_epoch = self.reference_inputs.frame_epoch;
        self.persist(|persisted| persisted.set_pose(pose, frame_epoch))
    }

    /// Frame epoch and inputs of what is published next.
    fn origin(&self) -> (u64, InputHashes) {
        let slam_map = self.map.as_ref().map_or(0, |map| map.content_hash);
        let ReferenceInputs { inputs, frame_epoch, .. } = self.reference_inputs;
        (frame_epoch, InputHashes { slam_map, ..inputs })
    }
}
