//! `groundplan convert`: the stages one after the other, archives in the heap.

mod args;
mod notices;
mod output;
mod plan_time_summary;
mod rooms;
mod storey_choice;
mod summary;

use crate::args::ScheduleInput;
use crate::date_argument;
use crate::failure::Failure;
use crate::input_document::read_document;
use crate::progress_line::ProgressLine;
use crate::run::{Outcome, Run};
pub use args::Args;
use bus::{give_back_freed_memory, keep_freed_memory, share_heap};
use daemon::WorldConfig;
use export::{ProbabilityInput, SiteFrameFile};
use ingest::SiteFrame;
use jiff::tz::TimeZone;
use messages::{ArchiveBuffer, Diagnostic, DiagnosticCode, DiagnosticRecord, ScheduleStateBuilder, Severity, Site};
use output::Job;
use raster::Rasterizer;
use schedule::{Period, Timeline, Uncertainty};
use site_files::OptionalFiles;
use std::time::Instant;
use summary::{Outputs, Summary};
use tracing::debug;
use waypoints::MissionPlanOptions;

/// Largest site of which the memory that reading took is kept for what comes next.
const MAX_SITE_BYTES: usize = 8 << 20;

/// Which maps are asked for.
enum RequestedMaps {
    /// Everything is built, without a date.
    Everything,
    /// At a date.
    At(Period),
    /// At every change.
    EveryChange,
}

impl Run for Args {
    /// Converts the models and writes the output folder and the recording.
    ///
    /// # Errors
    /// Bad arguments, models that cannot be read or do not belong together, dates that can be read in two ways, blank maps, a
    /// folder or file that cannot be written.
    fn run(&self) -> Result<Outcome, Failure> {
        let started = Instant::now();
        if self.model.n_threads() == 1 {
            share_heap();
        }
        let robot = self.robot.robot()?;
        let mut options = self.waypoint_options()?;
        let optional = self.optional_files.options(&WorldConfig::default())?;
        let schedule = ScheduleInput::read(&self.schedule)?;
        let requested_maps = self.requested_maps(schedule.site_zone())?;
        let folder = self.out.as_deref().map(|out| self.overwrite.folder_at(out)).transpose()?;
        self.check_outputs(&requested_maps, &optional)?;
        let frame = self.frame()?;
        let progress = ProgressLine::new(self.json);
        let pool = self.model.pool()?;
        let meshes = self.meshes.load()?;
        pool.install(|| {
            let epoch = frame.map_or(1, |f| f.frame_epoch.saturating_add(u32::from(self.new_frame)));
            let kept = frame.filter(|_| !self.new_frame);
            let site = self.model.site_with(meshes.as_ref(), &pool, kept, epoch, &progress)?;
            let mesh_counts = meshes.map(|meshes| {
                self.meshes.save(&meshes);
                meshes.counts()
            });
            keep_freed_memory();
            // Reading takes several times what the site does; of a small one the next stages take it.
            if site.bytes().len() > MAX_SITE_BYTES {
                give_back_freed_memory();
            }
            let site = Site::open(site.bytes()).map_err(Failure::work)?;
            let tasks = schedule.linked_tasks(&site)?;
            let site = tasks.site(&site)?;
            let (elements, spaces, map_storeys) = (site.elements.len(), site.spaces.len(), site.map_storeys.len());
            debug!(elements, spaces, map_storeys, elapsed_us = micros(started), "models read");
            waypoints::check_names(&site, &options).map_err(Failure::usage)?;
            options.storeys = storey_choice::chosen(&site, &self.storeys)?;
            let timeline = schedule.timeline(&site);
            debug!(tasks = site.schedule.tasks.len(), elapsed_us = micros(started), "schedule evaluated");
            let slice_progress = |done: usize, total: usize| progress.step("slicing", done, total);
            let resolution_m = self.robot.resolution;
            let mut rasterizer = Rasterizer::with_progress(&site, &robot.profile, resolution_m, &slice_progress)
                .map_err(Failure::work)?;
            let job = Job {
                arguments: self,
                robot: &robot,
                options: &options,
                optional: &optional,
                site: &site,
                progress: &progress,
                folder: folder.as_ref(),
            };
            let schedule_states = match requested_maps {
                RequestedMaps::Everything => {
                    let schedule_state = everything_built(&site, timeline);
                    vec![job.replace(&mut rasterizer, &schedule_state, None)?]
                }
                RequestedMaps::At(period) if self.probability => {
                    let timeline = timeline?;
                    let probabilities = schedule.probabilities(&site, &timeline)?;
                    debug!(elapsed_us = micros(started), "schedule simulated");
                    let there: Vec<f64> = probabilities.elements(period).into_iter().map(|e| e.there).collect();
                    let schedule_state = probabilities.schedule_state(period).finish();
                    let probability = probability_input(probabilities.uncertainty(), &there);
                    vec![job.replace(&mut rasterizer, &schedule_state, Some(probability))?]
                }
                RequestedMaps::At(period) => {
                    let schedule_state = timeline?.schedule_state(period).finish();
                    vec![job.replace(&mut rasterizer, &schedule_state, None)?]
                }
                RequestedMaps::EveryChange => match timeline {
                    Ok(timeline) if self.or_everything && timeline.instants_s().is_empty() => {
                        vec![job.replace(&mut rasterizer, &everything_built(&site, Ok(timeline)), None)?]
                    }
                    timeline => job.replace_by_all(&mut rasterizer, &timeline?)?,
                },
            };
            debug!(elapsed_us = micros(started), "output swapped in");
            let outputs = Outputs { out: self.out.clone(), mcap: self.mcap.clone() };
            let summary = Summary::of(&site, outputs, mesh_counts, schedule_states, started.elapsed(), self.json);
            Ok(summary.text().into())
        })
    }
}

impl Args {
    fn requested_maps(&self, site_zone: Option<&TimeZone>) -> Result<RequestedMaps, Failure> {
        let until = self.until.as_deref();
        match self.date.as_deref() {
            None if self.schedule.changes_dates() => {
                Err(Failure::usage("--delay and --actuals change dates: say which with --date"))
            }
            None => Ok(RequestedMaps::Everything),
            Some("all") if until.is_some() => Err(Failure::usage("--until ends a period, and --date all has none")),
            Some("all") if self.probability => {
                Err(Failure::usage("--probability needs one --date: probabilities change at all times"))
            }
            Some("all") => Ok(RequestedMaps::EveryChange),
            Some(date) => Ok(RequestedMaps::At(date_argument::period(date, until, site_zone)?)),
        }
    }

    /// Refuses options of outputs that are not asked for.
    fn check_outputs(&self, requested_maps: &RequestedMaps, optional: &OptionalFiles) -> Result<(), Failure> {
        if self.mcap.is_some() && !matches!(requested_maps, RequestedMaps::EveryChange) {
            return Err(Failure::usage("--mcap records every change: give --date all"));
        }
        if self.mcap.is_none() && (self.recording.grid_map || self.recording.speed_mask) {
            return Err(Failure::usage("--grid-map and --speed-mask say what is recorded: give --mcap"));
        }
        if self.out.is_none() && (optional.are_asked_for() || self.with_geometry) {
            return Err(Failure::usage(
                "--world, --cloud, --octomap, --fleet, --open-rmf, --with-ground and --with-geometry write into the output folder: \
                 give -o",
            ));
        }
        Ok(())
    }

    /// What waypoints are planned.
    fn waypoint_options(&self) -> Result<MissionPlanOptions, Failure> {
        let Some(path) = self.waypoints.as_deref() else { return Ok(MissionPlanOptions::default()) };
        daemon::read_parsed("options of waypoints", path, MissionPlanOptions::parse).map_err(Failure::usage)
    }

    /// The site's frame: of `--frame`, else of an earlier run into the same folder.
    fn frame(&self) -> Result<Option<SiteFrame>, Failure> {
        let earlier = self.out.as_ref().map(|out| out.join("site-frame.json")).filter(|path| path.is_file());
        let Some(path) = self.frame.as_ref().or(earlier.as_ref()) else { return Ok(None) };
        let unusable = |e: &dyn std::fmt::Display| Failure::usage(format!("frame file {}: {e}", path.display()));
        let bytes = read_document(path).map_err(|e| unusable(&e))?;
        let file = SiteFrameFile::parse(&bytes).map_err(|e| unusable(&format!("{:#}", Failure::usage(e))))?;
        Ok(Some(SiteFrame { map_from_world: file.motion(), frame_epoch: file.frame_epoch }))
    }
}

/// What an export says of the probabilities that its maps were decided by.
fn probability_input<'a>(uncertainty: &Uncertainty, there: &'a [f64]) -> ProbabilityInput<'a> {
    let Uncertainty { runs, seed, obstacle_above, floor_above, open_above, optimistic: _, pessimistic: _ } =
        *uncertainty;
    ProbabilityInput { runs, seed, obstacle_above, floor_above, open_above, there }
}

/// The schedule state in which everything is built, with dates and diagnostics of the schedule; unusable dates are no
/// error here.
fn everything_built(site: &Site<'_>, timeline: Result<Timeline, Failure>) -> ArchiveBuffer {
    let failure = match timeline {
        Ok(timeline) => return timeline.everything_built().finish(),
        Err(failure) => failure,
    };
    let mut schedule_state =
        ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), site.spaces.len());
    let diagnostic = Diagnostic {
        severity: Severity::Warning,
        code: DiagnosticCode::ScheduleUnusable,
        entity: None,
        source: None,
        message: format!("the schedule cannot be used: {failure:#}"),
    };
    schedule_state.diagnostics.push(DiagnosticRecord::of(&diagnostic, &mut schedule_state.texts));
    schedule_state.finish()
}

fn micros(since: Instant) -> u64 {
    u64::try_from(since.elapsed().as_micros()).unwrap_or(u64::MAX)
}
