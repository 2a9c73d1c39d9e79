//! The page's server beside running daemons and on files, asked as a browser asks it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use bus::Daemon;
use daemon::facts::WebFacts;
use daemon::{Report, StatusBoard};
use end_to_end::live::{DEADLINE, Live, POLL_INTERVAL};
use end_to_end::{client, convert, demo_model};
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Instant;

/// A server that ends with its value.
struct Server {
    process: Child,
    address: String,
}

impl Server {
    /// `groundplan view` on a free port.
    fn view(arguments: &[&str]) -> Self {
        let mut command = Command::new(client());
        command.arg("view").args(arguments).args(["--listen", "127.0.0.1:0"]);
        let mut process = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(process.stdout.take().unwrap()).read_line(&mut line).unwrap();
        Self { address: address_of(line.trim()), process }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = Command::new("kill").arg(self.process.id().to_string()).status();
        let _ = self.process.wait();
    }
}

fn address_of(url: &str) -> String {
    let address = url.strip_prefix("http://").and_then(|rest| rest.strip_suffix('/'));
    address.unwrap_or_else(|| panic!("{url:?} is no address")).to_owned()
}

/// Status and body of an answer.
fn ask(address: &str, method: &str, path: &str, body: &str) -> (u16, Vec<u8>) {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(DEADLINE)).unwrap();
    let length = body.len();
    let head = format!(
        "{method} /{path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nX-Groundplan: 1\r\nContent-Length: {length}\r\n\r\n"
    );
    stream.write_all((head + body).as_bytes()).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    let end = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap();
    let status = std::str::from_utf8(&answer[9..12]).unwrap().parse().unwrap();
    (status, answer.split_off(end + 4))
}

fn document(address: &str, path: &str) -> Value {
    let (status, body) = ask(address, "GET", path, "");
    assert_eq!(status, 200, "{path}: {}", String::from_utf8_lossy(&body));
    serde_json::from_slice(&body).unwrap()
}

/// The document of a date of a page of files, by its number.
fn date_of(address: &str, number: usize) -> Value {
    let site = document(address, "data/site.json");
    document(address, &format!("data/dates/{}.json", site["dates"][number]["key"].as_str().unwrap()))
}

/// The events of a live page: opened once, read as they come.
struct Events(BufReader<TcpStream>);

impl Events {
    fn of(address: &str) -> Self {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(DEADLINE)).unwrap();
        stream.write_all(b"GET /data/events HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        Self(BufReader::new(stream))
    }

    /// The next event of a kind that is as it should be.
    fn wait_for(&mut self, kind: &str, is_so: impl Fn(&Value) -> bool) -> Value {
        let (begun, mut of_kind) = (Instant::now(), false);
        loop {
            let mut line = String::new();
            assert!(self.0.read_line(&mut line).unwrap() > 0, "the connection ended before {kind}");
            assert!(begun.elapsed() < DEADLINE, "{kind} does not come");
            let line = line.trim_end();
            match line.split_once(": ") {
                Some(("event", name)) => of_kind = name == kind,
                Some(("data", data)) if of_kind => {
                    let event: Value = serde_json::from_str(data).unwrap();
                    if is_so(&event) {
                        return event;
                    }
                }
                _ => {}
            }
        }
    }
}

/// A site with a page on a free port.
fn site(more: &str) -> Live {
    let web = format!("[web]\nenabled = true\nlisten = \"127.0.0.1:0\"\n{more}");
    Live::of(&demo_model(), &format!("[schedule]\nplan_time = \"2024-03-01\"\n{web}"))
}

/// Where the page of a site is, once it shows maps.
fn page_of(live: &Live) -> String {
    let begun = Instant::now();
    loop {
        let report: Option<Report<WebFacts>> = StatusBoard::of(live.root.path()).report(Daemon::Web);
        let url = report.and_then(|report| report.facts.url).map(|url| address_of(&url));
        if let Some(address) = url.filter(|address| ask(address, "GET", "data/site.json", "").0 == 200) {
            return address;
        }
        assert!(begun.elapsed() < DEADLINE, "{:?}", live.status());
        std::thread::sleep(POLL_INTERVAL);
    }
}

fn planning_tile(address: &str, date: &Value, storey: usize) -> Vec<u8> {
    let name = date["storeys"][storey]["layers"]["planning"].as_str().unwrap();
    let index = &date["storeys"][storey]["index"];
    let (status, tile) = ask(address, "GET", &format!("data/tiles/{index}/planning/{name}/0/0/0.png"), "");
    assert_eq!(status, 200);
    tile
}

#[test]
fn the_page_of_the_daemons_shows_what_that_of_files_shows_at_the_same_date() {
    let live = site("");
    let address = page_of(&live);
    let mut events = Events::of(&address);
    live.text(&[&"date", &"2024-06-15"]);
    let event = events.wait_for("date", |event| event["at"] == "2024-06-15T00:00:00");
    let now = document(&address, &format!("data/dates/{}.json", event["key"].as_str().unwrap()));

    let maps = convert(&demo_model(), &["--date", "2024-06-15T00:00:00"]);
    let files = Server::view(&["--out", maps.path().to_str().unwrap()]);
    let then = date_of(&files.address, 0);
    for key in ["at", "until", "elements", "spaces", "passages", "doors", "waypoints", "mission", "graph"] {
        assert_eq!(now[key], then[key], "{key}");
    }
    for storey in 0..then["storeys"].as_array().unwrap().len() {
        let (live, of_files) = (planning_tile(&address, &now, storey), planning_tile(&files.address, &then, storey));
        assert!(live == of_files, "storey {storey}");
    }
    let counted = |address: &str, date: &Value| {
        let summary = document(address, &format!("data/summary/{}.json", date["key"].as_str().unwrap()));
        [summary["storeys"].clone(), summary["sum"].clone()]
    };
    assert_eq!(counted(&address, &now), counted(&files.address, &then));
    assert!(counted(&address, &now)[1]["free_m2"].as_f64().unwrap() > 100.0);
    let (sites, dates) = (document(&address, "data/site.json"), document(&files.address, "data/site.json"));
    for key in ["elements", "spaces", "storeys", "tiles", "tasks", "robot", "frames"] {
        assert_eq!(sites[key], dates[key], "{key}");
    }
}

#[test]
fn the_page_of_the_daemons_answers_what_the_client_answers_and_that_of_files_names_the_command() {
    let live = site("");
    let address = page_of(&live);
    live.text(&[&"date", &"2024-05-01"]);
    Events::of(&address).wait_for("date", |event| event["at"] == "2024-05-01T00:00:00");
    Events::of(&address).wait_for("status", |event| event["stale"] == false);
    // Once a second the page looks whether its maps may be used; until it has, and where that is long ago, it says so.
    let checked = |path: &str| -> Value {
        let begun = Instant::now();
        loop {
            let told = document(&address, path);
            if told["answer"]["circumstances"]["maps"]["may_be_used"] == true {
                return told;
            }
            assert!(begun.elapsed() < DEADLINE, "{told}");
            std::thread::sleep(POLL_INTERVAL);
        }
    };
    let asked = |words: &[&str]| -> Value {
        let words: Vec<&dyn AsRef<std::ffi::OsStr>> = words.iter().map(|w| w as &dyn AsRef<std::ffi::OsStr>).collect();
        let output = live.run(&[&words[..], &[&"--only-now", &"--json"]].concat());
        serde_json::from_slice(&output.stdout).unwrap_or_else(|_| panic!("{output:?}"))
    };
    for (path, words) in [
        ("data/room/G.13", &["room", "G.13"][..]),
        ("data/door/G.D04%20plant%20room", &["door", "G.D04 plant room"]),
        ("data/way/G.02/G.10", &["way", "G.02", "G.10"]),
        ("data/way/3.5,2.0,0/G.13", &["way", "3.5,2.0,0", "G.13"]),
    ] {
        let told = checked(path);
        let mut expected = asked(words);
        // The page draws no maps of later dates.
        expected["changes"] = Value::Null;
        assert_eq!(told["answer"], expected, "{path}");
        assert!(told["text"].as_str().unwrap().contains("maps of epoch"), "{told}");
    }
    let room = document(&address, "data/room/G.13");
    assert_eq!(room["answer"]["closed_by"][0]["task"]["identification"], "3.1");
    assert!(room["text"].as_str().unwrap().contains("works in it until 2024-05-08T17:00:00"), "{room}");
    for path in ["data/room/G.99", "data/way/G.02/G.99"] {
        let (status, why) = ask(&address, "GET", path, "");
        let why = String::from_utf8(why).unwrap();
        assert!(status == 404 && why.starts_with("there is no room \"G.99\"; nearest: \"G.09\""), "{why}");
    }

    let maps = convert(&demo_model(), &["--date", "2024-05-01"]);
    let files = Server::view(&["--out", maps.path().to_str().unwrap()]);
    let (status, why) = ask(&files.address, "GET", "data/room/G.13", "");
    assert!(status == 404 && String::from_utf8_lossy(&why).contains("groundplan room 'G.13' demo.ifc"), "{why:?}");
}

#[test]
fn a_viewer_is_told_of_dead_daemons_and_cannot_change_anything_unasked() {
    let live = site("");
    let address = page_of(&live);
    let mut events = Events::of(&address);
    events.wait_for("status", |event| event["stale"] == false && event["services"].as_array().unwrap().len() >= 7);
    let (status, body) = ask(&address, "POST", "data/control/date", "{\"at\": \"2024-04-15T00:00:00\"}");
    assert_eq!(status, 403, "{}", String::from_utf8_lossy(&body));
    let (status, _) = ask(&address, "POST", "data/control/confirm", "{\"global_id\": \"x\"}");
    assert_eq!(status, 403);
    assert!(live.text(&[&"date"]).starts_with("2024-03-01T00:00:00"));

    let rasterize = live.status().unwrap()["daemons"]["rasterize"]["process_id"].as_u64().unwrap();
    assert!(rasterize > 1);
    assert!(Command::new("kill").args(["-STOP", &rasterize.to_string()]).status().unwrap().success());
    let stale = events.wait_for("status", |event| event["stale"] == true);
    assert!(stale["why"].as_str().unwrap().contains("rasterize"), "{stale}");
    events.wait_for("status", |event| event["stale"] == false);

    live.kill("groundplan-web");
    let address = page_of(&live);
    assert_eq!(document(&address, "data/site.json")["live"], true);
    let (status, model) = model_at(&address);
    assert!(status == 200 && model.starts_with(b"glTF"));
}

/// The 3D model of the newest date.
fn model_at(address: &str) -> (u16, Vec<u8>) {
    let event = Events::of(address).wait_for("date", |_| true);
    let date = document(address, &format!("data/dates/{}.json", event["key"].as_str().unwrap()));
    ask(address, "GET", &format!("data/models/{}.glb", date["model"].as_str().unwrap()), "")
}

/// Starts the site again with its log in a file, and does not wait.
fn up_with_log(live: &mut Live) -> PathBuf {
    live.down();
    let path = live.home.path().join("log");
    let log = std::fs::File::create(&path).unwrap();
    let up = Command::new(client()).arg("up").arg("--config").arg(live.config()).stderr(log).spawn();
    live.up = Some(up.unwrap());
    path
}

#[test]
fn a_port_in_use_leaves_the_daemons_at_work_until_it_is_free() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let mut live = site("");
    let config = std::fs::read_to_string(live.config()).unwrap();
    assert!(config.contains("127.0.0.1:0"));
    std::fs::write(live.config(), config.replace("127.0.0.1:0", &address)).unwrap();
    up_with_log(&mut live);
    let told = |daemon: &Value| daemon["error"].as_str().is_some_and(|why| why.contains(&address));
    live.wait_for_status("the port", |status| told(&status["daemons"]["groundplan-web"]) && status["healthy"] == false);
    live.text(&[&"date", &"2024-06-15"]);
    let page = live.run(&[&"view"]);
    let why = String::from_utf8_lossy(&page.stderr);
    assert!(page.status.code() == Some(1) && why.contains(&address), "{why}");
    assert_eq!(live.status().unwrap()["daemons"]["groundplan-web"]["restarts"], 0, "it waits, and does not die");
    drop(taken);
    assert_eq!(page_of(&live), address);
    live.wait_until_healthy();
    live.down();
}

#[test]
fn a_taken_port_ends_a_page_of_files_and_is_named() {
    let taken = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = taken.local_addr().unwrap().to_string();
    let maps = convert(&demo_model(), &["--date", "2024-06-15T00:00:00"]);
    let output = end_to_end::groundplan(&[&"view", &"--out", &maps.path(), &"--listen", &address]);
    let why = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(1) && why.contains(&address) && why.contains("--listen"), "{why}");
}

#[test]
fn maps_that_are_converted_into_the_folder_are_shown_under_their_own_date() {
    let maps = convert(&demo_model(), &["--date", "2024-04-15T08:00:00"]);
    let folder = maps.path();
    let server = Server::view(&["--out", folder.to_str().unwrap()]);
    let before = date_of(&server.address, 0);
    let shown = planning_tile(&server.address, &before, 0);
    let output = end_to_end::groundplan(&[&"convert", &demo_model(), &"--date", &"2024-05-13", &"-o", &folder]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let gone = format!("data/dates/{}.json", before["key"].as_str().unwrap());
    let (status, why) = ask(&server.address, "GET", &gone, "");
    assert_eq!(status, 409, "{}", String::from_utf8_lossy(&why));
    let now = date_of(&server.address, 0);
    assert_eq!((&before["at"], &now["at"]), (&json!("2024-04-15T08:00:00"), &json!("2024-05-13T00:00:00")));
    assert!(planning_tile(&server.address, &now, 0) != shown, "the plan has changed meanwhile");
    let name = before["storeys"][0]["layers"]["planning"].as_str().unwrap();
    assert_eq!(ask(&server.address, "GET", &format!("data/tiles/0/planning/{name}/0/0/0.png"), "").0, 404);
}

#[test]
fn the_viewer_who_is_one_too_many_is_told_so() {
    let live = site("");
    let address = page_of(&live);
    let mut viewers: Vec<Events> = (0..64).map(|_| Events::of(&address)).collect();
    viewers.iter_mut().for_each(|viewer| drop(viewer.wait_for("status", |_| true)));
    let (status, why) = ask(&address, "GET", "data/events", "");
    let why = String::from_utf8_lossy(&why);
    assert!(status == 503 && why.contains("64 viewers") && why.contains("too many"), "{status} {why}");
    assert_eq!(ask(&address, "GET", "data/site.json", "").0, 200, "it can look");
    viewers.pop();
    let begun = Instant::now();
    while ask_head(&address, "data/events") != 200 {
        assert!(begun.elapsed() < DEADLINE, "the place of the viewer who left stays taken");
        std::thread::sleep(POLL_INTERVAL);
    }
}

/// Status of an answer whose body has no end.
fn ask_head(address: &str, path: &str) -> u16 {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.set_read_timeout(Some(DEADLINE)).unwrap();
    stream.write_all(format!("GET /{path} HTTP/1.1\r\nHost: localhost\r\n\r\n").as_bytes()).unwrap();
    let mut head = [0; 12];
    stream.read_exact(&mut head).unwrap();
    std::str::from_utf8(&head[9..]).unwrap().parse().unwrap()
}

#[test]
fn viewers_set_the_date_where_the_site_allows_it() {
    let mut live = site("allow_control = true\n");
    let log = up_with_log(&mut live);
    let address = page_of(&live);
    assert_eq!(document(&address, "data/site.json")["control"], true);
    let mut events = Events::of(&address);
    let (status, body) = ask(&address, "POST", "data/control/date", "{\"at\": \"2024-04-15T08:00:00\"}");
    assert_eq!((status, body.as_slice()), (200, b"{}".as_slice()));
    events.wait_for("date", |event| event["at"] == "2024-04-15T08:00:00");
    for wrong in ["{\"at\": \"tomorrow\"}", "{\"at\": 7}", "{}", "[", "{\"at\": \"2024-04-15\", \"and\": 1}"] {
        let (status, body) = ask(&address, "POST", "data/control/date", wrong);
        let answer: Value = serde_json::from_slice(&body).unwrap();
        assert!((400..500).contains(&status) && answer["error"].is_string(), "{wrong}: {status} {answer}");
    }
    let log = std::fs::read_to_string(log).unwrap();
    for (what, asked) in [("a viewer changed the site", "2024-04-15T08:00:00"), ("a viewer was refused", "tomorrow")] {
        let line = log.lines().find(|line| line.contains(what)).unwrap_or_else(|| panic!("{what}: {log}"));
        assert!(line.contains("127.0.0.1:") && line.contains(asked), "{line}");
    }
    live.down();
}

#[test]
fn models_are_converted_at_every_change_and_written_as_a_page() {
    let folder = tempfile::tempdir().unwrap();
    let page = folder.path().join("page");
    let model = demo_model();
    let arguments = ["view", model.to_str().unwrap(), "--export", page.to_str().unwrap()];
    let output = Command::new(client()).args(arguments).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let site = script(&page.join("data/site.js"), "site");
    let dates = site["dates"].as_array().unwrap();
    assert!(dates.len() > 10);
    let key = dates[dates.len() - 1]["key"].as_str().unwrap();
    let last = script(&page.join(format!("data/dates/{key}.js")), &format!("dates/{key}"));
    assert_eq!(last["at"], dates[dates.len() - 1]["at"]);
    let model = last["model"].as_str().unwrap();
    assert!(page.join(format!("data/models/{model}.js")).is_file());
    let name = last["storeys"][0]["layers"]["planning"].as_str().unwrap();
    assert!(page.join(format!("data/tiles/0/planning/{name}/0/0/0.png")).is_file());
    let calendar = script(&page.join("data/calendar.js"), "calendar");
    assert!(calendar["spaces"].as_object().unwrap().values().any(|states| states[0] == json!([0, "blocked"])));
    let tasks = script(&page.join("data/tasks.js"), "tasks");
    assert_eq!(tasks["known_from"], "schedule");
    let told = Command::new(client()).arg("tasks").arg(demo_model()).arg("--json").output().unwrap();
    let told: Value = serde_json::from_slice(&told.stdout).unwrap();
    let facts = |list: &Value| -> Vec<[Value; 4]> {
        let facts = |task: &Value| ["global_id", "start", "finish", "spaces"].map(|key| task[key].clone());
        list["tasks"].as_array().unwrap().iter().map(facts).collect()
    };
    let without_names = |mut list: Value| {
        for space in list["tasks"].as_array_mut().unwrap().iter_mut().flat_map(|t| t["spaces"].as_array_mut().unwrap())
        {
            *space = json!({"global_id": space["global_id"]});
        }
        list
    };
    assert!(facts(&tasks).len() > 10);
    assert_eq!(facts(&tasks), facts(&without_names(told)));
    let summary = script(&page.join(format!("data/summary/{key}.js")), &format!("summary/{key}"));
    assert!(summary["tasks"].as_object().unwrap().values().all(|status| status == "finished"));
}

/// The document that a script hands to the page.
fn script(path: &Path, name: &str) -> Value {
    let text = std::fs::read_to_string(path).unwrap();
    let json = text.strip_prefix(&format!("groundplanData(\"{name}\",")).and_then(|rest| rest.strip_suffix(");\n"));
    serde_json::from_str(json.unwrap()).unwrap()
}
