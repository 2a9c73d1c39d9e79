//! `fresh`: the file by which consumers see whether the maps beside it may be used.

use crate::date_argument;
use jiff::{Timestamp, Unit};
use schemars::JsonSchema;
use serde::Serialize;
use site_view::{Freshness, MapState};
use std::collections::BTreeSet;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

/// The file `fresh` beside the link `current`. Maps of a storey may be used while the file is there, is younger than 3 s,
/// has the state `fresh`, and does not list the storey.
#[derive(Debug, Serialize, JsonSchema)]
struct FreshDocument {
    /// 1.
    version: u32,
    state: FreshState,
    /// Why the maps are stale; null if they are fresh.
    reason: Option<String>,
    /// When that was found, in UTC (RFC 3339); the file is replaced about once a second while the maps are fresh.
    checked_at: String,
    /// The epoch that `current` names; null before the first.
    epoch: Option<u64>,
    /// Plan time of the daemons; null if everything is built.
    plan_time: Option<String>,
    /// When the schedule changes next, in plan time; null if it does not.
    valid_until: Option<String>,
    /// Indices of map storeys whose maps are outdated although the others are fresh: the new ones are being written.
    outdated_storeys: BTreeSet<u32>,
}

#[derive(Debug, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
enum FreshState {
    /// The maps are those that the daemons hold.
    Fresh,
    /// They are not, or it is unknown.
    Stale,
}

/// The file.
pub(super) struct FreshFile {
    path: PathBuf,
}

impl FreshFile {
    /// Beside the link.
    pub(super) fn beside(link: &Path) -> Self {
        Self { path: link.with_file_name("fresh") }
    }

    /// Replaces the file by what is known of the maps; what is unknown leaves it to its age.
    ///
    /// # Errors
    /// The file system refuses; then the file is removed, because an older one is wrong.
    pub(super) fn write(&self, freshness: &Freshness, state: &MapState) -> io::Result<()> {
        let (state, reason, outdated_storeys) = match state {
            MapState::Unknown => return Ok(()),
            MapState::Fresh { outdated_storeys } => (FreshState::Fresh, None, outdated_storeys.clone()),
            MapState::Stale { reason } => (FreshState::Stale, Some(reason.clone()), BTreeSet::new()),
        };
        let now = Timestamp::now();
        let head = freshness.schedule_state();
        let document = FreshDocument {
            version: 1,
            state,
            reason,
            checked_at: now.round(Unit::Millisecond).unwrap_or(now).to_string(),
            epoch: freshness.maps().map(|maps| maps.epoch),
            plan_time: head.and_then(|head| date_argument::optional_text(head.plan_time_s)),
            valid_until: head.and_then(|head| date_argument::optional_text(head.valid_until_s)),
            outdated_storeys,
        };
        let text = serde_json::to_string_pretty(&document)? + "\n";
        let replaced = daemon::replace_file(&self.path, text.as_bytes());
        if replaced.is_err() {
            let _ = fs::remove_file(&self.path);
        }
        replaced
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shipped_schema::assert_shipped_schema;

    #[test]
    fn the_shipped_schema_is_that_of_the_document() {
        assert_shipped_schema("fresh", &schemars::schema_for!(FreshDocument));
    }

    #[test]
    fn what_is_unknown_leaves_the_file_to_its_age_and_what_is_stale_replaces_it() {
        let home = tempfile::tempdir().unwrap();
        let (file, freshness) = (FreshFile::beside(&home.path().join("current")), Freshness::default());
        let read = || fs::read_to_string(home.path().join("fresh")).unwrap();
        let fresh = MapState::Fresh { outdated_storeys: [3].into() };
        file.write(&freshness, &fresh).unwrap();
        let first: serde_json::Value = serde_json::from_str(&read()).unwrap();
        assert_eq!((&first["state"], &first["outdated_storeys"]), (&"fresh".into(), &serde_json::json!([3])));
        let before = read();
        file.write(&freshness, &MapState::Unknown).unwrap();
        assert_eq!(read(), before);
        file.write(&freshness, &MapState::Stale { reason: "there is no bus".to_owned() }).unwrap();
        let last: serde_json::Value = serde_json::from_str(&read()).unwrap();
        assert_eq!((&last["state"], &last["reason"]), (&"stale".into(), &"there is no bus".into()));
        assert_eq!(fs::read_dir(home.path()).unwrap().count(), 1, "nothing is left beside it");
    }
}
