//! What differs between the maps of two dates.

use crate::draw_error::DrawError;
use crate::drawing::Drawing;
use crate::kept_rasterizer::KeptRasterizer;
use crate::maps::{MapInputs, with_maps};
use answers::changes::{Causes, Difference, Side, causes_of, difference};
use messages::{ScheduleState, Site};
use schedule::{Period, Timeline};
use waypoints::MissionPlanOptions;

/// Draws the maps of two instants of a schedule, civil seconds, and compares them.
///
/// # Errors
/// Maps that cannot be drawn.
pub fn difference_between<'s>(
    drawing: &Drawing<'_>,
    site: &'s Site<'_>,
    timeline: &Timeline,
    [from_s, to_s]: [i64; 2],
    kept: &mut KeptRasterizer,
) -> Result<Difference<'s>, DrawError> {
    let mut side = |at_s| side_at(drawing, timeline, at_s, kept);
    let (before, after) = (side(from_s)?, side(to_s)?);
    let between = from_s.min(to_s) + 1..=from_s.max(to_s);
    let changes = timeline.changes().into_iter().filter(|change| between.contains(&change.at_s));
    let causes: Vec<Causes<'s>> =
        changes.map(|change| causes_of(site, timeline, &change)).filter(|causes| !causes.is_empty()).collect();
    Ok(difference(site, &before, &after, causes))
}

/// Draws and plans the maps of one of the two dates.
fn side_at(
    drawing: &Drawing<'_>,
    timeline: &Timeline,
    at_s: i64,
    kept: &mut KeptRasterizer,
) -> Result<Side, DrawError> {
    let Drawing { site, robot, progress, .. } = *drawing;
    let schedule_state = timeline.schedule_state(Period::instant(at_s)).finish();
    let schedule_state = ScheduleState::open(schedule_state.bytes())?;
    let options = MissionPlanOptions::centres_only();
    let inputs = MapInputs { site, schedule_state: &schedule_state, robot, options: &options, progress };
    let rasterizer = kept.of(site, &robot.profile, drawing.resolution_m)?;
    with_maps(&inputs, rasterizer, |maps| Ok(Side::of(site, at_s, &schedule_state, maps.index, maps.mission_plan)))
}
