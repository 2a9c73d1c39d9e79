//! A site with two robots in one process: each one's grids are those of a fresh rasterizer for its own profile, whatever happens to
//! the daemons of the other.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "support/models.rs"]
#[expect(dead_code, reason = "other tests use the rest of it")]
mod models;

use bus::{Bus, Daemon, RobotName};
use daemon::ScheduleRequest;
use messages::{ContentHash, RobotProfile};
use models::{RESOLUTION_M, RULES, START_MS, models};
use raster::Rasterizer;
use site_simulator::{Daemons, End, SimulatedClock};
use site_view::SiteSetReader;
use std::sync::Arc;
use std::sync::atomic::AtomicI64;

const DAY_S: i64 = 86_400;
const OF_SITE: [Daemon; 2] = [Daemon::IfcIngest, Daemon::ScheduleEval];
const OF_ROBOT: [Daemon; 2] = [Daemon::Rasterize, Daemon::WaypointGen];
const PROFILES: [(&str, &str); 2] =
    [("lift", "name = \"tall\"\nradius_m = 0.6\nheight_m = 2.2\n"), ("scan", "name = \"low\"\nradius_m = 0.2\n")];

struct Site {
    _home: tempfile::TempDir,
    site: Daemons,
    robots: [(RobotName, Daemons); 2],
}

impl Site {
    fn new() -> Self {
        let home = tempfile::Builder::new().prefix("sim").tempdir_in("/dev/shm").unwrap();
        let tables = PROFILES.map(|(name, profile)| {
            let path = home.path().join(format!("{name}.toml"));
            std::fs::write(&path, profile).unwrap();
            format!("[[robots]]\nname = {name:?}\nprofile = {path:?}\nresolution_m = {RESOLUTION_M}\n")
        });
        let models = models();
        std::fs::write(home.path().join("rules.toml"), RULES.replace("IfcBuiltElement", "IfcWall")).unwrap();
        let toml = format!(
            "models = [{:?}]\nstate = \"state\"\n[schedule]\nrules = {:?}\nplan_time = \"2024-03-01\"\n{}",
            models.paths[0],
            home.path().join("rules.toml"),
            tables.concat()
        );
        let clock = SimulatedClock(Arc::new(AtomicI64::new(START_MS)));
        let site = Daemons::of(&toml, home.path(), clock);
        let robots = PROFILES.map(|(name, _)| {
            let name = name.parse().unwrap();
            (name, Daemons::of_robot(&site, name))
        });
        let mut all = Self { _home: home, site, robots };
        OF_SITE.iter().for_each(|daemon| started(&mut all.site, *daemon));
        for (_, robot) in &mut all.robots {
            OF_ROBOT.iter().for_each(|daemon| started(robot, *daemon));
        }
        all.deliver();
        // The first model is in force once schedule-eval has judged it.
        all.site.tick(Daemon::IfcIngest);
        all.deliver();
        all
    }

    /// All daemons that live take what has come.
    fn deliver(&mut self) {
        for daemon in OF_SITE {
            (0..4).for_each(|input| drop(self.site.deliver(daemon, input)));
        }
        for (_, robot) in &mut self.robots {
            for daemon in OF_ROBOT {
                (0..4).for_each(|input| drop(robot.deliver(daemon, input)));
            }
        }
    }

    fn set_day(&mut self, day: i64) {
        let at_s = START_MS / 1_000 + day * DAY_S;
        assert!(matches!(self.site.schedule.ask(ScheduleRequest::SetPlanTime { at_s }), End::Done(_)));
        self.deliver();
    }

    /// The profile and the grids that a reader of a robot gets, which are those of a fresh rasterizer for that profile.
    fn checked_grids(&self, robot: usize) -> (RobotProfile, Vec<ContentHash>, i64) {
        let reader = Bus::in_process_of_robot(&self.site.shared.bus, Daemon::Groundplan, self.robots[robot].0);
        let mut reader = SiteSetReader::of(&reader).unwrap();
        reader.take().unwrap();
        let set = reader.set().expect("the newest samples belong together");
        let (index, site, state) = (set.index.view(), set.site.view(), set.state.view());
        let mut fresh = Rasterizer::new(&site, &index.head.robot, RESOLUTION_M).unwrap();
        fresh.draw(&site, &state);
        let expected: Vec<ContentHash> = fresh.drawn().map(|grid| grid.content_hash).collect();
        let grids: Vec<ContentHash> = index.slots.iter().map(|slot| slot.content_hash).collect();
        assert_eq!(grids, expected);
        assert!(set.mission_plan.is_some(), "there is a mission plan of these grids");
        (index.head.robot, grids, index.head.plan_time_s)
    }
}

fn started(daemons: &mut Daemons, daemon: Daemon) {
    let end = daemons.start(daemon);
    assert!(matches!(end, End::Done(())), "{daemon}: {end:?}");
}

#[test]
fn each_robots_grids_are_those_of_its_profile_at_every_date() {
    let mut site = Site::new();
    for day in [0, 5, 12, 30, 8] {
        site.set_day(day);
        let [(lift, of_lift, lift_at), (scan, of_scan, scan_at)] = [0, 1].map(|robot| site.checked_grids(robot));
        assert_eq!((lift.radius_m, scan.radius_m), (0.6, 0.2));
        assert_eq!((lift_at, scan_at), (START_MS / 1_000 + day * DAY_S, START_MS / 1_000 + day * DAY_S));
        assert!(of_lift != of_scan, "their margins differ on day {day}");
    }
}

#[test]
fn the_death_of_one_robots_daemons_does_not_touch_the_other() {
    let mut site = Site::new();
    site.set_day(12);
    let before = site.checked_grids(0);
    OF_ROBOT.iter().for_each(|daemon| site.robots[1].1.kill(*daemon));
    assert_eq!(site.checked_grids(0), before);
    site.set_day(30);
    let (_, of_lift, at_s) = site.checked_grids(0);
    assert_eq!(at_s, START_MS / 1_000 + 30 * DAY_S);
    assert_ne!(of_lift, before.1);
    for daemon in OF_ROBOT {
        started(&mut site.robots[1].1, daemon);
    }
    site.deliver();
    assert_eq!(site.checked_grids(1).2, at_s, "it comes back at the date of the site");
    assert_eq!(site.checked_grids(0).1, of_lift);
}
