//! A limit of connections: whoever is one too many is told so, and one that takes nothing does not hold its place.

use axum::extract::Request;
use axum::http::{HeaderValue, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use axum_server::accept::Accept;
use std::future::{Ready, ready};
use std::io;
use std::sync::Arc;
use std::task::{Context, Poll};
use std::time::Duration;
use tokio::net::TcpStream;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tower_service::Service;

/// Connections that are told at the same time that they are too many; those beyond are closed.
const MAX_TOLD: usize = 32;
/// A connection whose other end takes nothing for this time is closed.
const UNSENT_TIMEOUT: Duration = Duration::from_secs(30);

/// Gives places to connections.
#[derive(Clone)]
pub(crate) struct ConnectionLimit {
    places: Arc<Semaphore>,
    told: Arc<Semaphore>,
}

/// Marks requests of a connection without a place.
#[derive(Clone)]
struct OneTooMany;

impl ConnectionLimit {
    /// So many at the same time.
    pub(crate) fn of(n_connections: usize) -> Self {
        Self { places: Arc::new(Semaphore::new(n_connections)), told: Arc::new(Semaphore::new(MAX_TOLD)) }
    }
}

impl<S> Accept<TcpStream, S> for ConnectionLimit {
    type Stream = TcpStream;
    type Service = OfConnection<S>;
    type Future = Ready<io::Result<(TcpStream, OfConnection<S>)>>;

    fn accept(&self, stream: TcpStream, service: S) -> Self::Future {
        let milliseconds = UNSENT_TIMEOUT.as_millis() as u32;
        if let Err(why) = rustix::net::sockopt::set_tcp_user_timeout(&stream, milliseconds) {
            return ready(Err(why.into()));
        }
        let (place, is_one_too_many) = match Arc::clone(&self.places).try_acquire_owned() {
            Ok(place) => (Some(place), false),
            Err(_) => (Arc::clone(&self.told).try_acquire_owned().ok(), true),
        };
        let taken = place.ok_or_else(|| io::Error::other("there are too many connections"));
        ready(taken.map(|place| (stream, OfConnection { service, is_one_too_many, _place: Arc::new(place) })))
    }
}

/// The service of a connection, which holds its place.
#[derive(Clone)]
pub(crate) struct OfConnection<S> {
    service: S,
    is_one_too_many: bool,
    _place: Arc<OwnedSemaphorePermit>,
}

impl<S: Service<axum::http::Request<B>>, B> Service<axum::http::Request<B>> for OfConnection<S> {
    type Response = S::Response;
    type Error = S::Error;
    type Future = S::Future;

    fn poll_ready(&mut self, context: &mut Context<'_>) -> Poll<Result<(), S::Error>> {
        self.service.poll_ready(context)
    }

    fn call(&mut self, mut request: axum::http::Request<B>) -> S::Future {
        if self.is_one_too_many {
            request.extensions_mut().insert(OneTooMany);
        }
        self.service.call(request)
    }
}

/// Answers whoever has no place, and closes the connection.
pub async fn tell_one_too_many(request: Request, next: Next) -> Response {
    if request.extensions().get::<OneTooMany>().is_none() {
        return next.run(request).await;
    }
    let headers = [
        (header::CONNECTION, HeaderValue::from_static("close")),
        (header::RETRY_AFTER, HeaderValue::from_static("10")),
        (header::CONTENT_TYPE, HeaderValue::from_static("text/plain; charset=utf-8")),
    ];
    let text = "there are too many connections: try again when somebody has left";
    (StatusCode::SERVICE_UNAVAILABLE, headers, text).into_response()
}
