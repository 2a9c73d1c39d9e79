//! Jobs of the background worker: reference maps, pose search, deviations, on the planned site.

use crate::newest_inputs::JobInputs;
use crate::robot_map::RobotMap;
use alignment::{
    Alignment, Hint, Looks, PlaceHint, PreparedMap, References, SitePlaces, UnknownPlace, align_maps_within,
    references_hash,
};
use daemon::{Failure, KnownPlaces};
use deviations::{DeviationInput, deviations};
use frames::Map;
use messages::{Checked, PoseRecord, Site, SlamFrame, payload};
use site_view::SiteSamples;
use std::sync::Arc;

/// Where a pose is searched.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct SearchArea {
    pub(crate) hint: Option<Hint>,
    /// The robot is on this map storey.
    pub(crate) storey: Option<u32>,
    /// Where the robot is known to be.
    pub(crate) places: KnownPlaces,
    /// True if a request narrowed it: what is not found there may lie elsewhere.
    pub(crate) is_narrowed: bool,
}

/// A job of the worker.
pub struct Job {
    /// Site, schedule state and index of grids, which belong together.
    pub samples: SiteSamples,
    /// What they are.
    pub(crate) inputs: JobInputs,
    /// The generation of the bus that the samples belong to.
    pub(crate) generation: u64,
    /// What is to be done.
    pub task: Task,
}

/// The work of a job.
#[derive(Clone)]
pub enum Task {
    /// Draw the reference maps.
    Draw,
    /// Search the pose of a map.
    Search {
        /// The map.
        map: Arc<RobotMap>,
        /// Where its pose is searched.
        search_area: SearchArea,
        /// The number of the search, if a client asked for it.
        asked: Option<u64>,
        /// What earlier looks at the same map said: it begins with that.
        evidence: Option<Arc<Evidence>>,
    },
    /// Compare the site with a map.
    Compare {
        /// The map.
        map: Arc<RobotMap>,
        /// Its pose.
        pose: PoseRecord,
        /// How it lies in the model's map.
        slam_frame: Arc<SlamFrame>,
        /// The number of the comparison.
        comparison: u64,
    },
}

/// The kind of a task.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum TaskKind {
    Draw,
    Search,
    Compare,
}

impl Task {
    pub(crate) fn kind(&self) -> TaskKind {
        match self {
            Self::Draw => TaskKind::Draw,
            Self::Search { .. } => TaskKind::Search,
            Self::Compare { .. } => TaskKind::Compare,
        }
    }
}

impl TaskKind {
    /// What it does, for people.
    pub(crate) fn name(self) -> &'static str {
        match self {
            Self::Draw => "drawing the site as planned",
            Self::Search => "the search of the pose",
            Self::Compare => "the comparison with the site",
        }
    }
}

/// What looks at a growing map have said.
pub type Evidence = Checked<payload::AlignmentEvidence>;

/// Maps of the site, by map storey.
pub type ReferenceMaps = Vec<Arc<PreparedMap<Map>>>;

/// What came of a job: the reference maps, and the result of its task.
#[derive(Clone)]
pub struct JobResult {
    /// The reference maps.
    pub references: ReferenceMaps,
    /// The result of the task.
    pub found: Found,
}

/// The result of a task.
#[derive(Clone)]
pub enum Found {
    /// The reference maps are all.
    Drawn,
    /// Storeys are indices of the references; with the evidence after this look, if it says more than that before.
    Poses(Arc<Alignment>, Option<Arc<Evidence>>),
    /// Nothing was searched: a hint names what the site does not have.
    UnknownPlace(Arc<UnknownPlace>),
    /// What differs.
    Deviations(Arc<Checked<payload::Deviations>>),
}

/// Does a job. `references` are those of the last one, and are lost in a panic.
///
/// # Errors
/// Samples that do not belong together, a site that cannot be drawn, a storey that it does not have.
pub fn work(references: &mut Option<References>, job: &Job) -> Result<JobResult, Failure> {
    let state = job.samples.state().ok_or("site and schedule state do not belong together")?;
    let index = job.samples.index_of(state.site).ok_or("the index of the grids is of another site")?;
    let (site, schedule_state) = state.views()?;
    let robot = index.view().head.robot;
    let mut drawn = match references.take().filter(|r| r.is_of(&site, &robot)) {
        Some(references) => references,
        None => References::new(&site, &robot)?,
    };
    let maps: ReferenceMaps = drawn.at(&site, &schedule_state)?.collect();
    let found = match &job.task {
        Task::Draw => Found::Drawn,
        Task::Search { map, search_area, evidence, .. } => align(&site, &maps, map, search_area, evidence.as_deref())?,
        Task::Compare { map, pose, slam_frame, .. } => {
            let map_storey = pose.map_storey as usize;
            if map_storey >= maps.len() {
                return Err(format!("the site has no storey {map_storey} with which maps are compared").into());
            }
            Found::Deviations(Arc::new(Checked::new(deviations(&DeviationInput {
                site: &site,
                schedule_state: &schedule_state,
                robot: &robot,
                map_storey,
                slam: &map.map,
                slam_map_hash: map.content_hash,
                slam_frame,
                about_m: pose.about_m,
                covariance: pose.pose_covariance(),
            }))?))
        }
    };
    *references = Some(drawn);
    Ok(JobResult { references: maps, found })
}

fn align(
    site: &Site<'_>,
    references: &[Arc<PreparedMap<Map>>],
    map: &RobotMap,
    search_area: &SearchArea,
    evidence: Option<&Evidence>,
) -> Result<Found, Failure> {
    let (places, known) = (SitePlaces::of(site), &search_area.places);
    let mut hints = match places.hints(known.points_in_rooms(), known.elevation_m, known.portal.as_deref()) {
        Ok(hints) => hints,
        Err(why) => return Ok(Found::UnknownPlace(Arc::new(why))),
    };
    let storeys: Vec<u32> = (0..references.len() as u32).collect();
    if let Some(storey) = search_area.storey {
        if !storeys.contains(&storey) {
            return Err(format!("the site has no storey {storey} with which maps are aligned").into());
        }
        hints.push(PlaceHint::on_storey(storey));
    }
    let hash = references_hash(references, &storeys);
    let looks = evidence.and_then(|evidence| Looks::of(evidence.view(), hash, &map.prepared));
    let hint = search_area.hint.as_ref();
    let mut alignment = align_maps_within(references, &storeys, &map.prepared, hint, &hints, looks.as_ref());
    // Where a client narrowed the search, what was not looked for is no evidence.
    let after = (!search_area.is_narrowed)
        .then(|| alignment.evidence(&map.prepared, map.content_hash, hash, &storeys, looks.as_ref()))
        .flatten();
    let after = after.map(Evidence::new).transpose()?;
    alignment.decide(references, &map.prepared, &storeys, &places.rooms);
    Ok(Found::Poses(Arc::new(alignment), after.map(Arc::new)))
}
