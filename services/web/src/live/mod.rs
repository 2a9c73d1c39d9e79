//! A site from the running daemons: documents of the newest maps, what changes as events, control.

mod content_names;
mod control;
mod fleet;
mod live_answers;
mod live_documents;
mod overlays;
mod service;
mod shared_site;
mod slam_picture;
mod watchdog;

pub(crate) use service::WebService;

use crate::source::{Bytes, ContentName};
use daemon::Failure;
use std::collections::BTreeMap;
use std::sync::Arc;
use tokio::sync::watch;

/// The newest event of each kind, as JSON.
pub(crate) type Feed = BTreeMap<&'static str, Arc<str>>;

/// What a running site has beside documents.
pub(crate) trait LiveSite: Send + Sync {
    /// Its events.
    fn feed(&self) -> watch::Receiver<Feed>;

    /// The robot's own map as a picture.
    fn slam_picture(&self, name: &ContentName) -> Option<Bytes>;

    /// The robots of the site, as its server knows them; `None` for a site without a link with robots.
    ///
    /// # Errors
    /// A document that cannot be read.
    fn fleet(&self) -> Result<Option<Bytes>, Failure>;

    /// Sets the plan time, as `2024-04-15T08:00:00` at the site; returns when it is on disk.
    ///
    /// # Errors
    /// See [`ControlError`].
    fn set_date(&self, at: &str) -> Result<(), ControlError>;

    /// Confirms that an element is absent.
    ///
    /// # Errors
    /// See [`ControlError`].
    fn confirm(&self, global_id: &str) -> Result<(), ControlError>;
}

/// Why nothing was changed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ControlError {
    /// The site does not allow it.
    #[error("this page may not change anything: allow_control in [web] of the site's configuration allows it")]
    NotAllowed,
    /// The daemon refuses, or does not answer.
    #[error("it cannot be done")]
    Failed(#[source] Failure),
}
