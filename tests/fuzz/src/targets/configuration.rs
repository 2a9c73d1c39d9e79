//! Configuration texts: a line with the kind of file, then the file.

use super::site;
use daemon::{
    AlignRequest, IngestRequest, RasterizeRequest, Robot, ScheduleRequest, SiteConfig, WaypointRequest, parse_request,
};
use export::SiteFrameFile;
use frames::PlanTime;
use messages::{ArchiveBuffer, Site};
use raster::Rasterizer;
use schedule::{Delay, Overrides, Rules, evaluate, parse_actuals};
use std::path::Path;
use std::sync::LazyLock;
use waypoints::MissionPlanOptions;
use world::WorldOptions;

/// Coarse: what a robot's numbers do to a map shows at any resolution.
const RESOLUTION_M: f64 = 0.25;

static HOUSE: LazyLock<ArchiveBuffer> = LazyLock::new(site::house);

/// Reads the file; what can be read is used on a small house.
pub fn run(bytes: &[u8]) {
    let Some(end) = memchr::memchr(b'\n', bytes) else { return };
    let (kind, content) = (&bytes[..end], &bytes[end + 1..]);
    if kind == b"actuals" {
        return actuals(content);
    }
    if kind == b"site-frame" {
        return drop(SiteFrameFile::parse(content));
    }
    if kind == b"request" {
        return request(content);
    }
    let Ok(text) = std::str::from_utf8(content) else { return };
    match kind {
        b"robot" => robot(text),
        b"site" => drop(SiteConfig::parse(text, Path::new("/home"))),
        b"rules" => rules(text),
        b"waypoints" => drop(MissionPlanOptions::parse(text)),
        b"world" => drop(WorldOptions::parse(text)),
        b"delay" => delay(text),
        b"date" => drop(text.parse::<PlanTime>()),
        _ => {}
    }
}

/// Requests are parsed as those of every daemon.
fn request(content: &[u8]) {
    drop(parse_request::<IngestRequest>(content));
    drop(parse_request::<ScheduleRequest>(content));
    drop(parse_request::<RasterizeRequest>(content));
    drop(parse_request::<WaypointRequest>(content));
    drop(parse_request::<AlignRequest>(content));
}

fn house() -> Site<'static> {
    Site::open(HOUSE.bytes()).expect("what was written can be read")
}

fn robot(text: &str) {
    let Ok(robot) = Robot::parse(text) else { return };
    let _ = Rasterizer::new(&house(), &robot.profile, RESOLUTION_M);
}

fn rules(text: &str) {
    let Ok(rules) = Rules::parse(text) else { return };
    let _ = evaluate(&house(), &rules, &Overrides::default());
}

fn delay(text: &str) {
    let Ok(delay) = Delay::parse(text) else { return };
    let _ = evaluate(&house(), &Rules::default(), &Overrides { delays: vec![delay], ..Overrides::default() });
}

fn actuals(table: &[u8]) {
    let Ok(actuals) = parse_actuals(table) else { return };
    for overrides in [
        Overrides { actuals: actuals.clone(), ..Overrides::default() },
        Overrides { observed: actuals, ..Overrides::default() },
    ] {
        let _ = evaluate(&house(), &Rules::default(), &overrides);
    }
}
