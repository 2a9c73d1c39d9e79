//! Facts of groundplan-ask.

use serde::{Deserialize, Serialize};

/// Facts of groundplan-ask.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default)]
pub struct AskFacts {
    /// Where it answers; `None` without a server that listens.
    pub url: Option<String>,
    /// Questions that it has answered or refused since it started.
    pub questions: u64,
}
