//! The map storey that a robot is on.

use daemon::{Failure, SiteConfig, StateFile, state_files};
use serde::{Deserialize, Serialize};

/// The storey that is shown, and who tells it.
pub(crate) struct RobotStorey {
    configured: Option<u32>,
    told: Told,
    /// A daemon that is started again shows the same.
    file: StateFile,
}

/// What was told while the daemon ran.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Told {
    /// The storey that was set.
    set: Option<u32>,
    /// The storey that the robot has come to through a portal since then.
    followed: Option<Followed>,
}

/// A storey at the end of a portal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
struct Followed {
    storey: u32,
    /// The storey of the alignment by which the robot was seen there: another one says that the robot is elsewhere.
    aligned: u32,
}

impl RobotStorey {
    /// The storey of a site.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn of(config: &SiteConfig) -> Result<Self, Failure> {
        let file = StateFile::at(&config.state, state_files::ROBOT_STOREY)?;
        Ok(Self { configured: config.ros.storey, told: file.load()?.unwrap_or_default(), file })
    }

    /// Another one from now on; `None` for that of configuration or alignment.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn set(&mut self, storey: Option<u32>) -> Result<(), Failure> {
        self.tell(Told { set: storey, followed: None })
    }

    /// The robot has come to another one through a portal, by an alignment with a storey.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn follow(&mut self, storey: u32, aligned: u32) -> Result<(), Failure> {
        self.tell(Told { followed: Some(Followed { storey, aligned }), ..self.told })
    }

    fn tell(&mut self, told: Told) -> Result<(), Failure> {
        self.file.save(&told)?;
        self.told = told;
        Ok(())
    }

    /// What an operator should know of the file: that it was damaged, or removed.
    pub(crate) fn finding(&self) -> Option<&str> {
        self.file.finding()
    }

    /// The one that was set while the daemon ran.
    pub(crate) fn was_set(&self) -> Option<u32> {
        self.told.set
    }

    /// The storey that the robot is known to be on: it has come there through a portal, or it was set.
    pub(crate) fn known(&self, aligned: Option<u32>) -> Option<u32> {
        let is_there = |followed: &Followed| aligned.is_none_or(|aligned| aligned == followed.aligned);
        self.told.followed.filter(is_there).map(|followed| followed.storey).or(self.told.set)
    }

    /// What tells the storey, the first that does counts: the robot has come through a portal, it was set, the configuration, the
    /// alignment of the robot's map; else the lowest.
    ///
    /// `n_storeys` are those that have a grid. `None` without one, or where the one that is meant is not among them.
    pub(crate) fn index(&self, aligned: Option<u32>, n_storeys: usize) -> Option<usize> {
        let storey = self.known(aligned).or(self.configured).or(aligned).unwrap_or(0) as usize;
        (storey < n_storeys).then_some(storey)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::RosConfig;
    use std::path::Path;

    fn site(home: &Path) -> SiteConfig {
        SiteConfig::parse("state = \"state\"\n", home).unwrap()
    }

    #[test]
    fn what_was_set_goes_before_the_configuration_and_that_before_the_alignment() {
        let home = tempfile::tempdir().unwrap();
        let site = site(home.path());
        let config = |storey| SiteConfig { ros: RosConfig { storey, ..RosConfig::default() }, ..site.clone() };
        let aligned = RobotStorey::of(&config(None)).unwrap();
        assert_eq!(
            [aligned.index(Some(2), 3), aligned.index(None, 3), aligned.index(None, 0)],
            [Some(2), Some(0), None]
        );
        let mut configured = RobotStorey::of(&config(Some(1))).unwrap();
        assert_eq!(configured.index(Some(2), 3), Some(1));
        assert_eq!(configured.index(Some(0), 1), None, "another storey is never shown in its place");
        configured.set(Some(0)).unwrap();
        assert_eq!((configured.index(Some(2), 3), configured.known(Some(2))), (Some(0), Some(0)));
        let mut again = RobotStorey::of(&config(Some(1))).unwrap();
        assert_eq!(again.was_set(), Some(0), "it is in a file");
        again.set(None).unwrap();
        assert_eq!(again.index(Some(2), 3), Some(1));
    }

    #[test]
    fn a_robot_that_came_through_a_portal_is_there_until_its_map_is_aligned_elsewhere_or_another_is_set() {
        let home = tempfile::tempdir().unwrap();
        let config = site(home.path());
        RobotStorey::of(&config).unwrap().follow(1, 0).unwrap();
        let mut robot = RobotStorey::of(&config).unwrap();
        let storeys = [Some(0), None, Some(2)].map(|aligned| robot.index(aligned, 3));
        assert_eq!(storeys, [Some(1), Some(1), Some(2)], "it is in a file");
        assert_eq!([robot.known(Some(0)), robot.known(Some(2))], [Some(1), None]);
        robot.set(Some(0)).unwrap();
        assert_eq!(robot.index(Some(0), 3), Some(0));
    }
}
