//! Tells where a SLAM map shows two storeys: what does not lie on the storey of its pose lies on another one.

use crate::alignment::{AlignedPose, Alignment, judged_anywhere};
use crate::part_fit::is_explained;
use crate::pose_field::PoseField;
use crate::prepared_map::{PreparedMap, between_cells};
use crate::wall_points::WallPoint;
use frames::{Map, Slam};
use messages::{AlignmentVerdict, NONE};
use occupancy::CELL_M;
use std::borrow::Cow;

/// Walls of so many metres, by weight, tell storeys apart; and so much of what one storey does not have lies on the other.
const MIN_WALLS_M: f64 = 6.0;
const MIN_SHARE: f64 = 0.6;

/// Walls of a SLAM map that are those of another storey.
struct OtherStorey {
    /// Which of the maps of the model.
    reference: usize,
    walls_m: f64,
    /// The middle of these walls in the SLAM map.
    about_m: [f64; 2],
}

impl Alignment {
    /// Tells with the reason that a SLAM map shows two storeys, also if it is accepted. `storeys` are those of the references.
    pub(crate) fn with_storeys(
        mut self,
        references: &[impl AsRef<PreparedMap<Map>>],
        storeys: &[u32],
        slam: &PreparedMap<Slam>,
    ) -> Self {
        let references: Vec<&PreparedMap<Map>> = references.iter().map(AsRef::as_ref).collect();
        let Some(best) = self.poses.first().filter(|_| references.len() > 1) else { return self };
        let Some(other) = other_storey(&self, best, &references, slam) else { return self };
        let name = |reference: usize| match storeys.get(reference) {
            Some(&storey) if storey != NONE => format!("storey {storey}"),
            _ => format!("map {} of the model", reference + 1),
        };
        let OtherStorey { reference, walls_m, about_m: [x_m, y_m] } = other;
        let (own, other) = (name(best.reference), name(reference));
        let separator = if self.reason.is_empty() { "" } else { "; " };
        self.reason.push_str(&format!(
            "{separator}{walls_m:.0} m of its walls, around x {x_m:.1} m, y {y_m:.1} m, are those of {other} and not of {own}: if the \
             robot changed storeys while it mapped, save a map for each"
        ));
        self
    }
}

fn other_storey(
    alignment: &Alignment,
    best: &AlignedPose,
    references: &[&PreparedMap<Map>],
    slam: &PreparedMap<Slam>,
) -> Option<OtherStorey> {
    let own = references[best.reference];
    let field = match &alignment.field {
        Some(field) => Cow::Borrowed(field),
        None => Cow::Owned(PoseField::of(own, slam, &best.map_from_slam)),
    };
    let own_m: f64 = field.parts.iter().filter(|part| part.is_borne_out).map(|part| part.explained_m).sum();
    if own_m < MIN_WALLS_M {
        return None;
    }
    let walls = Walls { slam, field: &field };
    let left: Vec<&WallPoint> = slam.features.wall_points().iter().filter(|wall| !walls.are_of(own, wall)).collect();
    if length_m(&left) < MIN_WALLS_M {
        return None;
    }
    if alignment.verdict != AlignmentVerdict::Accepted {
        // The part that is borne out alone must be of this storey.
        let judged = judged_anywhere(references, &slam.within(|place| walls.is_borne_out(place)));
        if judged.verdict != AlignmentVerdict::Accepted || judged.poses[0].reference != best.reference {
            return None;
        }
    }
    let others = || references.iter().copied().enumerate().filter(|(at, _)| *at != best.reference);
    // A lift ends where it began: the storeys lie one over the other.
    let over = others().filter_map(|(reference, map)| {
        let there: Vec<&WallPoint> = left.iter().copied().filter(|wall| walls.are_of(map, wall)).collect();
        let walls_m = length_m(&there);
        let is_other = walls_m >= MIN_WALLS_M && walls_m >= MIN_SHARE * length_m(&left);
        is_other.then(|| OtherStorey { reference, walls_m, about_m: walls.middle_m(&there) })
    });
    if let Some(other) = over.max_by(|a, b| a.walls_m.total_cmp(&b.walls_m)) {
        return Some(other);
    }
    // A stair ends elsewhere: they lie one beside the other.
    let beside: Vec<&WallPoint> =
        left.into_iter().filter(|wall| !walls.is_borne_out(slam.frame_from_cells().apply(wall.at))).collect();
    if length_m(&beside) < MIN_WALLS_M {
        return None;
    }
    let (numbers, maps): (Vec<usize>, Vec<&PreparedMap<Map>>) = others().unzip();
    let judged = judged_anywhere(&maps, &slam.within(|place| !walls.is_borne_out(place)));
    (judged.verdict == AlignmentVerdict::Accepted).then(|| OtherStorey {
        reference: numbers[judged.poses[0].reference],
        walls_m: length_m(&beside),
        about_m: walls.middle_m(&beside),
    })
}

/// The walls of a SLAM map where its field of poses puts them.
struct Walls<'a> {
    slam: &'a PreparedMap<Slam>,
    field: &'a PoseField,
}

impl Walls<'_> {
    /// True if a map of the model has this wall.
    fn are_of(&self, map: &PreparedMap<Map>, wall: &WallPoint) -> bool {
        let local = self.field.at(self.slam.frame_from_cells().apply(wall.at));
        local.is_some_and(|local| {
            is_explained(&map.features, wall, &between_cells(map, self.slam, &local.map_from_slam))
        })
    }

    /// True if the walls around a place of the SLAM map bear its pose out.
    fn is_borne_out(&self, in_slam_m: [f64; 2]) -> bool {
        self.field.at(in_slam_m).is_some_and(|part| part.is_borne_out)
    }

    /// The middle of walls in the SLAM map.
    fn middle_m(&self, walls: &[&WallPoint]) -> [f64; 2] {
        let all = walls.iter().map(|wall| wall.weight).sum::<f64>();
        let mean = |k: usize| walls.iter().map(|wall| wall.weight * wall.at[k]).sum::<f64>() / all;
        self.slam.frame_from_cells().apply([mean(0), mean(1)])
    }
}

fn length_m(walls: &[&WallPoint]) -> f64 {
    walls.iter().map(|wall| wall.weight).sum::<f64>() * CELL_M
}
