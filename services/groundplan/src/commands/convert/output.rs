//! Writes the files of schedule states into an output folder, and their messages into a recording.

use super::args::Args;
use super::plan_time_summary::PlanTimeSummary;
use crate::args::report_set_aside;
use crate::date_argument;
use crate::failure::Failure;
use crate::film::{Facts, Film, FilmTime};
use crate::progress_line::ProgressLine;
use crate::recording::FinishedRecording;
use daemon::Robot;
use export::{DatedFolder, ExportInput, FolderBeside, OutputFolder, ProbabilityInput};
use messages::{ArchiveBuffer, ChosenGrids, ScheduleState, Site};
use raster::Rasterizer;
use schedule::{Period, Timeline};
use site_answers::{MapInputs, Maps, with_maps, with_maps_once};
use site_files::OptionalFiles;
use std::collections::BTreeMap;
use std::path::PathBuf;
use waypoints::MissionPlanOptions;
use world::WorldFiles;

/// What became of the maps of a schedule state.
struct Written {
    /// Sums of the files, by their path; none without an output folder.
    sums: BTreeMap<String, String>,
    summary: PlanTimeSummary,
    /// True if the robot can stand at the start that it is given, or why it cannot; false without a start or any floor.
    start: Result<bool, String>,
}

/// What all maps of a conversion share.
pub(super) struct Job<'a> {
    pub(super) arguments: &'a Args,
    pub(super) robot: &'a Robot,
    pub(super) options: &'a MissionPlanOptions,
    pub(super) optional: &'a OptionalFiles,
    pub(super) site: &'a Site<'a>,
    pub(super) progress: &'a ProgressLine,
    /// Where the files go, if they are asked for.
    pub(super) folder: Option<&'a OutputFolder>,
}

impl Job<'_> {
    /// One schedule state is the whole output.
    pub(super) fn replace(
        &self,
        rasterizer: &mut Rasterizer,
        schedule_state: &ArchiveBuffer,
        probability: Option<ProbabilityInput<'_>>,
    ) -> Result<PlanTimeSummary, Failure> {
        let schedule_state = ScheduleState::open(schedule_state.bytes()).map_err(Failure::work)?;
        with_maps_once(&self.inputs(&schedule_state), rasterizer, |maps| {
            let grids = self.grids_to_write(&schedule_state, maps)?;
            let mut beside = self.folder.map(OutputFolder::begin).transpose().map_err(Failure::work)?;
            let place = beside.as_mut().map(|beside| (beside, ""));
            let Written { summary, start, .. } = self.write(&schedule_state, maps, &grids, probability, None, place)?;
            start.map_err(Failure::usage)?;
            if let Some(beside) = beside {
                report_set_aside(beside.swap_in().map_err(Failure::work)?);
            }
            Ok(summary)
        })
    }

    /// A folder per change and a manifest of them, and a recording of all changes.
    pub(super) fn replace_by_all(
        &self,
        rasterizer: &mut Rasterizer,
        timeline: &Timeline,
    ) -> Result<Vec<PlanTimeSummary>, Failure> {
        if timeline.instants_s().is_empty() {
            return Err(Failure::work("nothing of the model has a date, so nothing ever changes: leave --date out"));
        }
        let mut beside = self.folder.map(OutputFolder::begin).transpose().map_err(Failure::work)?;
        let mut film = self.film(timeline.instants_s().len())?;
        let mut summaries = Vec::new();
        let (mut dated, mut sums) = (Vec::new(), BTreeMap::new());
        let (mut stands, mut why_not) = (false, None);
        for &at_s in timeline.instants_s() {
            let schedule_state = timeline.schedule_state(Period::instant(at_s)).finish();
            let schedule_state = ScheduleState::open(schedule_state.bytes()).map_err(Failure::work)?;
            let directory = date_argument::text(at_s).replace(':', "-");
            let written = with_maps(&self.inputs(&schedule_state), rasterizer, |maps| {
                let grids = self.grids_to_write(&schedule_state, maps)?;
                let place = beside.as_mut().map(|beside| (beside, directory.as_str()));
                self.write(&schedule_state, maps, &grids, None, film.as_mut(), place)
            });
            let Written { sums: sums_of_date, summary, start } = written?;
            match start {
                Ok(now) => stands |= now,
                Err(why) => why_not = Some(why),
            }
            summaries.push(summary);
            if beside.is_none() {
                continue;
            }
            sums.extend(sums_of_date.into_iter().map(|(path, sum)| (format!("{directory}/{path}"), sum)));
            let valid_until = messages::plan_time(schedule_state.head.valid_until_s).map(|t| t.to_string());
            dated.push(DatedFolder { plan_time: date_argument::text(at_s), valid_until, directory });
        }
        // A start may be blocked at some dates; at all of them it is wrong.
        if let Some(why) = why_not.filter(|_| !stands) {
            return Err(Failure::usage(why));
        }
        // Both are on disk before one is moved to its place.
        let recording = film.map(Film::finish).transpose()?;
        if let Some(mut beside) = beside {
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
                self.arguments.recording,
                Facts { time: FilmTime::Plan { n_change_instants }, robot, resolution_m },
            )
        };
        self.arguments.mcap.as_ref().map(begin).transpose()
    }

    fn inputs<'b>(&'b self, schedule_state: &'b ScheduleState<'b>) -> MapInputs<'b> {
        let Self { site, robot, options, progress, .. } = *self;
        MapInputs { site, schedule_state, robot, options, progress }
    }

    /// The grids of the storeys that are asked for.
    fn grids_to_write<'b>(
        &self,
        schedule_state: &ScheduleState<'_>,
        maps: &Maps<'b>,
    ) -> Result<ChosenGrids<'b>, Failure> {
        let grids = ChosenGrids::of(maps.grids, |head| self.options.storeys.contains(&head.map_storey));
        // Before anything is built a map is blank for a reason.
        if !self.arguments.allow_empty && schedule_state.head.plan_time().is_none() {
            raster::check_not_blank(self.site, &grids).map_err(Failure::work)?;
        }
        Ok(grids)
    }

    /// Writes the files of a schedule state into a folder of the output, each as soon as it is made, and its messages into a
    /// recording.
    fn write(
        &self,
        schedule_state: &ScheduleState<'_>,
        maps: &Maps<'_>,
        grids: &ChosenGrids<'_>,
        probability: Option<ProbabilityInput<'_>>,
        film: Option<&mut Film>,
        place: Option<(&mut FolderBeside<'_>, &str)>,
    ) -> Result<Written, Failure> {
        let Self { site, arguments, options, optional, progress, .. } = *self;
        progress.stage("writing");
        if place.is_some() && (arguments.exact_footprints || probability.is_some()) {
            maps.unite_footprints(site);
        }
        let input = ExportInput {
            site,
            schedule_state,
            index: maps.index,
            grids,
            mission_plan: maps.mission_plan,
            footprints: maps.footprints,
            resolution_m: arguments.robot.resolution,
            with_geometry: arguments.with_geometry,
            exact_footprints: arguments.exact_footprints,
            probability,
        };
        let start = options.start.map_or(Ok(false), |start| maps.check_start(site, schedule_state, options, start));
        if let Some(film) = film {
            film.add_at_plan_time(&input)?;
        }
        let mut sums = BTreeMap::new();
        let mut world_diagnostics = Vec::new();
        if let Some((beside, directory)) = place {
            let write = |file| beside.write(directory, &[file]);
            let WorldFiles { files, diagnostics } =
                optional.files(&input, maps.grids, &|| true).map_err(Failure::work)?;
            sums = export::each_file_while_writing(&input, files, write).map_err(Failure::work)?;
            world_diagnostics = diagnostics;
        }
        Ok(Written { sums, summary: PlanTimeSummary::of(&input, &world_diagnostics), start })
    }
}
