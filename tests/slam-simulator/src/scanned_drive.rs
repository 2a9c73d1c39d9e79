//! A drive of a robot through one building in use, with what its lidar measured: true poses, scans, and walls that came in view.

use crate::building::{Contents, fill};
use crate::plane::Vector;
use crate::random_generator::RandomGenerator;
use crate::reference::Reference;
use crate::robot::drive::{Drive, drive};
use crate::robot::lidar::{Beam, LidarScene, beam_directions};
use crate::robot::people::People;
use crate::strengths::Strengths;
use crate::world::{Material, World};

/// Fewer scans are no drive, and less of the model's walls no map of the building.
const MIN_SCANS: usize = 8;
const MIN_VISIBLE_M: f64 = 4.0;

/// What happens between two scans, and until the last.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pace {
    /// The robot turns by at most this angle, on the spot where its way turns more.
    pub(crate) max_turn_rad: f64,
    /// Steps that people walk.
    pub(crate) people_steps: f64,
    /// The robot stops after this way.
    pub(crate) max_way_m: f64,
}

impl Pace {
    /// Scans where a map needs them: the robot turns at once, and people walk one step.
    pub(crate) const OF_MAPS: Self = Self { max_turn_rad: f64::INFINITY, people_steps: 1.0, max_way_m: f64::INFINITY };
}

/// What a robot measured on its way.
pub(crate) struct ScannedDrive {
    /// True poses, in the frame of the model map.
    pub(crate) drive: Drive,
    /// Directions of the beams of each scan from the direction of travel.
    pub(crate) beams: Vec<Vector>,
    /// Ranges of each scan in metres, by beam: infinite where nothing is in range, NaN where the answer was lost.
    pub(crate) scans: Vec<Vec<f32>>,
    /// What is in the building and not in the model.
    pub(crate) contents: Contents,
    /// The first scan that met each cell of the model's walls; [`usize::MAX`] for none and for other cells.
    seen_first: Vec<usize>,
}

impl ScannedDrive {
    /// Middles of the wall cells of the model that a beam of the first scans met; `None` if these scans show too little.
    pub(crate) fn visible_walls(&self, reference: &Reference, n_scans: usize) -> Option<Vec<Vector>> {
        let is_visible = |k: &usize| self.seen_first[*k] < n_scans;
        let visible: Vec<Vector> =
            (0..self.seen_first.len()).filter(is_visible).map(|k| reference.grid.middle(k)).collect();
        let is_enough = n_scans >= MIN_SCANS && (visible.len() as f64) * reference.grid.resolution_m >= MIN_VISIBLE_M;
        is_enough.then_some(visible)
    }
}

/// A drive through a world that is filled first; all beams are reported. `None` if there is too little floor to drive on.
pub(crate) fn scanned_drive(
    mut world: World,
    reference: &Reference,
    strengths: &Strengths,
    pace: Pace,
    random: &RandomGenerator,
    mut saw: impl FnMut(&Beam),
) -> Option<ScannedDrive> {
    let contents = fill(&mut world, reference, strengths, &random.part("building"));
    let clearance = world.clearance();
    let way = drive(&world, &clearance, strengths, &mut random.part("drive"))?;
    let drive = way.begin(way.way_m.partition_point(|m| *m <= pace.max_way_m)).turning(pace.max_turn_rad);
    let scene = LidarScene { world: &world, clearance: &clearance, strengths };
    let beams = beam_directions(&strengths.lidar);
    let mut people = People::new(strengths.people_per_scan, pace.people_steps);
    let (mut walkers, mut lidar) = (random.part("people"), random.part("lidar"));
    let mut seen_first = vec![usize::MAX; reference.grid.walls.len()];
    let mut scans = Vec::with_capacity(drive.places.len());
    for (number, (&place, &heading)) in drive.places.iter().zip(&drive.headings).enumerate() {
        let discs = people.step(&world, place, &mut walkers);
        let ranges = scene.scan(place, heading, &beams, &discs, &mut lidar, |beam| {
            saw(beam);
            let ended_at =
                beam.ended_at.filter(|p| world.index_at(*p).is_some_and(|k| world.cells[k] == Material::Wall));
            if let Some(k) = ended_at.and_then(|p| reference.grid.index_at(p)).filter(|&k| reference.grid.walls[k]) {
                seen_first[k] = seen_first[k].min(number);
            }
        });
        scans.push(ranges);
    }
    Some(ScannedDrive { drive, beams, scans, contents, seen_first })
}
