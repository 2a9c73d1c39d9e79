//! Goals of the model carried into the robot's map.

use crate::failure::Failure;
use crate::input_document::read_document;
use ::deviations::LocalTransform;
use export::{ExportFile, rounded};
use serde::{Deserialize, Serialize};
use std::path::Path;

/// The part of `waypoints.json` that goals need.
#[derive(Deserialize)]
struct GoalFile {
    waypoints: Vec<Goal>,
}

/// A waypoint in the model's map.
#[derive(Deserialize)]
struct Goal {
    id: Option<u32>,
    name: Option<String>,
    /// Index of the map storey; without it, that of the SLAM map.
    storey: Option<u32>,
    x_m: f64,
    y_m: f64,
    yaw_rad: f64,
}

/// `goals.json`.
#[derive(Serialize)]
struct CarriedGoals {
    /// Index of the map storey.
    storey: usize,
    goals: Vec<CarriedGoal>,
}

#[derive(Serialize)]
struct CarriedGoal {
    id: Option<u32>,
    name: Option<String>,
    /// In the model's map.
    map: GoalPose,
    /// In the robot's map.
    slam: GoalPose,
    /// Standard deviations, along the axes of the robot's map.
    deviation: GoalPose,
    /// False if the rigid pose alone carried it.
    is_corrected: bool,
}

#[derive(Serialize)]
struct GoalPose {
    x_m: f64,
    y_m: f64,
    yaw_rad: f64,
}

impl GoalPose {
    fn of([x_m, y_m, yaw_rad]: [f64; 3]) -> Self {
        Self { x_m: rounded(x_m), y_m: rounded(y_m), yaw_rad: rounded(yaw_rad) }
    }
}

/// `goals.json`: the waypoints of a file that lie on the storey, in the robot's map.
///
/// # Errors
/// A file that cannot be read, or holds no waypoints; a goal that lies nowhere in the robot's map.
pub(super) fn carried(path: &Path, storey: usize, transform: &LocalTransform<'_>) -> Result<ExportFile, Failure> {
    let fault = |error: &dyn std::fmt::Display| Failure::usage(format!("{}: {error}", path.display()));
    let bytes = read_document(path).map_err(|error| fault(&error))?;
    let file: GoalFile = serde_json::from_slice(&bytes).map_err(|error| fault(&error))?;
    let here = file.waypoints.into_iter().filter(|goal| goal.storey.is_none_or(|of| of as usize == storey));
    let goals: Result<Vec<CarriedGoal>, Failure> = here.map(|goal| carried_goal(goal, transform)).collect();
    let goals = goals?;
    let text = serde_json::to_string_pretty(&CarriedGoals { storey, goals }).map_err(Failure::work)? + "\n";
    Ok(ExportFile { path: "goals.json".to_owned(), bytes: text.into_bytes() })
}

fn carried_goal(goal: Goal, transform: &LocalTransform<'_>) -> Result<CarriedGoal, Failure> {
    let place = transform.slam_place([goal.x_m, goal.y_m], goal.yaw_rad).ok_or_else(|| {
        let Goal { x_m, y_m, .. } = goal;
        Failure::work(format!(
            "the goal at ({x_m}, {y_m}) lies nowhere in the robot's map, which bends so much that it folds there"
        ))
    })?;
    let [x_m, y_m] = place.at_m;
    Ok(CarriedGoal {
        id: goal.id,
        name: goal.name,
        map: GoalPose::of([goal.x_m, goal.y_m, goal.yaw_rad]),
        slam: GoalPose::of([x_m, y_m, place.yaw_rad]),
        deviation: GoalPose::of(place.covariance.deviations()),
        is_corrected: place.is_corrected,
    })
}
