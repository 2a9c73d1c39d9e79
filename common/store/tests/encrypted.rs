//! A store behind a web server that encrypts: whoever the robot was told to trust, and nobody else, is believed.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, DnType, IsCa, KeyPair};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use store::{Credentials, Fetched, Objects, Store};

/// Serves a folder by https, as Python's library does; prints its port.
const SERVER: &str = "
import functools, http.server, ssl, sys
folder, certificate, key = sys.argv[1:]
handler = functools.partial(http.server.SimpleHTTPRequestHandler, directory=folder)
server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), handler)
context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
context.load_cert_chain(certificate, key)
server.socket = context.wrap_socket(server.socket, server_side=True)
print(server.server_address[1], flush=True)
server.serve_forever()
";

struct Server {
    child: Child,
    port: u16,
}

impl Server {
    fn of(folder: &Path, certificate: &Path, key: &Path) -> Self {
        let mut python = Command::new("python3");
        python.args(["-c", SERVER]).arg(folder).arg(certificate).arg(key);
        let mut child = python.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut line = String::new();
        BufReader::new(child.stdout.take().unwrap()).read_line(&mut line).unwrap();
        Self { child, port: line.trim().parse().unwrap() }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn authority(home: &Path, name: &str) -> (CertifiedIssuer<'static, KeyPair>, PathBuf) {
    let mut params = CertificateParams::new(Vec::new()).unwrap();
    params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
    params.distinguished_name.push(DnType::CommonName, name);
    let issuer = CertifiedIssuer::self_signed(params, KeyPair::generate().unwrap()).unwrap();
    let file = home.join(format!("{name}.pem"));
    std::fs::write(&file, issuer.pem()).unwrap();
    (issuer, file)
}

#[test]
fn a_store_is_believed_if_the_authority_of_its_credentials_vouches_for_it() {
    let home = tempfile::tempdir().unwrap();
    let ([(ours, our_file), (_, foreign_file)], folder) =
        (["ours", "foreign"].map(|name| authority(home.path(), name)), home.path().join("store"));
    std::fs::create_dir(&folder).unwrap();
    std::fs::write(folder.join("index"), b"an index").unwrap();
    let pair = KeyPair::generate().unwrap();
    let params = CertificateParams::new(vec!["localhost".to_owned()]).unwrap();
    let certificate = params.signed_by(&pair, &ours).unwrap();
    let [certificate_file, key_file] = ["cert.pem", "key.pem"].map(|name| home.path().join(name));
    std::fs::write(&certificate_file, certificate.pem()).unwrap();
    std::fs::write(&key_file, pair.serialize_pem()).unwrap();
    let server = Server::of(&folder, &certificate_file, &key_file);
    let fetched = |host: &str, authority: Option<&PathBuf>| {
        let credentials = Credentials { authority: authority.cloned(), ..Credentials::default() };
        let store = Store::open_to_read(&format!("https://{host}:{}", server.port), &credentials).unwrap();
        store.fetch_unless("index", None, 1_000)
    };
    let found = fetched("localhost", Some(&our_file)).unwrap();
    assert!(matches!(&found, Fetched::New { bytes, .. } if bytes == b"an index"), "{found:?}");
    // Nobody vouches for it, somebody else does, and it has another name than its certificate.
    for (host, authority) in [("localhost", None), ("localhost", Some(&foreign_file)), ("127.0.0.1", Some(&our_file))] {
        let refused = fetched(host, authority);
        assert!(refused.is_err(), "{host} {authority:?}: {refused:?}");
    }
}
