//! The link between a server and its robots, with real processes: robots hear of an index at once, the server knows how they are, and
//! what one of them saw comes into force for all.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::{DEADLINE, Live, POLL_INTERVAL};
use end_to_end::mapping_robot::{MappingRobot, planning_at};
use end_to_end::tower::{FIRST, Tower, published};
use end_to_end::{convert, demo_model, groundplan};
use serde_json::Value;
use std::net::TcpListener;
use std::time::Instant;

/// Two robots of one make, and the ports of their site.
struct Linked {
    tower: Tower,
    link: u16,
    page: u16,
}

impl Linked {
    fn new() -> Self {
        let port = || TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        Self { tower: Tower::with_keys(), link: port(), page: port() }
    }

    fn serve(&self, more: &str) -> String {
        let Self { link, page, .. } = self;
        let more = format!(
            "{more}[web]\nenabled = true\nlisten = \"127.0.0.1:{page}\"\nrobot = \"scout\"\n[[robots]]\nname = \"scout\"\n[serve.link]\n\
             listen = [\"tcp/127.0.0.1:{link}\"]\nrobots = [\"r1\", \"r2\"]\n"
        );
        self.tower.serve("signing", &more)
    }

    /// A robot that does not look at the store by itself in the time of a test.
    fn robot(&self, name: &str, more: &str) -> Live {
        let link = format!("[follow.link]\nconnect = [\"tcp/127.0.0.1:{}\"]\nname = {name:?}\n", self.link);
        let follow = self.tower.follow("robot = \"scout\"\n").replace("poll_s = 1\n", "poll_s = 3600\n");
        Live::following(&format!("{more}{follow}{link}"))
    }

    fn fleet(&self) -> (Option<i32>, Value) {
        let server = format!("http://127.0.0.1:{}", self.page);
        let output = groundplan(&[&"fleet", &"status", &"--server", &server, &"--json"]);
        (output.status.code(), serde_json::from_slice(&output.stdout).unwrap_or_default())
    }

    /// The fleet once it is as it should be.
    fn wait_for_fleet(&self, what: &str, is_so: impl Fn(&Value) -> bool) -> Value {
        let begun = Instant::now();
        loop {
            let (_, fleet) = self.fleet();
            if is_so(&fleet) {
                return fleet;
            }
            assert!(begun.elapsed() < DEADLINE, "{what}: {fleet}");
            std::thread::sleep(POLL_INTERVAL);
        }
    }
}

#[test]
fn robots_hear_of_an_index_at_once_and_the_server_knows_how_they_are() {
    let site = Linked::new();
    let server = Live::of(&demo_model(), &site.serve(FIRST));
    let first = published(&server, &site.tower, 0);
    let [r1, mut r2] = ["r1", "r2"].map(|name| site.robot(name, ""));
    for robot in [&r1, &r2] {
        robot.shows(first);
    }
    server.text(&[&"date", &"2024-05-20"]);
    let second = published(&server, &site.tower, first);
    for robot in [&r1, &r2] {
        assert_eq!(robot.shows(second)["clock"]["plan_time"], "2024-05-20T00:00:00");
    }
    let is_current = |fleet: &Value, robot: &str, epoch: u64| {
        let robot = &fleet["robots"][robot];
        robot["state"] == "current" && robot["report"]["epoch"].as_u64().is_some_and(|shown| shown >= epoch)
    };
    let fleet = site.wait_for_fleet("both are current", |fleet| {
        ["r1", "r2"].into_iter().all(|robot| is_current(fleet, robot, second))
    });
    let report = &fleet["robots"]["r1"]["report"];
    assert_eq!((&report["maps_of"], &report["plan_time"]), (&"scout".into(), &"2024-05-20T00:00:00".into()), "{fleet}");
    assert_eq!(report["daemons"]["site-follow"]["runs"], true, "{fleet}");
    // Dead daemons of a server and of a robot change nothing of that.
    server.kill("site-server");
    r1.kill("site-follow");
    server.text(&[&"date", &"2024-05-21"]);
    let third = published(&server, &site.tower, second);
    for robot in [&r1, &r2] {
        robot.shows(third);
    }
    site.wait_for_fleet("both are current again", |fleet| {
        ["r1", "r2"].into_iter().all(|robot| is_current(fleet, robot, third))
    });
    // A robot that is switched off is not current for long.
    r2.down();
    site.wait_for_fleet("it is not there", |fleet| fleet["robots"]["r2"]["here"] == false);
    let fleet = site.wait_for_fleet("it is silent", |fleet| fleet["robots"]["r2"]["state"] == "silent");
    assert!(fleet["robots"]["r2"]["findings"][0].as_str().unwrap().contains("told nothing"), "{fleet}");
    assert_eq!(fleet["robots"]["r1"]["state"], "current");
    // A robot knows nothing of the others.
    let asked = r1.run(&[&"fleet", &"status"]);
    assert!(asked.status.code() == Some(2) && String::from_utf8_lossy(&asked.stderr).contains("--server"), "{asked:?}");
    let (code, _) = site.fleet();
    assert_eq!(code, Some(1), "a robot that is silent is not well");
    // A date that it misses, and shows once it is on again.
    server.text(&[&"date", &"2024-05-22"]);
    let fourth = published(&server, &site.tower, third);
    r2.start_up();
    r2.shows(fourth);
    site.wait_for_fleet("it is current again", |fleet| is_current(fleet, "r2", fourth));
}

#[test]
fn what_a_robot_saw_comes_into_force_for_all_and_contradictions_are_told() {
    let maps = convert(&demo_model(), &[]);
    let site = Linked::new();
    // The partitions stand, the walls of the lift do not.
    let server = Live::of(&demo_model(), &site.serve("[schedule]\nplan_time = \"2024-04-18T00:00:00\"\n"));
    let first = published(&server, &site.tower, 0);
    let [r1, r2] = ["r1", "r2"].map(|name| site.robot(name, "[align]\napply = true\n"));
    for robot in [&r1, &r2] {
        robot.shows(first);
    }
    // The partition between meeting room and store was never built.
    let (wall, in_wall) = ("0T8xbPmeHQFhEy1wPGGLbq", [6.25, 12.0]);
    let (lift, in_lift) = ("1ghCNJDIzNKO1u55gceO4K", [14.85, 13.7]);
    assert_ne!(planning_at(&r2, in_lift), grid::OCCUPIED);
    let mut scout = MappingRobot::of(&r1, &maps, "localization.pgm");
    scout.sees_through(&maps, [5.7, 10.2, 6.8, 14.6]);
    scout.publish(2.0);
    let fleet = site.wait_for_fleet("the wall is told", |fleet| {
        let elements = fleet["elements"].as_array();
        elements.is_some_and(|elements| elements.iter().any(|element| element["id"] == wall))
    });
    let of = |fleet: &Value, id: &str| {
        fleet["elements"].as_array().unwrap().iter().find(|element| element["id"] == id).cloned().unwrap_or_default()
    };
    let told = &of(&fleet, wall)["told"]["r1"];
    assert_eq!((&told["observation"], &told["verdict"]), (&"absent".into(), &"late".into()), "{fleet}");
    // What stands earlier than planned is on the maps of the other robot, too; what seems absent stays there.
    let becomes = |robot: &Live, place, pixel, what: &str| {
        let begun = Instant::now();
        while planning_at(robot, place) != pixel {
            assert!(begun.elapsed() < DEADLINE, "{what}: {:?}", robot.status());
        }
    };
    becomes(&r2, in_lift, grid::OCCUPIED, "what one robot saw is not on the map of the other");
    assert_eq!(planning_at(&r2, in_wall), grid::OCCUPIED, "what seems absent stays on the map");
    r1.text(&[&"confirm", &wall]);
    becomes(&r2, in_wall, grid::FREE, "what was confirmed to be absent is still on the map");
    becomes(&r1, in_wall, grid::FREE, "the robot itself does not show it");
    // Neither the server nor the robot forgets it.
    server.kill("site-server");
    r1.kill("site-follow");
    server.kill("schedule-eval");
    assert_eq!(planning_at(&r2, in_wall), grid::FREE);
    // The other robot sees the wall stand: it is an obstacle again, and the contradiction is told.
    let mut other = MappingRobot::of(&r2, &maps, "localization.pgm");
    other.publish(2.0);
    let fleet = site.wait_for_fleet("the contradiction is told", |fleet| {
        fleet["elements"].is_array() && of(fleet, wall)["is_conflict"] == true
    });
    let told = &of(&fleet, wall)["told"];
    assert_eq!(
        (&told["r1"]["observation"], &told["r2"]["observation"]),
        (&"absent".into(), &"observed".into()),
        "{fleet}"
    );
    assert_eq!(of(&fleet, lift)["is_conflict"], false, "{fleet}");
    becomes(&r1, in_wall, grid::OCCUPIED, "what another robot saw stand is not on the map");
    let text = groundplan(&[&"fleet", &"status", &"--server", &format!("http://127.0.0.1:{}", site.page)]);
    let text = String::from_utf8_lossy(&text.stdout).into_owned();
    assert!(
        text.contains(&format!("conflict, {wall}")) && text.contains("is not in force, because r2 saw it stand"),
        "{text}"
    );
}
