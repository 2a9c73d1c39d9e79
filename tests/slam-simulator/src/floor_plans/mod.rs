//! Model maps of generated buildings, so that tests and calibrations need no building models.

mod drawing;
mod halls;
mod homes;
mod offices;
mod storeys;

use crate::random_generator::RandomGenerator;
use drawing::{Drawing, Shape};
use occupancy::OccupancyMap;

/// Named floor plans, in turn an office, a home and a hall; each depends on the seed and its number alone.
pub fn drawn(count: usize, seed: u64) -> Vec<(String, OccupancyMap)> {
    drawn_buildings(count, 1, seed)
        .into_iter()
        .flat_map(|(name, maps)| maps.into_iter().map(move |map| (name.clone(), map)))
        .collect()
}

/// Named buildings with so many storeys each: these have outer walls in common, and rooms of their own. The lowest is what
/// [`drawn`] gives.
pub fn drawn_buildings(count: usize, n_storeys: usize, seed: u64) -> Vec<(String, Vec<OccupancyMap>)> {
    (0..count)
        .map(|k| {
            let (kind, draw): (_, fn(&mut RandomGenerator, usize) -> Drawing) = match k % 3 {
                0 => ("office", offices::office),
                1 => ("home", homes::home),
                _ => ("hall", halls::hall),
            };
            let of_building = RandomGenerator::of(&[seed, 2, k as u64]);
            let mut of_corners = of_building.clone();
            draw(&mut of_corners, 0);
            let storey = |number: usize| {
                let mut drawing = draw(&mut of_building.clone(), number);
                reshape_corners(&mut drawing, &mut of_corners.clone());
                drawing.into_map()
            };
            (format!("{kind}-{k:03}"), (0..n_storeys).map(storey).collect())
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

    #[test]
    fn storeys_have_outer_walls_in_common_and_rooms_of_their_own() {
        for (name, maps) in drawn_buildings(6, 2, 5) {
            let [lower, upper] = [0, 1].map(|k| &maps[k]);
            let border = |map: &OccupancyMap| -> Vec<usize> {
                (0..map.cells.len()).filter(|&k| map.cells[k] == occupancy::Cell::Unknown).collect()
            };
            assert_eq!(lower.cells.len(), upper.cells.len(), "{name}");
            assert_eq!(border(lower), border(upper), "{name}: outlines");
            assert_ne!(lower.cells, upper.cells, "{name}: rooms");
        }
        let lowest: Vec<_> =
            drawn_buildings(6, 2, 5).into_iter().map(|(name, mut maps)| (name, maps.remove(0))).collect();
        assert!(lowest == drawn(6, 5), "a building's lowest storey does not depend on how many it has");
    }
}
