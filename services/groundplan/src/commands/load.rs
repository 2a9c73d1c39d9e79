//! `groundplan load`: loads models into the running daemons, compared with the site in force.

use crate::args::SiteArgs;
use crate::failure::Failure;
use crate::load_progress::LoadProgress;
use crate::revision_report;
use crate::run::{Outcome, Run};
use crate::wait::{ask_with_progress, join, wait_for_site};
use daemon::{IngestRequest, RevisionEffect};
use std::path::PathBuf;

/// Arguments of `load`.
#[derive(Debug, Clone, clap::Args)]
#[command(
    after_help = "A revision that shares few elements with the site in force, lies elsewhere, has another georeference or \
removes most of a storey waits for `groundplan confirm`: exit code 1.\n\n\
Examples:\n  groundplan load house.ifc mep.ifc\n  groundplan load house-b.ifc --dry-run\n  groundplan load --discard"
)]
pub struct Args {
    /// IFC files of one site [default: those in force, read again]
    #[arg(value_name = "MODEL.ifc")]
    models: Vec<PathBuf>,

    /// Compare with the site in force, and change nothing
    #[arg(long)]
    dry_run: bool,

    /// Do not wait for `groundplan confirm`
    #[arg(long, conflicts_with = "dry_run")]
    force: bool,

    /// Forget the revision that waits, or that was refused last
    #[arg(long, conflicts_with_all = ["models", "dry_run", "force"])]
    discard: bool,

    /// Return when the site is out; grids follow
    #[arg(long)]
    no_wait: bool,

    /// Print one JSON document on standard output and nothing else there
    #[arg(long)]
    json: bool,

    /// The site.
    #[command(flatten)]
    site: SiteArgs,
}

impl Run for Args {
    /// Loads these files, or those again that are in force.
    ///
    /// # Errors
    /// No daemons, files or a schedule that cannot be used; the site stays as it was.
    fn run(&self) -> Result<Outcome, Failure> {
        let config = self.site.config_of_drawing()?;
        let (bus, mut waiter) = join(&config)?;
        let progress = LoadProgress::new();
        let answer = ask_with_progress(&bus, &mut waiter, &self.request()?, |news| progress.show(news))?;
        if answer.effect == RevisionEffect::InForce && !self.no_wait {
            progress.waits_for("drawing maps");
            wait_for_site(&mut waiter, &config, &answer.site, "the site")?;
        }
        drop(progress);
        let text = if self.json {
            serde_json::to_string(&answer).map_err(Failure::work)? + "\n"
        } else {
            revision_report::text(&answer)
        };
        Ok(Outcome::judged(text, answer.effect != RevisionEffect::Waits))
    }
}

impl Args {
    fn request(&self) -> Result<IngestRequest, Failure> {
        if self.discard {
            return Ok(IngestRequest::Discard);
        }
        let absolute =
            |path: &PathBuf| std::path::absolute(path).map_err(|e| Failure::usage(format!("{}: {e}", path.display())));
        let models = self.models.iter().map(absolute).collect::<Result<_, _>>()?;
        Ok(IngestRequest::Load { models, dry_run: self.dry_run, force: self.force })
    }
}
