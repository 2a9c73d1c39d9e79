//! The robots of a site, as its server knows them: its document, and what viewers see of it.

use bus::Daemon;
use daemon::facts::Pose;
use daemon::{FLEET_FILE, Failure, FleetDocument, Report, SiteConfig, StatusBoard};
use input_files::read_regular_file;
use serde::de::IgnoredAny;
use serde_json::{Value, json};

/// A larger document is none of a fleet.
const MAX_BYTES: u64 = 64 << 20;

/// The document of the fleet; `None` for a site without a link with robots. Where its server does not run, it says so.
///
/// # Errors
/// A document that cannot be read, or is not there yet.
pub(super) fn document(config: &SiteConfig) -> Result<Option<FleetDocument>, Failure> {
    if config.serve.as_ref().is_none_or(|serve| serve.link.is_none()) {
        return Ok(None);
    }
    let bytes = read_regular_file(&config.site_state.join(FLEET_FILE), MAX_BYTES)?;
    let mut document: FleetDocument = serde_json::from_slice(&bytes)?;
    let report: Option<Report<IgnoredAny>> = StatusBoard::of_own(config).report(Daemon::SiteServer);
    if report.is_none_or(|report| report.is_silent()) {
        document.error = Some("site-server does not run: this is of before".to_owned());
    }
    Ok(Some(document))
}

/// What viewers see of it; null without a link.
pub(super) fn event(config: &SiteConfig) -> Value {
    let document = match document(config) {
        Ok(Some(document)) => document,
        Ok(None) => return Value::Null,
        Err(why) => return json!({ "error": daemon::chain(why.as_ref()), "robots": [] }),
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
