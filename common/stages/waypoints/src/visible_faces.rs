//! Target faces visible from a scan pose by range, incidence, field of view and line of sight.

use crate::target_face::{FaceTile, TargetFace, TargetFaces};
use grid::{BlockedSectors, LineOfSight};
use messages::ScanSensor;
use std::f64::consts::{PI, TAU};

/// Limits of a sensor, lengths in cells.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SensorLimits {
    range: f64,
    min_range_squared: f64,
    /// Squared cosine of the largest angle of incidence.
    cos_squared: f64,
    half_view_rad: f64,
}

/// Angle between the rays from a face on which a place is looked for: two and a half degrees.
const RAY_STEP_RAD: f64 = PI / 72.0;

/// Faces near a place from which on it pays to look around it first: looking around costs as much as lines to so many.
const MIN_FACES_BEHIND: usize = 400;

/// Lines of sight that are cast at once.
const N_LINES: usize = 4;

/// A position in cells and a heading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct ScanPose {
    pub(crate) at: [f64; 2],
    pub(crate) yaw_rad: f64,
}

impl SensorLimits {
    pub(crate) fn of(sensor: &ScanSensor, resolution_m: f64) -> Self {
        let cells = |m: f64| m / resolution_m;
        let cos = libm::cos(sensor.max_incidence_rad.clamp(0.0, PI / 2.0)).max(0.0);
        Self {
            range: cells(sensor.range_m),
            min_range_squared: cells(sensor.min_range_m) * cells(sensor.min_range_m),
            cos_squared: cos * cos,
            half_view_rad: if sensor.sees_around() { f64::INFINITY } else { sensor.field_of_view_rad / 2.0 },
        }
    }

    /// Faces visible all around from a position, ascending: in range, within the angle of incidence, with a line of sight
    /// over free cells.
    pub(crate) fn visible_around(&self, sight: &LineOfSight, faces: &TargetFaces, at: [f64; 2]) -> Vec<u32> {
        let tiles: Vec<FaceTile> = faces.near(at, self.range).collect();
        let n_faces: usize = tiles.iter().map(|tile| tile.faces.len()).sum();
        // Most of many faces stand behind walls of other rooms.
        let sectors = (n_faces > MIN_FACES_BEHIND).then(|| BlockedSectors::around(sight, at, self.range));
        let offset = |to: [f64; 2]| [to[0] - at[0], to[1] - at[1]];
        let may_be_seen = |tile: &FaceTile| {
            !sectors.as_ref().is_some_and(|sectors| sectors.hides_all([tile.low, tile.high].map(offset)))
        };
        let is_candidate = |k: &u32| {
            let face = &faces.all[*k as usize];
            self.faces_towards(face, at) && !sectors.as_ref().is_some_and(|sectors| sectors.hides(offset(face.middle)))
        };
        let open = tiles.into_iter().filter(may_be_seen);
        let candidates: Vec<u32> = open.flat_map(|tile| tile.faces).filter(is_candidate).collect();
        let middle = |k: u32| faces.all[k as usize].middle;
        let mut seen = Vec::with_capacity(candidates.len());
        let (several, rest) = candidates.as_chunks::<N_LINES>();
        for some in several {
            let clear = sight.are_clear(at, some.map(middle));
            seen.extend(some.iter().zip(clear).filter(|(_, clear)| *clear).map(|(k, _)| *k));
        }
        seen.extend(rest.iter().filter(|k| sight.is_clear(at, middle(**k))));
        seen
    }

    /// Of the faces visible from the position of a pose, those in its field of view.
    pub(crate) fn in_field_of_view(&self, faces: &TargetFaces, seen: &[u32], pose: ScanPose) -> Vec<u32> {
        let is_in_view = |&&k: &&u32| {
            let middle = faces.all[k as usize].middle;
            let bearing = libm::atan2(middle[1] - pose.at[1], middle[0] - pose.at[0]);
            turn_between(bearing, pose.yaw_rad) <= self.half_view_rad
        };
        seen.iter().filter(is_in_view).copied().collect()
    }

    /// A cell of those that fit from whose middle a face is seen, looked for along rays from the face, its middle direction and
    /// those near to it first.
    pub(crate) fn cell_that_sees(
        &self,
        sight: &LineOfSight,
        face: &TargetFace,
        fits: impl Fn(usize) -> bool,
    ) -> Option<usize> {
        let bearing = libm::atan2(f64::from(face.side[1]), f64::from(face.side[0]));
        let n_rays = (PI / 2.0 / RAY_STEP_RAD) as i32;
        // Straight in front of a face that lies in a slot there is more to see it from than beside.
        let beside = (0..n_rays).flat_map(|k| [f64::from(k) + 0.5, -f64::from(k) - 0.5]);
        let turns = std::iter::once(0.0).chain(beside);
        turns.map(|turn| libm::sincos(bearing + turn * RAY_STEP_RAD)).find_map(|(sin, cos)| {
            let along = cos * face.normal[0] + sin * face.normal[1];
            if along <= 0.0 || along * along < self.cos_squared {
                return None;
            }
            let length = sight.run(face.middle, [cos, sin], self.range);
            let first = self.min_range_squared.sqrt().ceil();
            let cell_after = |gone: f64| sight.cell_at([face.middle[0] + cos * gone, face.middle[1] + sin * gone]);
            let steps = (0..=(length - first).max(-1.0) as i64).map(|step| first + step as f64);
            let cells: Vec<usize> = steps.filter_map(cell_after).filter(|&cell| fits(cell)).collect();
            let middle = |cell: usize| [(cell % sight.width()) as f64 + 0.5, (cell / sight.width()) as f64 + 0.5];
            let tried = [cells.len() / 2, cells.len().saturating_sub(1), 0];
            let mut tried = tried.into_iter().filter_map(|k| cells.get(k).copied());
            tried.find(|&cell| self.is_seen(sight, face, middle(cell)))
        })
    }

    fn is_seen(&self, sight: &LineOfSight, face: &TargetFace, at: [f64; 2]) -> bool {
        self.faces_towards(face, at) && sight.is_clear(at, face.middle)
    }

    /// True if a face is in range of a position and within the angle of incidence, whatever stands between.
    fn faces_towards(&self, face: &TargetFace, at: [f64; 2]) -> bool {
        let d = [at[0] - face.middle[0], at[1] - face.middle[1]];
        let squared = d[0] * d[0] + d[1] * d[1];
        let along = d[0] * face.normal[0] + d[1] * face.normal[1];
        let in_front = d[0] * f64::from(face.side[0]) + d[1] * f64::from(face.side[1]) > 0.0;
        in_front
            && along > 0.0
            && self.min_range_squared <= squared
            && squared <= self.range * self.range
            && along * along >= self.cos_squared * squared
    }
}

/// Angle between two headings, 0 to pi.
pub(crate) fn turn_between(a_rad: f64, b_rad: f64) -> f64 {
    let turn = libm::fabs(libm::fmod(a_rad - b_rad, TAU));
    turn.min(TAU - turn)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::free_space::FreeSpace;
    use crate::free_space::tests::drawn;
    use messages::Grid;

    /// A corridor of 20 x 5 cells between walls, in a frame of nothing: cells from (2, 2) to (21, 6).
    fn corridor(row: &str) -> String {
        let blank = " ".repeat(row.len() + 2);
        let wall = format!(" {} ", "#".repeat(row.len()));
        let row = format!(" {row} ");
        [&blank, &wall, &row, &row, &row, &row, &row, &wall, &blank].map(String::as_str).join("\n")
    }

    const FREE: &str = "#....................#";

    /// Middles of the faces that a sensor sees from a place, in tenths of a cell.
    fn seen(text: &str, sensor: &ScanSensor, pose: ScanPose) -> Vec<[i64; 2]> {
        let buffer = drawn(text);
        let grid = Grid::open(buffer.bytes()).unwrap();
        let (faces, free_space) = (TargetFaces::of(&grid, |_, _| true), FreeSpace::of(&grid, 0.1));
        let reach = SensorLimits::of(sensor, 0.1);
        let around = reach.visible_around(&free_space.sight(), &faces, pose.at);
        assert!(around.is_sorted());
        let seen = if sensor.sees_around() { around } else { reach.in_field_of_view(&faces, &around, pose) };
        seen.into_iter().map(|k| faces.all[k as usize].middle.map(|c| (c * 10.0).round() as i64)).collect()
    }

    /// A sensor to which only what a test changes matters, in cells of 0.1 m.
    fn sensor(range: f64) -> ScanSensor {
        ScanSensor { range_m: range * 0.1, min_range_m: 0.0, max_incidence_rad: 1.57, ..ScanSensor::DEFAULT }
    }

    const MIDDLE: ScanPose = ScanPose { at: [12.0, 4.5], yaw_rad: 0.0 };

    #[test]
    fn faces_in_range_are_seen_and_no_others() {
        let all = seen(&corridor(FREE), &sensor(100.0), MIDDLE);
        assert_eq!(all.len(), 50, "the long walls, and the short ones");
        let near = seen(&corridor(FREE), &sensor(5.0), MIDDLE);
        let far = |m: &[i64; 2]| libm::hypot(m[0] as f64 - 120.0, m[1] as f64 - 45.0);
        assert_eq!(near, all.iter().copied().filter(|m| far(m) <= 50.0).collect::<Vec<_>>());
        assert!(!near.is_empty());
        let apart = seen(&corridor(FREE), &ScanSensor { min_range_m: 0.5, ..sensor(100.0) }, MIDDLE);
        assert_eq!(apart, all.iter().copied().filter(|m| far(m) >= 50.0).collect::<Vec<_>>());
    }

    #[test]
    fn a_face_is_seen_up_to_the_angle_of_incidence() {
        let steep = ScanSensor { max_incidence_rad: 45.0f64.to_radians(), ..sensor(100.0) };
        // Where the walls meet, a face looks away from both.
        let of_lower_wall = |m: &&[i64; 2]| m[1] == 20 && (40..200).contains(&m[0]);
        let low: Vec<[i64; 2]> = seen(&corridor(FREE), &steep, MIDDLE).iter().filter(of_lower_wall).copied().collect();
        // The wall is two and a half cells away: as far to either side.
        assert_eq!(low.iter().map(|m| m[0]).collect::<Vec<_>>(), [105, 115, 125, 135]);
    }

    #[test]
    fn a_face_that_is_seen_along_one_row_alone_is_found() {
        // A niche at the end of a slot that is a cell wide and forty deep.
        const DEPTH: usize = 40;
        let row = |niche: &str, slot: &str| format!(" #{}{}....# ", niche.repeat(4), slot.repeat(DEPTH - 4));
        let [wall, niche, slot] = [row("#", "#"), row(".", "#"), row(".", ".")];
        let blank = " ".repeat(slot.len());
        let text = [&blank, &wall, &niche, &niche, &slot, &niche, &niche, &wall, &blank].map(String::as_str).join("\n");
        let buffer = drawn(&text);
        let grid = Grid::open(buffer.bytes()).unwrap();
        let (faces, free_space) = (TargetFaces::of(&grid, |_, _| true), FreeSpace::of(&grid, 0.1));
        let (limits, sight) = (SensorLimits::of(&sensor(100.0), 0.1), free_space.sight());
        let end = faces.all.iter().find(|face| face.side == [1, 0] && face.middle[0] < 3.0 && face.middle[1] == 4.5);
        let end = end.unwrap();
        // Only from the room beyond the slot.
        let fits = |cell: usize| cell % sight.width() > DEPTH + 1;
        assert!(limits.cell_that_sees(&sight, end, fits).is_some());
    }

    #[test]
    fn what_stands_between_hides_what_is_behind_it() {
        let blocked = seen(&corridor("#...............#....#"), &sensor(100.0), MIDDLE);
        assert!(blocked.iter().all(|m| m[0] <= 170), "{blocked:?}");
        assert_eq!(blocked.len(), 15 + 15 + 5 + 5);
        assert!(blocked.iter().any(|m| m[0] == 170), "its own face is seen");
        // Its other side looks away.
        let beyond = ScanPose { at: [19.0, 4.5], ..MIDDLE };
        assert!(seen(&corridor("#...............#....#"), &sensor(100.0), beyond).iter().all(|m| m[0] >= 180));
    }

    #[test]
    fn a_heading_and_a_field_of_view_bound_what_is_seen() {
        let quarter = ScanSensor { field_of_view_rad: PI / 2.0, ..sensor(100.0) };
        let all = seen(&corridor(FREE), &sensor(100.0), MIDDLE);
        let mut n = 0;
        for yaw_rad in [0.0, PI / 2.0, PI, -PI / 2.0] {
            let view = seen(&corridor(FREE), &quarter, ScanPose { yaw_rad, ..MIDDLE });
            for m in &view {
                let bearing = libm::atan2(m[1] as f64 - 45.0, m[0] as f64 - 120.0);
                assert!(turn_between(bearing, yaw_rad) <= PI / 4.0 + 0.01, "{m:?} at {yaw_rad}");
            }
            n += view.len();
        }
        assert_eq!(n, all.len(), "four quarters are the whole, and none of these faces is at an edge of two");
    }

    #[test]
    fn turns_are_never_more_than_half_a_turn() {
        for (a, b, turn) in [(0.0, 0.0, 0.0), (3.0, -3.0, TAU - 6.0), (-PI, PI, 0.0), (0.0, PI, PI), (0.1, TAU, 0.1)] {
            assert!((turn_between(a, b) - turn).abs() < 1e-12, "{a} {b}");
            assert!((turn_between(b, a) - turn).abs() < 1e-12, "{b} {a}");
        }
    }
}
