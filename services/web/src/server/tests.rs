use super::*;
use crate::source::{Source, TileAddress};
use std::io::{Read, Write};
use std::net::TcpStream;
use tokio::sync::Semaphore;

struct OneSite;

impl Source for OneSite {
    fn site(&self) -> Result<Bytes, SourceError> {
        Ok(Bytes::from(*b"{}"))
    }

    fn calendar(&self) -> Result<Bytes, SourceError> {
        Err(SourceError::NotYet)
    }

    fn date(&self, key: &str) -> Result<Option<Bytes>, SourceError> {
        Ok((key == "0").then(|| Bytes::from(*b"[]")))
    }

    fn tile(&self, address: &TileAddress) -> Result<Option<Bytes>, SourceError> {
        Ok((address.place.row == 7).then(|| Bytes::from(*b"png")))
    }

    fn model(&self, _name: &ContentName) -> Result<Option<Bytes>, SourceError> {
        Ok(None)
    }
}

/// Serves on a free port for as long as the tests run.
fn served(access: Access) -> SocketAddr {
    let served = Served {
        source: Arc::new(OneSite),
        live: None,
        access: Arc::new(access),
        viewers: Arc::new(Semaphore::new(1)),
    };
    let settings = ServerSettings { listen: "127.0.0.1:0".parse().unwrap(), tls: None };
    let server = Server::bind(settings, served).unwrap();
    let address = server.url().trim_start_matches("http://").trim_end_matches('/').parse().unwrap();
    std::thread::spawn(move || server.run());
    address
}

/// The answer to a request with these lines behind its first.
fn ask(address: SocketAddr, first: &str, more: &str) -> String {
    let mut stream = TcpStream::connect(address).unwrap();
    write!(stream, "{first} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n{more}\r\n").unwrap();
    let mut answer = Vec::new();
    stream.read_to_end(&mut answer).unwrap();
    String::from_utf8_lossy(&answer).into_owned()
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
    let name = "0123456789abcdef";
    assert_eq!(status(&ask(address, &format!("GET /data/tiles/0/planning/{name}/0/0/7.png"), "")), "200");
    let wrong = [
        format!("/data/tiles/0/planning/{name}/0/0/6.png"),
        format!("/data/tiles/0/other/{name}/0/0/7.png"),
        "/data/tiles/0/planning/..%2f..%2fetc/0/0/7.png".to_owned(),
        "/data/dates/..%2f0.json".to_owned(),
        "/data/dates/1.json".to_owned(),
        "/data/models/x.glb".to_owned(),
        "/data/events".to_owned(),
        "/data/slam/0123456789abcdef.png".to_owned(),
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
