//! The robot that survives a restart: the content of its profile, not the name of a file.

use daemon::{Failure, FileText, Robot, RobotConfig, StateFile};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// A robot in use, as it lies in the state folder.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Content {
    /// The file that it was read from.
    profile: PathBuf,
    /// The file as it was read: TOML.
    text: String,
    /// True if a request set it, which goes before the configured one.
    is_requested: bool,
}

/// The state file of the robot.
#[derive(Debug)]
pub(crate) struct SavedRobot {
    file: StateFile,
}

impl SavedRobot {
    /// The robot to begin with, and what an operator should know about it.
    ///
    /// What was saved goes before the file that it came from, until a request or another configured file replaces it:
    /// a restart draws with the robot of before, whatever became of the file.
    ///
    /// # Errors
    /// A profile or state that cannot be used.
    pub(crate) fn open(folder: &Path, config: &RobotConfig) -> Result<(Self, Robot, Option<String>), Failure> {
        let saved = Self { file: StateFile::at(folder, "robot.json")? };
        let kept = saved.file.load::<Content>()?;
        let kept = kept.filter(|c| c.is_requested || config.profile.as_ref() == Some(&c.profile));
        let Some(content) = kept else {
            let configured = config.profile.as_deref();
            let robot = configured.map_or(Ok(Robot::default()), |profile| saved.take(profile, false))?;
            return Ok((saved, robot, None));
        };
        let robot = Robot::parse(&content.text, &content.profile)?;
        let file = content.profile.display();
        let warning = match std::fs::read_to_string(&content.profile) {
            Ok(text) if text == content.text => None,
            Ok(_) => Some(format!("{file} is not the robot in use any more: `groundplan robot {file}` takes it")),
            Err(error) => Some(format!("{file} cannot be read ({error}): the robot in use is what was read before")),
        };
        Ok((saved, robot, warning))
    }

    /// Another robot from now on; it is on disk when this returns.
    ///
    /// # Errors
    /// A file that is no profile, or cannot be saved: the robot of before stays.
    pub(crate) fn set(&self, profile: &Path) -> Result<Robot, Failure> {
        self.take(profile, true)
    }

    fn take(&self, profile: &Path, is_requested: bool) -> Result<Robot, Failure> {
        let (robot, FileText { text, .. }) = Robot::read_with_text(profile)?;
        self.file.save(&Content { profile: profile.to_owned(), text, is_requested })?;
        Ok(robot)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    /// A folder with profiles of two robots, and the state folder.
    fn folder() -> (tempfile::TempDir, PathBuf, PathBuf) {
        let home = tempfile::tempdir().unwrap();
        let [first, second] = ["first", "second"].map(|name| home.path().join(format!("{name}.toml")));
        fs::write(&first, "name = \"first\"\nradius_m = 0.2\n").unwrap();
        fs::write(&second, "name = \"second\"\nradius_m = 0.4\n").unwrap();
        (home, first, second)
    }

    fn opened(home: &tempfile::TempDir, profile: &Path) -> (SavedRobot, Robot, Option<String>) {
        let config = RobotConfig { profile: Some(profile.to_owned()), ..RobotConfig::default() };
        SavedRobot::open(&home.path().join("state"), &config).unwrap()
    }

    #[test]
    fn a_restart_keeps_the_robot_whose_file_was_changed_or_removed_and_says_so() {
        let (home, first, _) = folder();
        let (_, robot, warning) = opened(&home, &first);
        assert_eq!((robot.name.as_str(), warning), ("first", None));
        assert_eq!(opened(&home, &first).2, None);
        fs::write(&first, "name = \"other\"\nradius_m = 0.3\n").unwrap();
        let (saved, robot, warning) = opened(&home, &first);
        assert_eq!((robot.name.as_str(), robot.profile.radius_m), ("first", 0.2));
        assert!(warning.unwrap().contains("not the robot in use any more"));
        fs::remove_file(&first).unwrap();
        let (_, robot, warning) = opened(&home, &first);
        assert!(robot.name == "first" && warning.unwrap().contains("cannot be read"));
        fs::write(&first, "name = \"other\"\nradius_m = 0.3\n").unwrap();
        assert_eq!(saved.set(&first).unwrap().name, "other");
        let (_, robot, warning) = opened(&home, &first);
        assert_eq!((robot.name.as_str(), warning), ("other", None));
    }

    #[test]
    fn another_configured_file_is_taken_unless_a_request_set_the_robot() {
        let (home, first, second) = folder();
        assert_eq!(opened(&home, &first).1.name, "first");
        let (saved, robot, _) = opened(&home, &second);
        assert_eq!(robot.name, "second");
        saved.set(&first).unwrap();
        assert_eq!(opened(&home, &second).1.name, "first");
        assert!(saved.set(&home.path().join("none.toml")).is_err());
        assert_eq!(opened(&home, &second).1.name, "first");
    }
}
