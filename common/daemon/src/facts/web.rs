//! Facts of groundplan-web.

use serde::{Deserialize, Serialize};

/// Facts of groundplan-web.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct WebFacts {
    /// Where the page is; `None` without a server that listens.
    pub url: Option<String>,
    /// Pages that are open.
    pub viewers: usize,
}
