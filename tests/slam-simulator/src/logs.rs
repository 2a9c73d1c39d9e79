//! Drives as logs for programs that do SLAM, with the true poses and the model map of each, as files.

use crate::building::Contents;
use crate::carmen_log::carmen_log;
use crate::map_files::write_map;
use crate::output_error::OutputError;
use crate::random_generator::RandomGenerator;
use crate::reference::{Reference, repeated_name};
use crate::robot::odometry::odometry;
use crate::scanned_drive::{Pace, ScannedDrive, scanned_drive};
use crate::strengths::{Clutter, Lidar, Strengths};
use crate::uniqueness::is_unique;
use crate::world::World;
use rayon::prelude::*;
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// Drives that are tried for a log before it is left out.
const MAX_TRIES: u64 = 16;
/// Way between two scans, and turn on the spot: from slow robots with a lidar of 4 Hz to fast ones with one of 1 Hz.
const SCAN_SPACING_M: [f64; 2] = [0.1, 0.5];
const MAX_TURN_RAD: [f64; 2] = [0.2, 0.5];
/// Way of the robot in which people walk one step.
const WAY_PER_STEP_M: f64 = 0.5;
/// Drift of the odometry, as a share of the way.
const DRIFT_SHARE: [f64; 2] = [0.01, 0.05];

/// What to simulate.
#[derive(Debug, Clone, Copy)]
pub struct LogOptions {
    /// Drives, spread evenly over the references.
    pub count: usize,
    /// The same seed gives the same files.
    pub seed: u64,
    /// How full the buildings are.
    pub clutter: Clutter,
    /// The robot stops after this way, in metres.
    pub max_way_m: f64,
}

/// A line of `drives.jsonl`.
#[derive(Debug, Serialize)]
struct DriveLine<'a> {
    /// Name of the files of the drive.
    drive: &'a str,
    building: &'a str,
    /// Mean offset of the odometry after 10 m of way, as a share of it.
    odometry_drift: f64,
    way_m: f64,
    scans: usize,
    /// Share of the reachable floor to which the robot came.
    covered: f64,
    /// True if the walls that the robot saw fit the model in one pose only.
    is_unique: bool,
    /// What is in the building and not in the model.
    #[serde(flatten)]
    contents: &'a Contents,
    #[serde(flatten)]
    strengths: &'a LogStrengths,
}

/// The strengths of the effects of a drive, without those of the map, which is not made here.
#[derive(Debug, Serialize)]
struct LogStrengths {
    clutter: f64,
    wall_changes_per_100_m2: f64,
    glass_share: f64,
    glass_hit_share: f64,
    people_per_scan: f64,
    scan_spacing_m: f64,
    lidar: Lidar,
}

/// Writes `drives.jsonl` and for each drive into a folder: `NAME.log`, what the robot measured and counted; `NAME-true.csv`, the
/// true pose of each scan in the frame of the model map, metres and radians; `NAME-reference.yaml`, the model map. The result is
/// the names of drives that could not be made.
///
/// # Errors
/// No references, references of one name, files that cannot be written.
pub fn write_logs(out: &Path, references: &[Reference], options: &LogOptions) -> Result<Vec<String>, OutputError> {
    if references.is_empty() {
        return Err(OutputError::NoReference);
    }
    if let Some(name) = repeated_name(references) {
        return Err(OutputError::SameName { name: name.to_owned() });
    }
    std::fs::create_dir_all(out).map_err(|source| OutputError::Write { path: out.to_owned(), source })?;
    let made: Vec<(String, Option<String>)> = (0..options.count)
        .into_par_iter()
        .map(|index| written(out, index, &references[index % references.len()], options))
        .collect::<Result<_, OutputError>>()?;
    let text: String = made.iter().filter_map(|(_, line)| Some(format!("{}\n", line.as_ref()?))).collect();
    write_text(&out.join("drives.jsonl"), &text)?;
    Ok(made.into_iter().filter(|(_, line)| line.is_none()).map(|(name, _)| name).collect())
}

fn write_text(path: &Path, text: &str) -> Result<(), OutputError> {
    std::fs::write(path, text).map_err(|source| OutputError::Write { path: path.to_owned(), source })
}

/// Simulates one drive and writes its files; its name and its line.
fn written(
    out: &Path,
    index: usize,
    reference: &Reference,
    options: &LogOptions,
) -> Result<(String, Option<String>), OutputError> {
    let name = format!("{index:04}_{}", reference.name);
    let drawn = (0..MAX_TRIES).find_map(|attempt| {
        let random = RandomGenerator::of(&[options.seed, 3, index as u64, attempt]);
        let mut of_log = random.part("log");
        let strengths = Strengths {
            scan_spacing_m: of_log.between(SCAN_SPACING_M[0], SCAN_SPACING_M[1]),
            ..Strengths::drawn(&mut random.part("strengths"), options.clutter)
        };
        let pace = Pace {
            max_turn_rad: of_log.between(MAX_TURN_RAD[0], MAX_TURN_RAD[1]),
            people_steps: strengths.scan_spacing_m / WAY_PER_STEP_M,
            max_way_m: options.max_way_m,
        };
        let scanned = scanned_drive(World::of(&reference.grid), reference, &strengths, pace, &random, |_| ())?;
        let is_unique = is_unique(reference, &scanned.visible_walls(reference, scanned.scans.len())?);
        let drift = of_log.between(DRIFT_SHARE[0], DRIFT_SHARE[1]);
        let odometry = odometry(&scanned.drive, drift, &mut random.part("odometry"));
        Some((strengths, scanned, is_unique, drift, odometry))
    });
    let Some((strengths, scanned, is_unique, drift, odometry)) = drawn else { return Ok((name, None)) };
    write_text(&out.join(format!("{name}.log")), &carmen_log(&scanned.scans, &odometry, &strengths.lidar))?;
    write_text(&out.join(format!("{name}-true.csv")), &true_poses(&scanned))?;
    write_map(out, &format!("{name}-reference"), &reference.map)
        .map_err(|source| OutputError::Write { path: out.to_owned(), source })?;
    let line = drive_line(&name, reference, &scanned, is_unique, drift, &strengths);
    Ok((name, Some(line)))
}

fn true_poses(scanned: &ScannedDrive) -> String {
    let mut text = String::from("true_x_m,true_y_m,true_yaw_rad\n");
    for ([x, y], heading) in scanned.drive.places.iter().zip(&scanned.drive.headings) {
        // Writing into a string cannot fail.
        let _ = writeln!(text, "{x:.6},{y:.6},{:.9}", libm::atan2(heading[1], heading[0]));
    }
    text
}

fn drive_line(
    name: &str,
    reference: &Reference,
    scanned: &ScannedDrive,
    is_unique: bool,
    odometry_drift: f64,
    strengths: &Strengths,
) -> String {
    let last = |values: &[f64]| values.last().copied().unwrap_or(0.0);
    let line = DriveLine {
        drive: name,
        building: &reference.building,
        odometry_drift,
        way_m: last(&scanned.drive.way_m),
        scans: scanned.scans.len(),
        covered: last(&scanned.drive.covered),
        is_unique,
        contents: &scanned.contents,
        strengths: &LogStrengths {
            clutter: strengths.clutter,
            wall_changes_per_100_m2: strengths.wall_changes_per_100_m2,
            glass_share: strengths.glass_share,
            glass_hit_share: strengths.glass_hit_share,
            people_per_scan: strengths.people_per_scan,
            scan_spacing_m: strengths.scan_spacing_m,
            lidar: strengths.lidar,
        },
    };
    serde_json::to_string(&line).expect("a line of finite numbers can be written")
}
