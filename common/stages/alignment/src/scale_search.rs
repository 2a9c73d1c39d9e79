//! Alignment of a SLAM map of unknown scale.

use crate::alignment::{Alignment, Hint, candidates_of, judged};
use crate::prepared_map::PreparedMap;
use crate::scale::Scale;
use crate::thresholds::{MAX_SCALE, RIVAL_LEAD, SCALE_STEP};
use frames::Map;
use messages::AlignmentVerdict;
use occupancy::OccupancyMap;

/// Aligns a SLAM map after dividing its lengths by every scale of a geometric series from 1 / 1.25 to 1.25. The poses are
/// those of the divided map, `p_map = R(yaw) p_slam / scale + (x, y)`, and the scale is that of the best.
pub fn align_maps_at_any_scale(
    references: &[impl AsRef<PreparedMap<Map>>],
    map: &OccupancyMap,
    hint: Option<&Hint>,
) -> Alignment {
    let steps = libm::ceil(libm::log(MAX_SCALE) / libm::log(SCALE_STEP)) as i32;
    let at = |scale: f64| {
        let slam = PreparedMap::of_slam(&map.divided_by(scale));
        judged(references, &slam, &candidates_of(references, &[], &slam, hint, None))
    };
    let tried: Vec<(f64, Alignment)> =
        (-steps..=steps).map(|k| libm::pow(SCALE_STEP, f64::from(k))).map(|scale| (scale, at(scale))).collect();
    let log_odds = |found: &Alignment| found.poses.first().map_or(f64::NEG_INFINITY, |p| p.evidence.log_odds);
    let best = tried.iter().max_by(|a, b| log_odds(&a.1).total_cmp(&log_odds(&b.1)));
    let Some((coarse, first)) = best else { return at(1.0) };
    let exact = coarse * first.scale.map_or(1.0, |s| s.value);
    let mut found = at(exact);
    found.scale = found.scale.map(|s| Scale { value: exact * s.value, deviation: exact * s.deviation });
    let is_other = |scale: f64| libm::fabs(libm::log(scale / exact)) > 2.0 * libm::log(SCALE_STEP);
    let needed = log_odds(&found) - RIVAL_LEAD;
    let n_rivals = tried.iter().filter(|(scale, other)| is_other(*scale) && log_odds(other) >= needed).count();
    if found.verdict == AlignmentVerdict::Accepted && n_rivals > 0 {
        found.verdict = AlignmentVerdict::Ambiguous;
        found.reason = format!("the map fits at {} other scales almost as well", n_rivals);
    }
    found
}
