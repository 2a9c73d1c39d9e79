//! A robot in the room of the models: its SLAM map, and results of the worker of slam-align.

use crate::models::models;
use alignment::{AlignedPose, Alignment, Contrast, CornersInSight, HeldOut, PoseHistory, References};
use bus::{Bus, Daemon, InProcessBus, Origin, Publisher, topics};
use daemon::Failure;
use frames::{PoseCovariance, Rigid2};
use messages::{AlignmentVerdict, ContentHash, InputHashes, PoseEvidence, RobotProfile, SlamMap, SlamMapHead};
use slam_align::job::{Found, Job, JobResult, ReferenceMaps, Task, work};
use std::collections::HashMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, OnceLock};

/// Where the robot's frame lies in the model's map: x, y in metres, yaw.
pub(crate) const TRUE_POSE: [f64; 3] = [-1.0, -0.5, 0.0];

/// Metres per cell of its map, and cells of it along x and y.
const CELL_M: f64 = 0.05;
const SIZE: [usize; 2] = [104, 72];
/// Its lower left corner in the model's map.
const CORNER_M: [f64; 2] = [-0.3, -0.3];

/// Maps that it has made, the newest last.
pub(crate) const N_MAPS: usize = 3;

/// A robot that publishes maps.
pub(crate) struct Robot {
    maps: Publisher<topics::SlamMap>,
    /// That of its last map.
    pub(crate) epoch: u64,
}

impl Robot {
    /// On this bus, after this epoch.
    pub(crate) fn of(bus: &InProcessBus, epoch: u64) -> Self {
        Self { maps: Bus::in_process(bus, Daemon::Robot).publisher(topics::SlamMap, 1 << 14).unwrap(), epoch }
    }

    /// Publishes the map of this number, if there is room. By the last one the robot sees through the wall at x = 4 m.
    pub(crate) fn publish(&mut self, map: usize) {
        let cells: Vec<i8> = (0..SIZE[0] * SIZE[1]).map(|k| cell([k % SIZE[0], k / SIZE[0]], map)).collect();
        let origin = [CORNER_M[0] - TRUE_POSE[0], CORNER_M[1] - TRUE_POSE[1], 0.0];
        let [width, height] = SIZE.map(|n| n as u32);
        let archive = SlamMap::write(&SlamMapHead { resolution_m: CELL_M, origin, width, height }, &cells);
        self.epoch += 1;
        let origin = Origin { epoch: self.epoch, frame_epoch: 0, inputs: InputHashes::default() };
        // Without room, or if it is the one that dies of it, the map is lost.
        let _ = catch_unwind(AssertUnwindSafe(|| self.maps.publish_copy(archive.bytes(), origin).is_ok()));
    }
}

/// Saves the map of this number as a map server does; the path of its description.
pub(crate) fn save(map: usize, folder: &Path) -> PathBuf {
    let rows = (0..SIZE[1]).rev();
    let pixels = rows.flat_map(|row| (0..SIZE[0]).map(move |column| cell([column, row], map)));
    let pixels = pixels.map(|cell| [205, 254, 0][usize::from(cell == 0) + 2 * usize::from(cell == 100)]);
    let image = [format!("P5\n{} {}\n255\n", SIZE[0], SIZE[1]).into_bytes(), pixels.collect()].concat();
    std::fs::write(folder.join("map.pgm"), image).unwrap();
    let origin = [CORNER_M[0] - TRUE_POSE[0], CORNER_M[1] - TRUE_POSE[1], 0.0];
    let path = folder.join("map.yaml");
    std::fs::write(&path, format!("image: map.pgm\nresolution: {CELL_M}\norigin: {origin:?}\n")).unwrap();
    path
}

/// A cell of a map: free in the room, occupied where a wall begins.
fn cell([column, row]: [usize; 2], map: usize) -> i8 {
    let [x, y] = [(CORNER_M[0], column), (CORNER_M[1], row)].map(|(from, n)| from + (n as f64 + 0.5) * CELL_M);
    let is_open = map == N_MAPS - 1;
    let x1 = if is_open { 4.8 } else { 4.0 };
    let is_free = 0.0 < x && x < x1 && 0.0 < y && y < 3.0;
    let is_wall = -CELL_M < x && x < 4.0 + CELL_M && -CELL_M < y && y < 3.0 + CELL_M;
    match (is_free, is_wall && !(is_open && 4.0 < x)) {
        // Each map has seen a little more of the room.
        (true, _) if map == 0 && x < 0.2 && y < 0.2 => -1,
        (true, _) => 0,
        (false, true) => 100,
        (false, false) => -1,
    }
}

/// An alignment that accepts this pose.
pub(crate) fn accepted(map_from_slam: [f64; 3]) -> Alignment {
    let mut evidence = PoseEvidence::default();
    (evidence.score, evidence.log_odds) = (1.0, 9.0);
    let pose = AlignedPose {
        reference: 0,
        map_from_slam: Rigid2::of_x_y_yaw(map_from_slam),
        evidence,
        contrast: Contrast::default(),
        corners: CornersInSight::default(),
        new: None,
        history: PoseHistory { of_this_building: 9.0, held_out: HeldOut::default() },
        about_m: [3.0, 2.0],
        covariance: PoseCovariance::from_rows([[1e-5, 0.0, 0.0], [0.0, 1e-5, 0.0], [0.0, 0.0, 1e-6]]),
    };
    let (verdict, reason) = (AlignmentVerdict::Accepted, String::new());
    Alignment { verdict, reason, wrong_probability: 1e-6, poses: vec![pose], ..Alignment::nothing_yet() }
}

/// The result of a job: a search finds this; the rest is worked out, once for all histories.
pub(crate) fn result_of(job: &Job, found: &Alignment) -> Result<JobResult, Failure> {
    match &job.task {
        Task::Search { .. } => {
            let references = references_of(job)?;
            Ok(JobResult { references, found: Found::Poses(Arc::new(found.clone()), None) })
        }
        Task::Draw => Ok(JobResult { references: references_of(job)?, found: Found::Drawn }),
        Task::Compare { map, pose, .. } => {
            type Compared = Mutex<HashMap<([ContentHash; 2], [i64; 3]), JobResult>>;
            static COMPARED: OnceLock<Compared> = OnceLock::new();
            let compared = COMPARED.get_or_init(Compared::default);
            // What a pose nearby, at another date, gives will do.
            let place = pose.map_from_slam.map(|c| (4.0 * c).round() as i64);
            let (site, ..) = key_of(job)?;
            let key = ([site, map.content_hash()], place);
            let known = compared.lock().unwrap().get(&key).cloned();
            if let Some(known) = known {
                return Ok(JobResult { references: references_of(job)?, ..known });
            }
            let result = work(&mut None, job)?;
            compared.lock().unwrap().insert(key, result.clone());
            Ok(result)
        }
    }
}

/// Site, schedule state, and the robot's radius.
type Key = (ContentHash, ContentHash, u64);

fn robot_of(job: &Job) -> Result<RobotProfile, Failure> {
    Ok(job.samples.index().ok_or("no index")?.view().head.robot)
}

fn key_of(job: &Job) -> Result<Key, Failure> {
    let state = job.samples.state().ok_or("no state of the site")?;
    Ok((state.site.content_hash(), state.state.content_hash(), robot_of(job)?.radius_m.to_bits()))
}

/// The reference maps of the samples of a job.
fn references_of(job: &Job) -> Result<ReferenceMaps, Failure> {
    type Drawn = Mutex<HashMap<Key, ReferenceMaps>>;
    static DRAWN: OnceLock<Drawn> = OnceLock::new();
    let (drawn, key) = (DRAWN.get_or_init(Drawn::default), key_of(job)?);
    let known = drawn.lock().unwrap().get(&key).cloned();
    if let Some(known) = known {
        return Ok(known);
    }
    let state = job.samples.state().ok_or("no state of the site")?;
    let (site, schedule_state) = state.views()?;
    let maps: ReferenceMaps = References::new(&site, &robot_of(job)?)?.at(&site, &schedule_state)?.collect();
    drawn.lock().unwrap().insert(key, maps.clone());
    Ok(maps)
}

/// The wall at x = 4 m, which the last map sees through.
pub(crate) fn east_wall() -> &'static str {
    &models().walls[3]
}
