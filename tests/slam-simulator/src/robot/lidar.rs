//! Scans of a lidar in the building as it is.

use super::people::Disc;
use crate::plane::{Vector, difference, direction_of, dot, turned};
use crate::random_generator::RandomGenerator;
use crate::strengths::{Lidar, Strengths};
use crate::world::{CELL_M, Material, World};

/// Directions of the beams of a scan from the direction of travel, unit vectors.
pub(crate) fn beam_directions(lidar: &Lidar) -> Vec<Vector> {
    let field = lidar.field_of_view_deg.to_radians();
    let whole_turn = lidar.field_of_view_deg >= 360.0;
    let n = if whole_turn { lidar.beams } else { lidar.beams - 1 };
    (0..lidar.beams).map(|k| direction_of(field * (k as f64 / n as f64 - 0.5))).collect()
}

/// What became of a beam.
pub(crate) struct Beam {
    pub(crate) from: Vector,
    /// Unit vector.
    pub(crate) direction: Vector,
    /// Where it ended; infinite out of range.
    pub(crate) range_m: f64,
    /// Middle of the cell of the building in which it ended; `None` at people and out of range.
    pub(crate) ended_at: Option<Vector>,
}

/// A building with what beams need to find their ends.
pub(crate) struct LidarScene<'a> {
    pub(crate) world: &'a World,
    /// Of [`World::clearance`].
    pub(crate) clearance: &'a [u8],
    pub(crate) strengths: &'a Strengths,
}

impl LidarScene<'_> {
    /// Measured ranges of all beams, infinite where nothing is in range and NaN where the answer was lost; all beams are
    /// reported as they were.
    pub(crate) fn scan(
        &self,
        place: Vector,
        heading: Vector,
        beams: &[Vector],
        people: &[Disc],
        random: &mut RandomGenerator,
        mut saw: impl FnMut(&Beam),
    ) -> Vec<f32> {
        let lidar = &self.strengths.lidar;
        let mut ranges = Vec::with_capacity(beams.len());
        for &beam in beams {
            let direction = turned(beam, heading);
            let end = self.cast(place, direction, random);
            let mut range_m = end.map_or(f64::INFINITY, |end| end.0);
            let before = people.iter().filter_map(|disc| range_to(disc, place, direction));
            let nearest = before.fold(f64::INFINITY, f64::min);
            let ended_at = end.filter(|_| range_m <= nearest).map(|(_, index)| self.world.middle(index));
            range_m = range_m.min(nearest);
            saw(&Beam {
                from: place,
                direction,
                range_m: if range_m < lidar.range_m { range_m } else { f64::INFINITY },
                ended_at,
            });
            let is_lost = random.happens(lidar.drop_out_share);
            let measured = range_m + lidar.noise_m * random.normal();
            ranges.push(match range_m < lidar.range_m {
                _ if is_lost || measured < 0.05 => f32::NAN,
                true => measured as f32,
                false => f32::INFINITY,
            });
        }
        ranges
    }

    /// Range and cell of the first thing that stops a beam; most beams pass glass.
    fn cast(&self, from: Vector, direction: Vector, random: &mut RandomGenerator) -> Option<(f64, usize)> {
        let world = self.world;
        let [x, y] = [0, 1].map(|k| (from[k] - world.origin[k]) / CELL_M);
        let limit = self.strengths.lidar.range_m / CELL_M;
        let mut passes_glass = None;
        let mut far = 0.0;
        while far < limit {
            let (column, row) = (x + direction[0] * far, y + direction[1] * far);
            if column < 0.0 || row < 0.0 || column >= world.width as f64 || row >= world.height as f64 {
                return None;
            }
            let index = row as usize * world.width + column as usize;
            let clear = self.clearance[index];
            if clear == 0 {
                let is_passed = world.cells[index] == Material::Glass
                    && *passes_glass.get_or_insert_with(|| !random.happens(self.strengths.glass_hit_share));
                if !is_passed {
                    return Some((far * CELL_M, index));
                }
            }
            // Within this many cells nothing is in the way.
            far += (f64::from(clear) - 1.0).max(0.4);
        }
        None
    }
}

/// Where a beam meets a disc.
fn range_to(disc: &Disc, from: Vector, direction: Vector) -> Option<f64> {
    let to_centre = difference(disc.centre, from);
    let along = dot(to_centre, direction);
    let beside = dot(to_centre, to_centre) - along * along;
    let half = disc.radius_m * disc.radius_m - beside;
    (along > 0.0 && half > 0.0).then(|| along - half.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_beam_ends_at_a_disc_before_it_only() {
        let disc = Disc { centre: [3.0, 0.1], radius_m: 0.5 };
        let range = range_to(&disc, [0.0, 0.0], [1.0, 0.0]).unwrap();
        assert!((range - (3.0 - 0.24f64.sqrt())).abs() < 1e-12);
        assert!(range_to(&disc, [0.0, 0.0], [-1.0, 0.0]).is_none());
        assert!(range_to(&disc, [0.0, 1.0], [1.0, 0.0]).is_none());
    }
}
