//! The robot and the resolution that grids are drawn for, kept with the content of the robot's profile.

use daemon::facts::RobotSummary;
use daemon::{Configured, Failure, FileText, Robot, RobotConfig, Save, Setting, SettingInForce, SettingKey};
use std::path::Path;

/// The settings of grids.
#[derive(Debug, Clone)]
pub(crate) struct DrawingSettings {
    profile: Setting<Option<FileText>>,
    resolution: Setting<f64>,
    robot: Robot,
}

impl DrawingSettings {
    /// The settings at the start of the daemon.
    ///
    /// # Errors
    /// An edit of the site's file that cannot be used, or state that cannot be read or written.
    pub(crate) fn open(state: &Path, config: &RobotConfig) -> Result<Self, Failure> {
        let profile = Setting::open(state, SettingKey::RobotProfile, Robot::configured(config.profile.as_deref()))?;
        let resolution = Setting::open(state, SettingKey::Resolution, resolution_of(config))?;
        let robot = Robot::of(profile.value().as_ref())?;
        Ok(Self { profile, resolution, robot })
    }

    /// The robot in force.
    pub(crate) fn robot(&self) -> &Robot {
        &self.robot
    }

    /// Metres per cell.
    pub(crate) fn resolution_m(&self) -> f64 {
        *self.resolution.value()
    }

    /// True if `site.toml` was edited before this start.
    pub(crate) fn were_edited(&self) -> bool {
        self.profile.was_edited() || self.resolution.was_edited()
    }

    /// What an operator should know.
    pub(crate) fn warning(&self) -> Option<&str> {
        self.profile.warning().or(self.resolution.warning())
    }

    /// The settings after the site's file was read again, and what keeps them.
    ///
    /// # Errors
    /// An edit that cannot be used.
    pub(crate) fn edited(&self, config: &RobotConfig) -> Result<(Self, Vec<Save>), Failure> {
        let mut next = self.clone();
        let resolution = next.resolution.edited(resolution_of(config))?;
        let profile = next.profile.edited(Robot::configured(config.profile.as_deref()))?;
        let saves = [next.profile.keep(profile)?, next.resolution.keep(resolution)?];
        next.robot = Robot::of(next.profile.value().as_ref())?;
        Ok((next, saves.into_iter().flatten().collect()))
    }

    /// The settings with the robot of this profile, set by a command of this user, and what keeps them.
    ///
    /// # Errors
    /// A text that is no profile.
    pub(crate) fn commanded(&self, profile: FileText, by_uid: u32) -> Result<(Self, Vec<Save>), Failure> {
        let mut next = self.clone();
        let save = next.profile.keep(next.profile.commanded(Some(profile), by_uid))?;
        next.robot = Robot::of(next.profile.value().as_ref())?;
        Ok((next, save.into_iter().collect()))
    }

    /// True if grids drawn for both are the same.
    pub(crate) fn draw_alike(&self, other: &Self) -> bool {
        self.robot == other.robot && self.resolution_m() == other.resolution_m()
    }

    /// The settings for `status`.
    pub(crate) fn in_force(&self) -> Vec<SettingInForce> {
        vec![self.robot_in_force(), self.resolution.in_force(|metres| format!("{metres} m"))]
    }

    /// Where the robot comes from.
    pub(crate) fn robot_in_force(&self) -> SettingInForce {
        self.profile.in_force(|file| FileText::words(file.as_ref(), "the default robot"))
    }

    /// The robot for people and programs.
    pub(crate) fn robot_summary(&self) -> RobotSummary {
        RobotSummary::of(&self.robot)
    }
}

fn resolution_of(config: &RobotConfig) -> Configured<f64> {
    let resolution_m = config.resolution_m;
    let value = grid::GridSpec::cell_tenths_of(resolution_m).map(|_| resolution_m);
    Configured { file: None, value: value.map_err(Failure::from) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::SettingSource;
    use std::fs;
    use std::path::PathBuf;

    /// A folder with profiles of two robots, and the state folder.
    fn folder() -> (tempfile::TempDir, PathBuf, PathBuf) {
        let home = tempfile::tempdir().unwrap();
        let [first, second] = ["first", "second"].map(|name| home.path().join(format!("{name}.toml")));
        fs::write(&first, "name = \"first\"\nradius_m = 0.2\n").unwrap();
        fs::write(&second, "name = \"second\"\nradius_m = 0.4\n").unwrap();
        (home, first, second)
    }

    fn config(profile: &Path) -> RobotConfig {
        RobotConfig { profile: Some(profile.to_owned()), ..RobotConfig::default() }
    }

    fn opened(home: &tempfile::TempDir, profile: &Path) -> DrawingSettings {
        DrawingSettings::open(&home.path().join("state"), &config(profile)).unwrap()
    }

    fn in_force(settings: &DrawingSettings) -> (&str, SettingSource, bool) {
        (&settings.robot().name, settings.robot_in_force().source, settings.warning().is_some())
    }

    #[test]
    fn a_command_counts_until_the_profile_of_the_site_is_edited() {
        let (home, first, second) = folder();
        assert_eq!(in_force(&opened(&home, &first)), ("first", SettingSource::SiteToml, false));
        let settings = opened(&home, &first);
        let profile = FileText::read_up_to("robot profile", &second, 1_000).unwrap();
        let (settings, saves) = settings.commanded(profile.clone(), 7).unwrap();
        assert_eq!(
            in_force(&opened(&home, &first)),
            ("first", SettingSource::SiteToml, false),
            "it is not written yet"
        );
        saves.iter().try_for_each(Save::write).unwrap();
        fs::remove_file(&second).unwrap();
        assert_eq!(in_force(&opened(&home, &first)), ("second", SettingSource::Command, false));
        assert!(
            settings.commanded(FileText { text: "radius_m = 9".to_owned(), ..profile }, 7).is_err(),
            "it has no name"
        );
        fs::write(&first, "name = \"first\"\nradius_m = 0.3\n").unwrap();
        let (edited, saves) = settings.edited(&config(&first)).unwrap();
        assert!(!edited.draw_alike(&settings));
        assert_eq!((edited.robot().name.as_str(), edited.robot().profile.radius_m), ("first", 0.3));
        saves.iter().try_for_each(Save::write).unwrap();
        assert_eq!(in_force(&opened(&home, &first)), ("first", SettingSource::SiteToml, false));
    }

    #[test]
    fn an_edit_that_cannot_be_used_changes_neither_robot_nor_resolution() {
        let (home, first, second) = folder();
        let settings = opened(&home, &first);
        let wrong = RobotConfig { resolution_m: 0.0, ..config(&second) };
        assert!(settings.edited(&wrong).is_err() && DrawingSettings::open(&home.path().join("state"), &wrong).is_err());
        assert_eq!(in_force(&opened(&home, &first)), ("first", SettingSource::SiteToml, false));
        let finer = RobotConfig { resolution_m: 0.025, ..config(&first) };
        let (edited, _) = settings.edited(&finer).unwrap();
        assert_eq!((edited.resolution_m(), settings.resolution_m()), (0.025, 0.05));
        let (same, saves) = settings.edited(&config(&first)).unwrap();
        assert!(same.draw_alike(&settings) && saves.is_empty());
    }
}
