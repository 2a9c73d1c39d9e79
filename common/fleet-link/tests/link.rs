//! Real sessions: what the server and a robot tell each other, and what a robot that is not honest can do.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use fleet_link::{
    Identity, LinkError, MAX_WAITING, Message, MessageKind, RobotLink, RobotSettings, ServerLink, ServerSettings,
};
use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, DnType, IsCa, KeyPair};
use std::fs::Permissions;
use std::net::TcpListener;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use zenoh::{Config, Session, Wait};

/// Far beyond what any machine needs.
const DEADLINE: Duration = Duration::from_secs(60);

/// A site with a server on a port of its own, and files of passwords and certificates.
struct Site {
    home: tempfile::TempDir,
    port: u16,
}

impl Site {
    fn new() -> Self {
        let home = tempfile::tempdir().unwrap();
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        Self { home, port }
    }

    fn secret(&self, name: &str, text: &str) -> PathBuf {
        let path = self.home.path().join(name);
        std::fs::write(&path, text).unwrap();
        std::fs::set_permissions(&path, Permissions::from_mode(0o600)).unwrap();
        path
    }

    fn server(&self) -> ServerSettings {
        ServerSettings {
            site: "tower".to_owned(),
            listen: vec![format!("tcp/127.0.0.1:{}", self.port)],
            robots: vec!["a".to_owned(), "b".to_owned()],
            passwords: Some(self.secret("passwords", "a:secret of a\nb:secret of b\n")),
            identity: None,
            robots_authority: None,
        }
    }

    fn robot(&self, name: &str, password: &str) -> RobotSettings {
        RobotSettings {
            site: "tower".to_owned(),
            robot: name.to_owned(),
            connect: vec![format!("tcp/127.0.0.1:{}", self.port)],
            password: Some(self.secret(&format!("password-{name}"), password)),
            authority: None,
            identity: None,
        }
    }

    /// A session of nobody's software, with a password.
    fn session(&self, user: &str) -> Session {
        let config = format!(
            r#"{{mode: "client", connect: {{endpoints: ["tcp/127.0.0.1:{}"]}}, scouting: {{multicast: {{enabled: false}}}},
               transport: {{auth: {{usrpwd: {{user: "{user}", password: "secret of {user}"}}}}}}}}"#,
            self.port
        );
        zenoh::open(Config::from_json5(&config).unwrap()).wait().unwrap()
    }
}

/// Robot, kind and bytes of a message.
type Heard = (String, MessageKind, Vec<u8>);

/// A server that answers each message with what it heard, and keeps that.
struct Server {
    link: ServerLink,
    heard: Arc<Mutex<Vec<Heard>>>,
}

impl Server {
    fn open(settings: &ServerSettings) -> Self {
        let (sender, messages): (_, Receiver<Message>) = channel();
        let link = ServerLink::open(settings, sender).unwrap();
        let heard = Arc::new(Mutex::new(Vec::new()));
        let kept = Arc::clone(&heard);
        std::thread::spawn(move || {
            for message in messages {
                let heard = (message.robot().to_owned(), message.kind(), message.payload().to_vec());
                let answer = match message.payload() {
                    b"refuse this" => Err("as you say".to_owned()),
                    payload => Ok([b"heard ", payload].concat()),
                };
                kept.lock().unwrap().push(heard);
                message.answer(answer);
            }
        });
        Self { link, heard }
    }

    fn heard(&self) -> Vec<Heard> {
        self.heard.lock().unwrap().clone()
    }
}

fn until(what: &str, is_so: impl Fn() -> bool) {
    let begun = Instant::now();
    while !is_so() {
        assert!(begun.elapsed() < DEADLINE, "{what}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Counts how often a robot was told of an index.
fn counter() -> (Arc<AtomicUsize>, impl Fn() + Clone + Send + Sync) {
    let n = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&n);
    (n, move || {
        counted.fetch_add(1, Ordering::SeqCst);
    })
}

#[test]
fn a_robot_hears_of_an_index_and_the_server_answers_what_it_tells() {
    let site = Site::new();
    let server = Server::open(&site.server());
    let (n_told, told) = counter();
    let robot = RobotLink::open(&site.robot("a", "secret of a"), told).unwrap();
    until("the robot is seen", || server.link.here() == ["a".to_owned()].into());
    until("the server is seen", || n_told.load(Ordering::SeqCst) == 1);
    server.link.announce(7).unwrap();
    until("the index is told", || n_told.load(Ordering::SeqCst) == 2);
    let answer = robot.tell(MessageKind::Report, b"well".to_vec()).unwrap();
    assert_eq!(answer, b"heard well");
    let refused = robot.tell(MessageKind::Progress, b"refuse this".to_vec()).unwrap_err();
    assert!(matches!(&refused, LinkError::Refused(why) if why == "as you say"), "{refused}");
    assert_eq!(server.heard()[0], ("a".to_owned(), MessageKind::Report, b"well".to_vec()));
    // A table of progress of a large site.
    let table = vec![b'x'; 8 << 20];
    assert_eq!(robot.tell(MessageKind::Progress, table).unwrap().len(), (8 << 20) + 6);
    drop(robot);
    until("the robot is gone", || server.link.here().is_empty());
}

#[test]
fn a_link_comes_back_with_its_server() {
    let site = Site::new();
    let server = Server::open(&site.server());
    let (n_told, told) = counter();
    let robot = RobotLink::open(&site.robot("a", "secret of a"), told).unwrap();
    robot.tell(MessageKind::Report, b"1".to_vec()).unwrap();
    drop(server);
    assert!(robot.tell(MessageKind::Report, b"2".to_vec()).is_err());
    let before = n_told.load(Ordering::SeqCst);
    let server = Server::open(&site.server());
    until("the robot tells again", || robot.tell(MessageKind::Report, b"3".to_vec()).is_ok());
    until("the robot is told that the server is back", || n_told.load(Ordering::SeqCst) > before);
    until("the robot is seen again", || server.link.here() == ["a".to_owned()].into());
}

#[test]
fn who_does_not_know_the_password_has_no_link() {
    let site = Site::new();
    let server = Server::open(&site.server());
    let (_, told) = counter();
    let wrong = [
        site.robot("a", "secret of b"),
        site.robot("c", "secret of a"),
        RobotSettings { password: None, ..site.robot("a", "") },
    ];
    for settings in wrong {
        let refused = RobotLink::open(&settings, told.clone());
        // Where a session opens nevertheless, nothing is heard over it.
        if let Ok(link) = refused {
            assert!(link.tell(MessageKind::Report, b"false".to_vec()).is_err(), "{settings:?}");
        }
    }
    RobotLink::open(&site.robot("b", "secret of b"), told)
        .unwrap()
        .tell(MessageKind::Report, b"true".to_vec())
        .unwrap();
    assert_eq!(server.heard(), [("b".to_owned(), MessageKind::Report, b"true".to_vec())]);
}

#[test]
fn a_robot_speaks_under_its_own_name_alone_and_hears_of_no_other() {
    let site = Site::new();
    let server = Server::open(&site.server());
    let (n_told, told) = counter();
    let other = RobotLink::open(&site.robot("b", "secret of b"), told).unwrap();
    until("the other robot is there", || server.link.here() == ["b".to_owned()].into());
    until("the server is seen", || n_told.load(Ordering::SeqCst) == 1);
    let session = site.session("a");
    let own = session.get("groundplan/tower/robots/a/report").payload("own").timeout(DEADLINE).wait().unwrap();
    assert!(own.recv().unwrap().result().is_ok());
    // Under the name of another one, and under those of all.
    for key in ["groundplan/tower/robots/b/report", "groundplan/tower/robots/*/report", "groundplan/**", "**"] {
        let replies = session.get(key).payload("stolen").timeout(Duration::from_secs(2)).wait().unwrap();
        assert!(replies.iter().all(|reply| reply.result().is_err()), "{key}");
    }
    // As another one that is there, as the server, and with an index that there is not.
    let _b = session.liveliness().declare_token("groundplan/tower/robots/b/here").wait().unwrap();
    let _c = session.liveliness().declare_token("groundplan/tower/robots/c/here").wait().unwrap();
    let _server = session.liveliness().declare_token("groundplan/tower/server").wait().unwrap();
    session.put("groundplan/tower/index", "99").wait().unwrap();
    // What others tell, and in the place of the server.
    let overheard = Arc::new(AtomicUsize::new(0));
    let counted = Arc::clone(&overheard);
    let _ear = session
        .declare_subscriber("**")
        .callback(move |_| {
            counted.fetch_add(1, Ordering::SeqCst);
        })
        .wait();
    let counted = Arc::clone(&overheard);
    let _mouth = session
        .declare_queryable("groundplan/tower/robots/**")
        .complete(true)
        .callback(move |query| {
            counted.fetch_add(1, Ordering::SeqCst);
            let _ = query.reply(query.key_expr(), "I am the server").wait();
        })
        .wait();
    let (other_session, all) = (site.session("a"), "groundplan/tower/robots/*/here");
    let here = other_session.liveliness().get(all).timeout(Duration::from_secs(2)).wait().unwrap();
    assert!(here.iter().all(|reply| reply.result().is_err()), "a robot sees another one");
    for n in 0..20 {
        let answer = other.tell(MessageKind::Report, format!("{n}").into_bytes()).unwrap();
        assert_eq!(answer, format!("heard {n}").into_bytes());
    }
    drop(other);
    until("the other robot is gone, whatever is said", || server.link.here().is_empty());
    assert_eq!(overheard.load(Ordering::SeqCst), 0);
    assert_eq!(n_told.load(Ordering::SeqCst), 1, "a robot told of an index");
    let stolen = |(_, _, payload): &&Heard| payload == b"stolen";
    assert_eq!(server.heard().iter().filter(stolen).count(), 0);
}

#[test]
fn what_a_robot_tells_too_fast_is_refused() {
    let site = Site::new();
    let (sender, messages) = channel();
    let _link = ServerLink::open(&site.server(), sender).unwrap();
    let session = site.session("a");
    let ask = || session.get("groundplan/tower/robots/a/report").payload("x").timeout(DEADLINE).wait().unwrap();
    let replies: Vec<_> = (0..MAX_WAITING + 3).map(|_| ask()).collect();
    // Nobody has answered: those that do not wait were refused at once.
    for reply in &replies[MAX_WAITING..] {
        assert!(reply.recv().unwrap().result().is_err());
    }
    let waiting: Vec<Message> = messages.iter().take(MAX_WAITING).collect();
    waiting.into_iter().for_each(|message| message.answer(Ok(Vec::new())));
    assert!(replies[..MAX_WAITING].iter().all(|reply| reply.recv().unwrap().result().is_ok()));
    let again = ask();
    messages.recv().unwrap().answer(Ok(Vec::new()));
    assert!(again.recv().unwrap().result().is_ok());
}

/// An authority and what it has signed, as PEM files.
struct Authority {
    name: String,
    issuer: CertifiedIssuer<'static, KeyPair>,
    file: PathBuf,
}

impl Authority {
    fn new(home: &Path, name: &str) -> Self {
        let mut params = CertificateParams::new(Vec::new()).unwrap();
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        params.distinguished_name.push(DnType::CommonName, name);
        let issuer = CertifiedIssuer::self_signed(params, KeyPair::generate().unwrap()).unwrap();
        let file = home.join(format!("{name}.pem"));
        std::fs::write(&file, issuer.pem()).unwrap();
        Self { name: name.to_owned(), issuer, file }
    }

    fn identity(&self, home: &Path, name: &str, host: &str) -> Identity {
        let mut params = CertificateParams::new(vec![host.to_owned()]).unwrap();
        params.distinguished_name.push(DnType::CommonName, name);
        let pair = KeyPair::generate().unwrap();
        let certificate = params.signed_by(&pair, &self.issuer).unwrap();
        let [certificate_file, key] =
            ["cert", "key"].map(|what| home.join(format!("{name}-by-{}-{what}.pem", self.name)));
        let identity = Identity { certificate: certificate_file, key };
        std::fs::write(&identity.certificate, certificate.pem()).unwrap();
        std::fs::write(&identity.key, pair.serialize_pem()).unwrap();
        identity
    }
}

#[test]
fn an_encrypted_link_asks_both_ends_for_their_certificates() {
    let site = Site::new();
    let home = site.home.path();
    let [ours, foreign] = ["ours", "foreign"].map(|name| Authority::new(home, name));
    let settings = ServerSettings {
        listen: vec![format!("tls/localhost:{}", site.port)],
        passwords: None,
        identity: Some(ours.identity(home, "office", "localhost")),
        robots_authority: Some(ours.file.clone()),
        ..site.server()
    };
    let server = Server::open(&settings);
    let of_robot = |name: &str, authority: &Authority, trusted: &Authority| RobotSettings {
        connect: vec![format!("tls/localhost:{}", site.port)],
        password: None,
        authority: Some(trusted.file.clone()),
        identity: Some(authority.identity(home, name, name)),
        ..site.robot(name, "")
    };
    let (_, told) = counter();
    let robot = RobotLink::open(&of_robot("a", &ours, &ours), told.clone()).unwrap();
    assert_eq!(robot.tell(MessageKind::Report, b"encrypted".to_vec()).unwrap(), b"heard encrypted");
    // A certificate of somebody else, a server that somebody else vouches for, and a name that is not that of the certificate.
    let other_name = RobotSettings { robot: "b".to_owned(), ..of_robot("a", &ours, &ours) };
    for settings in [of_robot("b", &foreign, &ours), of_robot("b", &ours, &foreign), other_name] {
        if let Ok(link) = RobotLink::open(&settings, told.clone()) {
            assert!(link.tell(MessageKind::Report, b"false".to_vec()).is_err(), "{settings:?}");
        }
    }
    assert_eq!(server.heard().len(), 1);
}
