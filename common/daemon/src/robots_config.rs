//! Robots of a site by name: what its configuration is for one of them, and what is left of those that it does not have any more.

use crate::config::SiteConfig;
use crate::robot_config::{NamedRobotConfig, RobotConfig};
use crate::state_files::{GRID_EPOCHS, ROBOTS};
use bus::{RobotName, names_of_robots};
use std::path::{Path, PathBuf};

/// A robot that is not named, or that there is not.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum RobotChoiceError {
    /// Which of several is meant is not known.
    #[error("the site has several robots, and each has its own: choose one with --robot-name: {robots}")]
    NotNamed {
        /// Their names.
        robots: String,
    },
    /// No robot of the site has this name.
    #[error("the site has no robot `{robot}`: {}", existing(robots))]
    Unknown {
        /// As given.
        robot: RobotName,
        /// Names of the robots that it has.
        robots: String,
    },
}

fn existing(robots: &str) -> String {
    match robots {
        "" => "its only robot has no name".to_owned(),
        robots => format!("it has {robots}"),
    }
}

impl SiteConfig {
    /// Names of the robots, in their order; none for a site whose robot has no name.
    pub fn robot_names(&self) -> Vec<RobotName> {
        let mut names: Vec<RobotName> = self.robots.iter().map(|robot| robot.name).collect();
        names.sort_unstable();
        names
    }

    /// Names of the robots whose observed progress counts, in their order: those of the site, and those that tell its server what they
    /// see. None for a site whose robot has no name.
    pub fn observers(&self) -> Vec<RobotName> {
        let mut names = self.robot_names();
        names.extend(self.serve.iter().flat_map(|serve| &serve.link).flat_map(|link| &link.robots));
        names.sort_unstable();
        names.dedup();
        names
    }

    /// The configuration as it is for a robot: of a site with one robot that need not be named. What the site has for all of them
    /// stays; state of the robot lies in a folder of its own in that of the site.
    ///
    /// # Errors
    /// A robot that there is not, or none of several.
    pub fn of_robot(&self, name: Option<RobotName>) -> Result<Self, RobotChoiceError> {
        let robots = || names_of_robots(&self.robot_names());
        let robot = match (name, self.robots.as_slice()) {
            (None, []) => return Ok(self.clone()),
            (None, [only]) => only,
            (None, _) => return Err(RobotChoiceError::NotNamed { robots: robots() }),
            (Some(name), all) => all
                .iter()
                .find(|robot| robot.name == name)
                .ok_or_else(|| RobotChoiceError::Unknown { robot: name, robots: robots() })?,
        };
        let NamedRobotConfig { name, profile, resolution_m, waypoints, align, ros } = robot.clone();
        let state = self.site_state.join(ROBOTS).join(name.as_str());
        let robot = RobotConfig { profile, resolution_m };
        Ok(Self { robot_name: Some(name), state, robot, waypoints, align, ros, ..self.clone() })
    }

    /// The configuration as it is for each robot that is meant: all of a site with names; of a configuration of one robot, and of a
    /// site whose robot has no name, this one.
    pub fn of_each_robot(&self) -> Vec<Self> {
        if self.robots.is_empty() || self.robot_name.is_some() {
            return vec![self.clone()];
        }
        self.robot_names().into_iter().filter_map(|name| self.of_robot(Some(name)).ok()).collect()
    }

    /// State of robots that the site does not have any more: it stays in its folder and is not used. A sentence for each.
    pub fn unused_robot_state(&self) -> Vec<String> {
        let mut found = Vec::new();
        let shown = self.site_state.display();
        if !self.robots.is_empty() && self.site_state.join(GRID_EPOCHS).exists() {
            found.push(format!(
                "the state of the robot without a name, of before [[robots]], stays in {shown} and is not used"
            ));
        }
        let folders = std::fs::read_dir(self.site_state.join(ROBOTS)).into_iter().flatten().flatten();
        let mut names: Vec<RobotName> =
            folders.filter_map(|folder| folder.file_name().to_str()?.parse().ok()).collect();
        names.sort_unstable();
        names.retain(|name| self.robots.iter().all(|robot| robot.name != *name));
        found.extend(names.into_iter().map(|name| {
            format!("the state of the robot {name}, which the site does not have, stays in {shown}/{ROBOTS}/{name} and is not used")
        }));
        found
    }
}

/// The state folder of a robot in that of its site.
pub(crate) fn robot_states(site_state: &Path, robots: &[RobotName]) -> Vec<(RobotName, PathBuf)> {
    robots.iter().map(|name| (*name, site_state.join(ROBOTS).join(name.as_str()))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const TWO: &str = "state = \"x\"\n[[robots]]\nname = \"scan\"\nprofile = \"scan.toml\"\n[robots.align]\nmap = \"m.yaml\"\n\
                       [[robots]]\nname = \"lift\"\nresolution_m = 0.1\n[robots.waypoints]\noptions = \"w.toml\"\n";

    /// The configuration in a file that says this; its paths count from a folder that is gone.
    fn read(text: &str) -> Result<SiteConfig, String> {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("site.toml");
        std::fs::write(&path, text).unwrap();
        SiteConfig::read(&path).map_err(|why| crate::chain(&why))
    }

    #[test]
    fn each_robot_has_its_own_and_the_site_is_that_of_all() {
        let site = read(TWO).unwrap();
        assert_eq!(names_of_robots(&site.robot_names()), "lift, scan");
        let home = site.file.parent().unwrap();
        let [lift, scan] = ["lift", "scan"].map(|name| site.of_robot(Some(name.parse().unwrap())).unwrap());
        assert_eq!((&scan.robot.profile, scan.robot.resolution_m), (&Some(home.join("scan.toml")), 0.05));
        assert_eq!((&scan.align.map, &scan.waypoints.options), (&Some(home.join("m.yaml")), &None));
        assert_eq!((&lift.robot.profile, lift.robot.resolution_m), (&None, 0.1));
        assert_eq!(lift.waypoints.options, Some(home.join("w.toml")));
        assert_eq!([&lift.state, &scan.state], [&home.join("x/robots/lift"), &home.join("x/robots/scan")]);
        assert_eq!([&lift.site_state, &scan.site_state], [&site.state; 2]);
        assert_eq!(lift.domain().unwrap().robot(), Some("lift".parse().unwrap()));
        assert_eq!((site.domain().unwrap().robot(), site.domain().unwrap().robots().len()), (None, 2));
        assert_eq!([lift.ros.namespace, scan.ros.namespace], ["/lift", "/scan"]);
    }

    #[test]
    fn a_robot_is_named_where_there_are_several() {
        let site = read(TWO).unwrap();
        let refused = site.of_robot(None).unwrap_err().to_string();
        assert!(refused.contains("--robot-name: lift, scan"), "{refused}");
        let refused = site.of_robot(Some("crane".parse().unwrap())).unwrap_err().to_string();
        assert!(refused.contains("no robot `crane`: it has lift, scan"), "{refused}");
        let one = read("state = \"x\"\n[[robots]]\nname = \"lift\"\n").unwrap();
        assert_eq!(one.of_robot(None).unwrap().robot_name, Some("lift".parse().unwrap()));
        let unnamed = read("state = \"x\"\n").unwrap();
        assert_eq!(unnamed.of_robot(None).unwrap(), unnamed);
        assert!(unnamed.of_robot(Some("lift".parse().unwrap())).unwrap_err().to_string().contains("has no name"));
    }

    #[test]
    fn robots_that_cannot_be_told_apart_are_refused() {
        let check = |more: &str, words: &[&str]| {
            let refused = read(&format!("{TWO}{more}")).unwrap_err();
            assert!(words.iter().all(|word| refused.contains(word)), "{refused}");
        };
        check("[robot]\n[ros]\nenabled = true\n", &["[robot], [ros] and [[robots]]"]);
        check("[[robots]]\nname = \"lift\"\n", &["two robots have the name `lift`"]);
        check("[[robots]]\nname = \"Lift\"\n", &["\"Lift\" is no name of a robot"]);
        check("[[robots]]\nname = \"a\"\n[[robots]]\nname = \"b\"\n[[robots]]\nname = \"c\"\n", &["5 robots"]);
        check("[robots.ros]\nnamespace = \"/scan\"\n", &["ros.namespace of `scan` and `lift` is /scan"]);
        check("speed = 3\n", &["speed"]);
        check("[robots.ros.foxglove]\n[[robots]]\nname = \"a\"\n[robots.ros.foxglove]\n", &["ros.foxglove.address"]);
    }

    #[test]
    fn state_that_is_not_used_is_told() {
        let home = tempfile::tempdir().unwrap();
        let at = |text: &str| SiteConfig::parse(text, home.path()).unwrap().unused_robot_state();
        assert!(at(TWO).is_empty() && at("state = \"x\"\n").is_empty());
        std::fs::create_dir_all(home.path().join("x/robots/lift")).unwrap();
        assert!(at(TWO).is_empty());
        let told = at("state = \"x\"\n");
        assert!(told.len() == 1 && told[0].contains("robots/lift") && told[0].contains("not used"), "{told:?}");
        std::fs::write(home.path().join("x/rasterize-epochs.json"), "7").unwrap();
        assert!(at(TWO)[0].contains("robot without a name"));
        assert_eq!(at("state = \"x\"\n").len(), 1);
    }
}
