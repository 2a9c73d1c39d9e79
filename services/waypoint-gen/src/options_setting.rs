//! The options of waypoints in force, kept with the content of their file.

use daemon::{Failure, Setting, SettingKey, SiteConfig, WaypointOptions};
use waypoints::MissionPlanOptions;

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
    let configured = WaypointOptions::configured(config, MissionPlanOptions::parse);
    Setting::open(&config.state, SettingKey::Waypoints, configured)
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::FileText;
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
}
