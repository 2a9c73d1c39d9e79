//! Model maps of generated buildings, so that tests and calibrations need no building models.

mod drawing;
mod halls;
mod homes;
mod offices;

use crate::random_generator::RandomGenerator;
use drawing::{Drawing, Shape};
use occupancy::OccupancyMap;

/// Named floor plans, in turn an office, a home and a hall; each depends on the seed and its number alone.
pub fn drawn(count: usize, seed: u64) -> Vec<(String, OccupancyMap)> {
    (0..count)
        .map(|k| {
            let random = &mut RandomGenerator::of(&[seed, 2, k as u64]);
            let (kind, mut drawing) = match k % 3 {
                0 => ("office", offices::office(random)),
                1 => ("home", homes::home(random)),
                _ => ("hall", halls::hall(random)),
            };
            reshape_corners(&mut drawing, random);
            (format!("{kind}-{k:03}"), drawing.into_map())
        })
        .collect()
}

/// Takes corners of some buildings away: set back, oblique, or round.
fn reshape_corners(drawing: &mut Drawing, random: &mut RandomGenerator) {
    let thickness = random.between(0.15, 0.4);
    let longest = drawing.size_m().into_iter().fold(f64::INFINITY, f64::min) / 3.0;
    for corner in [[false, false], [true, false], [true, true], [false, true]] {
        if random.happens(0.25) {
            let shape = random.one_of(&[Shape::SetBack, Shape::Oblique, Shape::Round]);
            drawing.reshape_corner(corner, random.between(1.5, longest.max(2.0)), thickness, shape);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reference::Reference;

    #[test]
    fn floor_plans_can_be_simulated_and_have_doors() {
        for (name, map) in drawn(24, 5) {
            let reference = Reference::new(name.clone(), name.clone(), map, None).unwrap();
            let is_home = name.starts_with("home");
            assert!(reference.grid.floor_m2() > 40.0, "{name}: {} m2", reference.grid.floor_m2());
            assert!(!reference.openings.is_empty() || name.starts_with("hall"), "{name} has no doors");
            assert!(!is_home || reference.grid.floor_m2() < 260.0, "{name}: {} m2", reference.grid.floor_m2());
        }
    }
}
