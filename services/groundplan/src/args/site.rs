//! The site of a command: its configuration file, or that of the demo building.

use crate::failure::Failure;
use bus::RobotName;
use daemon::SiteConfig;
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

const DEFAULT: &str = "/etc/groundplan/site.toml";
const DEMO_MODEL: &[u8] = include_bytes!("../../../../config/demo/demo.ifc");

/// Which site.
#[derive(Debug, Clone, clap::Args)]
pub struct SiteArgs {
    /// Configuration of the site [default: that of the only site that runs, else /etc/groundplan/site.toml]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,

    /// The demo building, on a bus of its own in memory
    #[arg(long, conflicts_with = "config")]
    demo: bool,
}

/// Which site, and which of its robots.
#[derive(Debug, Clone, clap::Args)]
pub struct SiteOfRobotArgs {
    /// The site.
    #[command(flatten)]
    site: SiteArgs,

    /// The robot, of a site with several [default: the only one]
    #[arg(long, value_name = "NAME")]
    robot_name: Option<RobotName>,
}

impl SiteOfRobotArgs {
    /// The configuration for a client of running daemons, as it is for the robot.
    ///
    /// # Errors
    /// As [`SiteArgs::config`]; a robot that there is not, or none of several.
    pub(crate) fn config(&self) -> Result<SiteConfig, Failure> {
        self.site.config()?.of_robot(self.robot_name).map_err(Failure::usage)
    }

    /// The same for what only the machine can do that draws the site.
    ///
    /// # Errors
    /// As [`Self::config`]; a robot that follows the server of its site.
    pub(crate) fn config_of_drawing(&self) -> Result<SiteConfig, Failure> {
        self.site.config_of_drawing()?.of_robot(self.robot_name).map_err(Failure::usage)
    }

    /// The same where the robot may be left out: then it is that of the site.
    ///
    /// # Errors
    /// As [`SiteArgs::config`]; a robot that there is not.
    pub(crate) fn config_of_any(&self) -> Result<SiteConfig, Failure> {
        let site = self.site.config()?;
        match self.robot_name {
            None if site.robots.len() > 1 => Ok(site),
            robot => site.of_robot(robot).map_err(Failure::usage),
        }
    }

    /// The site alone.
    pub(crate) fn site(&self) -> &SiteArgs {
        &self.site
    }
}

impl SiteArgs {
    /// The configuration for a client of running daemons: the named one, or that of the only site that runs.
    ///
    /// # Errors
    /// A file that cannot be read, or holds something else; several sites that run.
    pub(crate) fn config(&self) -> Result<SiteConfig, Failure> {
        let running = if self.named().is_none() { running_sites() } else { Vec::new() };
        match running.as_slice() {
            [site] => SiteConfig::read(site).map_err(Failure::usage),
            [] => self.own_config(),
            sites if sites.iter().any(|site| site == Path::new(DEFAULT)) => self.own_config(),
            sites => {
                let names: Vec<_> = sites.iter().map(|site| format!("--config {}", site.display())).collect();
                Err(Failure::usage(format!("several sites run: choose {}", names.join(" or "))))
            }
        }
    }

    /// The same for what only the machine can do that draws the site.
    ///
    /// # Errors
    /// As [`SiteArgs::config`]; a robot that follows the server of its site.
    pub(crate) fn config_of_drawing(&self) -> Result<SiteConfig, Failure> {
        let config = self.config()?;
        config.check_draws().map_err(Failure::usage)?;
        Ok(config)
    }

    /// The configuration to start with: the named one, or that of this machine.
    ///
    /// # Errors
    /// A file that cannot be read, or holds something else.
    pub(crate) fn own_config(&self) -> Result<SiteConfig, Failure> {
        let path = self.named().unwrap_or_else(|| PathBuf::from(DEFAULT));
        SiteConfig::read(&path).map_err(Failure::usage)
    }

    fn named(&self) -> Option<PathBuf> {
        self.config.clone().or_else(|| self.demo.then(|| demo_home().join("site.toml")))
    }

    /// Writes the demo site, if that is meant: the building, and a bus of its own.
    ///
    /// # Errors
    /// The file system refuses.
    pub(crate) fn prepare(&self) -> Result<(), Failure> {
        if !self.demo || self.config.is_some() {
            return Ok(());
        }
        let home = demo_home();
        std::fs::create_dir_all(&home).map_err(Failure::work)?;
        let user = rustix::process::getuid().as_raw();
        let site = format!(
            "state = \"state\"\nmodels = [\"demo.ifc\"]\n[schedule]\nplan_time = \"2024-03-01T00:00:00\"\n\
             [ros]\nslam_map_topic = \"/map\"\n\
             [bus]\nprefix = \"gpdemo{user}_\"\nroot = \"/dev/shm/gpdemo-{user}\"\n"
        );
        for (name, bytes) in [("demo.ifc", DEMO_MODEL), ("site.toml", site.as_bytes())] {
            write_if_different(&home.join(name), bytes)?;
        }
        Ok(())
    }
}

/// Configurations of the sites whose keepers run, as their command lines name them. Those of other users count only if the
/// file is root's or this user's: nobody chooses a site for others.
fn running_sites() -> Vec<PathBuf> {
    let own = rustix::process::getuid().as_raw();
    let processes = std::fs::read_dir("/proc").into_iter().flatten().flatten();
    let mut sites: Vec<PathBuf> = processes.filter_map(|process| keeper_site(&process.path())).collect();
    sites.retain(|site| std::fs::metadata(site).is_ok_and(|file| [0, own].contains(&file.uid())));
    sites.sort();
    sites.dedup();
    sites
}

/// The configuration of a process that is a keeper.
fn keeper_site(process: &Path) -> Option<PathBuf> {
    let line = std::fs::read(process.join("cmdline")).ok()?;
    let mut words = line.split(|byte| *byte == 0).map(OsStr::from_bytes);
    let is_keeper = Path::new(words.next()?).file_name()? == "groundplan" && words.next()? == "keeper";
    let site = words.skip_while(|word| *word != "--config").nth(1).filter(|_| is_keeper);
    site.map(PathBuf::from).filter(|site| site.is_absolute())
}

/// One folder per user.
fn demo_home() -> PathBuf {
    std::env::temp_dir().join(format!("groundplan-demo-{}", rustix::process::getuid().as_raw()))
}

/// A file that is as it should be keeps its time stamp, and the site its cache.
fn write_if_different(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    if std::fs::read(path).is_ok_and(|there| there == bytes) {
        return Ok(());
    }
    daemon::write_durably(path, bytes).map_err(|e| Failure::work(format!("{} cannot be written: {e}", path.display())))
}
