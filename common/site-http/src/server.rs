//! The listener: its address, its limits of time and number, its certificate.

use crate::connections::ConnectionLimit;
use crate::request_body::REQUEST_TIMEOUT;
use axum::Router;
use axum_server::tls_rustls::{RustlsAcceptor, RustlsConfig};
use hyper_util::rt::TokioTimer;
use input_files::{MAX_CONFIGURATION_BYTES, read_regular_file};
use std::net::{SocketAddr, TcpListener};
use std::path::{Path, PathBuf};
use std::time::Duration;
use tokio::runtime::Runtime;

/// Requests that are worked on at the same time; others wait.
const N_WORKERS: usize = 4;
/// Interval at which an idle connection of HTTP/2 is asked whether its other end is there.
const PING_INTERVAL: Duration = Duration::from_secs(20);
/// Connections at the same time: six, which a browser opens, for each of 64 viewers, and some.
pub const MAX_CONNECTIONS: usize = 400;

/// Where and how to serve.
#[derive(Debug, Clone)]
pub struct ServerSettings {
    /// Address and port; port 0 takes a free one.
    pub listen: SocketAddr,
    /// Certificate and private key, PEM files.
    pub tls: Option<(PathBuf, PathBuf)>,
    /// Connections at the same time.
    pub n_connections: usize,
}

impl ServerSettings {
    /// For as many connections as a page and its viewers need.
    pub fn of(listen: SocketAddr, tls: Option<(PathBuf, PathBuf)>) -> Self {
        Self { listen, tls, n_connections: MAX_CONNECTIONS }
    }
}

/// A server that listens.
pub struct Server {
    listener: TcpListener,
    settings: ServerSettings,
    router: Router,
    runtime: Runtime,
    tls: Option<RustlsConfig>,
}

/// Why nothing can be served.
#[derive(Debug, thiserror::Error)]
pub enum ServeError {
    /// The address is taken, or not one of this machine.
    #[error("cannot listen on {address}, which another program may use")]
    Listen {
        /// The address.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
    /// A certificate or key that cannot be read.
    #[error("{} cannot be read", path.display())]
    Pem {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Certificate or key that cannot be used.
    #[error("certificate {} with key {}", certificate.display(), key.display())]
    Certificate {
        /// The certificate.
        certificate: PathBuf,
        /// The key.
        key: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The server ended.
    #[error("the server ended")]
    Ended(#[source] std::io::Error),
}

/// The bytes of a certificate or key.
fn read_pem(path: &Path) -> Result<Vec<u8>, ServeError> {
    let failed = |source| ServeError::Pem { path: path.to_owned(), source };
    read_regular_file(path, MAX_CONFIGURATION_BYTES).map_err(failed)
}

impl Server {
    /// Listens.
    ///
    /// # Errors
    /// An address that cannot be had, a certificate that cannot be used, a machine that gives no threads.
    pub fn bind(settings: ServerSettings, router: Router) -> Result<Self, ServeError> {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .max_blocking_threads(N_WORKERS)
            .thread_name("http")
            .enable_all()
            .build()
            .map_err(ServeError::Ended)?;
        let tls = settings.tls.as_ref().map(|(certificate, key)| {
            let failed =
                |source| ServeError::Certificate { certificate: certificate.clone(), key: key.clone(), source };
            let [chain, secret] = [read_pem(certificate)?, read_pem(key)?];
            runtime.block_on(RustlsConfig::from_pem(chain, secret)).map_err(failed)
        });
        let tls = tls.transpose()?;
        let listen = |source| ServeError::Listen { address: settings.listen, source };
        let listener = TcpListener::bind(settings.listen).map_err(listen)?;
        listener.set_nonblocking(true).map_err(listen)?;
        Ok(Self { listener, settings, router, runtime, tls })
    }

    /// Its address, with a slash at the end.
    pub fn url(&self) -> String {
        let address = self.listener.local_addr().unwrap_or(self.settings.listen);
        let scheme = if self.tls.is_some() { "https" } else { "http" };
        format!("{scheme}://{address}/")
    }

    /// Serves until the process ends.
    ///
    /// # Errors
    /// The listener is of no use.
    pub fn run(self) -> Result<(), ServeError> {
        let Self { listener, settings, router, runtime, tls } = self;
        let limit = ConnectionLimit::of(settings.n_connections);
        let service = router.into_make_service_with_connect_info::<SocketAddr>();
        runtime.block_on(async {
            let server = axum_server::from_tcp(listener).map_err(ServeError::Ended)?;
            match tls {
                None => with_time_limits(server.acceptor(limit)).serve(service).await,
                Some(tls) => {
                    let encrypted = server.acceptor(RustlsAcceptor::new(tls).acceptor(limit));
                    with_time_limits(encrypted).serve(service).await
                }
            }
            .map_err(ServeError::Ended)
        })
    }
}

fn with_time_limits<A>(server: axum_server::Server<SocketAddr, A>) -> axum_server::Server<SocketAddr, A> {
    let mut server = server.first_request_timeout(REQUEST_TIMEOUT);
    server.http_builder().http1().timer(TokioTimer::new()).header_read_timeout(REQUEST_TIMEOUT);
    let http2 = server.http_builder();
    http2.http2().timer(TokioTimer::new()).keep_alive_interval(PING_INTERVAL).keep_alive_timeout(REQUEST_TIMEOUT);
    server
}
