//! The server of a running site: where its address cannot be had it is tried again, and the daemons go on without a page.

use crate::server::{ServeError, Served, Server, ServerSettings};
use daemon::{Failure, chain};
use std::thread::JoinHandle;
use tracing::{info, warn};

/// Listens, or says why it does not.
pub(super) struct Listening {
    settings: ServerSettings,
    served: Served,
    server: Option<(String, JoinHandle<Result<(), ServeError>>)>,
    why_not: Option<String>,
}

impl Listening {
    /// Listens for the first time.
    pub(super) fn of(settings: ServerSettings, served: Served) -> Self {
        let mut listening = Self { settings, served, server: None, why_not: None };
        listening.keep_up();
        listening
    }

    /// Listens if it does not; to be called every now and then.
    pub(super) fn keep_up(&mut self) {
        if self.server.as_ref().is_some_and(|(_, thread)| !thread.is_finished()) {
            return;
        }
        let ended = self.server.take().map(|(_, thread)| thread.join());
        let why_ended = match ended {
            Some(Ok(Err(why))) => Some(chain(&why)),
            Some(Err(_)) => Some("the server of the page panicked".to_owned()),
            Some(Ok(Ok(()))) | None => None,
        };
        match self.start() {
            Ok((url, thread)) => {
                info!(service = "groundplan-web", url, "the page is open");
                (self.server, self.why_not) = (Some((url, thread)), None);
            }
            Err(why) => {
                let why = format!("no page: {}; it is tried again each second", chain(why.as_ref()));
                if self.why_not.as_ref() != Some(&why) {
                    warn!(service = "groundplan-web", error = why, "the page is not open");
                }
                self.why_not = Some(why);
            }
        }
        if let Some(error) = why_ended {
            warn!(service = "groundplan-web", error, "the server ended, and is started again");
        }
    }

    /// Where the page is.
    pub(super) fn url(&self) -> Option<&str> {
        self.server.as_ref().map(|(url, _)| url.as_str())
    }

    /// Why there is none.
    pub(super) fn why_not(&self) -> Option<&str> {
        self.why_not.as_deref()
    }

    fn start(&self) -> Result<(String, JoinHandle<Result<(), ServeError>>), Failure> {
        let server = Server::bind(self.settings.clone(), self.served.clone())?;
        let url = server.url();
        let thread = std::thread::Builder::new().name("web-server".to_owned()).spawn(move || server.run())?;
        Ok((url, thread))
    }
}
