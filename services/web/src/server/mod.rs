//! The HTTP server: the page, its documents, live events, control.
//!
//! Requests name dates, storeys and hashes, and never a file. Everything is read-only but `data/control`, which only a site that
//! allows it has.

mod access;
mod control;
mod events;
mod headers;
mod paths;
mod served;

pub(crate) use access::Access;
pub(crate) use served::{MAX_VIEWERS, Served};

use crate::page::{FILES, INDEX, PageFile};
use crate::source::{Bytes, ContentName, SourceError};
use axum::Router;
use axum::extract::{DefaultBodyLimit, Path, State};
use axum::http::{HeaderMap, StatusCode, Uri, header};
use axum::middleware;
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};
use axum_server::tls_rustls::RustlsConfig;
use headers::{Caching, document, not_found};
use std::net::{SocketAddr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;

/// Longest body of a request.
const MAX_REQUEST_BYTES: usize = 4096;
/// Requests that are worked on at the same time; others wait.
const N_WORKERS: usize = 4;
/// Time in which the head of a request has to be there.
const HEAD_TIMEOUT: Duration = Duration::from_secs(10);

/// Where and how to serve.
#[derive(Debug, Clone)]
pub(crate) struct ServerSettings {
    /// Address and port; port 0 takes a free one.
    pub(crate) listen: SocketAddr,
    /// Certificate and private key, PEM files.
    pub(crate) tls: Option<(PathBuf, PathBuf)>,
}

/// A server that listens.
pub(crate) struct Server {
    listener: TcpListener,
    settings: ServerSettings,
    served: Served,
}

/// Why nothing can be served.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ServeError {
    /// The address is taken, or not one of this machine.
    #[error("cannot listen on {address}")]
    Listen {
        /// The address.
        address: SocketAddr,
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

impl Server {
    /// Listens.
    ///
    /// # Errors
    /// An address that cannot be had.
    pub(crate) fn bind(settings: ServerSettings, served: Served) -> Result<Self, ServeError> {
        let listen = |source| ServeError::Listen { address: settings.listen, source };
        let listener = TcpListener::bind(settings.listen).map_err(listen)?;
        listener.set_nonblocking(true).map_err(listen)?;
        Ok(Self { listener, settings, served })
    }

    /// The address of the page.
    pub(crate) fn url(&self) -> String {
        let address = self.listener.local_addr().unwrap_or(self.settings.listen);
        let scheme = if self.settings.tls.is_some() { "https" } else { "http" };
        format!("{scheme}://{address}/")
    }

    /// Serves until the process ends.
    ///
    /// # Errors
    /// A certificate that cannot be used, a machine that gives no threads.
    pub(crate) fn run(self) -> Result<(), ServeError> {
        let runtime = tokio::runtime::Builder::new_multi_thread()
            .worker_threads(1)
            .max_blocking_threads(N_WORKERS)
            .thread_name("web")
            .enable_all()
            .build()
            .map_err(ServeError::Ended)?;
        runtime.block_on(async {
            let service = router(self.served).into_make_service();
            match self.settings.tls {
                None => {
                    let mut server = axum_server::from_tcp(self.listener).map_err(ServeError::Ended)?;
                    server.http_builder().http1().timer(hyper_util_timer()).header_read_timeout(HEAD_TIMEOUT);
                    server.serve(service).await.map_err(ServeError::Ended)
                }
                Some((certificate, key)) => {
                    let config = RustlsConfig::from_pem_file(&certificate, &key).await;
                    let config = config.map_err(|source| ServeError::Certificate { certificate, key, source })?;
                    let mut server = axum_server::from_tcp_rustls(self.listener, config).map_err(ServeError::Ended)?;
                    server.http_builder().http1().timer(hyper_util_timer()).header_read_timeout(HEAD_TIMEOUT);
                    server.serve(service).await.map_err(ServeError::Ended)
                }
            }
        })
    }
}

fn hyper_util_timer() -> hyper_util::rt::TokioTimer {
    hyper_util::rt::TokioTimer::new()
}

/// All paths.
pub(crate) fn router(served: Served) -> Router {
    let mut router = Router::new().route("/", get(|headers: HeaderMap| async move { page_file(&headers, INDEX) }));
    for file in FILES {
        router = router
            .route(&format!("/{}", file.path), get(move |headers: HeaderMap| async move { page_file(&headers, file) }));
    }
    let access = Arc::clone(&served.access);
    router
        .route("/data/site.json", get(site))
        .route("/data/calendar.json", get(calendar))
        .route("/data/dates/{file}", get(date))
        .route("/data/tiles/{storey}/{layer}/{name}/{level}/{column}/{row}", get(tile))
        .route("/data/models/{file}", get(model))
        .route("/data/slam/{file}", get(slam_picture))
        .route("/data/events", get(events::events))
        .route("/data/control/date", post(control::set_date))
        .route("/data/control/confirm", post(control::confirm))
        .fallback(|_: Uri| async { not_found() })
        .layer(DefaultBodyLimit::max(MAX_REQUEST_BYTES))
        .layer(middleware::from_fn_with_state(access, access::check))
        .layer(middleware::from_fn(headers::with_security_headers))
        .with_state(served)
}

fn page_file(headers: &HeaderMap, file: PageFile) -> Response {
    document(headers, Bytes::from(file.bytes), file.media_type, Caching::Checked)
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

async fn tile(
    State(served): State<Served>,
    Path(path): Path<(u32, String, String, u32, u32, String)>,
    headers: HeaderMap,
) -> Response {
    let Some(address) = paths::tile_address(path) else { return not_found() };
    answer(headers, PNG, Caching::Forever, move || served.source.tile(&address)).await
}

async fn model(State(served): State<Served>, Path(file): Path<String>, headers: HeaderMap) -> Response {
    let Some(name) = file.strip_suffix(".glb").and_then(ContentName::of_hash) else { return not_found() };
    answer(headers, "model/gltf-binary", Caching::Forever, move || served.source.model(&name)).await
}

async fn slam_picture(State(served): State<Served>, Path(file): Path<String>, headers: HeaderMap) -> Response {
    let Some(name) = file.strip_suffix(".png").and_then(ContentName::of_hash) else { return not_found() };
    let Some(live) = served.live else { return not_found() };
    answer(headers, PNG, Caching::Forever, move || Ok(live.slam_picture(&name))).await
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
    match tokio::task::spawn_blocking(make).await {
        Ok(Ok(Some(bytes))) => document(&headers, bytes, media_type, caching),
        Ok(Ok(None)) => not_found(),
        Ok(Err(why @ SourceError::NotYet)) => (StatusCode::SERVICE_UNAVAILABLE, why.to_string()).into_response(),
        Ok(Err(why)) => {
            tracing::error!(service = "groundplan-web", error = daemon::chain(&why), "a document cannot be made");
            (StatusCode::INTERNAL_SERVER_ERROR, [(header::CONTENT_TYPE, "text/plain")], daemon::chain(&why))
                .into_response()
        }
        Err(_) => (StatusCode::INTERNAL_SERVER_ERROR, "the work was given up").into_response(),
    }
}

#[cfg(test)]
mod tests;
