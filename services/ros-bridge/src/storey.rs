//! The map storey that a robot is on.

use daemon::{Failure, SiteConfig, StateFile};

/// The storey that is shown, and who tells it.
pub(crate) struct RobotStorey {
    configured: Option<u32>,
    /// The one that was set while the daemon ran, in a file: a daemon that is started again shows the same.
    set: Option<u32>,
    file: StateFile,
}

impl RobotStorey {
    /// The storey of a site.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub(crate) fn of(config: &SiteConfig) -> Result<Self, Failure> {
        let file = StateFile::at(&config.state, "ros-bridge-storey.json")?;
        Ok(Self { configured: config.ros.storey, set: file.load()?.unwrap_or_default(), file })
    }

    /// Another one from now on; `None` for that of configuration or alignment.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub(crate) fn set(&mut self, storey: Option<u32>) -> Result<(), Failure> {
        self.file.save(&storey)?;
        self.set = storey;
        Ok(())
    }

    /// The one that was set while the daemon ran.
    pub(crate) fn was_set(&self) -> Option<u32> {
        self.set
    }

    /// What tells the storey, the first that does counts: it was set, the configuration, the alignment of the robot's map; else
    /// the lowest.
    ///
    /// `n_storeys` are those that have a grid. `None` without one, or where the one that is meant is not among them.
    pub(crate) fn index(&self, aligned: Option<u32>, n_storeys: usize) -> Option<usize> {
        let storey = self.set.or(self.configured).or(aligned).unwrap_or(0) as usize;
        (storey < n_storeys).then_some(storey)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use daemon::RosConfig;

    #[test]
    fn what_was_set_goes_before_the_configuration_and_that_before_the_alignment() {
        let home = tempfile::tempdir().unwrap();
        let path = home.path().join("site.toml");
        std::fs::write(&path, "state = \"state\"\n").unwrap();
        let site = SiteConfig::read(&path).unwrap();
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
        assert_eq!(configured.index(Some(2), 3), Some(0));
        let mut again = RobotStorey::of(&config(Some(1))).unwrap();
        assert_eq!(again.was_set(), Some(0), "it is in a file");
        again.set(None).unwrap();
        assert_eq!(again.index(Some(2), 3), Some(1));
    }
}
