//! Drives through changed storeys, as maps with what was changed and what was in view.

use super::changed_building::ChangedBuilding;
use super::changes::{Change, GroupChange, drawn_changes};
use super::model::{ModelError, ModelStorey};
use super::sightings::Sightings;
use crate::map_files::write_map;
use crate::plane::Vector;
use crate::random_generator::RandomGenerator;
use crate::simulation::{Measures, Simulation, simulated_in};
use crate::strengths::{Clutter, Strengths};
use rayon::prelude::*;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Drives that are tried for a run before it is left out.
const MAX_TRIES: u64 = 8;

/// What to simulate.
#[derive(Debug, Clone, Copy)]
pub struct RunOptions {
    /// Drives, spread evenly over the storeys.
    pub count: usize,
    /// Share of the walls, columns and pieces of furniture that are not as planned.
    pub changed_share: f64,
    /// The same seed gives the same files.
    pub seed: u64,
    /// How full the buildings are.
    pub clutter: Clutter,
}

/// Errors of runs.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A model cannot be read.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A file cannot be written.
    #[error("{} cannot be written", path.display())]
    Write {
        /// The file or the folder of the map.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// No storey can be simulated.
    #[error("no storey has elements at the height of the lidar")]
    NoStorey,
}

/// A line of `truth.jsonl`. The pose takes points of the SLAM map to the map of the model.
#[derive(Debug, Serialize)]
struct TruthLine<'a> {
    run: &'a str,
    building: &'a str,
    storey: usize,
    slam: String,
    x: f64,
    y: f64,
    yaw: f64,
    /// Mean of the free cells, in the frame of the SLAM map.
    centre: Vector,
    elements: BTreeMap<&'a str, ElementTruth<'a>>,
    #[serde(flatten)]
    measures: &'a Measures,
    #[serde(flatten)]
    strengths: &'a Strengths,
}

#[derive(Debug, Serialize)]
struct ElementTruth<'a> {
    class: &'a str,
    /// Along its longer side.
    length_m: f64,
    is_glass: bool,
    /// Leafs of the wall that it belongs to; 1 if it is one by itself.
    leafs: usize,
    /// Number of the group with which it was changed.
    group: Option<usize>,
    #[serde(flatten)]
    change: Option<Change>,
    is_planned_later: bool,
    /// Length on which beams ended.
    met_m: f64,
    /// Share of its place in the model, where nothing else stands now, that beams crossed.
    crossed_share: f64,
}

/// Writes `truth.jsonl` and the maps of all drives into a folder; the names of runs that could not be made.
///
/// # Errors
/// Models that cannot be read, files that cannot be written.
pub fn write_runs(out: &Path, folders: &[PathBuf], options: &RunOptions) -> Result<Vec<String>, RunError> {
    let mut storeys = Vec::new();
    for folder in folders {
        storeys.extend(ModelStorey::read_all(folder)?.into_iter().filter(|s| !s.elements.is_empty()));
    }
    // Without changes, a storey on which nobody can drive is left out at once.
    storeys.retain(|storey| ChangedBuilding::new(storey, &[]).is_ok());
    if storeys.is_empty() {
        return Err(RunError::NoStorey);
    }
    let fault = |path: PathBuf| move |source| RunError::Write { path, source };
    std::fs::create_dir_all(out).map_err(fault(out.to_owned()))?;
    let made: Vec<(String, Option<String>)> = (0..options.count)
        .into_par_iter()
        .map(|index| written(out, index, &storeys[index % storeys.len()], options))
        .collect::<Result<_, RunError>>()?;
    let text: String = made.iter().filter_map(|(_, line)| Some(format!("{}\n", line.as_ref()?))).collect();
    std::fs::write(out.join("truth.jsonl"), text).map_err(fault(out.join("truth.jsonl")))?;
    Ok(made.into_iter().filter(|(_, line)| line.is_none()).map(|(name, _)| name).collect())
}

/// Simulates one run and writes its map; its name and its line.
fn written(
    out: &Path,
    index: usize,
    storey: &ModelStorey,
    options: &RunOptions,
) -> Result<(String, Option<String>), RunError> {
    let run = format!("{index:04}_{}-{}", storey.building, storey.storey);
    for attempt in 0..MAX_TRIES {
        let random = RandomGenerator::of(&[options.seed, 2, index as u64, attempt]);
        let drawn = Strengths::drawn(&mut random.part("strengths"), options.clutter);
        // All that differs from the model is known by element.
        let strengths = Strengths { wall_changes_per_100_m2: 0.0, glass_share: 0.0, ..drawn };
        let changes = drawn_changes(storey, options.changed_share, &mut random.part("changes"));
        let Ok(building) = ChangedBuilding::new(storey, &changes) else { continue };
        let mut sightings = Sightings::new(storey, &building, &changes);
        let found =
            simulated_in(building.world(), &building.reference, &strengths, &random, |beam| sightings.add(beam));
        let Some(simulation) = found else { continue };
        write_map(out, &run, &simulation.slam).map_err(|source| RunError::Write { path: out.to_owned(), source })?;
        let line = truth_line(&run, storey, &changes, &sightings, &simulation, &strengths);
        return Ok((run, Some(line)));
    }
    Ok((run, None))
}

fn truth_line(
    run: &str,
    storey: &ModelStorey,
    changes: &[GroupChange],
    sightings: &Sightings<'_>,
    simulation: &Simulation,
    strengths: &Strengths,
) -> String {
    let truth_of = |k: usize| {
        let element = &storey.elements[k];
        let group = changes.iter().position(|c| c.members.contains(&k));
        let truth = ElementTruth {
            class: &element.class,
            length_m: 2.0 * element.rectangle.half[0],
            is_glass: element.is_glass(),
            leafs: group.map_or(1, |g| changes[g].members.len()),
            group,
            change: group.map(|g| changes[g].change),
            is_planned_later: group.is_some_and(|g| changes[g].is_planned_later),
            met_m: sightings.met_m(k),
            crossed_share: sightings.crossed_share(k),
        };
        (element.global_id.as_str(), truth)
    };
    let [x, y, yaw] = simulation.map_from_slam.x_y_yaw();
    let line = TruthLine {
        run,
        building: &storey.building,
        storey: storey.storey,
        slam: format!("{run}.yaml"),
        x,
        y,
        yaw,
        centre: simulation.centre,
        elements: (0..storey.elements.len()).map(truth_of).collect(),
        measures: &simulation.measures,
        strengths,
    };
    serde_json::to_string(&line).expect("a line of finite numbers can be written")
}
