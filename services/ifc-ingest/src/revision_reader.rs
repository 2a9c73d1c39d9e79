//! Reads files as a revision of a site that could take effect: the site, its schedule as it will be evaluated, and how it
//! differs from the site in force.

use crate::model_files::{ModelFiles, names_of};
use bus::give_back_freed_memory;
use daemon::{
    CurrentActivity, Failure, FileStamp, Reporter, Revision, SiteConfig, chain, progress_in_force, rules_in_force,
};
use ingest::{IngestOptions, SiteFrame, ingest};
use messages::{Activity, Checked, SiteComparison, SiteOutline, Tasks, TasksBuilder, TasksHead, payload};
use schedule::{Overrides, Rules, evaluate, parse_actuals};
use std::path::PathBuf;

/// Shares of a load that are done when the files are in memory, when the site is made, and when its schedule is evaluated.
const FILES_READ: f64 = 0.02;
const SITE_MADE: f64 = 0.95;
const SCHEDULE_EVALUATED: f64 = 0.97;

/// What revisions are read with.
pub(crate) struct RevisionReader {
    /// The state folder, in which the progress in force lies.
    state: PathBuf,
    rules: Rules,
    /// Schedule files are in force, so that the tasks of models are not.
    has_schedule_files: bool,
    allow_boxes: bool,
    activity: CurrentActivity,
}

/// What a revision has to fit to.
#[derive(Clone, Copy)]
pub(crate) struct Compared<'a> {
    /// The frame that revisions of the building keep.
    pub(crate) frame: Option<SiteFrame>,
    /// The highest epoch that a frame of the site had; 0 before the first.
    pub(crate) last_epoch: u32,
    /// The site.
    pub(crate) outline: Option<&'a SiteOutline>,
}

/// A revision that could take effect.
pub(crate) struct ReadRevision {
    pub(crate) models: Vec<PathBuf>,
    /// What the files looked like when they were read.
    pub(crate) stamps: Vec<Option<FileStamp>>,
    pub(crate) site: Checked<payload::Site>,
    pub(crate) outline: SiteOutline,
    pub(crate) comparison: SiteComparison,
}

impl RevisionReader {
    /// With the rules in force.
    ///
    /// # Errors
    /// Rules that cannot be used.
    pub(crate) fn new(config: &SiteConfig, activity: CurrentActivity) -> Result<Self, Failure> {
        Ok(Self {
            state: config.state.clone(),
            rules: rules_in_force(config, Rules::parse)?,
            has_schedule_files: !config.schedule.files.is_empty(),
            allow_boxes: config.allow_boxes,
            activity,
        })
    }

    /// The same with another configuration.
    ///
    /// # Errors
    /// Rules that cannot be used.
    pub(crate) fn configured(&self, config: &SiteConfig) -> Result<Self, Failure> {
        Self::new(config, self.activity.clone())
    }

    /// Reads files.
    ///
    /// # Errors
    /// Files that cannot be read as a site, and a schedule that cannot be evaluated with the rules and progress in force.
    pub(crate) fn read(
        &self,
        files: ModelFiles,
        in_force: Compared<'_>,
        reporter: &Reporter,
    ) -> Result<ReadRevision, Failure> {
        self.activity.set(Activity::Reading);
        let ModelFiles { models, stamps, sources } = files;
        let activity = self.activity.clone();
        // A robot is localised in the frame of its site: a revision keeps it, another building has another.
        let options = IngestOptions {
            frame: in_force.frame,
            frame_of: in_force.outline,
            frame_epoch: in_force.last_epoch.saturating_add(1),
            places: &[],
            prefer_last: false,
            allow_boxes: self.allow_boxes,
            isolation: Some(&daemon::in_mesh_process),
            pool: None,
            progress: &|progress| {
                let stage =
                    if progress.stage == ingest::Stage::Meshing { Activity::Meshing } else { Activity::Reading };
                activity.set(stage);
                reporter.report(&progress.doing(), FILES_READ + (SITE_MADE - FILES_READ) * progress.share);
            },
        };
        reporter.report("reading files", FILES_READ);
        let site = Checked::<payload::Site>::new(ingest(&sources, &options)?)?;
        drop(sources);
        give_back_freed_memory();
        self.activity.set(Activity::Writing);
        reporter.report("evaluating the schedule", SITE_MADE);
        self.check_schedule(&models, &site)?;
        reporter.report("comparing with the site in force", SCHEDULE_EVALUATED);
        let outline = SiteOutline::of(&site.view());
        let comparison = match in_force.outline {
            Some(before) => SiteComparison::of(before, &outline),
            None => SiteComparison::of_first(&outline),
        };
        Ok(ReadRevision { models, stamps, site, outline, comparison })
    }

    /// Evaluates what the models say of the schedule as schedule-eval will: their dates and their tasks. Where schedule files are in
    /// force, the tasks of the models are not, and nothing of theirs is a reason against the revision.
    fn check_schedule(&self, models: &[PathBuf], site: &Checked<payload::Site>) -> Result<(), Failure> {
        let overrides = Overrides::in_force(progress_in_force(&self.state, parse_actuals)?);
        let site = site.view();
        let no_tasks = TasksBuilder { head: TasksHead::of_site(&site), ..TasksBuilder::default() }.finish();
        let no_tasks = Tasks::open(no_tasks.bytes())?;
        let scheduled = if self.has_schedule_files { site.with_tasks(&no_tasks)? } else { site };
        evaluate(&scheduled, &self.rules, &overrides)
            .map_err(|why| format!("the schedule of {} cannot be used: {}", names_of(models), chain(&why)))?;
        Ok(())
    }
}

impl ReadRevision {
    /// sha256 of each file.
    pub(crate) fn sha256(&self) -> Vec<[u8; 32]> {
        self.site.view().sources.iter().map(|source| source.sha256).collect()
    }

    /// What clients get of it.
    pub(crate) fn described(&self) -> Revision {
        Revision { models: self.models.clone(), comparison: self.comparison.clone() }
    }
}
