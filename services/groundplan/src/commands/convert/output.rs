//! Writes the files of schedule states into an output folder, and their messages into a recording.

use super::args::Args;
use super::plan_time_summary::PlanTimeSummary;
use crate::args::report_set_aside;
use crate::date_argument;
use crate::failure::Failure;
use crate::film::{Facts, Film, FilmTime};
use crate::maps::{Maps, with_maps, world_files};
use crate::progress_line::ProgressLine;
use crate::recording::FinishedRecording;
use daemon::Robot;
use export::{DatedFolder, ExportFile, ExportInput, OutputFolder, ProbabilityInput};
use messages::{ArchiveBuffer, Grid, ScheduleState, Site};
use raster::Rasterizer;
use schedule::{Period, Timeline};
use std::collections::BTreeMap;
use std::path::PathBuf;
use waypoints::MissionPlanOptions;
use world::WorldOptions;

/// The maps of a schedule state.
struct Drawn {
    /// None without an output folder.
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
    /// Where the files go, if they are asked for.
    pub(super) folder: Option<&'a OutputFolder>,
}

impl Job<'_> {
    /// One schedule state is the whole output.
    pub(super) fn replace(
        &mut self,
        progress: &ProgressLine,
        schedule_state: &ArchiveBuffer,
        probability: Option<ProbabilityInput<'_>>,
    ) -> Result<PlanTimeSummary, Failure> {
        let Drawn { files, summary, start } = self.draw(schedule_state, probability, None, progress)?;
        start.map_err(Failure::usage)?;
        if let Some(folder) = self.folder {
            report_set_aside(folder.replace(&files).map_err(Failure::work)?);
        }
        Ok(summary)
    }

    /// A folder per change and a manifest of them, and a recording of all changes.
    pub(super) fn replace_by_all(
        &mut self,
        progress: &ProgressLine,
        timeline: &Timeline,
    ) -> Result<Vec<PlanTimeSummary>, Failure> {
        if timeline.instants_s().is_empty() {
            return Err(Failure::work("nothing of the model has a date, so nothing ever changes: leave --date out"));
        }
        let beside = self.folder.map(OutputFolder::begin).transpose().map_err(Failure::work)?;
        let mut film = self.film(timeline.instants_s().len())?;
        let mut summaries = Vec::new();
        let (mut dated, mut sums) = (Vec::new(), BTreeMap::new());
        let (mut stands, mut why_not) = (false, None);
        for &at_s in timeline.instants_s() {
            let schedule_state = timeline.schedule_state(Period::instant(at_s)).finish();
            let Drawn { files, summary, start } = self.draw(&schedule_state, None, film.as_mut(), progress)?;
            match start {
                Ok(now) => stands |= now,
                Err(why) => why_not = Some(why),
            }
            summaries.push(summary);
            let Some(beside) = &beside else { continue };
            let directory = date_argument::text(at_s).replace(':', "-");
            beside.write(&directory, &files).map_err(Failure::work)?;
            sums.extend(export::sums(&directory, &files));
            let valid_until = ScheduleState::open(schedule_state.bytes()).map_err(Failure::work)?.head.valid_until_s;
            let valid_until = messages::plan_time(valid_until).map(|t| t.to_string());
            dated.push(DatedFolder { plan_time: date_argument::text(at_s), valid_until, directory });
        }
        // A start may be blocked at some dates; at all of them it is wrong.
        if let Some(why) = why_not.filter(|_| !stands) {
            return Err(Failure::usage(why));
        }
        // Both are on disk before one is moved to its place.
        let recording = film.map(Film::finish).transpose()?;
        if let Some(beside) = beside {
            beside.write("", &export::dated_files(self.site, dated, sums)).map_err(Failure::work)?;
            report_set_aside(beside.swap_in().map_err(Failure::work)?);
        }
        recording.map_or(Ok(()), FinishedRecording::swap_in).map_err(Failure::work)?;
        Ok(summaries)
    }

    /// The recording, if one is asked for.
    fn film(&self, n_change_instants: usize) -> Result<Option<Film>, Failure> {
        let begin = |path: &PathBuf| {
            let (robot, resolution_m) = (self.robot.name.clone(), self.arguments.robot.resolution);
            Film::begin(
                path,
                self.site,
                &self.options.storeys,
                Facts { time: FilmTime::Plan { n_change_instants }, robot, resolution_m },
            )
        };
        self.arguments.mcap.as_ref().map(begin).transpose()
    }

    /// From a schedule state to its files, and to its messages in a recording.
    fn draw(
        &mut self,
        schedule_state: &ArchiveBuffer,
        probability: Option<ProbabilityInput<'_>>,
        film: Option<&mut Film>,
        progress: &ProgressLine,
    ) -> Result<Drawn, Failure> {
        let Self { site, arguments, robot, options, world, ref mut rasterizer, folder } = *self;
        let schedule_state = ScheduleState::open(schedule_state.bytes()).map_err(Failure::work)?;
        with_maps(site, &schedule_state, rasterizer, robot, options, progress, |maps: &Maps<'_>| {
            // Before anything is built a map is blank for a reason.
            let is_written = |grid: &&Grid<'_>| options.storeys.contains(&grid.head.map_storey);
            let written: Vec<Grid<'_>> = maps.grids.iter().filter(is_written).copied().collect();
            if !arguments.allow_empty && schedule_state.head.plan_time().is_none() {
                raster::check_not_blank(site, &written).map_err(Failure::work)?;
            }
            progress.stage("writing");
            if folder.is_some() {
                maps.unite_footprints(site);
            }
            let input = ExportInput {
                site,
                schedule_state: &schedule_state,
                index: maps.index,
                grids: &written,
                mission_plan: maps.mission_plan,
                footprints: maps.footprints,
                resolution_m: arguments.robot.resolution,
                with_geometry: arguments.with_geometry,
                probability,
            };
            let start =
                options.start.map_or(Ok(false), |start| maps.check_start(site, &schedule_state, options, start));
            if let Some(film) = film {
                film.add_at_plan_time(&input)?;
            }
            let files = folder.map_or_else(Vec::new, |_| export::files(&input, world_files(&input, world)));
            Ok(Drawn { files, summary: PlanTimeSummary::of(&input), start })
        })
    }
}
