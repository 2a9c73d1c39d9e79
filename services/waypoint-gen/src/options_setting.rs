//! The options of waypoints in force, kept with the content of their file.

use daemon::{Failure, FileText, OlderSetting, Setting, SettingKey, SiteConfig, StateFile, WaypointOptions};
use serde::Deserialize;
use std::path::PathBuf;
use tracing::warn;
use waypoints::MissionPlanOptions;

/// The requested options in the state of earlier versions.
const OLDER_FILE: &str = "waypoints.json";

/// The options for planning.
///
/// # Errors
/// A file that was kept and is none of this version.
pub(crate) fn parsed(options: &WaypointOptions) -> Result<MissionPlanOptions, Failure> {
    let of_file = options.parse(MissionPlanOptions::parse)?;
    Ok(of_file.narrowed(&options.spaces, options.changed_since_s))
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
        let in_site_toml = WaypointOptions::configured(config, MissionPlanOptions::parse).value.unwrap_or_default();
        // Only the name of its file was kept.
        let read = |path: PathBuf| {
            FileText::read(WaypointOptions::WHAT, &path, MissionPlanOptions::parse).map(|(file, _)| file)
        };
        let file = options.map(read).transpose().map_err(Failure::from);
        match file.and_then(|file| {
            WaypointOptions::of_command(file, spaces, changed_since_s, &in_site_toml, MissionPlanOptions::parse)
        }) {
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
    let setting = Setting::open(
        &config.state,
        SettingKey::Waypoints,
        WaypointOptions::configured(config, MissionPlanOptions::parse),
        older,
    )?;
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
        let spaces = WaypointOptions::of_command(
            None,
            vec!["B".to_owned()],
            Some(86_400),
            &in_site_toml,
            MissionPlanOptions::parse,
        )
        .unwrap();
        assert_eq!(parsed(&spaces).unwrap().spaces, ["B"]);
        assert!(
            spaces.words().ends_with("options.toml, spaces B, changed since 1970-01-02T00:00:00"),
            "{}",
            spaces.words()
        );
        let other = home.path().join("other.toml");
        fs::write(&other, "spaces = [\"C\"]\n").unwrap();
        let (file, _) = FileText::read(WaypointOptions::WHAT, &other, MissionPlanOptions::parse).unwrap();
        let command =
            WaypointOptions::of_command(Some(file), Vec::new(), None, &in_site_toml, MissionPlanOptions::parse)
                .unwrap();
        setting.keep(setting.commanded(command, 7)).unwrap().iter().for_each(|save| save.write().unwrap());
        fs::remove_file(&other).unwrap();
        let setting = open(&config).unwrap();
        assert_eq!(parsed(setting.value()).unwrap().spaces, ["C"]);
        assert_eq!(parsed(setting.without_command().value()).unwrap().spaces, ["A"]);
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
        assert_eq!(parsed(setting.value()).unwrap().spaces, ["C"]);
        assert_eq!(setting.in_force(WaypointOptions::words).source, SettingSource::Command);
    }
}
