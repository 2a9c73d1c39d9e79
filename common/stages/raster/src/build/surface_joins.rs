//! Joins the surfaces that one gets to from each other over steps that are taken: those that meet in a cell, or at the border of two.

use crate::model::band_surfaces::{BandSurfaces, Source, bands};
use crate::model::ground_patch::{STEP_TOLERANCE, are_apart, z_at};
use geometry::{DisjointSets, Plane};
use grid::{CellRect, GridSpec, Run};
use messages::NONE;
use std::ops::Range;

/// A surface that one may stand on.
pub(super) struct Walked<'a> {
    pub(super) plane: Plane,
    /// Cells that it overlaps.
    pub(super) cells: &'a [Run],
    pub(super) is_tread: bool,
    /// It belongs to what is there from the beginning; those that do need not be joined to each other.
    pub(super) is_seed: bool,
}

/// Surfaces, by index, and what of them is climbed.
pub(super) struct SurfaceJoins<'a> {
    pub(super) surfaces: &'a [Walked<'a>],
    pub(super) spec: &'a GridSpec,
    /// Greatest difference of height between two surfaces of which one is reached from the other; on a stair.
    pub(super) climb: [i32; 2],
}

/// Rectangles of a strip of rows, from left to right, with the surfaces of their cells.
#[derive(Default)]
struct Strip {
    rects: Vec<(CellRect, Range<usize>)>,
    surfaces: Vec<u32>,
}

impl Strip {
    fn of(&self, (rect, range): &(CellRect, Range<usize>)) -> (CellRect, &[u32]) {
        (*rect, &self.surfaces[range.clone()])
    }

    fn last(&self) -> Option<(CellRect, &[u32])> {
        self.rects.last().map(|rect| self.of(rect))
    }

    /// Those that have cells in some columns.
    fn in_columns(&self, columns: Range<u32>) -> impl Iterator<Item = (CellRect, &[u32])> {
        let from = self.rects.partition_point(|(rect, _)| rect.max[0] <= columns.start);
        let rects = self.rects[from..].iter().take_while(move |(rect, _)| rect.min[0] < columns.end);
        rects.map(|rect| self.of(rect))
    }

    fn push(&mut self, rect: CellRect, surfaces: &[u32]) {
        let from = self.surfaces.len();
        self.surfaces.extend_from_slice(surfaces);
        self.rects.push((rect, from..self.surfaces.len()));
    }

    fn clear(&mut self) {
        self.rects.clear();
        self.surfaces.clear();
    }
}

/// Places in rows and columns, a cell apart, by the first of them.
#[derive(Debug, Clone, Copy)]
struct Places {
    /// Column and row.
    first: [f64; 2],
    n: [u32; 2],
}

impl Places {
    fn at(&self, [column, row]: [u32; 2]) -> [f64; 2] {
        [self.first[0] + f64::from(column), self.first[1] + f64::from(row)]
    }

    /// Of those that there are.
    fn corners(&self) -> Option<[[f64; 2]; 4]> {
        let [right, high] = [self.n[0].checked_sub(1)?, self.n[1].checked_sub(1)?];
        Some([[0, 0], [right, 0], [0, high], [right, high]].map(|place| self.at(place)))
    }

    fn all(self) -> impl Iterator<Item = [f64; 2]> {
        (0..self.n[1]).flat_map(move |row| (0..self.n[0]).map(move |column| self.at([column, row])))
    }
}

impl SurfaceJoins<'_> {
    /// Joins the sets of surfaces that meet.
    pub(super) fn join(&self, sets: &mut DisjointSets) {
        let whole = CellRect::whole(self.spec.width, self.spec.height);
        let rects: Vec<Option<CellRect>> = self.surfaces.iter().map(|of| CellRect::around(of.cells)).collect();
        let all = || (0..).zip(self.surfaces).zip(&rects).filter_map(|((k, of), rect)| Some((k, of, (*rect)?)));
        // Where there is something to join, with the cells beside it.
        let others = all().filter(|(_, of, _)| !of.is_seed).map(|(_, _, rect)| rect.grown(1, &whole));
        let others: Vec<CellRect> = others.collect();
        let Some(around) = CellRect::around_all(others.iter().copied()) else { return };
        let (mut in_band, mut below, mut here) = (BandSurfaces::default(), Strip::default(), Strip::default());
        for band in bands(&around) {
            let columns = CellRect::around_all(others.iter().filter(|rect| rect.meets(&band)).copied());
            let Some(CellRect { min: [left, _], max: [right, _] }) = columns else { continue };
            let band = CellRect { min: [left, band.min[1]], max: [right, band.max[1]] };
            let sources = all().filter(|(_, _, rect)| rect.meets(&band));
            let sources = sources.map(|(surface, ..)| Source { surface, body: NONE });
            in_band.rects(
                &band,
                sources,
                |source| self.surfaces[source.surface as usize].cells,
                |rect, surfaces| {
                    if here.rects.last().is_some_and(|(last, _)| last.min[1] != rect.min[1]) {
                        std::mem::swap(&mut below, &mut here);
                        here.clear();
                    }
                    self.join_rect(&rect, surfaces, [&below, &here], sets);
                    here.push(rect, surfaces);
                },
            );
        }
    }

    /// Joins the surfaces of a rectangle with each other, and with those of the strip below and of the rectangle to the left.
    fn join_rect(&self, rect: &CellRect, surfaces: &[u32], [below, here]: [&Strip; 2], sets: &mut DisjointSets) {
        let [x, y] = rect.min.map(f64::from);
        let [width, height] = [0, 1].map(|k| rect.max[k] - rect.min[k]);
        // Middles of cells, and of the borders between them.
        let inside = [
            Places { first: [x + 0.5, y + 0.5], n: [width, height] },
            Places { first: [x + 1.0, y + 0.5], n: [width - 1, height] },
            Places { first: [x + 0.5, y + 1.0], n: [width, height - 1] },
        ];
        for (k, &one) in surfaces.iter().enumerate() {
            surfaces[k + 1..].iter().for_each(|&other| self.join_at([one, other], &inside, sets));
        }
        let mut join_beside = |others: &[u32], places: Places| {
            for &one in surfaces {
                others.iter().for_each(|&other| self.join_at([one, other], &[places], sets));
            }
        };
        if let Some((_, others)) = here.last().filter(|(left, _)| left.max[0] == rect.min[0]) {
            join_beside(others, Places { first: [x, y + 0.5], n: [1, height] });
        }
        let of_strip_below = below.in_columns(rect.min[0]..rect.max[0]);
        for (other, others) in of_strip_below.filter(|(below, _)| below.max[1] == rect.min[1]) {
            let (from, to) = (other.min[0].max(rect.min[0]), other.max[0].min(rect.max[0]));
            join_beside(others, Places { first: [f64::from(from) + 0.5, y], n: [to - from, 1] });
        }
    }

    /// Joins two surfaces if one gets from one to the other at one of these places.
    fn join_at(&self, pair: [u32; 2], places: &[Places], sets: &mut DisjointSets) {
        if sets.first(pair[0]) != sets.first(pair[1]) && self.meet(pair, places) {
            sets.join(pair[0], pair[1]);
        }
    }

    fn meet(&self, pair: [u32; 2], places: &[Places]) -> bool {
        let [one, other] = pair.map(|k| &self.surfaces[k as usize]);
        let most = f64::from(self.climb[usize::from(one.is_tread || other.is_tread)]) + STEP_TOLERANCE;
        let off = |place: [f64; 2]| z_at(&one.plane, place, self.spec) - z_at(&other.plane, place, self.spec);
        let Some(corners) = places[0].corners() else { return false };
        let at_corners = corners.map(off);
        if at_corners.iter().any(|off| off.abs() <= most) {
            return true;
        }
        !are_apart(&at_corners, most)
            && places.iter().copied().flat_map(Places::all).any(|place| off(place).abs() <= most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{FillRule, union};
    use grid::overlapped_cells;
    use proptest::prelude::*;

    const SPEC: GridSpec = GridSpec { cell_tenths: 100, first_cell: [0; 2], width: 40, height: 90 };

    /// A surface over a triangle or a rectangle, level or rising.
    fn surface() -> impl Strategy<Value = (Vec<Run>, Plane, bool)> {
        let place = || (-300..4_300i32, -300..9_300i32);
        let rise = || prop::sample::select(vec![0, 0, 100, -700, 4_000]);
        let z = prop::sample::select(vec![0, 45, 55, 300, 320, 1_000]);
        (place(), (100..3_000i32, 100..5_000i32), any::<[bool; 2]>(), z, rise(), rise()).prop_map(
            |((x, y), (w, h), [is_triangle, is_tread], z, along_x, along_y)| {
                let mut ring = vec![[x, y], [x + w, y], [x + w, y + h], [x, y + h]];
                ring.truncate(if is_triangle { 3 } else { 4 });
                let cells = overlapped_cells(&union(&[ring], FillRule::NonZero), &[], &SPEC);
                (cells, Plane::of(&[[0, 0, z], [4_000, 0, z + along_x], [0, 9_000, z + along_y]]), is_tread)
            },
        )
    }

    /// The sets from every cell and its borders.
    fn cell_by_cell(joins: &SurfaceJoins<'_>, sets: &mut DisjointSets) {
        let has = |k: usize, [column, row]: [u32; 2]| {
            let cells = joins.surfaces[k].cells;
            cells.iter().any(|run| run.row == row && run.start <= column && column < run.end)
        };
        let n = joins.surfaces.len();
        for (column, row) in (0..SPEC.width).flat_map(|column| (0..SPEC.height).map(move |row| (column, row))) {
            let [x, y] = [column, row].map(|k| f64::from(k) + 0.5);
            let beside =
                [([column, row], [x, y]), ([column + 1, row], [x + 0.5, y]), ([column, row + 1], [x, y + 0.5])];
            for ((other, place), (k, l)) in
                beside.iter().flat_map(|beside| (0..n).flat_map(move |k| (0..n).map(move |l| (*beside, (k, l)))))
            {
                let [a, b] = [k, l].map(|k| &joins.surfaces[k]);
                let most = f64::from(joins.climb[usize::from(a.is_tread || b.is_tread)]) + STEP_TOLERANCE;
                let off = (z_at(&a.plane, place, &SPEC) - z_at(&b.plane, place, &SPEC)).abs();
                if has(k, [column, row]) && has(l, other) && off <= most {
                    sets.join(k as u32, l as u32);
                }
            }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(96))]
        #[test]
        fn surfaces_are_joined_where_cells_join_them(
            surfaces in prop::collection::vec(surface(), 1..7),
            n_seeds in 0..4usize,
        ) {
            let walked: Vec<Walked<'_>> = surfaces
                .iter()
                .enumerate()
                .map(|(k, (cells, plane, is_tread))| Walked {
                    plane: *plane,
                    cells,
                    is_tread: *is_tread,
                    is_seed: k < n_seeds,
                })
                .collect();
            let joins = SurfaceJoins { surfaces: &walked, spec: &SPEC, climb: [50, 250] };
            let [mut found, mut expected] = [(); 2].map(|()| {
                let mut sets = DisjointSets::new(walked.len());
                (1..n_seeds.min(walked.len()) as u32).for_each(|seed| sets.join(0, seed));
                sets
            });
            joins.join(&mut found);
            cell_by_cell(&joins, &mut expected);
            for (k, l) in (0..walked.len() as u32).flat_map(|k| (0..k).map(move |l| (k, l))) {
                let is_joined = |sets: &mut DisjointSets| sets.first(k) == sets.first(l);
                prop_assert_eq!(is_joined(&mut found), is_joined(&mut expected), "{} {}", k, l);
            }
        }
    }
}
