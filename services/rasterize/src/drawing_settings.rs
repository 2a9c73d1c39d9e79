//! The robot and the resolution that grids are drawn for, kept with the content of the robot's profile.

use daemon::facts::RobotSummary;
use daemon::{
    Configured, Failure, FileText, KeptSetting, OlderSetting, Robot, RobotConfig, Setting, SettingInForce, SettingKey,
    StateFile,
};
use serde::Deserialize;
use std::path::{Path, PathBuf};
use tracing::warn;

/// The settings of grids in force.
#[derive(Debug)]
pub(crate) struct DrawingSettings {
    profile: Setting<Option<FileText>>,
    resolution: Setting<f64>,
    robot: Robot,
}

/// Settings that are to be tried before they are kept.
pub(crate) struct TriedSettings {
    pub(crate) robot: Robot,
    pub(crate) resolution_m: f64,
    profile: KeptSetting<Option<FileText>>,
    resolution: KeptSetting<f64>,
}

/// The robot in the state of earlier versions, in `robot.json`.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum OlderRobot {
    /// The content of its profile, and whether a command set it.
    Content { profile: PathBuf, text: String, is_requested: bool },
    /// The path of the profile that a command set.
    Path(PathBuf),
}

impl OlderRobot {
    fn taken_over(self) -> Option<OlderSetting<Option<FileText>>> {
        match self {
            Self::Content { profile: path, text, is_requested } => {
                let file = Some(FileText { path: path.clone(), text });
                Some(if is_requested { OlderSetting::Command(file) } else { OlderSetting::SiteToml(Some(path), file) })
            }
            Self::Path(path) => match Robot::read_with_text(&path) {
                Ok((_, file)) => Some(OlderSetting::Command(Some(file))),
                Err(why) => {
                    let error = daemon::chain(&why);
                    warn!(
                        service = "rasterize",
                        error, "the robot of an earlier command is lost: that of site.toml is in force"
                    );
                    None
                }
            },
        }
    }
}

/// Its file.
const OLDER_FILE: &str = "robot.json";

impl DrawingSettings {
    /// The settings at the start of the daemon.
    ///
    /// # Errors
    /// An edit of the site's file that cannot be used, or state that cannot be read or written.
    pub(crate) fn open(state: &Path, config: &RobotConfig) -> Result<Self, Failure> {
        let older_file = StateFile::at(state, OLDER_FILE)?;
        let older = || Ok(older_file.load()?.and_then(OlderRobot::taken_over));
        let configured = Robot::configured(config.profile.as_deref());
        let profile = Setting::open(state, SettingKey::RobotProfile, configured, older)?;
        older_file.remove()?;
        let resolution = Setting::open(state, SettingKey::Resolution, resolution_of(config), || Ok(None))?;
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

    /// The settings after the site's file was read again; `None` if nothing is to change.
    ///
    /// # Errors
    /// An edit that cannot be used.
    pub(crate) fn edited(&mut self, config: &RobotConfig) -> Result<Option<TriedSettings>, Failure> {
        let resolution = self.resolution.edited(resolution_of(config))?;
        let profile = self.profile.edited(Robot::configured(config.profile.as_deref()))?;
        let tried = tried(profile, resolution)?;
        if tried.robot == self.robot && tried.resolution_m == self.resolution_m() {
            self.keep(tried)?;
            return Ok(None);
        }
        Ok(Some(tried))
    }

    /// The settings with the robot of this profile, set by a command of this user.
    ///
    /// # Errors
    /// A text that is no profile.
    pub(crate) fn commanded(&self, profile: FileText, by_uid: u32) -> Result<TriedSettings, Failure> {
        tried(self.profile.commanded(Some(profile), by_uid), self.resolution.as_kept())
    }

    /// Takes what was tried; on disk when this returns. The answer is what was in force before.
    ///
    /// # Errors
    /// The file system refuses; the settings stay.
    pub(crate) fn keep(&mut self, tried: TriedSettings) -> Result<TriedSettings, Failure> {
        let TriedSettings { robot, profile, resolution, .. } = tried;
        let resolution_m = self.resolution_m();
        let profile = self.profile.keep(profile)?;
        let resolution = match self.resolution.keep(resolution) {
            Ok(resolution) => resolution,
            Err(why) => {
                self.profile.keep(profile)?;
                return Err(why.into());
            }
        };
        let robot = std::mem::replace(&mut self.robot, robot);
        Ok(TriedSettings { robot, resolution_m, profile, resolution })
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

fn tried(profile: KeptSetting<Option<FileText>>, resolution: KeptSetting<f64>) -> Result<TriedSettings, Failure> {
    let robot = Robot::of(profile.value().as_ref())?;
    Ok(TriedSettings { robot, resolution_m: *resolution.value(), profile, resolution })
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
        let mut settings = opened(&home, &first);
        let (_, profile) = Robot::read_with_text(&second).unwrap();
        let tried = settings.commanded(profile.clone(), 7).unwrap();
        settings.keep(tried).unwrap();
        fs::remove_file(&second).unwrap();
        assert_eq!(in_force(&opened(&home, &first)), ("second", SettingSource::Command, false));
        assert!(
            settings.commanded(FileText { text: "radius_m = 9".to_owned(), ..profile }, 7).is_err(),
            "it has no name"
        );
        fs::write(&first, "name = \"first\"\nradius_m = 0.3\n").unwrap();
        let tried = settings.edited(&config(&first)).unwrap().unwrap();
        assert_eq!((tried.robot.name.as_str(), tried.robot.profile.radius_m), ("first", 0.3));
        settings.keep(tried).unwrap();
        assert_eq!(in_force(&opened(&home, &first)), ("first", SettingSource::SiteToml, false));
    }

    #[test]
    fn an_edit_that_cannot_be_used_changes_neither_robot_nor_resolution() {
        let (home, first, second) = folder();
        let mut settings = opened(&home, &first);
        let wrong = RobotConfig { resolution_m: 0.0, ..config(&second) };
        assert!(settings.edited(&wrong).is_err() && DrawingSettings::open(&home.path().join("state"), &wrong).is_err());
        assert_eq!(in_force(&opened(&home, &first)), ("first", SettingSource::SiteToml, false));
        let finer = RobotConfig { resolution_m: 0.025, ..config(&first) };
        let tried = settings.edited(&finer).unwrap().unwrap();
        let before = settings.keep(tried).unwrap();
        assert_eq!((settings.resolution_m(), before.resolution_m), (0.025, 0.05));
        settings.keep(before).unwrap();
        assert_eq!(settings.resolution_m(), 0.05);
    }

    #[test]
    fn a_path_that_a_command_left_with_an_earlier_version_is_read_once() {
        let (home, first, second) = folder();
        let state = home.path().join("state");
        fs::create_dir(&state).unwrap();
        fs::write(state.join(OLDER_FILE), serde_json::json!(second).to_string()).unwrap();
        assert_eq!(in_force(&opened(&home, &first)), ("second", SettingSource::Command, false));
        fs::remove_file(&second).unwrap();
        assert_eq!(in_force(&opened(&home, &first)), ("second", SettingSource::Command, false));
    }

    #[test]
    fn the_robot_of_an_earlier_version_stays_in_force() {
        for is_requested in [false, true] {
            let (home, first, second) = folder();
            let state = home.path().join("state");
            fs::create_dir(&state).unwrap();
            let older = if is_requested { &second } else { &first };
            let text = fs::read_to_string(older).unwrap();
            let older_state = serde_json::json!({ "profile": older, "text": text, "is_requested": is_requested });
            fs::write(state.join(OLDER_FILE), older_state.to_string()).unwrap();
            fs::remove_file(older).unwrap();
            for _ in 0..2 {
                let settings = opened(&home, &first);
                let expected = if is_requested {
                    ("second", SettingSource::Command, false)
                } else {
                    ("first", SettingSource::SiteToml, true)
                };
                assert_eq!(in_force(&settings), expected);
                assert!(!state.join(OLDER_FILE).exists());
            }
        }
    }
}
