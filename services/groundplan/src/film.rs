//! Sets of maps as a recording: maps and markers as ROS 2 messages, of every change instant or as the daemons publish them.

use crate::args::RecordingArgs;
use crate::date_argument;
use crate::failure::Failure;
use crate::recording::{FinishedRecording, Recording, RecordingError};
use export::ExportInput;
use messages::{ContentId, Grid, Site};
use ros::msg::builtin_interfaces::Time;
use ros::msg::tf2_msgs::TFMessage;
use ros::relief::{foxglove_grid, grid_map};
use ros::topics::{NAMESPACE, StoreyTopics, TF_STATIC, storey_name};
use ros::{Layers, Relief, maps, markers, transforms};
use safety::{SafetyInput, speed_mask, speed_step_m_s};
use std::collections::BTreeMap;
use std::path::Path;

/// The frame of the site: that of all maps if there is one storey.
const SITE_FRAME: &str = "map";

/// A recording of sets of maps that is being written.
pub(crate) struct Film {
    recording: Recording,
    arguments: RecordingArgs,
    /// By map storey.
    storeys: BTreeMap<u32, FilmStorey>,
    /// True once the frames of the storeys were written.
    has_frames: bool,
}

/// Where the messages of a storey go.
struct FilmStorey {
    frame_id: String,
    topics: StoreyTopics,
}

impl Film {
    /// Begins the recording of some map storeys of a site.
    ///
    /// One storey has the frame `map` and topics below `/groundplan`; several have a frame and a namespace each.
    ///
    /// # Errors
    /// A file of another kind at the path, a folder that cannot be written.
    pub(crate) fn begin(
        path: &Path,
        site: &Site<'_>,
        map_storeys: &[u32],
        arguments: RecordingArgs,
        facts: Facts,
    ) -> Result<Self, Failure> {
        let mut recording = Recording::begin(path).map_err(|error| match error {
            RecordingError::Foreign { .. } => Failure::usage(error),
            _ => Failure::work(error),
        })?;
        describe(&mut recording, site, facts).map_err(Failure::work)?;
        let storeys = map_storeys.iter().map(|&map_storey| (map_storey, FilmStorey::of(site, map_storey, map_storeys)));
        Ok(Self { recording, arguments, storeys: storeys.collect(), has_frames: false })
    }

    /// Adds the maps and markers at a change instant, stamped with the plan time.
    ///
    /// # Errors
    /// A plan time that stamps do not reach, a disk that is full.
    pub(crate) fn add_at_plan_time(&mut self, input: &ExportInput<'_>) -> Result<(), Failure> {
        let plan_time_s = input.schedule_state.head.plan_time_s;
        let (stamp, at_ns) = stamp_of(plan_time_s).ok_or_else(|| {
            let at = date_argument::text(plan_time_s);
            Failure::work(format!("{at} cannot be recorded: stamps of ROS 2 are from 1970 to 2038-01-19"))
        })?;
        self.add_at(input, stamp, at_ns).map_err(Failure::work)
    }

    /// Adds the maps and markers of an instant, nanoseconds since 1970. Storeys that the recording did not begin with are left
    /// out.
    ///
    /// # Errors
    /// A disk that is full.
    pub(crate) fn add_at(&mut self, input: &ExportInput<'_>, stamp: Time, at_ns: u64) -> Result<(), RecordingError> {
        self.add_frames(input.site, stamp, at_ns)?;
        (0..input.grids.count())
            .try_for_each(|at| input.grids.with(at, |grid| self.add_storey(input, grid, stamp, at_ns)))
    }

    /// Where the frames of several storeys lie, once.
    fn add_frames(&mut self, site: &Site<'_>, stamp: Time, at_ns: u64) -> Result<(), RecordingError> {
        if std::mem::replace(&mut self.has_frames, true) || self.storeys.len() < 2 {
            return Ok(());
        }
        let frame = |(&map_storey, storey): (&u32, &FilmStorey)| {
            transforms::storey(&site.map_storeys[map_storey as usize], SITE_FRAME, &storey.frame_id, stamp)
        };
        self.recording.add(TF_STATIC, at_ns, &TFMessage { transforms: self.storeys.iter().map(frame).collect() })
    }

    /// The keep-out mask is first: a player that follows never has a map without the mask that it needs.
    fn add_storey(
        &mut self,
        input: &ExportInput<'_>,
        grid: &Grid<'_>,
        stamp: Time,
        at_ns: u64,
    ) -> Result<(), RecordingError> {
        let (site, plan, map_storey) = (input.site, input.mission_plan, grid.head.map_storey);
        let Some(FilmStorey { frame_id, topics }) = self.storeys.get(&map_storey) else { return Ok(()) };
        let recording = &mut self.recording;
        let mut layers = Layers::of(grid);
        if self.arguments.speed_mask {
            let safety_input = SafetyInput { site, schedule_state: input.schedule_state, index: input.index };
            layers = layers.with_speed(speed_mask(safety_input, grid));
        }
        let keepout_info = maps::keepout_info(&topics.keepout_mask, frame_id, stamp);
        recording.add(&topics.keepout_info, at_ns, &keepout_info)?;
        recording.add(&topics.keepout_mask, at_ns, &maps::keepout_mask(&layers, frame_id, stamp))?;
        if let Some(mask) = maps::speed_mask(&layers, frame_id, stamp) {
            let step_m_s = speed_step_m_s(input.index.safety_rules);
            let speed_info = maps::speed_info(&topics.speed_mask, step_m_s, frame_id, stamp);
            recording.add(&topics.speed_info, at_ns, &speed_info)?;
            recording.add(&topics.speed_mask, at_ns, &mask)?;
        }
        recording.add(&topics.map, at_ns, &maps::planning(&layers, frame_id, stamp))?;
        recording.add(&topics.localization_map, at_ns, &maps::localization(&layers, frame_id, stamp))?;
        if self.arguments.grid_map {
            let relief = Relief::of(grid, &input.index.head.robot);
            recording.add(&topics.grid_map, at_ns, &grid_map(&relief, frame_id, stamp))?;
            recording.add(&topics.elevation, at_ns, &foxglove_grid(&relief, frame_id, stamp))?;
        }
        let rooms = markers::together([
            markers::rooms(site, input.schedule_state, map_storey, frame_id, stamp),
            markers::doors(site, input.index, map_storey, frame_id, stamp),
            markers::drop_offs(grid, frame_id, stamp),
        ]);
        recording.add(&topics.rooms, at_ns, &rooms)?;
        recording.add(&topics.waypoints, at_ns, &markers::waypoints(site, plan, map_storey, frame_id, stamp))?;
        recording.add(&topics.route, at_ns, &markers::route(site, plan, map_storey, frame_id, stamp))
    }

    /// The whole recording, on disk beside its place.
    pub(crate) fn finish(self) -> Result<FinishedRecording, Failure> {
        self.recording.finish().map_err(Failure::work)
    }
}

impl FilmStorey {
    fn of(site: &Site<'_>, map_storey: u32, all: &[u32]) -> Self {
        if all.len() == 1 {
            return Self { frame_id: SITE_FRAME.to_owned(), topics: StoreyTopics::below(NAMESPACE) };
        }
        let frame_id = storey_name(site, map_storey);
        Self { topics: StoreyTopics::below(&format!("{NAMESPACE}/{frame_id}")), frame_id }
    }
}

/// What a recording says of itself, beside its models.
pub(crate) struct Facts {
    /// What the stamps are.
    pub(crate) time: FilmTime,
    pub(crate) robot: String,
    pub(crate) resolution_m: f64,
}

/// The time of a recording.
pub(crate) enum FilmTime {
    /// Plan time, at so many change instants.
    Plan { n_change_instants: usize },
    /// That of the machine.
    Machine,
}

/// A record `groundplan` of the whole, and a record `model` for each file.
fn describe(recording: &mut Recording, site: &Site<'_>, facts: Facts) -> Result<(), RecordingError> {
    let named =
        |facts: &[(&str, String)]| facts.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
    let time = match facts.time {
        FilmTime::Plan { .. } => "civil time at the site, written as if it were UTC",
        FilmTime::Machine => "of the machine, when the maps were published",
    };
    let mut whole = vec![
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("time", time.to_owned()),
        ("robot", facts.robot),
        ("resolution_m", facts.resolution_m.to_string()),
        ("frame_epoch", site.head.frame_epoch.to_string()),
    ];
    if let FilmTime::Plan { n_change_instants } = facts.time {
        whole.push(("change_instants", n_change_instants.to_string()));
    }
    recording.describe("groundplan", named(&whole))?;
    for source in site.sources {
        let model = [
            ("file", site.text(source.file).to_owned()),
            ("schema", site.text(source.schema).to_owned()),
            ("sha256", ContentId::from_sha256(source.sha256).to_string()),
        ];
        recording.describe("model", named(&model))?;
    }
    Ok(())
}

/// Stamp and nanoseconds of civil seconds, taken for seconds in UTC: in order and without the gaps of summer time. `None` where
/// stamps do not reach.
fn stamp_of(civil_s: i64) -> Option<(Time, u64)> {
    let stamp = Time::of_unix_s(civil_s)?;
    let at_ns = u64::try_from(civil_s).ok()?.checked_mul(1_000_000_000)?;
    Some((stamp, at_ns))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_reach_from_1970_to_2038() {
        let check = |text: &str| stamp_of(date_argument::instant_s(text, None).unwrap()).map(|(_, ns)| ns);
        assert_eq!(check("1970-01-01T00:00:01"), Some(1_000_000_000));
        assert_eq!(check("2024-04-27T00:00:00"), Some(1_714_176_000_000_000_000));
        assert_eq!((check("1969-12-31T23:59:59"), check("2038-01-19T03:14:08")), (None, None));
        assert!(check("2038-01-19T03:14:07").is_some());
        assert_eq!(stamp_of(messages::ScheduleStateHead::NO_TIME).map(|(_, ns)| ns), None);
    }
}
