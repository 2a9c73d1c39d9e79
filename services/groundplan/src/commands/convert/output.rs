//! Writes the files of schedule states into an output folder.

use super::args::Args;
use super::plan_time_summary::PlanTimeSummary;
use crate::args::report_set_aside;
use crate::date_argument;
use crate::failure::Failure;
use crate::maps::{Maps, with_maps, world_files};
use crate::progress::ProgressLine;
use daemon::Robot;
use export::{DatedFolder, ExportFile, ExportInput, OutputFolder};
use messages::{ArchiveBuffer, Grid, ScheduleState, Site};
use raster::Rasterizer;
use schedule::{Period, Timeline};
use std::collections::BTreeMap;
use waypoints::MissionPlanOptions;
use world::WorldOptions;

/// The maps of a schedule state.
struct Drawn {
    files: Vec<ExportFile>,
    summary: PlanTimeSummary,
    /// True if the robot can stand at the start that it is given, or why it cannot; false without a start or any floor.
    start: Result<bool, String>,
}

/// What all maps of a conversion share.
pub(super) struct Job<'a> {
    pub(super) arguments: &'a Args,
    pub(super) robot: &'a Robot,
    pub(super) options: &'a MissionPlanOptions,
    pub(super) world: Option<&'a WorldOptions>,
    pub(super) site: &'a Site<'a>,
    pub(super) rasterizer: Rasterizer,
}

impl Job<'_> {
    /// One schedule state is the whole output.
    pub(super) fn replace(
        &mut self,
        folder: &OutputFolder,
        progress: &ProgressLine,
        schedule_state: &ArchiveBuffer,
    ) -> Result<PlanTimeSummary, Failure> {
        let Drawn { files, summary, start } = self.draw(schedule_state, progress)?;
        start.map_err(Failure::usage)?;
        report_set_aside(folder.replace(&files).map_err(Failure::work)?);
        Ok(summary)
    }

    /// A folder per change, and a manifest of them.
    pub(super) fn replace_by_all(
        &mut self,
        folder: &OutputFolder,
        progress: &ProgressLine,
        timeline: &Timeline,
    ) -> Result<Vec<PlanTimeSummary>, Failure> {
        if timeline.instants_s().is_empty() {
            return Err(Failure::work("nothing of the model has a date, so nothing ever changes: leave --date out"));
        }
        let beside = folder.begin().map_err(Failure::work)?;
        let mut summaries = Vec::new();
        let (mut dated, mut sums) = (Vec::new(), BTreeMap::new());
        let (mut stands, mut why_not) = (false, None);
        for &at_s in timeline.instants_s() {
            let schedule_state = timeline.schedule_state(Period::instant(at_s)).finish();
            let Drawn { files, summary, start } = self.draw(&schedule_state, progress)?;
            match start {
                Ok(now) => stands |= now,
                Err(why) => why_not = Some(why),
            }
            let directory = date_argument::text(at_s).replace(':', "-");
            beside.write(&directory, &files).map_err(Failure::work)?;
            sums.extend(export::sums(&directory, &files));
            let valid_until = ScheduleState::open(schedule_state.bytes()).map_err(Failure::work)?.head.valid_until_s;
            let valid_until = messages::plan_time(valid_until).map(|t| t.to_string());
            dated.push(DatedFolder { plan_time: date_argument::text(at_s), valid_until, directory });
            summaries.push(summary);
        }
        // A start may be blocked at some dates; at all of them it is wrong.
        if let Some(why) = why_not.filter(|_| !stands) {
            return Err(Failure::usage(why));
        }
        beside.write("", &export::dated_files(self.site, dated, sums)).map_err(Failure::work)?;
        report_set_aside(beside.swap_in().map_err(Failure::work)?);
        Ok(summaries)
    }

    /// From a schedule state to its files.
    fn draw(&mut self, schedule_state: &ArchiveBuffer, progress: &ProgressLine) -> Result<Drawn, Failure> {
        let Self { site, arguments, robot, options, world, ref mut rasterizer } = *self;
        let schedule_state = ScheduleState::open(schedule_state.bytes()).map_err(Failure::work)?;
        progress.stage("drawing");
        with_maps(site, &schedule_state, rasterizer, robot, options, |maps: &Maps<'_>| {
            // Before anything is built a map is blank for a reason.
            let is_written = |grid: &&Grid<'_>| options.storeys.contains(&grid.head.map_storey);
            let written: Vec<Grid<'_>> = maps.grids.iter().filter(is_written).copied().collect();
            if !arguments.allow_empty && schedule_state.head.plan_time().is_none() {
                raster::check_not_blank(site, &written).map_err(Failure::work)?;
            }
            progress.stage("writing");
            let input = ExportInput {
                site,
                schedule_state: &schedule_state,
                index: maps.index,
                grids: &written,
                mission_plan: maps.mission_plan,
                footprints: maps.footprints,
                resolution_m: arguments.robot.resolution,
                with_geometry: arguments.with_geometry,
            };
            let start =
                options.start.map_or(Ok(false), |start| maps.check_start(site, &schedule_state, options, start));
            Ok(Drawn {
                files: export::files(&input, world_files(&input, world)),
                summary: PlanTimeSummary::of(&input),
                start,
            })
        })
    }
}
