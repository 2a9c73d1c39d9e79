//! Background worker at low priority: reference maps, pose search, deviations.

use crate::robot_map::RobotMap;
use alignment::References;
use alignment::{Alignment, Hint, PreparedMap, align_maps};
use bus::SiteSamples;
use daemon::Failure;
use deviations::{DeviationInput, deviations};
use frames::Map;
use messages::{ArchiveBuffer, PoseRecord, RobotProfile, ScheduleState, Site};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

/// Where a pose is searched.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct SearchArea {
    pub(crate) hint: Option<Hint>,
    /// Only on this map storey.
    pub(crate) storey: Option<u32>,
}

/// A job of the worker.
pub(crate) struct Job {
    /// Site, schedule state and index of grids, which belong together.
    pub(crate) samples: SiteSamples,
    pub(crate) task: WorkerTask,
}

/// The work of a job, on the planned site.
pub(crate) enum WorkerTask {
    /// Draw the reference maps.
    Draw,
    /// Search the pose of a map.
    Search(Arc<RobotMap>, SearchArea),
    /// Compare the site with a map in a pose.
    Compare(Arc<RobotMap>, PoseRecord),
}

/// The result of a job, with its samples.
pub(crate) struct JobOutcome {
    /// Those of the job.
    pub(crate) samples: SiteSamples,
    pub(crate) found: Result<JobResult, Failure>,
}

/// Maps of the site, and an alignment with them.
pub(crate) struct JobResult {
    /// By map storey.
    pub(crate) references: Vec<Arc<PreparedMap<Map>>>,
    /// The result of a search; storeys are indices of the references. With the content hash of the map that was searched.
    pub(crate) alignment: Option<(Alignment, u64)>,
    /// The result of a comparison.
    pub(crate) deviations: Option<ArchiveBuffer>,
}

/// The worker thread, and whether it is busy.
pub(crate) struct Worker {
    jobs: Sender<Job>,
    outcomes: Receiver<JobOutcome>,
    is_busy: bool,
}

impl Worker {
    /// Starts the thread.
    pub(crate) fn start() -> Result<Self, Failure> {
        let (jobs, pending) = channel::<Job>();
        let (done, outcomes) = channel();
        let thread = std::thread::Builder::new().name("slam-align-work".to_owned());
        thread.spawn(move || {
            // Tracking and publication must not wait for it; threads of the pool inherit the priority.
            daemon::in_background();
            let Ok(pool) = rayon::ThreadPoolBuilder::new().build() else { return };
            let mut references = None;
            pool.install(|| {
                for Job { samples, task } in pending {
                    let found = work(&mut references, &samples, &task);
                    if done.send(JobOutcome { samples, found }).is_err() {
                        return;
                    }
                }
            });
        })?;
        Ok(Self { jobs, outcomes, is_busy: false })
    }

    pub(crate) fn is_busy(&self) -> bool {
        self.is_busy
    }

    /// Starts a job on the idle thread.
    pub(crate) fn begin(&mut self, job: Job) -> Result<(), Failure> {
        self.is_busy = true;
        self.jobs.send(job).map_err(|_| "the search has panicked".into())
    }

    /// The result of the last job, if it is done.
    pub(crate) fn take(&mut self) -> Result<Option<JobOutcome>, Failure> {
        match self.outcomes.try_recv() {
            Ok(outcome) => {
                self.is_busy = false;
                Ok(Some(outcome))
            }
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err("the search has panicked".into()),
        }
    }

    /// Waits for the running job.
    pub(crate) fn wait(&mut self) -> Result<JobOutcome, Failure> {
        let outcome = self.outcomes.recv().map_err(|_| "the search has panicked")?;
        self.is_busy = false;
        Ok(outcome)
    }
}

fn work(references: &mut Option<References>, samples: &SiteSamples, task: &WorkerTask) -> Result<JobResult, Failure> {
    let state = samples.state().ok_or("site and schedule state do not belong together")?;
    let index = samples.index_of(state.site).ok_or("the index of the grids is of another site")?;
    let (site, schedule_state) = state.views()?;
    let robot = index.view().head.robot;
    if references.as_ref().is_none_or(|r| !r.is_of(&site, &robot)) {
        *references = Some(References::new(&site, &robot)?);
    }
    let references = references.as_mut().ok_or("there is nothing to compare with")?;
    let maps: Vec<Arc<PreparedMap<Map>>> = references.at(&site, &schedule_state)?.collect();
    let (alignment, deviations) = match task {
        WorkerTask::Draw => (None, None),
        WorkerTask::Search(map, search_area) => (Some((align(&maps, map, search_area)?, map.content_hash)), None),
        WorkerTask::Compare(map, pose) => (None, Some(compare(&site, &schedule_state, &robot, map, pose)?)),
    };
    Ok(JobResult { references: maps, alignment, deviations })
}

fn align(references: &[Arc<PreparedMap<Map>>], map: &RobotMap, search_area: &SearchArea) -> Result<Alignment, Failure> {
    let Some(storey) = search_area.storey else {
        return Ok(align_maps(references, &map.prepared, search_area.hint.as_ref()));
    };
    let only = references.get(storey as usize).ok_or_else(|| format!("the site has no storey {storey}"))?;
    let mut alignment = align_maps(std::slice::from_ref(only), &map.prepared, search_area.hint.as_ref());
    alignment.poses.iter_mut().for_each(|pose| pose.reference = storey as usize);
    Ok(alignment)
}

fn compare(
    site: &Site<'_>,
    schedule_state: &ScheduleState<'_>,
    robot: &RobotProfile,
    map: &RobotMap,
    pose: &PoseRecord,
) -> Result<ArchiveBuffer, Failure> {
    let map_storey = pose.map_storey as usize;
    if map_storey >= site.map_storeys.len() {
        return Err(format!("the site has no storey {map_storey}").into());
    }
    Ok(deviations(&DeviationInput {
        site,
        schedule_state,
        robot,
        map_storey,
        slam: &map.map,
        slam_map_hash: map.content_hash,
        map_from_slam: pose.map_from_slam(),
        about_m: pose.about_m,
        covariance: pose.pose_covariance(),
    }))
}
