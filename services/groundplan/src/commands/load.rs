//! `groundplan load`: other models for the running daemons.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::progress::LoadProgress;
use crate::run::{Outcome, Run};
use crate::wait::{ask_with_progress, join, wait_for_site};
use daemon::IngestRequest;
use std::path::PathBuf;

/// Arguments of `load`.
#[derive(Debug, Clone, clap::Args)]
pub struct Args {
    /// IFC files of one site
    #[arg(value_name = "MODEL.ifc")]
    models: Vec<PathBuf>,

    /// Return when the site is out; grids follow
    #[arg(long)]
    no_wait: bool,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Loads these files, or those again that are loaded.
    ///
    /// # Errors
    /// No daemons, files that cannot be read; the site stays as it was.
    fn run(&self) -> Result<Outcome, Failure> {
        let absolute =
            |path: &PathBuf| std::path::absolute(path).map_err(|e| Failure::usage(format!("{}: {e}", path.display())));
        let models = self.models.iter().map(absolute).collect::<Result<_, _>>()?;
        let config = self.site.config()?;
        let (bus, mut waiter) = join(&config)?;
        let progress = LoadProgress::new();
        let request = IngestRequest::Load { models };
        let answer = ask_with_progress(&bus, &mut waiter, &request, |news| progress.show(news))?;
        if !self.no_wait {
            progress.waits_for("drawing maps");
            wait_for_site(&bus, &mut waiter, &config, &answer)?;
        }
        Ok(Outcome::silent())
    }
}
