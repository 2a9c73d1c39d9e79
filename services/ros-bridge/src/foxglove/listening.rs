//! A server that listens, and the limit of its clients.
//!
//! The server itself accepts as many connections as the process may have files, and no more for ever after that; the bus needs
//! files too. Therefore connections are counted, and where there are too many, all of them are closed.

use super::latch::Latches;
use super::world_model::WorldModel;
use daemon::chain;
use foxglove::{Context, FoxgloveError, WebSocketServer, WebSocketServerHandle};
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;
use tokio::runtime::{Handle, Runtime};
use tokio::task::JoinHandle;
use tracing::info;

/// Messages that wait for a client: two sets of maps, and diagnostics for the seconds that a slow network needs for them.
const MAX_WAITING: usize = 48;
/// Connections at once, those included that do not speak yet.
pub(super) const MAX_CLIENTS: usize = 64;
/// Interval between two counts: shorter than what a thousand connections, the files of many processes, take.
const COUNT_INTERVAL: Duration = Duration::from_millis(20);

/// Why Foxglove is not served.
#[derive(Debug, thiserror::Error)]
pub(super) enum ServeError {
    #[error("Foxglove cannot be served at {address}")]
    Bind { address: SocketAddr, source: FoxgloveError },
    #[error(
        "Foxglove was served at {address} to more than {MAX_CLIENTS} clients, or to one that could not be accepted"
    )]
    Clients { address: SocketAddr },
}

/// A server that listens.
pub(super) struct Listening {
    address: SocketAddr,
    limit: JoinHandle<()>,
}

impl Listening {
    /// Begins to listen, on the threads of a runtime that has nothing else to do.
    ///
    /// # Errors
    /// An address that is taken, or none of this machine.
    pub(super) fn begin(
        asked: SocketAddr,
        runtime: &Runtime,
        context: &Arc<Context>,
        latches: Arc<Latches>,
        world: &Arc<WorldModel>,
    ) -> Result<Self, ServeError> {
        let host = match asked {
            SocketAddr::V4(address) => address.ip().to_string(),
            SocketAddr::V6(address) => format!("[{}]", address.ip()),
        };
        let world = Arc::clone(world);
        let server = WebSocketServer::new()
            .context(context)
            .name("groundplan")
            .bind(host, asked.port())
            .message_backlog_size(MAX_WAITING)
            .listener(latches)
            .fetch_asset_handler_blocking_fn(move |_, url| world.fetch(&url).map_err(|why| chain(why.as_ref())));
        // The server takes the runtime in which it is started; it listens when this returns.
        let server = runtime.block_on(server.start()).map_err(|source| ServeError::Bind { address: asked, source })?;
        let address = SocketAddr::new(asked.ip(), server.port());
        info!(service = "ros-bridge", %address, "Foxglove is served");
        Ok(Self { address, limit: runtime.spawn(limit(server)) })
    }

    /// Where it listens.
    pub(super) fn address(&self) -> SocketAddr {
        self.address
    }

    /// Why it does not listen any more.
    pub(super) fn end(&self) -> Option<ServeError> {
        self.limit.is_finished().then_some(ServeError::Clients { address: self.address })
    }
}

/// Stops a server that has too many clients, or accepts none any more.
async fn limit(server: WebSocketServerHandle) {
    let mut interval = tokio::time::interval(COUNT_INTERVAL);
    loop {
        interval.tick().await;
        // This task, one that accepts, and one for each client.
        let n_tasks = Handle::current().metrics().num_alive_tasks();
        if !(2..=2 + MAX_CLIENTS).contains(&n_tasks) {
            drop(server.stop());
            return;
        }
    }
}
