//! Many pairs of model maps and simulated SLAM maps, as files.

use crate::map_files::write_map;
use crate::output_error::OutputError;
use crate::plane::Vector;
use crate::random_generator::RandomGenerator;
use crate::reference::{Reference, repeated_name};
use crate::simulation::{Growth, Measures, Simulation, simulated_growth};
use crate::strengths::{Clutter, Strengths};
use crate::uniqueness::{fits, is_unique, overlap};
use rayon::prelude::*;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Drives that are tried for a pair before it is left out.
const MAX_TRIES: u64 = 16;

/// What to simulate.
#[derive(Debug, Clone, Copy)]
pub struct PairOptions {
    /// Pairs of a model map with a SLAM map of the same building, spread evenly over the references.
    pub count: usize,
    /// Pairs with a SLAM map of another building or storey.
    pub wrong: usize,
    /// The same seed gives the same files.
    pub seed: u64,
    /// How full the buildings are.
    pub clutter: Clutter,
    /// Storeys of a building with a larger share of their walls in common are not paired.
    pub max_storey_overlap: f64,
    /// Maps of each drive after equal parts of its way, each a pair of its own; 1 for the map of the whole way only.
    pub looks: usize,
}

/// Errors of pairs.
#[derive(Debug, thiserror::Error)]
pub enum PairError {
    /// No references, or files that cannot be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// Wrong pairs need another building, or a storey that differs.
    #[error("no two references are of different buildings or of storeys that differ")]
    NothingDiffers,
}

/// What a wrong pair mixes up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Wrong {
    /// Maps of two buildings.
    Building,
    /// Maps of two storeys of one building.
    Storey,
}

/// A line of `pairs.jsonl`.
#[derive(Debug, Serialize)]
struct PairLine<'a> {
    pair: &'a str,
    #[serde(flatten)]
    look: Option<Look<'a>>,
    reference: String,
    slam: String,
}

/// The pair of a growing map: a drive has several, in the order of their looks.
#[derive(Debug, Clone, Copy, Serialize)]
struct Look<'a> {
    drive: &'a str,
    /// From 1.
    look: usize,
    looks: usize,
}

/// A line of `truth.jsonl`. The pose takes points of the SLAM map to the model map of the building in which the robot drove.
#[derive(Debug, Serialize)]
struct TruthLine<'a> {
    pair: &'a str,
    #[serde(flatten)]
    look: Option<Look<'a>>,
    /// A place that is known again moves what was mapped before; null of a map of the whole way only.
    bends_back: Option<bool>,
    same_building: bool,
    wrong: Option<Wrong>,
    x: f64,
    y: f64,
    yaw: f64,
    centre: Vector,
    /// No other motion takes 95 % of the visible walls to walls of the model; null in wrong pairs.
    is_unique: Option<bool>,
    /// Some motion takes 95 % of the visible walls to walls of the wrong model; null in right pairs.
    fits_wrong_reference: Option<bool>,
    #[serde(flatten)]
    measures: &'a Measures,
    #[serde(flatten)]
    strengths: &'a Strengths,
}

struct Job<'a> {
    index: usize,
    drive: &'a Reference,
    wrong: Option<(&'a Reference, Wrong)>,
}

impl Job<'_> {
    /// The model map that the SLAM map is paired with.
    fn reference(&self) -> &Reference {
        self.wrong.map_or(self.drive, |(other, _)| other)
    }
}

/// Writes all pairs into a folder; the names of pairs that could not be made.
///
/// # Errors
/// No references that fit the options, files that cannot be written.
pub fn write_pairs(out: &Path, references: &[Reference], options: &PairOptions) -> Result<Vec<String>, PairError> {
    if let Some(name) = repeated_name(references) {
        return Err(OutputError::SameName { name: name.to_owned() }.into());
    }
    let jobs = jobs(references, options)?;
    let fault = |path: PathBuf| move |source| OutputError::Write { path, source };
    for folder in ["references", "slam"].map(|name| out.join(name)) {
        std::fs::create_dir_all(&folder).map_err(fault(folder))?;
    }
    for reference in references {
        let folder = out.join("references");
        write_map(&folder, &reference.name, &reference.map).map_err(fault(folder.clone()))?;
    }
    let made: Vec<(String, Vec<[String; 2]>)> =
        jobs.par_iter().map(|job| written(out, job, options)).collect::<Result<_, PairError>>()?;
    for (k, name) in ["pairs.jsonl", "truth.jsonl"].into_iter().enumerate() {
        let text: String = made.iter().flat_map(|(_, lines)| lines).map(|line| format!("{}\n", line[k])).collect();
        std::fs::write(out.join(name), text).map_err(fault(out.join(name)))?;
    }
    Ok(made.into_iter().filter(|(_, lines)| lines.is_empty()).map(|(name, _)| name).collect())
}

fn jobs<'a>(references: &'a [Reference], options: &PairOptions) -> Result<Vec<Job<'a>>, PairError> {
    if references.is_empty() {
        return Err(OutputError::NoReference.into());
    }
    let mut jobs: Vec<Job> = (0..options.count)
        .map(|index| Job { index, drive: &references[index % references.len()], wrong: None })
        .collect();
    if options.wrong == 0 {
        return Ok(jobs);
    }
    let wrong_of = |drive: &'a Reference, kind: Wrong| -> Vec<(&'a Reference, Wrong)> {
        let is_wrong = |other: &&Reference| match kind {
            Wrong::Building => other.building != drive.building,
            Wrong::Storey => other.building == drive.building && other.name != drive.name,
        };
        let differs =
            |other: &&Reference| kind == Wrong::Building || overlap(drive, other) < options.max_storey_overlap;
        references.iter().filter(is_wrong).filter(differs).map(|other| (other, kind)).collect()
    };
    // Each reference takes turns between other buildings and other storeys where it has both.
    let choices: Vec<[Vec<_>; 2]> =
        references.iter().map(|drive| [Wrong::Building, Wrong::Storey].map(|kind| wrong_of(drive, kind))).collect();
    let usable: Vec<usize> = (0..references.len()).filter(|&k| choices[k].iter().any(|c| !c.is_empty())).collect();
    if usable.is_empty() {
        return Err(PairError::NothingDiffers);
    }
    for k in 0..options.wrong {
        let (drive, turn) = (usable[k % usable.len()], k / usable.len());
        let [buildings, storeys] = &choices[drive];
        let takes_storey = buildings.is_empty() || (turn % 2 == 1 && !storeys.is_empty());
        let others = if takes_storey { storeys } else { buildings };
        let mut random = RandomGenerator::of(&[options.seed, 1, k as u64]);
        let wrong = Some(random.one_of(others));
        jobs.push(Job { index: options.count + k, drive: &references[drive], wrong });
    }
    Ok(jobs)
}

/// Simulates one drive and writes its maps; its name, and the lines of both tables for each map.
fn written(out: &Path, job: &Job, options: &PairOptions) -> Result<(String, Vec<[String; 2]>), PairError> {
    let other = job.wrong.map_or_else(String::new, |(other, _)| format!("_in_{}", other.name));
    let of = format!("{}{other}", job.drive.name);
    let drive = format!("{:04}_{of}", job.index);
    let is_growing = options.looks > 1;
    let drawn = (0..MAX_TRIES).find_map(|attempt| {
        let random = RandomGenerator::of(&[options.seed, 0, job.index as u64, attempt]);
        let strengths = Strengths::drawn(&mut random.part("strengths"), options.clutter);
        let bends_back = is_growing && random.part("growth").happens(0.5);
        let growth = Growth { n_looks: options.looks.max(1), bends_back };
        Some((simulated_growth(job.drive, &strengths, &random, growth)?, strengths, bends_back))
    });
    let Some((simulations, strengths, bends_back)) = drawn else { return Ok((drive, Vec::new())) };
    let mut lines = Vec::new();
    for (k, simulation) in simulations.iter().enumerate() {
        let Some(simulation) = simulation else { continue };
        let look = is_growing.then_some(Look { drive: &drive, look: k + 1, looks: simulations.len() });
        let pair = if is_growing { format!("{:04}-{:02}_{of}", job.index, k + 1) } else { drive.clone() };
        let folder = out.join("slam");
        write_map(&folder, &pair, &simulation.slam).map_err(|source| OutputError::Write { path: folder, source })?;
        let truth = truth(&pair, look, is_growing.then_some(bends_back), job, simulation, &strengths);
        let line = PairLine {
            pair: &pair,
            look,
            reference: format!("references/{}.yaml", job.reference().name),
            slam: format!("slam/{pair}.yaml"),
        };
        lines.push([
            serde_json::to_string(&line).expect("a line of names can be written"),
            serde_json::to_string(&truth).expect("a line of finite numbers can be written"),
        ]);
    }
    Ok((drive, lines))
}

fn truth<'a>(
    pair: &'a str,
    look: Option<Look<'a>>,
    bends_back: Option<bool>,
    job: &Job<'_>,
    simulation: &'a Simulation,
    strengths: &'a Strengths,
) -> TruthLine<'a> {
    let Simulation { map_from_slam, centre, visible_walls, measures, .. } = simulation;
    let [x, y, yaw] = map_from_slam.x_y_yaw();
    TruthLine {
        pair,
        look,
        bends_back,
        same_building: job.wrong.is_none(),
        wrong: job.wrong.map(|(_, kind)| kind),
        x,
        y,
        yaw,
        centre: *centre,
        is_unique: job.wrong.is_none().then(|| is_unique(job.drive, visible_walls)),
        fits_wrong_reference: job.wrong.map(|(other, _)| fits(other, visible_walls)),
        measures,
        strengths,
    }
}
