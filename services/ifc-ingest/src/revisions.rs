//! Revisions of a site: the one in force, and one that was refused or waits for an operator; they survive the daemon.

use crate::model_files::names_of;
use daemon::{FileStamp, Revision, SettingInForce, SettingKey, SettingSource, Standing};
use messages::ContentHash;
use serde::{Deserialize, Serialize};
use std::path::PathBuf;

/// The revisions of a site, as they are on disk.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Revisions {
    /// Files of the revision in force, or of the first one that is to be.
    pub(crate) models: Vec<PathBuf>,
    /// What they looked like when they were read; empty while no revision is in force.
    pub(crate) stamps: Vec<Option<FileStamp>>,
    /// What they looked like when they were last read, whatever came of it: files that look different are read again.
    pub(crate) seen: Option<Vec<Option<FileStamp>>>,
    /// Content hash of the site in force; `None` before the first.
    pub(crate) site_hash: Option<ContentHash>,
    /// Epoch of the map frame in force: another frame has a higher one, also if its file is lost.
    pub(crate) frame_epoch: u32,
    /// Files that the configuration named when the files above were chosen.
    pub(crate) configured: Vec<PathBuf>,
    /// Where the files above come from; `None` before the first site.
    pub(crate) setting: Option<SettingInForce>,
    /// The revision that was refused last.
    pub(crate) refused: Option<Refused>,
    /// The revision that waits for an operator.
    pub(crate) waiting: Option<Waiting>,
}

/// A revision that cannot take effect.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Refused {
    /// Its files.
    pub(crate) models: Vec<PathBuf>,
    /// What they looked like: when they look different they are read again.
    pub(crate) stamps: Vec<Option<FileStamp>>,
    /// Why.
    pub(crate) why: String,
}

/// A revision that takes effect when an operator confirms it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Waiting {
    /// Its files, and how it differs from the site in force.
    pub(crate) revision: Revision,
}

impl Refused {
    /// True if another refusal tells nothing new: of the same files for the same reason.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        self.models == other.models && self.why == other.why
    }
}

impl Revisions {
    /// True if no file looks different from when it was read last.
    pub(crate) fn are_seen(&self, now: &[Option<FileStamp>]) -> bool {
        self.seen.as_deref().unwrap_or(&self.stamps) == now
    }

    /// True if files are the ones that are in force: to read them again is no revision.
    pub(crate) fn are_in_force(&self, models: &[PathBuf], stamps: &[Option<FileStamp>]) -> bool {
        self.models == models && self.stamps == stamps
    }

    /// The files have been read: they are not read again before they change.
    pub(crate) fn see(&mut self, models: &[PathBuf], stamps: &[Option<FileStamp>]) {
        if self.models == models {
            self.seen = Some(stamps.to_vec());
        }
    }

    /// The refused and the waiting revision that outlive this site's coming into force: where it is in force already, and its
    /// files were only read again.
    pub(crate) fn unaffected_by(
        &self,
        models: &[PathBuf],
        site_hash: ContentHash,
    ) -> (Option<Refused>, Option<Waiting>) {
        if self.models != models || self.site_hash != Some(site_hash) {
            return (None, None);
        }
        let refused = self.refused.clone().filter(|refused| refused.models != models);
        let waiting = self.waiting.clone().filter(|waiting| waiting.revision.models != models);
        (refused, waiting)
    }

    /// Where these files come from once they are in force: those that are in force already come from where they came from.
    pub(crate) fn setting_of(&self, models: &[PathBuf], by_uid: Option<u32>) -> SettingInForce {
        if let Some(setting) = self.setting.as_ref().filter(|_| self.models == models) {
            return setting.clone();
        }
        let is_configured = self.configured == models;
        let (source, by_uid) =
            if is_configured { (SettingSource::SiteToml, None) } else { (SettingSource::Command, by_uid) };
        SettingInForce::now(SettingKey::Models, names_of(models), source, by_uid)
    }

    /// True before the first site.
    pub(crate) fn is_without_site(&self) -> bool {
        self.stamps.is_empty()
    }

    /// Why files cannot be used, and what stays in force.
    pub(crate) fn stays(&self, why: &str) -> String {
        if self.is_without_site() {
            format!("{why}; there is no site yet")
        } else {
            format!("{why}; the site of {} stays in force", names_of(&self.models))
        }
    }

    /// What an operator has to know of revisions that are not in force.
    pub(crate) fn standing(&self) -> Standing {
        let error = self.refused.as_ref().map(|refused| self.stays(&refused.why));
        let warning = self.waiting.as_ref().map(|waiting| {
            let Revision { models, comparison, .. } = &waiting.revision;
            let (names, why) = (names_of(models), comparison.objections.join("; "));
            self.stays(&format!("the revision {names} waits for `groundplan confirm` ({why})"))
        });
        Standing { error, warning }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_that_were_tried_are_not_tried_again_and_those_in_force_keep_their_stamps() {
        let models = vec![PathBuf::from("/a.ifc")];
        let stamp = |n: u64| -> Vec<Option<FileStamp>> {
            serde_json::from_str(&format!(r#"[{{"length":{n},"modified_ns":1,"changed_ns":1,"inode":1}}]"#)).unwrap()
        };
        let mut revisions = Revisions { models: models.clone(), stamps: stamp(1), ..Revisions::default() };
        assert!(revisions.are_seen(&stamp(1)) && !revisions.are_seen(&stamp(2)));
        revisions.see(&[PathBuf::from("/b.ifc")], &stamp(9));
        assert!(revisions.are_seen(&stamp(1)), "another file was read");
        revisions.see(&models, &stamp(2));
        assert!(revisions.are_seen(&stamp(2)) && !revisions.are_seen(&stamp(1)));
        assert!(revisions.are_in_force(&models, &stamp(1)) && !revisions.are_in_force(&models, &stamp(2)));
    }

    #[test]
    fn files_come_from_the_configuration_or_from_the_command_that_chose_others() {
        let [a, b] = ["/a.ifc", "/b.ifc"].map(|path| vec![PathBuf::from(path)]);
        let mut revisions = Revisions { models: a.clone(), configured: a.clone(), ..Revisions::default() };
        let origin = |setting: &SettingInForce| (setting.source, setting.by_uid);
        assert_eq!(origin(&revisions.setting_of(&a, Some(7))), (SettingSource::SiteToml, None));
        let command = revisions.setting_of(&b, Some(7));
        assert_eq!(origin(&command), (SettingSource::Command, Some(7)));
        (revisions.models, revisions.setting) = (b.clone(), Some(command.clone()));
        assert_eq!(revisions.setting_of(&b, Some(8)), command, "they are only read again");
        assert_eq!(origin(&revisions.setting_of(&a, None)), (SettingSource::SiteToml, None));
    }

    #[test]
    fn revisions_of_another_layout_are_not_read() {
        let whole = serde_json::to_value(Revisions::default()).unwrap();
        let read = |of: &serde_json::Value| serde_json::from_value::<Revisions>(of.clone());
        assert_eq!(read(&whole).unwrap(), Revisions::default());
        let (mut more, mut less) = (whole.clone(), whole);
        more["sources"] = "/a.ifc".into();
        less.as_object_mut().unwrap().remove("frame_epoch");
        assert!(read(&more).is_err() && read(&less).is_err());
    }
}
