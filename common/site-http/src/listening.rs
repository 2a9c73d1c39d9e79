//! The server of a daemon: where its address cannot be had it is tried again, and the daemon goes on without it.

use crate::server::{ServeError, Server, ServerSettings};
use axum::Router;
use daemon::{Failure, chain};
use std::thread::JoinHandle;
use tracing::{info, warn};

/// Who listens for what, in the log and in errors.
#[derive(Debug, Clone, Copy)]
pub struct ListeningFor {
    /// Name of the daemon.
    pub service: &'static str,
    /// What there is not while it does not listen: `page`.
    pub what: &'static str,
}

/// Listens, or says why it does not.
pub struct Listening {
    whose: ListeningFor,
    settings: ServerSettings,
    router: Router,
    server: Option<(String, JoinHandle<Result<(), ServeError>>)>,
    why_not: Option<String>,
}

impl Listening {
    /// Listens for the first time.
    pub fn of(whose: ListeningFor, settings: ServerSettings, router: Router) -> Self {
        let mut listening = Self { whose, settings, router, server: None, why_not: None };
        listening.keep_up();
        listening
    }

    /// Listens if it does not; to be called every now and then.
    pub fn keep_up(&mut self) {
        let ListeningFor { service, what } = self.whose;
        if self.server.as_ref().is_some_and(|(_, thread)| !thread.is_finished()) {
            return;
        }
        let ended = self.server.take().map(|(_, thread)| thread.join());
        let why_ended = match ended {
            Some(Ok(Err(why))) => Some(chain(&why)),
            Some(Err(_)) => Some("the server panicked".to_owned()),
            Some(Ok(Ok(()))) | None => None,
        };
        match self.start() {
            Ok((url, thread)) => {
                info!(service, url, "it listens");
                (self.server, self.why_not) = (Some((url, thread)), None);
            }
            Err(why) => {
                let why = format!("no {what}: {}; it is tried again each second", chain(why.as_ref()));
                if self.why_not.as_ref() != Some(&why) {
                    warn!(service, error = why, "it does not listen");
                }
                self.why_not = Some(why);
            }
        }
        if let Some(error) = why_ended {
            warn!(service, error, "the server ended, and is started again");
        }
    }

    /// Its address; `None` while it does not listen.
    pub fn url(&self) -> Option<&str> {
        self.server.as_ref().map(|(url, _)| url.as_str())
    }

    /// Why it does not listen.
    pub fn why_not(&self) -> Option<&str> {
        self.why_not.as_deref()
    }

    fn start(&self) -> Result<(String, JoinHandle<Result<(), ServeError>>), Failure> {
        let server = Server::bind(self.settings.clone(), self.router.clone())?;
        let url = server.url();
        let thread = std::thread::Builder::new().name("http-server".to_owned()).spawn(move || server.run())?;
        Ok((url, thread))
    }
}
