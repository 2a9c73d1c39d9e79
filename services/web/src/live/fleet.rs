//! The robots of a site, as viewers see them.

use daemon::SiteConfig;
use daemon::facts::Pose;
use serde_json::{Value, json};
use site_answers::fleet_document;

/// What viewers see of it; null without a link.
pub(super) fn event(config: &SiteConfig) -> Value {
    let document = match fleet_document(config) {
        Ok(Some(document)) => document,
        Ok(None) => return Value::Null,
        Err(why) => return json!({ "error": daemon::chain(&why), "robots": [] }),
    };
    let robots = document.robots.iter().map(|(name, robot)| {
        let place = robot.report.as_ref().and_then(|report| report.place);
        let place = place.map(|place| {
            let Pose { x_m, y_m, yaw_rad } = place.pose;
            json!({ "storey": place.map_storey, "x_m": x_m, "y_m": y_m, "yaw_rad": yaw_rad })
        });
        json!({
            "name": name, "state": robot.state, "here": robot.here, "findings": robot.findings, "place": place,
            "epoch": robot.report.as_ref().map(|report| report.epoch),
            "plan_time": robot.report.as_ref().and_then(|report| report.plan_time.clone()),
        })
    });
    let conflicts = document.elements.iter().filter(|element| element.is_conflict);
    let conflicts = conflicts.map(|element| {
        let told: Vec<String> =
            element.told.iter().map(|(robot, told)| format!("{robot}: {}", told.observed.observation)).collect();
        json!({ "id": element.id, "told": told.join(", ") })
    });
    json!({
        "error": document.error, "epoch": document.epoch, "robots": robots.collect::<Vec<_>>(),
        "conflicts": conflicts.take(N_CONFLICTS).collect::<Vec<_>>(), "n_elements": document.n_elements,
    })
}

/// So many conflicts are shown.
const N_CONFLICTS: usize = 50;
