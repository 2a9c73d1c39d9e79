use super::*;
use crate::source::{Source, TileAddress};
use site_http::{Access, MAX_CONNECTIONS, Server, ServerSettings};
use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::time::Duration;
use tokio::sync::Semaphore;

/// For what must happen by itself.
const DEADLINE: Duration = Duration::from_secs(120);

struct OneSite;

/// A document that is worth compressing.
const LONG: &str = include_str!("tests.rs");

impl Source for OneSite {
    fn site(&self) -> Result<Bytes, SourceError> {
        Ok(Bytes::from(*b"{}"))
    }

    fn calendar(&self) -> Result<Bytes, SourceError> {
        Err(SourceError::NotYet)
    }

    fn date(&self, key: &str) -> Result<Option<Bytes>, SourceError> {
        match key {
            "0" => Ok(Some(Bytes::from(*b"[]"))),
            "long" => Ok(Some(LONG.as_bytes().into())),
            "before" => Err(SourceError::Changed { folder: "maps".into() }),
            _ => Ok(None),
        }
    }

    fn tasks(&self) -> Result<Bytes, SourceError> {
        Ok(Bytes::from(*b"{\"tasks\":[]}"))
    }

    fn summary(&self, key: &str) -> Result<Option<Bytes>, SourceError> {
        self.date(key)
    }

    fn tile(&self, address: &TileAddress) -> Result<Option<Bytes>, SourceError> {
        Ok((address.place.row == 7).then(|| Bytes::from(*b"png")))
    }

    fn model(&self, _name: &ContentName) -> Result<Option<Bytes>, SourceError> {
        Ok(None)
    }

    fn answer(&self, question: &Question) -> Result<Bytes, SourceError> {
        match question {
            Question::Way(ends) => Ok(Bytes::from(ends.join("|").into_bytes())),
            _ => Err(SourceError::NotHeld { command: question.command("house.ifc") }),
        }
    }
}

/// Serves on a free port for as long as the tests run.
fn served(access: Access) -> SocketAddr {
    served_to(access, MAX_CONNECTIONS)
}

fn content(access: Access) -> Served {
    let viewers = Arc::new(Semaphore::new(1));
    Served { source: Arc::new(OneSite), live: None, access: Arc::new(access), viewers }
}

fn served_to(access: Access, n_connections: usize) -> SocketAddr {
    let settings = ServerSettings { listen: "127.0.0.1:0".parse().unwrap(), tls: None, n_connections };
    let server = Server::bind(settings, router(content(access), false)).unwrap();
    let address = server.url().trim_start_matches("http://").trim_end_matches('/').parse().unwrap();
    std::thread::spawn(move || server.run());
    address
}

/// The answer to a request with these lines behind its first.
fn ask(address: SocketAddr, first: &str, more: &str) -> String {
    String::from_utf8_lossy(&bytes_of(address, first, more)).into_owned()
}

fn bytes_of(address: SocketAddr, first: &str, more: &str) -> Vec<u8> {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "{first} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{more}\r\n").unwrap();
    rest_of(&mut stream)
}

/// What comes until the other end closes.
fn rest_of(stream: &mut TcpStream) -> Vec<u8> {
    stream.set_read_timeout(Some(DEADLINE)).unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    answer
}

fn status(answer: &str) -> &str {
    answer.split(' ').nth(1).unwrap_or_default()
}

#[test]
fn documents_have_a_strict_policy_and_a_tag() {
    let address = served(Access::OwnMachine);
    let answer = ask(address, "GET /data/site.json", "");
    assert_eq!(status(&answer), "200", "{answer}");
    for header in [
        "content-security-policy: default-src 'none'; script-src 'self'",
        "x-content-type-options: nosniff",
        "cache-control: no-cache",
    ] {
        assert!(answer.contains(header), "{header} in {answer}");
    }
    assert!(!answer.to_lowercase().contains("access-control-allow"), "no other site may read this");
    let tag = answer.lines().find_map(|line| line.strip_prefix("etag: ")).unwrap();
    assert_eq!(status(&ask(address, "GET /data/site.json", &format!("If-None-Match: {tag}\r\n"))), "304");
    let page = ask(address, "GET /", "");
    assert!(page.contains("text/html") && page.contains("<html"), "{page}");
}

#[test]
fn what_is_not_there_is_not_found_and_no_path_leads_to_a_file() {
    let address = served(Access::OwnMachine);
    let name = "0123456789abcdef0123456789abcdef";
    assert_eq!(status(&ask(address, &format!("GET /data/tiles/0/planning/{name}/0/0/7.png"), "")), "200");
    let wrong = [
        format!("/data/tiles/0/planning/{name}/0/0/6.png"),
        format!("/data/tiles/0/other/{name}/0/0/7.png"),
        "/data/tiles/0/planning/..%2f..%2fetc/0/0/7.png".to_owned(),
        "/data/dates/..%2f0.json".to_owned(),
        "/data/dates/1.json".to_owned(),
        "/data/summary/1.json".to_owned(),
        "/data/summary/..%2f0.json".to_owned(),
        "/data/models/x.glb".to_owned(),
        "/data/events".to_owned(),
        "/data/slam/0123456789abcdef0123456789abcdef.png".to_owned(),
        "/../Cargo.toml".to_owned(),
        "/data/../../Cargo.toml".to_owned(),
    ];
    for path in wrong {
        let answer = ask(address, &format!("GET {path}"), "");
        assert!(["404", "400"].contains(&status(&answer)), "{path}: {answer}");
    }
    assert_eq!(status(&ask(address, "GET /data/calendar.json", "")), "503");
    assert_eq!(status(&ask(address, "POST /data/site.json", "")), "405");
}

#[test]
fn questions_name_things_as_people_do_and_what_cannot_be_answered_is_said() {
    let address = served(Access::OwnMachine);
    let way = ask(address, "GET /data/way/Lab%203/1.5,-2,0%2F", "");
    assert!(status(&way) == "200" && way.ends_with("Lab 3|1.5,-2,0/"), "{way}");
    let room = ask(address, "GET /data/room/Lab%203", "");
    assert!(status(&room) == "404" && room.ends_with("groundplan room 'Lab 3' house.ifc --date DATE"), "{room}");
    assert_eq!(status(&ask(address, &format!("GET /data/door/{}", "x".repeat(401)), "")), "414");
    let guarded = served(Access::Token(Access::hash_of("secret")));
    assert_eq!(status(&ask(guarded, "GET /data/way/a/b", "")), "403");
}

#[test]
fn without_a_running_site_nothing_can_be_changed() {
    let address = served(Access::OwnMachine);
    let answer = ask(address, "POST /data/control/date", "Content-Length: 0\r\nX-Groundplan: 1\r\n");
    assert!(!answer.contains("200 OK"), "{answer}");
}

#[test]
fn other_names_and_viewers_without_a_token_are_refused() {
    let own = served(Access::OwnMachine);
    let mut stream = TcpStream::connect(own).unwrap();
    write!(stream, "GET / HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    assert_eq!(status(&answer), "403");
    let guarded = served(Access::Token(Access::hash_of("secret")));
    assert_eq!(status(&ask(guarded, "GET /data/site.json", "")), "403");
    let welcome = ask(guarded, "GET /?token=secret", "");
    assert!(status(&welcome) == "303" && welcome.contains("set-cookie: groundplan_token=secret"), "{welcome}");
    assert!(welcome.contains("HttpOnly") && welcome.contains("SameSite=Strict"));
    assert_eq!(status(&ask(guarded, "GET /data/site.json", "Cookie: groundplan_token=secret\r\n")), "200");
}

#[test]
fn documents_are_compressed_for_whoever_takes_it() {
    let address = served(Access::OwnMachine);
    let plain = bytes_of(address, "GET /data/dates/long.json", "");
    let packed = bytes_of(address, "GET /data/dates/long.json", "Accept-Encoding: br, gzip\r\n");
    let parts = |answer: &[u8]| {
        let end = answer.windows(4).position(|w| w == b"\r\n\r\n").unwrap() + 4;
        (String::from_utf8(answer[..end].to_vec()).unwrap(), answer[end..].to_vec())
    };
    let (plain_head, plain_body) = parts(&plain);
    let (head, body) = parts(&packed);
    assert!(head.contains("content-encoding: gzip") && head.contains("vary: Accept-Encoding"), "{head}");
    assert!(!plain_head.contains("content-encoding") && plain_head.contains("vary: Accept-Encoding"), "{plain_head}");
    let mut unpacked = String::new();
    flate2::read::GzDecoder::new(&body[..]).read_to_string(&mut unpacked).unwrap();
    assert!(unpacked == LONG && plain_body == LONG.as_bytes() && body.len() < LONG.len() / 2);
    let tag = |head: &str| head.lines().find_map(|line| line.strip_prefix("etag: ").map(str::to_owned)).unwrap();
    assert_eq!(tag(&head), tag(&plain_head), "one document has one tag");
    let known = format!("Accept-Encoding: gzip\r\nIf-None-Match: \"x\", {}\r\n", tag(&head));
    assert_eq!(status(&ask(address, "GET /data/dates/long.json", &known)), "304");
    assert!(!ask(address, "GET /data/dates/0.json", "Accept-Encoding: gzip\r\n").contains("content-encoding"));
}

#[test]
fn only_what_its_address_names_is_kept_by_browsers() {
    let address = served(Access::OwnMachine);
    let kept = "cache-control: private, max-age=31536000, immutable";
    assert!(ask(address, "GET /data/tiles/0/planning/0123456789abcdef0123456789abcdef/0/0/7.png", "").contains(kept));
    for path in ["", "app.js", "data/site.json", "data/tasks.json", "data/dates/0.json", "data/summary/0.json"] {
        let answer = ask(address, &format!("GET /{path}"), "");
        assert!(status(&answer) == "200" && answer.contains("cache-control: no-cache"), "{path}: {answer}");
    }
    let before = ask(address, "GET /data/dates/before.json", "");
    assert!(status(&before) == "409" && before.contains("load the page again"), "{before}");
}

#[test]
fn a_body_and_a_head_that_do_not_come_end_their_connections() {
    let address = served(Access::OwnMachine);
    let head = "POST /data/control/date HTTP/1.1\r\nHost: localhost\r\nContent-Length: 9\r\n";
    let begun = |text: &str| {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.write_all(text.as_bytes()).unwrap();
        stream
    };
    let mut streams = ["", "GET / HT", head, &format!("{head}\r\n{{\"at\"")].map(begun);
    let answers = streams.each_mut().map(|stream| String::from_utf8(rest_of(stream)).unwrap());
    assert_eq!(status(&answers[3]), "408", "{answers:?}");
    assert!(answers[..3].iter().all(|answer| !answer.contains(" 200 ")), "{answers:?}");
    let long = format!("{}\r\n{}", head.replace("Content-Length: 9", "Content-Length: 5000"), " ".repeat(5000));
    let mut stream = begun(&long);
    assert_eq!(status(&String::from_utf8_lossy(&rest_of(&mut stream))), "413");
}

#[test]
fn who_is_one_too_many_is_told_so_until_a_place_is_free() {
    let address = served_to(Access::OwnMachine, 2);
    let mut held: Vec<TcpStream> = (0..2).map(|_| TcpStream::connect(address).unwrap()).collect();
    for stream in &mut held {
        write!(stream, "GET /data/dates/0.json HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
        let mut answer = [0; 12];
        stream.read_exact(&mut answer).unwrap();
        assert_eq!(&answer, b"HTTP/1.1 200");
    }
    let refused = ask(address, "GET /data/site.json", "");
    assert!(status(&refused) == "503" && refused.contains("there are too many connections"), "{refused}");
    assert!(refused.contains("retry-after: 10"), "{refused}");
    held.pop();
    let begun = std::time::Instant::now();
    while status(&ask(address, "GET /data/site.json", "")) != "200" {
        assert!(begun.elapsed() < DEADLINE, "the place stays taken");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn the_cookie_is_sent_back_encrypted_where_the_viewer_came_so() {
    let guarded = served(Access::Token(Access::hash_of("secret")));
    assert!(!ask(guarded, "GET /?token=secret", "").contains("Secure"));
    let of_proxy = ask(guarded, "GET /?token=secret", "X-Forwarded-Proto: https\r\n");
    assert!(of_proxy.contains("SameSite=Strict; Max-Age=31536000; Secure"), "{of_proxy}");
}

#[test]
fn a_certificate_that_is_a_pipe_or_has_no_end_is_refused_at_once_and_named() {
    let home = tempfile::tempdir().unwrap();
    let [pipe, pem] = ["pipe.pem", "site.pem"].map(|name| home.path().join(name));
    let mode = rustix::fs::Mode::from_raw_mode(0o600);
    rustix::fs::mknodat(rustix::fs::CWD, &pipe, rustix::fs::FileType::Fifo, mode, 0).unwrap();
    std::fs::write(&pem, "").unwrap();
    for (tls, named) in
        [((&pipe, &pem), &pipe), ((&pem, &pipe), &pipe), ((&"/dev/zero".into(), &pem), &"/dev/zero".into())]
    {
        let tls = Some((tls.0.clone(), tls.1.clone()));
        let settings = ServerSettings::of("127.0.0.1:0".parse().unwrap(), tls);
        let why = Server::bind(settings, router(content(Access::OwnMachine), false)).err().unwrap();
        assert!(why.to_string().starts_with(&named.display().to_string()), "{why}");
    }
}
