//! The options of waypoints in force, kept with the content of their file.

use daemon::{Configured, Failure, FileText, OlderSetting, Setting, SettingKey, SiteConfig, StateFile};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use tracing::warn;
use waypoints::MissionPlanOptions;

/// What the files are called in errors.
const WHAT: &str = "options of waypoints";
/// The requested options in the state of earlier versions.
const OLDER_FILE: &str = "waypoints.json";

/// What waypoints are planned: a file of options, and what a command set beside them.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WaypointOptions {
    /// The options; without a file, the default ones.
    pub(crate) file: Option<FileText>,
    /// Only these spaces; without any, those of the options.
    pub(crate) spaces: Vec<String>,
    /// Only what was built since this plan time, civil seconds since 1970; without one, that of the options.
    pub(crate) changed_since_s: Option<i64>,
}

impl WaypointOptions {
    /// Those of a command; without a file, with the options that `site.toml` names.
    ///
    /// # Errors
    /// Options that cannot be used.
    pub(crate) fn of_command(
        file: Option<FileText>,
        spaces: Vec<String>,
        changed_since_s: Option<i64>,
        in_site_toml: &Self,
    ) -> Result<Self, Failure> {
        if let Some(file) = &file {
            file.parse(WHAT, MissionPlanOptions::parse)?;
        }
        let file = file.or_else(|| in_site_toml.file.clone());
        Ok(Self { file, spaces, changed_since_s })
    }

    /// The options for planning.
    ///
    /// # Errors
    /// A file that was kept and is none of this version.
    pub(crate) fn parse(&self) -> Result<MissionPlanOptions, Failure> {
        let parse = |file: &FileText| file.parse(WHAT, MissionPlanOptions::parse);
        let mut options = self.file.as_ref().map_or_else(|| Ok(MissionPlanOptions::default()), parse)?;
        if !self.spaces.is_empty() {
            options.spaces.clone_from(&self.spaces);
        }
        options.changed_since_s = self.changed_since_s.or(options.changed_since_s);
        Ok(options)
    }

    /// In words: the file, and what a command set beside it.
    pub(crate) fn words(&self) -> String {
        let mut words = FileText::words(self.file.as_ref(), "the default options");
        if !self.spaces.is_empty() {
            words += &format!(", spaces {}", self.spaces.join(", "));
        }
        if let Some(since) = self.changed_since_s.and_then(messages::plan_time) {
            words += &format!(", changed since {since}");
        }
        words
    }
}

/// What `waypoints.options` of `site.toml` says.
pub(crate) fn configured(config: &SiteConfig) -> Configured<WaypointOptions> {
    let Configured { file, value } =
        FileText::configured(WHAT, config.waypoints.options.as_deref(), MissionPlanOptions::parse);
    Configured { file, value: value.map(|file| WaypointOptions { file, ..WaypointOptions::default() }) }
}

/// The setting at the start of the daemon.
///
/// # Errors
/// An edit of the site's file that cannot be used, or state that cannot be read or written.
pub(crate) fn open(config: &SiteConfig) -> Result<Setting<WaypointOptions>, Failure> {
    /// The last request, with the path of its file.
    #[derive(Debug, Default, Deserialize)]
    #[serde(default)]
    struct Older {
        options: Option<PathBuf>,
        spaces: Vec<String>,
        changed_since_s: Option<i64>,
    }
    let older_file = StateFile::at(&config.state, OLDER_FILE)?;
    let older = || {
        let Some(Older { options, spaces, changed_since_s }) = older_file.load()? else { return Ok(None) };
        if options.is_none() && spaces.is_empty() && changed_since_s.is_none() {
            return Ok(None);
        }
        let in_site_toml = configured(config).value.unwrap_or_default();
        // Only the name of its file was kept.
        let read = |path: PathBuf| FileText::read(WHAT, &path, MissionPlanOptions::parse).map(|(file, _)| file);
        let file = options.map(read).transpose().map_err(Failure::from);
        match file.and_then(|file| WaypointOptions::of_command(file, spaces, changed_since_s, &in_site_toml)) {
            Ok(command) => Ok(Some(OlderSetting::Command(command))),
            Err(why) => {
                let error = daemon::chain(why.as_ref());
                warn!(
                    service = "waypoint-gen",
                    error, "options of an earlier command are lost: those of site.toml are in force"
                );
                Ok(None)
            }
        }
    };
    let setting = Setting::open(&config.state, SettingKey::Waypoints, configured(config), older)?;
    older_file.remove()?;
    Ok(setting)
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::SettingSource;
    use std::fs;
    use std::path::Path;

    fn config(home: &Path) -> SiteConfig {
        let options = home.join("options.toml");
        if !options.exists() {
            fs::write(&options, "spaces = [\"A\"]\n").unwrap();
        }
        SiteConfig::parse("state = \"state\"\n[waypoints]\noptions = \"options.toml\"\n", home).unwrap()
    }

    #[test]
    fn options_of_a_command_outlive_their_file_and_stand_beside_those_of_the_site() {
        let home = tempfile::tempdir().unwrap();
        let config = config(home.path());
        let mut setting = open(&config).unwrap();
        let in_site_toml = setting.without_command().value().clone();
        let spaces = WaypointOptions::of_command(None, vec!["B".to_owned()], Some(86_400), &in_site_toml).unwrap();
        assert_eq!(spaces.parse().unwrap().spaces, ["B"]);
        assert!(
            spaces.words().ends_with("options.toml, spaces B, changed since 1970-01-02T00:00:00"),
            "{}",
            spaces.words()
        );
        let other = home.path().join("other.toml");
        fs::write(&other, "spaces = [\"C\"]\n").unwrap();
        let (file, _) = FileText::read(WHAT, &other, MissionPlanOptions::parse).unwrap();
        let command = WaypointOptions::of_command(Some(file), Vec::new(), None, &in_site_toml).unwrap();
        setting.keep(setting.commanded(command, 7)).unwrap().iter().for_each(|save| save.write().unwrap());
        fs::remove_file(&other).unwrap();
        let setting = open(&config).unwrap();
        assert_eq!(setting.value().parse().unwrap().spaces, ["C"]);
        assert_eq!(setting.without_command().value().parse().unwrap().spaces, ["A"]);
    }

    #[test]
    fn the_request_of_an_earlier_version_stays_in_force_with_its_content() {
        let home = tempfile::tempdir().unwrap();
        let config = config(home.path());
        fs::create_dir(&config.state).unwrap();
        let other = home.path().join("other.toml");
        fs::write(&other, "spaces = [\"C\"]\n").unwrap();
        let older = serde_json::json!({ "options": other, "spaces": [], "changed_since_s": null });
        fs::write(config.state.join(OLDER_FILE), older.to_string()).unwrap();
        open(&config).unwrap();
        fs::remove_file(&other).unwrap();
        let setting = open(&config).unwrap();
        assert_eq!(setting.value().parse().unwrap().spaces, ["C"]);
        assert_eq!(setting.in_force(WaypointOptions::words).source, SettingSource::Command);
    }
}
