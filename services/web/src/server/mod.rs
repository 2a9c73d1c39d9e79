//! The HTTP server: the page, its documents, live events, control.
//!
//! Requests name dates, storeys and hashes, and never a file. Everything is read-only but `data/control`, which only a site that
//! allows it has.

mod access;
mod compression;
mod connections;
mod control;
mod events;
mod headers;
mod paths;
mod request_body;
mod served;

pub(crate) use access::Access;
pub(crate) use served::{MAX_VIEWERS, Served};

use crate::page::{FILES, INDEX, PageFile};
use crate::question::Question;
use crate::source::{Bytes, ContentName, SourceError};
use access::Door;
use axum::Router;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode, Uri, header};
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum_server::tls_rustls::RustlsAcceptor;
use axum_server::tls_rustls::RustlsConfig;
use connections::ConnectionLimit;
use headers::{Caching, document, not_found};
use hyper_util::rt::TokioTimer;
use input_files::{MAX_CONFIGURATION_BYTES, read_regular_file};
use request_body::REQUEST_TIMEOUT;
use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use tokio::runtime::Runtime;

/// Requests that are worked on at the same time; others wait.
const N_WORKERS: usize = 4;
/// Interval at which an idle connection of HTTP/2 is asked whether its other end is there.
const PING_INTERVAL: Duration = Duration::from_secs(20);
/// Connections at the same time: six, which a browser opens, for each viewer, and some.
const MAX_CONNECTIONS: usize = 400;

/// Where and how to serve.
#[derive(Debug, Clone)]
pub(crate) struct ServerSettings {
    /// Address and port; port 0 takes a free one.
    pub(crate) listen: SocketAddr,
    /// Certificate and private key, PEM files.
    pub(crate) tls: Option<(PathBuf, PathBuf)>,
    /// Connections at the same time.
    pub(crate) n_connections: usize,
}

impl ServerSettings {
    /// For as many connections as its viewers need.
    pub(crate) fn of(listen: SocketAddr, tls: Option<(PathBuf, PathBuf)>) -> Self {
        Self { listen, tls, n_connections: MAX_CONNECTIONS }
    }
}

/// A server that listens.
pub(crate) struct Server {
    listener: TcpListener,
    settings: ServerSettings,
    served: Served,
    runtime: Runtime,
    tls: Option<RustlsConfig>,
}

/// Why nothing can be served.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ServeError {
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
fn read_pem(path: &std::path::Path) -> Result<Vec<u8>, ServeError> {
    let failed = |source| ServeError::Pem { path: path.to_owned(), source };
    read_regular_file(path, MAX_CONFIGURATION_BYTES).map_err(failed)
}

impl Server {
    /// Listens.
    ///
    /// # Errors
    /// An address that cannot be had, a certificate that cannot be used, a machine that gives no threads.
    pub(crate) fn bind(settings: ServerSettings, served: Served) -> Result<Self, ServeError> {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .max_blocking_threads(N_WORKERS)
            .thread_name("web")
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
        Ok(Self { listener, settings, served, runtime, tls })
    }

    /// The address of the page.
    pub(crate) fn url(&self) -> String {
        let address = self.listener.local_addr().unwrap_or(self.settings.listen);
        let scheme = if self.tls.is_some() { "https" } else { "http" };
        format!("{scheme}://{address}/")
    }

    /// Serves until the process ends.
    ///
    /// # Errors
    /// The listener is of no use.
    pub(crate) fn run(self) -> Result<(), ServeError> {
        let Self { listener, settings, served, runtime, tls } = self;
        let limit = ConnectionLimit::of(settings.n_connections);
        let service = router(served, tls.is_some()).into_make_service_with_connect_info::<SocketAddr>();
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

/// All paths.
pub(crate) fn router(served: Served, is_encrypted: bool) -> Router {
    let mut router = Router::new().route("/", get(|headers: HeaderMap| page_file(headers, INDEX)));
    for file in FILES {
        router = router.route(&format!("/{}", file.path), get(move |headers: HeaderMap| page_file(headers, file)));
    }
    let door = Door { access: Arc::clone(&served.access), is_encrypted };
    router
        .route("/data/site.json", get(site))
        .route("/data/calendar.json", get(calendar))
        .route("/data/dates/{file}", get(date))
        .route("/data/tasks.json", get(tasks))
        .route("/data/summary/{file}", get(summary))
        .route("/data/tiles/{storey}/{layer}/{name}/{level}/{column}/{row}", get(tile))
        .route("/data/models/{file}", get(model))
        .route("/data/room/{room}", get(about_room))
        .route("/data/door/{door}", get(about_door))
        .route("/data/way/{from}/{to}", get(about_way))
        .route("/data/slam/{file}", get(slam_picture))
        .route("/data/fleet.json", get(fleet))
        .route("/data/events", get(events::events))
        .route("/data/control/date", post(control::set_date))
        .route("/data/control/confirm", post(control::confirm))
        .fallback(|_: Uri| async { not_found() })
        .layer(middleware::from_fn(request_body::read_whole))
        .layer(middleware::from_fn_with_state(door, access::check))
        .layer(middleware::from_fn(connections::tell_one_too_many))
        .layer(middleware::from_fn(headers::with_security_headers))
        .with_state(served)
}

async fn page_file(headers: HeaderMap, file: PageFile) -> Response {
    answer(headers, file.media_type, Caching::Checked, move || Ok(Some(Bytes::from(file.bytes)))).await
}

async fn site(State(served): State<Served>, headers: HeaderMap) -> Response {
    answer(headers, JSON, Caching::Checked, move || served.source.site().map(Some)).await
}

async fn calendar(State(served): State<Served>, headers: HeaderMap) -> Response {
    answer(headers, JSON, Caching::Checked, move || served.source.calendar().map(Some)).await
}

async fn date(State(served): State<Served>, Path(file): Path<String>, headers: HeaderMap) -> Response {
    let Some(key) = file.strip_suffix(".json").map(str::to_owned) else { return not_found() };
    answer(headers, JSON, Caching::Checked, move || served.source.date(&key)).await
}

async fn tasks(State(served): State<Served>, headers: HeaderMap) -> Response {
    answer(headers, JSON, Caching::Checked, move || served.source.tasks().map(Some)).await
}

async fn summary(State(served): State<Served>, Path(file): Path<String>, headers: HeaderMap) -> Response {
    let Some(key) = file.strip_suffix(".json").map(str::to_owned) else { return not_found() };
    answer(headers, JSON, Caching::Checked, move || served.source.summary(&key)).await
}

async fn tile(
    State(served): State<Served>,
    Path(path): Path<(u32, String, String, u32, u32, String)>,
    headers: HeaderMap,
) -> Response {
    let Some(address) = paths::tile_address(path) else { return not_found() };
    answer(headers, PNG, Caching::Forever, move || served.source.tile(&address)).await
}

async fn model(State(served): State<Served>, Path(file): Path<String>, headers: HeaderMap) -> Response {
    let Some(name) = file.strip_suffix(".glb").and_then(ContentName::parse) else { return not_found() };
    answer(headers, "model/gltf-binary", Caching::Forever, move || served.source.model(&name)).await
}

async fn about_room(State(served): State<Served>, Path(room): Path<String>, headers: HeaderMap) -> Response {
    asked(served, headers, Question::Room(room)).await
}

async fn about_door(State(served): State<Served>, Path(door): Path<String>, headers: HeaderMap) -> Response {
    asked(served, headers, Question::Door(door)).await
}

async fn about_way(State(served): State<Served>, Path(ends): Path<[String; 2]>, headers: HeaderMap) -> Response {
    asked(served, headers, Question::Way(ends)).await
}

async fn asked(served: Served, headers: HeaderMap, question: Question) -> Response {
    if !question.is_short() {
        return (StatusCode::URI_TOO_LONG, "no room, door or point has such a long name").into_response();
    }
    answer(headers, JSON, Caching::Checked, move || served.source.answer(&question).map(Some)).await
}

async fn slam_picture(State(served): State<Served>, Path(file): Path<String>, headers: HeaderMap) -> Response {
    let Some(name) = file.strip_suffix(".png").and_then(ContentName::parse) else { return not_found() };
    let Some(live) = served.live else { return not_found() };
    answer(headers, PNG, Caching::Forever, move || Ok(live.slam_picture(&name))).await
}

async fn fleet(State(served): State<Served>, headers: HeaderMap) -> Response {
    let Some(live) = served.live else { return not_found() };
    let made = tokio::task::spawn_blocking(move || live.fleet()).await;
    match made {
        Ok(Ok(Some(bytes))) => document(&headers, &bytes, JSON, Caching::Checked),
        Ok(Ok(None)) => not_found(),
        Ok(Err(why)) => (StatusCode::SERVICE_UNAVAILABLE, daemon::chain(why.as_ref())).into_response(),
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "the work was given up").into_response(),
    }
}

const JSON: &str = "application/json";
const PNG: &str = "image/png";

/// Makes an answer on a thread for work that takes its time.
async fn answer(
    headers: HeaderMap,
    media_type: &'static str,
    caching: Caching,
    make: impl FnOnce() -> Result<Option<Bytes>, SourceError> + Send + 'static,
) -> Response {
    let made = tokio::task::spawn_blocking(move || {
        let made = make();
        made.map(|bytes| bytes.map(|bytes| document(&headers, &bytes, media_type, caching)))
    });
    match made.await {
        Ok(Ok(Some(document))) => document,
        Ok(Ok(None)) => not_found(),
        Ok(Err(why @ SourceError::NotYet)) => (StatusCode::SERVICE_UNAVAILABLE, why.to_string()).into_response(),
        Ok(Err(why @ (SourceError::Unknown(_) | SourceError::NotHeld { .. }))) => {
            (StatusCode::NOT_FOUND, why.to_string()).into_response()
        }
        Ok(Err(why @ SourceError::Changed { .. })) => (StatusCode::CONFLICT, why.to_string()).into_response(),
        Ok(Err(why)) => {
            tracing::error!(service = "groundplan-web", error = daemon::chain(&why), "a document cannot be made");
            (
                StatusCode::INTERNAL_SERVER_ERROR,
                [(header::CONTENT_TYPE, "text/plain; charset=utf-8")],
                daemon::chain(&why),
            )
                .into_response()
        }
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "the work was given up").into_response(),
    }
}

#[cfg(test)]
mod tests;
