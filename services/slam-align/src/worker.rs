//! The slow work on a thread of its own, behind all other processes: maps of the site as planned, searches of all poses.

use crate::alignment::{Alignment, Hint, PreparedMap, align_maps};
use crate::reference::References;
use crate::robot_map::RobotMap;
use bus::Sample;
use daemon::Failure;
use messages::{CheckedSite, Grids, Phase};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};

/// Samples of one state of the site.
pub(crate) struct Inputs {
    pub(crate) site: CheckedSite<Sample>,
    pub(crate) phase: Sample,
    /// Of the grids: it names the robot.
    pub(crate) index: Sample,
}

/// Where a pose is looked for.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Where {
    pub(crate) hint: Option<Hint>,
    /// Only on this map storey.
    pub(crate) storey: Option<u32>,
}

/// What is to be done.
pub(crate) struct Job {
    pub(crate) inputs: Inputs,
    /// The map whose pose is searched; without one only the maps of the site are made.
    pub(crate) search: Option<(Arc<RobotMap>, Where)>,
}

/// What came of it.
pub(crate) struct Outcome {
    pub(crate) inputs: Inputs,
    pub(crate) found: Result<Found, Failure>,
}

/// Maps of the site, and an alignment with them.
pub(crate) struct Found {
    /// By map storey.
    pub(crate) references: Vec<Arc<PreparedMap>>,
    /// Of the map that it was searched for; storeys count as in the references.
    pub(crate) alignment: Option<(Arc<RobotMap>, Alignment)>,
}

/// The thread, and whether it works.
pub(crate) struct Worker {
    jobs: Sender<Job>,
    outcomes: Receiver<Outcome>,
    is_busy: bool,
}

impl Worker {
    /// Starts the thread.
    pub(crate) fn start() -> Result<Self, Failure> {
        let (jobs, to_do) = channel::<Job>();
        let (done, outcomes) = channel();
        let thread = std::thread::Builder::new().name("slam-align-work".to_owned());
        thread.spawn(move || {
            // Maps and the pose that is followed do not wait for it; threads of the pool inherit that.
            daemon::in_background();
            let Ok(pool) = rayon::ThreadPoolBuilder::new().build() else { return };
            let mut references = None;
            pool.install(|| {
                for Job { inputs, search } in to_do {
                    let found = work(&mut references, &inputs, search);
                    if done.send(Outcome { inputs, found }).is_err() {
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

    /// Gives the idle thread something to do.
    pub(crate) fn begin(&mut self, job: Job) -> Result<(), Failure> {
        self.is_busy = true;
        self.jobs.send(job).map_err(|_| "the search has panicked".into())
    }

    /// What came of the last job, if it is done.
    pub(crate) fn take(&mut self) -> Result<Option<Outcome>, Failure> {
        match self.outcomes.try_recv() {
            Ok(outcome) => {
                self.is_busy = false;
                Ok(Some(outcome))
            }
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err("the search has panicked".into()),
        }
    }

    /// Waits for the job that the thread is at.
    pub(crate) fn wait(&mut self) -> Result<Outcome, Failure> {
        let outcome = self.outcomes.recv().map_err(|_| "the search has panicked")?;
        self.is_busy = false;
        Ok(outcome)
    }
}

fn work(
    references: &mut Option<References>,
    inputs: &Inputs,
    search: Option<(Arc<RobotMap>, Where)>,
) -> Result<Found, Failure> {
    let (site, phase) = (inputs.site.view(), Phase::open(inputs.phase.bytes())?);
    phase.check_site(&site)?;
    let robot = Grids::open(inputs.index.bytes())?.head.robot;
    if references.as_ref().is_none_or(|r| !r.is_of(&site, &robot)) {
        *references = Some(References::new(&site, &robot)?);
    }
    let references = references.as_mut().ok_or("there is nothing to compare with")?;
    let maps: Vec<Arc<PreparedMap>> = references.at(&site, &phase)?.collect();
    let alignment = search.map(|(map, place)| align(&maps, map, &place)).transpose()?;
    Ok(Found { references: maps, alignment })
}

fn align(
    references: &[Arc<PreparedMap>],
    map: Arc<RobotMap>,
    place: &Where,
) -> Result<(Arc<RobotMap>, Alignment), Failure> {
    let Some(storey) = place.storey else {
        let alignment = align_maps(references, &map.prepared, place.hint.as_ref());
        return Ok((map, alignment));
    };
    let only = references.get(storey as usize).ok_or_else(|| format!("the site has no storey {storey}"))?;
    let mut alignment = align_maps(std::slice::from_ref(only), &map.prepared, place.hint.as_ref());
    alignment.poses.iter_mut().for_each(|pose| pose.reference = storey as usize);
    Ok((map, alignment))
}
