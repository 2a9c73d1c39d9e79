//! The site of a command: its configuration file, or that of the demo building.

use crate::failure::Failure;
use daemon::SiteConfig;
use std::path::{Path, PathBuf};

const DEFAULT: &str = "/etc/groundplan/site.toml";
const DEMO_MODEL: &[u8] = include_bytes!("../../../../config/demo/demo.ifc");

/// Which site.
#[derive(Debug, Clone, clap::Args)]
pub struct SiteArgs {
    /// Configuration of the site [default: /etc/groundplan/site.toml]
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,

    /// The demo building, on a bus of its own in memory
    #[arg(long, conflicts_with = "config")]
    demo: bool,
}

impl SiteArgs {
    /// Path of the configuration.
    pub(crate) fn path(&self) -> PathBuf {
        match &self.config {
            Some(path) => path.clone(),
            None if self.demo => demo_home().join("site.toml"),
            None => PathBuf::from(DEFAULT),
        }
    }

    /// The configuration.
    ///
    /// # Errors
    /// A file that cannot be read, or holds something else.
    pub(crate) fn config(&self) -> Result<SiteConfig, Failure> {
        SiteConfig::read(&self.path()).map_err(Failure::usage)
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
             [bus]\nprefix = \"gpdemo{user}_\"\nroot = \"/dev/shm/gpdemo-{user}\"\n"
        );
        for (name, bytes) in [("demo.ifc", DEMO_MODEL), ("site.toml", site.as_bytes())] {
            write_if_different(&home.join(name), bytes)?;
        }
        Ok(())
    }
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
