//! Differences between the storeys of a building.

use crate::random_generator::RandomGenerator;

/// Numbers for the rooms of a storey: those of the lowest go on with the building's.
pub(super) fn of_storey(random: &mut RandomGenerator, number: usize) {
    if number > 0 {
        *random = random.part(&format!("storey {number}"));
    }
}
