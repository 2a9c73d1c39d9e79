//! Description of a sample as JSON, for `topic echo`.

use crate::alignment_report;
use crate::date_argument::optional_text;
use bus::{RawSample, TopicName};
use daemon::facts::Pose;
use messages::{Alignment, ArchiveError, ContentHash, Grid, Grids, MissionPlan, ScheduleState, Site, SlamMap, Tasks};
use serde_json::{Value, json};

/// A hash as text.
pub(super) fn hash_text(hash: ContentHash) -> String {
    hash.to_string()
}

/// A sample: its header, and the head of what it holds.
///
/// # Errors
/// A sample that is damaged.
pub(super) fn describe(sample: &RawSample) -> Result<Value, ArchiveError> {
    let header = sample.header();
    let content = match sample.topic() {
        TopicName::Site | TopicName::Candidate => {
            let site = Site::open(sample.bytes())?;
            let (elements, spaces, tasks) = (site.elements.len(), site.spaces.len(), site.schedule.tasks.len());
            json!({"elements": elements, "spaces": spaces, "map_storeys": site.map_storeys.len(), "tasks": tasks})
        }
        TopicName::Tasks => {
            let schedule = Tasks::open(sample.bytes())?.schedule();
            let files: Vec<&str> = schedule.sources.iter().map(|source| schedule.text(source.file)).collect();
            json!({"files": files, "tasks": schedule.tasks.len(), "links": schedule.task_links.len()})
        }
        TopicName::ScheduleState => {
            let head = ScheduleState::open(sample.bytes())?.head;
            json!({
                "plan_time": optional_text(head.plan_time_s),
                "valid_from": optional_text(head.valid_from_s),
                "valid_until": optional_text(head.valid_until_s),
                "changes": head.n_changes,
            })
        }
        TopicName::Grid(_) => {
            let grid = Grid::open(sample.bytes())?;
            let spec = grid.spec();
            json!({
                "map_storey": grid.head.map_storey,
                "size_cells": [grid.head.width, grid.head.height],
                "resolution_m": spec.resolution_m(),
                "origin_m": spec.origin_m(),
                "free_cells": grid.planning.iter().filter(|&&p| p == 0).count(),
            })
        }
        TopicName::Grids => {
            let index = Grids::open(sample.bytes())?;
            let grids: Vec<String> = index.slots.iter().map(|s| hash_text(s.content_hash)).collect();
            json!({"plan_time": optional_text(index.head.plan_time_s), "robot": index.robot_name, "grids": grids})
        }
        TopicName::MissionPlan => {
            let mission_plan = MissionPlan::open(sample.bytes())?;
            let share = |n: u32, of: u32| (of > 0).then(|| f64::from(n) / f64::from(of));
            let storeys: Vec<Value> = mission_plan
                .storeys
                .iter()
                .map(|s| {
                    json!({
                        "map_storey": s.map_storey,
                        "scans": s.n_scans,
                        "coverage": share(s.n_seen, s.n_faces),
                        "tour_m": s.tour_m,
                        "reached_m2": s.reached_m2,
                    })
                })
                .collect();
            let covered = mission_plan.spaces.iter().map(|s| share(s.n_seen, s.n_faces)).collect::<Vec<_>>();
            json!({"waypoints": mission_plan.waypoints.len(), "storeys": storeys, "space_coverage": covered})
        }
        TopicName::SlamMap => {
            let head = SlamMap::open(sample.bytes())?.head;
            let size = [head.width, head.height];
            json!({"size_cells": size, "resolution_m": head.resolution_m, "origin": Pose::of(head.origin)})
        }
        TopicName::Alignment => alignment_report::document(
            &Alignment::open(sample.bytes())?,
            None,
            alignment_report::inputs_of(sample.header()),
        ),
        TopicName::Deviations => Value::Null,
    };
    Ok(json!({
        "topic": sample.topic().to_string(),
        "epoch": header.epoch,
        "bytes": header.payload_length,
        "content_hash": hash_text(header.content_hash),
        "site_hash": hash_text(header.inputs.site),
        "phase_hash": hash_text(header.inputs.schedule_state),
        "content": content,
    }))
}
