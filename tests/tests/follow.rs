//! A server that gives a site to a store, and robots elsewhere that follow it: they show the very maps, believe nothing that is old or
//! not signed, and go on without the store.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::live::{DEADLINE, Live, POLL_INTERVAL};
use end_to_end::tower::{FIRST, Tower, published};
use end_to_end::{announce, contents, demo_model, files_in};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

#[test]
fn a_robot_shows_the_very_maps_of_the_server() {
    let tower = Tower::with_keys();
    let server = Live::of(&demo_model(), &tower.serve("signing", FIRST));
    let first = published(&server, &tower, 0);
    let robot = Live::following(&tower.follow(""));
    robot.shows(first);
    assert!(server.exported("first") == robot.exported("first"), "the maps of the first date");
    server.text(&[&"date", &"2024-05-20"]);
    let second = published(&server, &tower, first);
    let status = robot.shows(second);
    assert_eq!(status["clock"]["plan_time"], "2024-05-20T00:00:00");
    let (of_server, of_robot) = (server.exported("second"), robot.exported("second"));
    assert!(of_server == of_robot, "the maps of the second date");
    // What is decided on the server is refused on the robot, with the reason.
    let output = robot.run(&[&"date", &"2024-05-21"]);
    let why = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.code() == Some(2) && why.contains("follows the site tower"), "{why}");
    assert_eq!(robot.text(&[&"date"]), "2024-05-20T00:00:00  moved by the server");
}

#[test]
fn what_dies_comes_back_with_the_same_maps_and_higher_epochs() {
    let tower = Tower::with_keys();
    let mut server = Live::of(&demo_model(), &tower.serve("signing", FIRST));
    let first = published(&server, &tower, 0);
    let robot = Live::following(&tower.follow(""));
    robot.shows(first);
    let before = robot.index();
    let maps = robot.exported("before");
    // Without its store, too: what it showed is on its disk.
    std::fs::rename(tower.store(), tower.at("away")).unwrap();
    let process = robot.status().unwrap()["daemons"]["site-follow"]["process_id"].clone();
    assert!(Command::new("kill").args(["-9", &process.to_string()]).status().unwrap().success());
    robot.wait_for_status("it comes back", |status| {
        let daemon = &status["daemons"]["site-follow"];
        daemon["process_id"].as_u64().is_some_and(|id| id > 0 && daemon["process_id"] != process)
            && status["follower"]["epoch"] == first
    });
    let begun = Instant::now();
    while robot.index()["epoch"].as_u64() <= before["epoch"].as_u64() {
        assert!(begun.elapsed() < DEADLINE, "{}", robot.index());
        std::thread::sleep(POLL_INTERVAL);
    }
    robot.says("valid until 2024-04-15T08:00:00");
    assert!(robot.exported("after") == maps);
    std::fs::rename(tower.at("away"), tower.store()).unwrap();
    // The server dies, and its site moves on while it is away from the store.
    server.kill("site-server");
    server.text(&[&"date", &"2024-04-20"]);
    let second = published(&server, &tower, first);
    assert_eq!(robot.shows(second)["clock"]["plan_time"], "2024-04-20T00:00:00");
    // A whole restart of the server's machine goes on above what is in the store.
    server.down();
    server.up();
    server.text(&[&"date", &"2024-04-21"]);
    assert!(published(&server, &tower, second) > second);
}

#[test]
fn nothing_older_changed_or_foreign_is_shown() {
    let tower = Tower::with_keys();
    let server = Live::of(&demo_model(), &tower.serve("signing", FIRST));
    let first = published(&server, &tower, 0);
    let old = std::fs::read(tower.current()).unwrap();
    server.text(&[&"date", &"2024-05-20"]);
    let second = published(&server, &tower, first);
    let robot = Live::following(&tower.follow(""));
    robot.shows(second);
    let new = std::fs::read(tower.current()).unwrap();
    // The old index comes again.
    replaced(&tower.current(), &old);
    let why = robot.says("an old index comes again");
    assert!(why.contains(&format!("the index has epoch {first}, this robot has acknowledged {second}")), "{why}");
    // One that was changed after it was signed, which says that it is newer.
    let text = String::from_utf8(new.clone()).unwrap();
    let forged = text.replacen(&format!("\"epoch\":{second}"), &format!("\"epoch\":{}", second + 50), 1);
    assert_ne!(forged, text);
    replaced(&tower.current(), forged.as_bytes());
    robot.says("the signature of its index is wrong");
    // One that somebody else signed, from a list of keys of his own.
    let other = Tower::with_keys();
    let of_other = Live::of(&demo_model(), &other.serve("signing", FIRST));
    published(&of_other, &other, 0);
    replaced(&tower.current(), &std::fs::read(other.current()).unwrap());
    robot.says("which is no root key of this robot");
    // All the time the last one is shown, and a robot that begins now shows nothing.
    assert_eq!(robot.status().unwrap()["follower"]["epoch"], second);
    let late = Live::following(&tower.follow(""));
    late.says("which is no root key of this robot");
    assert_eq!(late.status().unwrap()["follower"]["epoch"], 0);
    assert!(late.status().unwrap()["grids"].is_null());
    replaced(&tower.current(), &new);
    for robot in [&robot, &late] {
        robot.shows(second);
    }
}

/// Puts a file in the place of another one, as a store does.
fn replaced(path: &Path, bytes: &[u8]) {
    let beside = path.with_extension("new");
    std::fs::write(&beside, bytes).unwrap();
    std::fs::rename(beside, path).unwrap();
}

#[test]
fn a_key_that_was_revoked_signs_nothing_any_more() {
    let tower = Tower::with_keys();
    let mut server = Live::of(&demo_model(), &tower.serve("signing", FIRST));
    let first = published(&server, &tower, 0);
    let robot = Live::following(&tower.follow(""));
    robot.shows(first);
    // Another key signs, and the old one is not in the list any more.
    server.down();
    let old_keys = std::fs::read(tower.at("keys.jsonl")).unwrap();
    tower.key("next");
    tower.list(2, &["next"]);
    let config = std::fs::read_to_string(server.config()).unwrap().replace("signing.pem", "next.pem");
    std::fs::write(server.config(), config).unwrap();
    server.up();
    server.text(&[&"date", &"2024-04-20"]);
    let second = published(&server, &tower, first);
    robot.shows(second);
    server.down();
    // Whoever has the old key makes an index that is newer than all, with the old list.
    std::fs::write(tower.at("keys.jsonl"), old_keys).unwrap();
    let config = std::fs::read_to_string(server.config()).unwrap().replace("next.pem", "signing.pem");
    std::fs::write(server.config(), config).unwrap();
    server.up();
    server.text(&[&"date", &"2024-05-20"]);
    let stolen = published(&server, &tower, second);
    assert!(stolen > second);
    robot.says("a key that was revoked may be in it");
    assert_eq!(robot.status().unwrap()["follower"]["epoch"], second);
    // A server whose key is not in its list does not start with it, and a site does not start without its server.
    tower.list(3, &["next"]);
    server.down();
    let refused = server.run(&[&"up"]);
    let told = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{told}");
    assert!(told.contains("is not in it") && told.contains("site-server cannot use"), "{told}");
}

#[test]
fn what_a_store_lost_is_told_and_comes_back_with_the_server() {
    let tower = Tower::with_keys();
    let mut server = Live::of(&demo_model(), &tower.serve("signing", FIRST));
    let first = published(&server, &tower, 0);
    // A blob that is lost, and one that is another's.
    let blobs: Vec<PathBuf> = contents(&tower.at("store/tower/blobs"))
        .into_iter()
        .map(|(path, _)| tower.at("store/tower/blobs").join(path))
        .collect();
    let largest = blobs.iter().max_by_key(|path| std::fs::metadata(path).unwrap().len()).unwrap();
    let content = std::fs::read(largest).unwrap();
    let robot = Live::following(&tower.follow(""));
    robot.shows(first);
    let maps = robot.exported("before");
    let late_config = tower.follow("");
    std::fs::write(largest, vec![7; content.len()]).unwrap();
    let late = Live::following(&late_config);
    late.says("a block");
    assert!(late.status().unwrap()["grids"].is_null(), "of bytes that are wrong nothing is shown");
    std::fs::remove_file(largest).unwrap();
    late.says("has no tower/blobs/");
    assert!(robot.exported("meanwhile") == maps, "who has it needs the store no more");
    // The server notices at its start.
    server.down();
    server.up();
    server.text(&[&"date", &"2024-04-20"]);
    let second = published(&server, &tower, first);
    for robot in [&robot, &late] {
        robot.shows(second);
    }
    assert!(late.exported("late") == server.exported("server"));
}

#[test]
fn a_robot_fetches_the_storeys_that_it_needs_alone() {
    let tower = Tower::with_keys();
    let server = Live::of(&demo_model(), &tower.serve("signing", FIRST));
    let first = published(&server, &tower, 0);
    let robot = Live::following(&tower.follow("storeys = [\"1\"]\n"));
    let status = robot.shows(first);
    assert_eq!(status["grids"]["storeys"], 1);
    let (of_robot, of_server) = (robot.index(), server.index());
    let grids = of_robot["content"]["grids"].as_array().unwrap();
    assert_eq!(grids.len(), 1);
    assert_eq!(grids[0], of_server["content"]["grids"][1]);
    // The files of the storey are those of the server.
    let of_storey = |files: Vec<(PathBuf, Vec<u8>)>| {
        let maps = |(path, _): &(PathBuf, Vec<u8>)| {
            path.starts_with("storeys") && path.extension().is_some_and(|end| end == "pgm")
        };
        files.into_iter().filter(maps).collect::<Vec<_>>()
    };
    let (of_robot, of_server) = (of_storey(robot.exported("maps")), of_storey(server.exported("maps")));
    assert_eq!(of_robot.len(), 3);
    assert!(of_robot.iter().all(|file| of_server.contains(file)), "the same maps under the same names");
    let wrong = Live::following(&tower.follow("storeys = [\"attic\"]\n"));
    let why = wrong.says("attic");
    assert!(why.contains("it has "), "{why}");
}

#[test]
fn each_make_of_robot_has_its_own_maps() {
    let tower = Tower::with_keys();
    std::fs::write(tower.at("low.toml"), "name = \"low\"\nheight_m = 0.4\nradius_m = 0.2\n").unwrap();
    let low = tower.at("low.toml");
    let robots = format!("{FIRST}[[robots]]\nname = \"lift\"\n[[robots]]\nname = \"scan\"\nprofile = {low:?}\n");
    let server = Live::of(&demo_model(), &tower.serve("signing", &robots));
    let first = published(&server, &tower, 0);
    let of_server = |name: &str| {
        let out = server.home.path().join(name);
        server.text(&[&"export", &out, &"--robot-name", &name]);
        contents(&out)
    };
    for name in ["lift", "scan"] {
        let robot = Live::following(&tower.follow(&format!("robot = {name:?}\n")));
        robot.shows(first);
        assert!(robot.exported(name) == of_server(name), "{name}");
    }
    let unknown = Live::following(&tower.follow("robot = \"crane\"\n"));
    let why = unknown.says("crane");
    assert!(why.contains("it has lift, scan"), "{why}");
}

#[test]
fn a_robot_that_was_off_shows_what_it_has_while_what_is_newer_cannot_be_fetched() {
    let tower = Tower::with_keys();
    let server = Live::of(&demo_model(), &tower.serve("signing", FIRST));
    let first = published(&server, &tower, 0);
    let mut robot = Live::following(&tower.follow(""));
    robot.shows(first);
    let maps = robot.exported("before");
    robot.down();
    // Meanwhile there is a newer index, of which the store has lost what is new.
    let before: Vec<PathBuf> = contents(&tower.at("store/tower/blobs")).into_iter().map(|(path, _)| path).collect();
    server.text(&[&"date", &"2024-05-20"]);
    let second = published(&server, &tower, first);
    let after = contents(&tower.at("store/tower/blobs")).into_iter().filter(|(path, _)| !before.contains(path));
    let new: Vec<(PathBuf, Vec<u8>)> = after.collect();
    assert!(!new.is_empty());
    new.iter().for_each(|(path, _)| std::fs::remove_file(tower.at("store/tower/blobs").join(path)).unwrap());
    robot.start_up();
    robot.says("has no tower/blobs/");
    robot.wait_for_status("what it had is shown", |status| {
        status["follower"]["epoch"] == first
            && status["follower"]["newest_epoch"] == second
            && status["plan"]["is_current"] == true
    });
    assert!(robot.exported("after") == maps);
    new.iter().for_each(|(path, bytes)| replaced(&tower.at("store/tower/blobs").join(path), bytes));
    robot.shows(second);
    assert!(robot.exported("newer") == server.exported("newer"));
}

#[test]
fn a_store_that_was_set_back_makes_no_epoch_fall() {
    let tower = Tower::with_keys();
    let mut server = Live::of(&demo_model(), &tower.serve("signing", FIRST));
    let first = published(&server, &tower, 0);
    server.text(&[&"date", &"2024-05-20"]);
    let second = published(&server, &tower, first);
    let robot = Live::following(&tower.follow(""));
    robot.shows(second);
    server.down();
    std::fs::remove_dir_all(tower.store()).unwrap();
    server.up();
    let third = published(&server, &tower, 0);
    assert!(third > second, "{third}");
    robot.shows(third);
    assert!(robot.exported("maps") == server.exported("maps"));
    // What others have put in the place of the index is replaced when the server starts.
    server.down();
    std::fs::write(tower.current(), "no index").unwrap();
    robot.says("it is not four lines of text");
    server.up();
    server.text(&[&"date", &"2024-05-21"]);
    let begun = Instant::now();
    while std::fs::read(tower.current()).unwrap() == b"no index" {
        assert!(begun.elapsed() < DEADLINE, "it is not replaced");
        std::thread::sleep(POLL_INTERVAL);
    }
    let fourth = published(&server, &tower, third);
    robot.shows(fourth);
}

/// A schedule of which three things change soon, by the clock of this machine.
fn soon(tower: &Tower, seconds: &[i64]) -> (String, Vec<i64>) {
    let now = jiff::Timestamp::now().as_second();
    let at = |s: i64| {
        let time = jiff::Timestamp::from_second(s).unwrap().to_zoned(jiff::tz::TimeZone::UTC);
        time.strftime("%d.%m.%Y %H:%M:%S").to_string()
    };
    let shipped = std::fs::read_to_string(end_to_end::root().join("tests/fixtures/demo-schedule.csv")).unwrap();
    let instants: Vec<i64> = seconds.iter().map(|s| now + s).collect();
    let mut lines: Vec<String> = shipped.lines().take(1).map(str::to_owned).collect();
    let mut next = instants.iter().cycle();
    for line in shipped.lines().skip(1) {
        let cells: Vec<&str> = line.split(';').collect();
        let dates = if cells[3].is_empty() {
            [String::new(), String::new()]
        } else {
            [at(now - 86_400), at(*next.next().unwrap())]
        };
        lines.push([cells[0], cells[1], cells[2], &dates[0], &dates[1], "", ""].join(";"));
    }
    std::fs::write(tower.at("soon.csv"), lines.join("\n") + "\n").unwrap();
    std::fs::write(tower.at("rules.toml"), "date_format = \"dmy\"\nsite_zone = \"UTC\"\n").unwrap();
    let (files, rules) = (tower.at("soon.csv"), tower.at("rules.toml"));
    (format!("[schedule]\nfiles = [{files:?}]\nrules = {rules:?}\n"), instants)
}

#[test]
fn a_robot_goes_on_to_later_maps_by_its_own_clock_without_server_and_store() {
    let tower = Tower::with_keys();
    let (schedule, instants) = soon(&tower, &[45, 55, 65]);
    let mut server = Live::of(&demo_model(), &tower.serve("signing", &schedule));
    server.text(&[&"date", &"--wall"]);
    server.wait_for_status("later sets are drawn", |status| {
        let times = status["server"]["plan_times_s"].as_array().cloned().unwrap_or_default();
        times.iter().filter_map(Value::as_i64).filter(|at| instants.contains(at)).count() >= 3
    });
    let robot = Live::following(&tower.follow(""));
    robot.wait_for_status("all sets are here", |status| {
        status["follower"]["later"].as_array().is_some_and(|later| later.len() >= 3)
    });
    // Neither is there any more.
    server.down();
    std::fs::rename(tower.store(), tower.at("away")).unwrap();
    let until = |at_s: i64| {
        let text = messages::plan_time(at_s).unwrap().to_string();
        robot.wait_for_status("the next maps are shown", |status| status["grids"]["plan_time"] == text.as_str());
    };
    for at_s in &instants {
        until(*at_s);
    }
    assert!(!tower.store().exists());
    // Past the last set the maps end, and it says so.
    robot.says("what is shown has no end of validity");
    // The server, which goes on by its own clock, has the same maps.
    server.up();
    let shown = messages::plan_time(instants[2]).unwrap().to_string();
    server.wait_for_status("it went on", |status| {
        status["grids"]["plan_time"] == shown.as_str() && status["plan"]["is_current"] == true
    });
    assert!(server.exported("last") == robot.exported("last"));
    server.down();
}

/// A web server of a folder, from the standard library of Python: it ignores ranges.
struct WebServer {
    child: Child,
    url: String,
}

impl WebServer {
    fn start(folder: &Path) -> Self {
        let mut command = Command::new("python3");
        command.args(["-u", "-m", "http.server", "--bind", "127.0.0.1", "0", "--directory"]).arg(folder);
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        std::io::BufRead::read_line(&mut std::io::BufReader::new(child.stdout.take().unwrap()), &mut line).unwrap();
        let port = line.split(" port ").nth(1).unwrap().split(' ').next().unwrap();
        Self { url: format!("http://127.0.0.1:{port}"), child }
    }
}

impl Drop for WebServer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A site whose store is behind a web server, with the epoch of its first index; `None`, and a loud word, without Python.
fn behind_a_web_server() -> Option<(Tower, Live, u64, WebServer)> {
    if Command::new("python3").arg("--version").output().is_err() {
        announce("SKIPPED: no python3 for a web server");
        return None;
    }
    let tower = Tower::with_keys();
    let server = Live::of(&demo_model(), &tower.serve("signing", FIRST));
    let first = published(&server, &tower, 0);
    let web = WebServer::start(&tower.store());
    Some((tower, server, first, web))
}

#[test]
fn a_folder_behind_any_web_server_serves_a_site() {
    let Some((tower, server, first, web)) = behind_a_web_server() else { return };
    let robot = Live::following(&tower.follow_at(&web.url, ""));
    robot.shows(first);
    server.text(&[&"date", &"2024-05-20"]);
    let second = published(&server, &tower, first);
    robot.shows(second);
    assert!(server.exported("maps") == robot.exported("maps"));
    // The web server goes, and what is shown stays.
    drop(web);
    robot.says("what is shown is valid until");
    assert_eq!(robot.status().unwrap()["follower"]["epoch"], second);
}

/// A package of Python in the environment of the tests; `None`, and a loud word, where it cannot be had.
fn python_program(package: &str, program: &str) -> Option<PathBuf> {
    let installed = Command::new("bash").arg(end_to_end::root().join("scripts/python-env")).arg(package).status();
    let path = end_to_end::root().join("target/venv/bin").join(program);
    if !installed.is_ok_and(|status| status.success()) || !path.is_file() {
        announce(&format!("SKIPPED: {package} could not be installed"));
        return None;
    }
    Some(path)
}

/// A port that nobody listens on; another process may take it, which the caller notices.
fn free_port() -> u16 {
    std::net::TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// Waits until something listens, and sends it a request.
fn request(port: u16, request: &str) -> String {
    let begun = Instant::now();
    loop {
        if let Ok(mut stream) = std::net::TcpStream::connect(("127.0.0.1", port)) {
            std::io::Write::write_all(&mut stream, request.as_bytes()).unwrap();
            let mut answer = String::new();
            let _ = std::io::Read::read_to_string(&mut stream, &mut answer);
            return answer;
        }
        assert!(begun.elapsed() < DEADLINE, "nothing listens on {port}");
        std::thread::sleep(POLL_INTERVAL);
    }
}

#[test]
fn a_bucket_serves_a_site() {
    // moto: an S3 service for tests, with conditions and ranges.
    let Some(moto) = python_program("moto[server]==5.2.5", "moto_server") else { return };
    let tower = Tower::with_keys();
    let port = free_port();
    let mut command = Command::new(moto);
    command.args(["-H", "127.0.0.1", "-p", &port.to_string()]).stdout(Stdio::null()).stderr(Stdio::null());
    let bucket = WebServer { child: command.spawn().unwrap(), url: "s3://maps/site".to_owned() };
    let made = request(port, "PUT /maps HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
    assert!(made.starts_with("HTTP/1.1 200"), "{made}");
    let credentials = tower.at("store.toml");
    let text = format!("access_key = \"a\"\nsecret_key = \"b\"\nendpoint = \"http://127.0.0.1:{port}\"\n");
    std::fs::write(&credentials, text).unwrap();
    std::fs::set_permissions(&credentials, std::os::unix::fs::PermissionsExt::from_mode(0o600)).unwrap();
    let [key, keys] = [tower.at("signing.pem"), tower.at("keys.jsonl")];
    let serve = format!(
        "{FIRST}[serve]\nstore = {:?}\ncredentials = {credentials:?}\nsite = \"tower\"\nkey = {key:?}\nkeys = {keys:?}\n",
        bucket.url
    );
    let server = Live::of(&demo_model(), &serve);
    let epoch = |status: &Value| status["server"]["epoch"].as_u64().unwrap_or(0);
    server.wait_for_status("it is published", |status| epoch(status) >= 1);
    let robot = Live::following(&tower.follow_at(&bucket.url, &format!("credentials = {credentials:?}\n")));
    let is_shown = |robot: &Live, date: &str| {
        let is_so = |status: &Value| {
            status["healthy"] == true && status["grids"]["plan_time"] == date && status["plan"]["is_current"] == true
        };
        robot.wait_for_status(date, is_so)
    };
    is_shown(&robot, "2024-04-15T00:00:00");
    server.text(&[&"date", &"2024-05-20"]);
    is_shown(&robot, "2024-05-20T00:00:00");
    assert!(server.exported("maps") == robot.exported("maps"));
    // Two servers of one site: an epoch is created once, and the first one notices that another has published.
    let published = robot.shows(1)["follower"]["epoch"].as_u64().unwrap();
    let other = Live::of(&demo_model(), &serve);
    other.wait_for_status("it goes on above", |status| epoch(status) > published);
    server.text(&[&"date", &"2024-05-21"]);
    server.daemon_says("site-server", "another server has published epoch");
}

#[test]
fn a_web_server_that_breaks_off_is_asked_again_for_what_is_missing() {
    let Some((tower, server, first, web)) = behind_a_web_server() else { return };
    let behind: u16 = web.url.rsplit(':').next().unwrap().parse().unwrap();
    let proxy = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://127.0.0.1:{}", proxy.local_addr().unwrap().port());
    std::thread::spawn(move || {
        for (n, client) in proxy.incoming().flatten().enumerate() {
            std::thread::spawn(move || break_off(client, behind, n));
        }
    });
    let robot = Live::following(&tower.follow_at(&url, ""));
    robot.wait_for_status("it is shown", |status| {
        status["follower"]["epoch"] == first && status["plan"]["is_current"] == true
    });
    assert!(server.exported("maps") == robot.exported("maps"));
}

/// Passes one request on, and of most answers a part: a third of the connections is closed at once, a third after 2,000 bytes.
fn break_off(mut client: std::net::TcpStream, behind: u16, n: usize) {
    use std::io::{Read, Write};
    // Not in turn: who asks in a rhythm would meet the same each time.
    let limit = match xxhash_rust::xxh3::xxh3_64(&n.to_le_bytes()) % 3 {
        0 => 0,
        1 => 2_000,
        _ => usize::MAX,
    };
    let mut request = [0; 4096];
    let Ok(length) = client.read(&mut request) else { return };
    let Ok(mut web) = std::net::TcpStream::connect(("127.0.0.1", behind)) else { return };
    // One request for a connection: what comes next is another connection, and breaks off elsewhere.
    let request = String::from_utf8_lossy(&request[..length]).replacen("\r\n", "\r\nConnection: close\r\n", 1);
    if web.write_all(request.as_bytes()).is_err() {
        return;
    }
    let mut answer = Vec::new();
    let _ = web.read_to_end(&mut answer);
    let _ = client.write_all(&answer[..answer.len().min(limit)]);
}

/// Every format that a server exports.
const ALL_FILES: &str =
    "export = [\"maps\", \"ground\", \"world\", \"usd\", \"cloud\", \"octomap\", \"vda5050\", \"lif\", \"open-rmf\"]\n";

/// An object of a web server.
fn fetched(web: &WebServer, path: &str) -> Vec<u8> {
    use std::io::{Read, Write};
    let mut stream = std::net::TcpStream::connect(web.url.trim_start_matches("http://")).unwrap();
    write!(stream, "GET /{path} HTTP/1.0\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    assert!(
        answer.starts_with(b"HTTP/1.0 200"),
        "{path}: {}",
        String::from_utf8_lossy(&answer[..30.min(answer.len())])
    );
    let body = answer.windows(4).position(|end| end == b"\r\n\r\n").unwrap() + 4;
    answer.split_off(body)
}

/// A blob of a web server, which has the bytes that its name says.
fn fetched_blob(web: &WebServer, blob: &Value) -> Vec<u8> {
    let id = blob["id"].as_str().unwrap();
    let bytes = fetched(web, &format!("tower/blobs/{}/{id}", &id[..2]));
    assert_eq!((sha256(&bytes).as_str(), blob["bytes"].as_u64()), (id, Some(bytes.len() as u64)));
    bytes
}

fn sha256(bytes: &[u8]) -> String {
    use sha2::Digest;
    sha2::Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The exported files of a set, by plain HTTP.
fn fetched_files(web: &WebServer, set: &Value) -> Vec<(PathBuf, Vec<u8>)> {
    let list = fetched_blob(web, &set["robots"]["robot"]["files"]["list"]);
    let list: Value = serde_json::from_slice(&list).unwrap();
    let file = |file: &Value| (PathBuf::from(file["path"].as_str().unwrap()), fetched_blob(web, file));
    let mut files: Vec<_> = list["files"].as_array().unwrap().iter().map(file).collect();
    files.sort();
    files
}

/// The newest index, once its first set is of this plan time and has exported files.
fn exported(server: &Live, tower: &Tower, date: &str) -> Value {
    let has_files = || {
        let index = Some(tower).filter(|tower| tower.current().is_file()).map(Tower::index);
        let is_it = |index: &Value| !index["sets"][0]["robots"]["robot"]["files"].is_null();
        index.filter(|index| tower.plan_time().as_deref() == Some(date) && is_it(index))
    };
    server.wait_for_status("files are exported", |_| has_files().is_some());
    has_files().unwrap()
}

/// Names of the files in which two outputs differ.
fn differing(a: &[(PathBuf, Vec<u8>)], b: &[(PathBuf, Vec<u8>)]) -> Vec<PathBuf> {
    let not_in = |some: &[(PathBuf, Vec<u8>)], others: &[(PathBuf, Vec<u8>)]| {
        some.iter().filter(|file| !others.contains(file)).map(|(path, _)| path.clone()).collect::<Vec<_>>()
    };
    [not_in(a, b), not_in(b, a)].concat()
}

#[test]
fn whoever_has_no_groundplan_fetches_the_files_of_export_by_their_sha256() {
    let tower = Tower::with_keys();
    std::fs::create_dir(tower.store()).unwrap();
    if Command::new("python3").arg("--version").output().is_err() {
        announce("SKIPPED: no python3 for a web server");
        return;
    }
    let web = WebServer::start(&tower.store());
    let mut server = Live::of(&demo_model(), &(tower.serve("signing", FIRST) + ALL_FILES));
    let first = exported(&server, &tower, "2024-04-15T00:00:00");
    let export = |server: &Live, name: &str| {
        let out = server.home.path().join(name);
        let formats =
            ["--with-ground", "--world", "--usd", "--cloud", "--octomap", "--fleet=vda5050,lif", "--open-rmf"];
        let mut arguments: Vec<&dyn AsRef<std::ffi::OsStr>> = vec![&"export", &out];
        arguments.extend(formats.iter().map(|format| format as &dyn AsRef<std::ffi::OsStr>));
        server.text(&arguments);
        contents(&out)
    };
    let of_first = fetched_files(&web, &first["sets"][0]);
    let by_command = export(&server, "first");
    assert!(of_first == by_command, "{:?}", differing(&of_first, &by_command));
    for path in ["manifest.json", "world/site.usda", "octomap/structure.bt", "fleet/lif/site.lif.json", "ground.json"] {
        assert!(of_first.iter().any(|(of, _)| of == Path::new(path)), "{path}");
    }
    // Maps and zone sets of fleets, by links from the address of the store.
    let maps = fetched_blob(&web, &first["sets"][0]["robots"]["robot"]["files"]["vda5050_maps"]);
    let maps: Value = serde_json::from_slice(&maps).unwrap();
    assert_eq!((&maps["site"], &maps["enable_at"]), (&"tower".into(), &Value::Null), "the plan time follows no clock");
    for map in maps["maps"].as_array().unwrap() {
        for (action, kind, key) in [(0, "map", "map"), (1, "zone_set", "zoneSet")] {
            let parameters = map["download"][action]["actionParameters"].as_array().unwrap();
            let value = |name: &str| parameters.iter().find(|p| p["key"] == name).unwrap()["value"].as_str().unwrap();
            let bytes = fetched(&web, value(&format!("{key}DownloadLink")));
            assert_eq!(sha256(&bytes), value(&format!("{key}Hash")));
            assert_eq!(map[kind]["sha256"], value(&format!("{key}Hash")));
            assert!(of_first.iter().any(|(_, of)| *of == bytes), "{kind}");
        }
    }
    // Another date: what is as before is no other blob.
    server.text(&[&"date", &"2024-05-20"]);
    let second = exported(&server, &tower, "2024-05-20T00:00:00");
    let (of_second, by_command) = (fetched_files(&web, &second["sets"][0]), export(&server, "second"));
    assert!(of_second == by_command, "{:?}", differing(&of_second, &by_command));
    assert!(of_second != of_first);
    judged(&tower);
    // A server that comes back has nothing to write; what was lost meanwhile comes back with it.
    let list = second["sets"][0]["robots"]["robot"]["files"].clone();
    let written = || {
        let home = tower.at("store/tower/blobs");
        let modified = |path: &PathBuf| std::fs::metadata(home.join(path)).unwrap().modified().unwrap();
        let blobs = contents(&home).into_iter().map(|(path, _)| path);
        blobs.map(|path| (modified(&path), path)).collect::<BTreeSet<_>>()
    };
    let before = written();
    let (_, semantic) = of_second.iter().find(|(path, _)| path == Path::new("semantic.json")).unwrap();
    let id = sha256(semantic);
    let blob = tower.store().join(format!("tower/blobs/{}/{id}", &id[..2]));
    for is_lost in [false, true] {
        server.down();
        if is_lost {
            std::fs::remove_file(&blob).unwrap();
        }
        server.up();
        server.wait_for_status("the files are there", |status| {
            let is_shown = status["server"]["epoch"].as_u64() == Some(tower.epoch());
            is_shown && tower.index()["sets"][0]["robots"]["robot"]["files"] == list && blob.is_file()
        });
        assert!(fetched_files(&web, &tower.index()["sets"][0]) == of_second);
        if !is_lost {
            assert!(written().is_superset(&before), "a blob was written again");
        }
    }
}

/// The files of fleets in a store, judged by the formats' schemas and against the maps.
fn judged(tower: &Tower) {
    let python = end_to_end::root().join("target/venv/bin/python");
    let mut install = Command::new("bash");
    install.arg(end_to_end::root().join("scripts/python-env"));
    install.args(["numpy", "shapely==2.2.0", "jsonschema==4.26.0", "rfc3339-validator==0.1.4"]);
    let is_installed = install.status().is_ok_and(|status| status.success());
    if !is_installed || !python.is_file() {
        announce(
            "SKIPPED: numpy, shapely and jsonschema could not be installed: files of fleets in a store are not judged",
        );
        return;
    }
    let script = end_to_end::root().join("scripts/check_fleet.py");
    let output = Command::new(python)
        .arg(script)
        .arg("--self-test")
        .arg("--store")
        .arg(tower.store().join("tower"))
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && text.contains("PASS") && text.contains("with another instant"), "{text}");
}

/// The plan time of a folder of exported files, if all of it is as its manifest says; `None` if the link has moved on meanwhile.
fn plan_time_of_files(link: &Path) -> Option<String> {
    let folder = std::fs::canonicalize(link).ok()?;
    let looked = || -> Option<String> {
        let manifest: Value = serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).ok()?).ok()?;
        let mut is_whole = true;
        for (path, sum) in manifest["files"].as_object()? {
            let bytes = std::fs::read(folder.join(path)).ok();
            is_whole &= bytes.is_some_and(|bytes| sha256(&bytes) == *sum);
        }
        is_whole.then(|| manifest["plan_time"].as_str().map(str::to_owned))?
    };
    let found = looked();
    // What no link names any more may go.
    let is_still = std::fs::canonicalize(link).is_ok_and(|now| now == folder);
    assert!(found.is_some() || !is_still, "{} is not whole", folder.display());
    found.filter(|_| is_still)
}

/// The plan time of the maps that a robot shows, if there are any.
fn plan_time_of_maps(robot: &Live) -> Option<String> {
    let output = robot.run(&[&"topic", &"echo", &"grids"]);
    let index: Value = serde_json::from_slice(&output.stdout).ok()?;
    index["content"]["plan_time"].as_str().map(str::to_owned)
}

/// Raises a flag when it goes.
struct Raised<'a>(&'a std::sync::atomic::AtomicBool);

impl Drop for Raised<'_> {
    fn drop(&mut self) {
        self.0.store(true, std::sync::atomic::Ordering::Relaxed);
    }
}

#[test]
fn files_of_a_robot_are_those_of_its_maps_whatever_dies() {
    let tower = Tower::with_keys();
    let server = Live::of(&demo_model(), &(tower.serve("signing", FIRST) + "export = [\"maps\"]\n"));
    exported(&server, &tower, "2024-04-15T00:00:00");
    let robot = Live::following(&tower.follow("files = \"files\"\n"));
    let link = robot.home.path().join("files/current");
    let files_of = |date: &str| {
        let begun = Instant::now();
        while plan_time_of_files(&link).as_deref() != Some(date) {
            assert!(begun.elapsed() < DEADLINE, "there are no files of {date}: {:?}", robot.status());
            std::thread::sleep(POLL_INTERVAL);
        }
        let files = contents(&std::fs::canonicalize(&link).unwrap());
        let of_server = server.exported("files");
        assert!(files == of_server, "{:?}", differing(&files, &of_server));
    };
    files_of("2024-04-15T00:00:00");
    let is_over = std::sync::atomic::AtomicBool::new(false);
    let n_looks = std::thread::scope(|scope| {
        // Also after a failure: the other thread ends with this one.
        let over = Raised(&is_over);
        // Whoever looks sees files of the maps on the bus, whole, or none.
        let watch = scope.spawn(|| {
            let mut n_looks = 0;
            while !is_over.load(std::sync::atomic::Ordering::Relaxed) {
                let before = plan_time_of_maps(&robot);
                let files = plan_time_of_files(&link);
                let after = plan_time_of_maps(&robot);
                if let (Some(files), true) = (files, before.is_some() && before == after) {
                    assert_eq!(Some(files), before);
                    n_looks += 1;
                }
            }
            n_looks
        });
        for (n, date) in ["2024-04-20", "2024-05-20", "2024-04-15", "2024-05-21"].into_iter().enumerate() {
            server.text(&[&"date", &date]);
            let at = format!("{date}T00:00:00");
            // In the middle of what it does, each time elsewhere.
            std::thread::sleep(std::time::Duration::from_millis(300 * n as u64));
            if let Some(id) =
                robot.status().and_then(|s| s["daemons"]["site-follow"]["process_id"].as_u64()).filter(|id| *id > 1)
            {
                assert!(Command::new("kill").args(["-9", &id.to_string()]).status().unwrap().success());
            }
            exported(&server, &tower, &at);
            files_of(&at);
        }
        drop(over);
        watch.join().unwrap()
    });
    assert!(n_looks > 10, "{n_looks}");
    // Without the store they stay.
    std::fs::rename(tower.store(), tower.at("away")).unwrap();
    robot.says("what is shown is valid until");
    assert_eq!(plan_time_of_files(&link).as_deref(), Some("2024-05-21T00:00:00"));
}

#[test]
fn maps_do_not_wait_for_files_that_a_store_has_lost() {
    let tower = Tower::with_keys();
    let server = Live::of(&demo_model(), &(tower.serve("signing", FIRST) + "export = [\"maps\"]\n"));
    let first = exported(&server, &tower, "2024-04-15T00:00:00");
    let semantic = server.exported("first").into_iter().find(|(path, _)| path == Path::new("semantic.json")).unwrap();
    let id = sha256(&semantic.1);
    std::fs::remove_file(tower.store().join(format!("tower/blobs/{}/{id}", &id[..2]))).unwrap();
    let robot = Live::following(&tower.follow("files = \"files\"\n"));
    let why = robot.says("exported files are not here");
    assert!(why.contains(&id), "{why}");
    assert!(robot.exported("maps") == server.exported("maps"));
    let link = robot.home.path().join("files/current");
    assert!(!link.is_symlink(), "a part of them is not shown");
    // Nor for a link that somebody has put something in the place of.
    std::fs::create_dir(&link).unwrap();
    server.text(&[&"date", &"2024-05-20"]);
    let second = exported(&server, &tower, "2024-05-20T00:00:00")["epoch"].as_u64().unwrap();
    assert!(second > first["epoch"].as_u64().unwrap());
    robot.wait_for_status("the maps are shown", |status| {
        status["follower"]["epoch"] == second && status["plan"]["is_current"] == true
    });
    robot.says("files/current");
    std::fs::remove_dir(&link).unwrap();
    robot.wait_for_status("the files are shown", |_| {
        plan_time_of_files(&link).as_deref() == Some("2024-05-20T00:00:00")
    });
}

#[test]
fn files_of_later_maps_are_there_before_and_are_shown_with_them() {
    let tower = Tower::with_keys();
    let (schedule, instants) = soon(&tower, &[60, 70]);
    let serve = tower.serve("signing", &schedule) + "export = [\"vda5050\"]\n";
    let mut server = Live::of(&demo_model(), &serve);
    server.text(&[&"date", &"--wall"]);
    let sets = || tower.index()["sets"].as_array().unwrap().clone();
    let of_later = |set: &Value| instants.contains(&set["plan_time_s"].as_i64().unwrap_or(0));
    server.wait_for_status("files of later sets are exported", |_| {
        let later = Some(()).filter(|()| tower.current().is_file()).map(|()| sets()).unwrap_or_default();
        let has_files = |set: &&Value| of_later(set) && !set["robots"]["robot"]["files"]["vda5050_maps"].is_null();
        later.iter().filter(has_files).count() == 2
    });
    for set in sets().iter().filter(|set| of_later(set)) {
        let blob = set["robots"]["robot"]["files"]["vda5050_maps"]["id"].as_str().unwrap();
        let text = std::fs::read(tower.store().join(format!("tower/blobs/{}/{blob}", &blob[..2]))).unwrap();
        let maps: Value = serde_json::from_slice(&text).unwrap();
        let at: jiff::Timestamp = maps["enable_at"].as_str().unwrap().parse().unwrap();
        assert_eq!(Some(at.as_second()), set["plan_time_s"].as_i64(), "the zone of the site is UTC");
    }
    let robot = Live::following(&tower.follow("files = \"files\"\n"));
    let link = robot.home.path().join("files/current");
    // What the robot is still writing has a name that begins with a dot, and may be gone at any time.
    let folder = robot.home.path().join("files/sets");
    let is_whole = |set: &PathBuf| !set.file_name().unwrap().as_encoded_bytes().starts_with(b".");
    let n_sets = || if folder.is_dir() { files_in(&folder).iter().filter(|set| is_whole(set)).count() } else { 0 };
    robot.wait_for_status("files of later sets are here", |_| link.exists() && n_sets() >= 3);
    server.down();
    std::fs::rename(tower.store(), tower.at("away")).unwrap();
    for at_s in instants {
        let text = messages::plan_time(at_s).unwrap().to_string();
        robot.wait_for_status("the next files are shown", |_| plan_time_of_files(&link).as_ref() == Some(&text));
        assert_eq!(plan_time_of_maps(&robot).as_ref(), Some(&text));
    }
}
