//! Held-out evidence for a pose: what a SLAM map shows in places that were unknown when the pose was found. No search chose the pose
//! by them, as it did by all else.

use crate::features::Features;
use crate::known_cells::NewPlaces;
use crate::pose::Pose;
use crate::score::{IN_FRONT_M, THROUGH_M, closeness};
use crate::thresholds::{HELD_OUT, HeldOutWeights};
use occupancy::{CELL_M, Cell};

/// What new places say about a pose, in metres of the model's walls.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HeldOut {
    /// Length that came in sight.
    pub seen_m: f64,
    /// Length of that which the SLAM map has.
    pub recalled_m: f64,
    /// Length of that which the robot saw through.
    pub through_m: f64,
}

impl HeldOut {
    /// Of the new places of a SLAM map in a pose.
    pub(crate) fn of(reference: &Features, slam: &Features, pose: &Pose, new_places: &NewPlaces) -> Self {
        let mut found = Self::default();
        for wall_point in reference.wall_points() {
            let at =
                |before_m: f64| pose.apply_inverse([0, 1].map(|k| wall_point.at[k] + before_m * wall_point.normal[k]));
            let is_free = |before_m: f64| slam.raster.at(at(before_m)) == Cell::Free;
            if !is_free(IN_FRONT_M) || !new_places.has(at(IN_FRONT_M)) || !new_places.has(at(0.0)) {
                continue;
            }
            found.seen_m += CELL_M;
            found.recalled_m += CELL_M * slam.nearest(at(0.0)).map_or(0.0, |(_, squared)| closeness(squared));
            found.through_m += if THROUGH_M.into_iter().all(is_free) { CELL_M } else { 0.0 };
        }
        found
    }

    /// Of two parts of a map.
    pub(crate) fn and(&self, other: &Self) -> Self {
        Self {
            seen_m: self.seen_m + other.seen_m,
            recalled_m: self.recalled_m + other.recalled_m,
            through_m: self.through_m + other.through_m,
        }
    }

    /// Log odds that the map is of this building, by these places alone.
    pub(crate) fn log_odds(&self) -> f64 {
        let HeldOutWeights { constant, recalled, through } = HELD_OUT;
        if self.seen_m == 0.0 {
            return 0.0;
        }
        let [recalled_share, through_share] = [self.recalled_m, self.through_m].map(|m| m / self.seen_m);
        libm::log1p(self.seen_m) * (constant + recalled * recalled_share + through * through_share)
    }
}

/// Log odds over looks that a SLAM map in a pose is of this building: those of a look, and what new places have said since.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseHistory {
    /// Log odds at the look from which new places count.
    pub of_this_building: f64,
    /// New places since.
    pub held_out: HeldOut,
}

impl PoseHistory {
    /// Log odds by now.
    pub(crate) fn log_odds(&self) -> f64 {
        self.of_this_building + self.held_out.log_odds()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_that_are_there_speak_for_a_pose_and_walls_that_were_seen_through_against_it() {
        let of = |seen_m, recalled_m, through_m| HeldOut { seen_m, recalled_m, through_m }.log_odds();
        assert_eq!(of(0.0, 0.0, 0.0), 0.0);
        assert!(of(10.0, 9.0, 0.0) > 1.0 && of(10.0, 4.0, 4.0) < -1.0);
        assert!(of(20.0, 18.0, 0.0) > of(10.0, 9.0, 0.0), "more says more");
        assert!(of(20.0, 18.0, 0.0) < 2.0 * of(10.0, 9.0, 0.0), "but walls are alike");
        let [first, second] = [[5.0, 4.5, 0.0], [5.0, 4.0, 0.5]].map(|[seen_m, recalled_m, through_m]| HeldOut {
            seen_m,
            recalled_m,
            through_m,
        });
        assert_eq!(first.and(&second).log_odds(), of(10.0, 8.5, 0.5), "in whatever parts the map grows");
    }
}
