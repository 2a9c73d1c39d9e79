//! State of the request handlers: documents, the running site, admission, places of viewers.

use crate::live::LiveSite;
use crate::source::Source;
use site_http::Access;
use std::sync::Arc;
use tokio::sync::Semaphore;

/// What is served.
#[derive(Clone)]
pub(crate) struct Served {
    /// The documents.
    pub(crate) source: Arc<dyn Source>,
    /// The running site, if it is one.
    pub(crate) live: Option<Arc<dyn LiveSite>>,
    /// Who may look.
    pub(crate) access: Arc<Access>,
    /// Places of viewers that follow events.
    pub(crate) viewers: Arc<Semaphore>,
}

/// Viewers that follow events at the same time.
pub(crate) const MAX_VIEWERS: usize = 64;
