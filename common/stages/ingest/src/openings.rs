//! Plan rectangles of wall openings.

use frames::TENTHS_PER_M;
use geometry::{OrientedBox, Point};

/// No wall is thicker: 1.5 m. A deeper box is no passage through a wall.
const MAX_HALF_DEPTH: f64 = 0.75 * TENTHS_PER_M as f64;

/// The plan of an opening inside its wall: first side along the wall, second through it.
///
/// `axis` is a direction of the wall's placement in plan, if it has one. `None` if it is no passage through a wall.
pub(crate) fn plan_of_opening(opening: &[Point], host: &[Point], axis: Option<[f64; 2]>) -> Option<OrientedBox> {
    let along = axis.and_then(|axis| straight(host, axis)).or_else(|| {
        let smallest = OrientedBox::smallest_around(opening)?;
        Some(if smallest.half[0] >= smallest.half[1] { smallest.axis } else { smallest.across() })
    })?;
    let own = OrientedBox::around(opening.iter().copied(), along)?;
    let wall = OrientedBox::around(host.iter().copied(), along)?;
    // The opening may reach out of the wall on both sides: what counts is inside.
    let range = |b: &OrientedBox| {
        let across = b.across();
        let middle = b.centre[0] * across[0] + b.centre[1] * across[1];
        [middle - b.half[1], middle + b.half[1]]
    };
    let (o, w) = (range(&own), range(&wall));
    let through = if wall.half[1] <= MAX_HALF_DEPTH { [o[0].max(w[0]), o[1].min(w[1])] } else { o };
    let half_depth = (through[1] - through[0]) / 2.0;
    if !(0.0..=MAX_HALF_DEPTH).contains(&half_depth) {
        return None;
    }
    let across = own.across();
    let offset = (through[0] + through[1]) / 2.0 - (o[0] + o[1]) / 2.0;
    let centre = [0, 1].map(|k| own.centre[k] + offset * across[k]);
    Some(OrientedBox { centre, axis: along, half: [own.half[0], half_depth] })
}

/// The direction, of `axis` and its normal, along which a straight wall runs; `None` if it is not thin across it.
fn straight(host: &[Point], axis: [f64; 2]) -> Option<[f64; 2]> {
    let wall = OrientedBox::around(host.iter().copied(), axis)?;
    let (along, half_depth) =
        if wall.half[0] >= wall.half[1] { (axis, wall.half[1]) } else { (wall.across(), wall.half[0]) };
    (half_depth <= MAX_HALF_DEPTH).then_some(along)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WALL: [Point; 4] = [[0, 0], [50_000, 0], [50_000, 3_000], [0, 3_000]];

    #[test]
    fn an_opening_is_as_deep_as_its_wall() {
        let opening = [[10_000, -1_000], [19_000, 4_000]];
        let plan = plan_of_opening(&opening, &WALL, Some([1.0, 0.0])).unwrap();
        assert_eq!((plan.centre, plan.half), ([14_500.0, 1_500.0], [4_500.0, 1_500.0]));
    }

    #[test]
    fn a_placement_across_the_wall_is_turned() {
        let opening = [[10_000, -1_000], [19_000, 4_000]];
        let plan = plan_of_opening(&opening, &WALL, Some([0.0, 1.0])).unwrap();
        assert_eq!(plan.half, [4_500.0, 1_500.0]);
    }

    #[test]
    fn a_hole_as_deep_as_a_room_is_no_passage() {
        let slab = [[0, 0], [100_000, 0], [100_000, 100_000], [0, 100_000]];
        let hole = [[10_000, 10_000], [50_000, 10_000], [50_000, 40_000], [10_000, 40_000]];
        assert!(plan_of_opening(&hole, &slab, Some([1.0, 0.0])).is_none());
    }
}
