//! Requests to ifc-ingest.

use crate::request::{Published, Request};
use bus::Daemon;
use messages::{ContentId, SiteComparison};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// Requests to ifc-ingest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum IngestRequest {
    /// Read these files as the site; without any, read those again that are in force.
    Load {
        /// Absolute paths.
        models: Vec<PathBuf>,
        /// Compare only: nothing changes.
        #[serde(default)]
        dry_run: bool,
        /// The revision takes effect also if an operator had to confirm it.
        #[serde(default)]
        force: bool,
    },
    /// The waiting revision takes effect. One whose files have changed since is compared again.
    Confirm {
        /// What waits as the client has seen it, [`Revision::sha256`]: another one is not confirmed.
        sha256: Vec<ContentId>,
    },
    /// The waiting revision, or the one that was refused last, is forgotten; its files are not read again before they change.
    Discard,
    /// What is in force and what waits; nothing changes.
    GetRevision,
}

/// Answer of ifc-ingest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct IngestAnswer {
    /// The site in force.
    pub site: Published,
    /// What became of the revision.
    pub effect: RevisionEffect,
    /// The revision that waits, or that was asked for.
    pub revision: Option<Revision>,
}

/// What becomes of a revision.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RevisionEffect {
    /// It is in force; or nothing waits.
    InForce,
    /// It waits for an operator: the site before it stays in force.
    Waits,
    /// It was compared only.
    DryRun,
    /// It is forgotten.
    Discarded,
}

/// A revision, compared with the site that was in force before it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Revision {
    /// Absolute paths of its files.
    pub models: Vec<PathBuf>,
    /// sha256 of each file: only what was compared is confirmed.
    pub sha256: Vec<ContentId>,
    /// How it differs, with what an operator has to confirm.
    pub comparison: SiteComparison,
}

impl Request for IngestRequest {
    const DAEMON: Daemon = Daemon::IfcIngest;
    type Answer = IngestAnswer;

    fn may_be_sent_twice(&self) -> bool {
        match self {
            Self::GetRevision => true,
            // The files may be what the daemon died of.
            Self::Load { .. } => false,
            // Where it is in force already, that is the answer.
            Self::Confirm { .. } => true,
            // Another revision may wait by then.
            Self::Discard => false,
        }
    }
}
