//! Facts of ifc-ingest.

use crate::request::Published;
use crate::requests::Revision;
use crate::setting::SettingInForce;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// A file of a site.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct ModelFile {
    /// Where it was read from.
    pub path: PathBuf,
    /// sha256 of the bytes that are in force, in hexadecimal; null before it was read.
    pub sha256: Option<String>,
}

/// What the cache of meshes was good for when files were read last.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct MeshFacts {
    /// Bodies and cuts that were taken from the cache, because all that they are made of is as it was.
    pub found: u64,
    /// Bodies and cuts that were made.
    pub made: u64,
    /// Bytes of the cache, for the next revision.
    pub bytes: u64,
}

/// Facts of ifc-ingest.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct IngestFacts {
    /// The files of the site that is published, or that is to be read.
    pub models: Vec<ModelFile>,
    /// The site that is published.
    pub site: Published,
    /// Counts the changes of the map frame; 0 for none.
    pub frame_epoch: u64,
    /// The revision that waits for an operator.
    pub waiting: Option<Revision>,
    /// Where the models come from; `None` before the first site.
    pub setting: Option<SettingInForce>,
    /// Meshes of the files that were read last; `None` before the first.
    pub meshes: Option<MeshFacts>,
}
