//! Facts of ifc-ingest.

use crate::request::Published;
use crate::requests::Revision;
use crate::setting::SettingInForce;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Facts of ifc-ingest.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct IngestFacts {
    /// The files of the site that is published, or that is to be read.
    pub models: Vec<PathBuf>,
    /// The site that is published.
    pub site: Published,
    /// Counts the changes of the map frame; 0 for none.
    pub frame_epoch: u64,
    /// The revision that waits for an operator.
    pub waiting: Option<Revision>,
    /// Where the models come from; `None` before the first site, and for a site that an earlier version chose.
    pub setting: Option<SettingInForce>,
}
