//! Walls as lines: Open-RMF knows no other.

use export::{ExportInput, rounded};
use frames::TENTHS_PER_M;
use geometry::{OrientedBox, Polygon};
use grid::Class;
use messages::{ElementState, FloorKind};

/// Share of the box around a piece of wall that a straight piece fills.
const STRAIGHT: f64 = 0.95;

/// What meets the slab of a storey in more parts is no plain wall.
const PARTS_MAX: usize = 1000;

/// The middle lines of the finished straight walls that stand in the slab of a map storey, without their openings for doors; and how
/// many pieces of walls are not straight. The map of the ground outdoors has none: its walls are those of the storeys.
pub(crate) fn walls(input: &ExportInput<'_>, map_storey: u32) -> (Vec<[[f64; 2]; 2]>, usize) {
    let site = input.site;
    let (mut lines, mut n_left_out) = (Vec::new(), 0);
    if site.map_storeys[map_storey as usize].floor == FloorKind::Ground {
        return (lines, n_left_out);
    }
    for (element, footprint) in input.footprints.get(map_storey as usize).copied().unwrap_or_default() {
        let record = &site.elements[*element as usize];
        let is_wall = matches!(record.class(), Class::Wall | Class::CurtainWall);
        if !is_wall || input.schedule_state.effective(*element as usize) != ElementState::Built {
            continue;
        }
        if footprint.n_parts() > PARTS_MAX {
            n_left_out += 1;
            continue;
        }
        for piece in &footprint.get(|| site.element_meshes(record)).area.0 {
            match middle_line(piece) {
                Some(line) => lines.push(line),
                None => n_left_out += 1,
            }
        }
    }
    (lines, n_left_out)
}

/// The middle line of a piece of wall, in metres; `None` unless it is straight.
fn middle_line(piece: &Polygon) -> Option<[[f64; 2]; 2]> {
    let around = OrientedBox::smallest_around(&piece.exterior)?;
    let [u, v] = around.half;
    let per_m2 = f64::from(TENTHS_PER_M) * f64::from(TENTHS_PER_M);
    if piece.area_m2() < STRAIGHT * 4.0 * u * v / per_m2 {
        return None;
    }
    let ends = if u >= v { [around.at(-u, 0.0), around.at(u, 0.0)] } else { [around.at(0.0, -v), around.at(0.0, v)] };
    Some(ends.map(|end| end.map(|c| rounded(c / f64::from(TENTHS_PER_M)))))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_straight_piece_is_its_middle_line_and_a_bent_one_none() {
        let of = |exterior: &[[i32; 2]]| middle_line(&Polygon { exterior: exterior.to_vec(), holes: Vec::new() });
        let upright = of(&[[0, 0], [2000, 0], [2000, 30_000], [0, 30_000]]);
        assert!(matches!(upright, Some([[0.1, 0.0], [0.1, 3.0]] | [[0.1, 3.0], [0.1, 0.0]])), "{upright:?}");
        assert_eq!(of(&[[0, 0], [30_000, 0], [30_000, 2000], [2000, 2000], [2000, 30_000], [0, 30_000]]), None);
        assert_eq!(of(&[]), None);
    }
}
