//! Distance transform: squared distance to the nearest marked cell.

use crate::{SparseCells, SparseLayer};

/// Squared distance to the nearest marked cell, for every cell, in cells².
///
/// `marked` is row-major, `width` wide. Without a marked cell all are [`u32::MAX`]. Linear in cells.
///
/// # Source
/// Felzenszwalb and Huttenlocher, "Distance Transforms of Sampled Functions", Theory of Computing 8, 2012.
pub fn squared_distances(marked: &[bool], width: usize) -> Vec<u32> {
    let mut out: Vec<u32> = marked.iter().map(|&m| if m { 0 } else { u32::MAX }).collect();
    if out.is_empty() {
        return out;
    }
    // Along columns first, row after row: cells to the next marked one below, then above.
    for cell in width..out.len() {
        out[cell] = out[cell].min(out[cell - width].saturating_add(1));
    }
    for cell in (0..out.len() - width).rev() {
        out[cell] = out[cell].min(out[cell + width].saturating_add(1));
    }
    let mut line = Line::new(width);
    for row in out.chunks_exact_mut(width) {
        line.square(row);
    }
    out
}

/// [`squared_distances`] as a sparse layer: 0 where all cells of a chunk are marked. They take no room.
pub fn sparse_distances(marked: &[bool], width: usize) -> SparseLayer<u32> {
    let cells = SparseCells::of(marked.len(), |cell| !marked[cell]);
    let mut squared = cells.layer_of(0, |cell| if marked[cell] { 0 } else { u32::MAX });
    let mut row = vec![0; width];
    let mut beside = vec![u32::MAX; width];
    let add_step = |row: &mut [u32], beside: &[u32]| {
        row.iter_mut().zip(beside).for_each(|(cells, beside)| *cells = (*cells).min(beside.saturating_add(1)));
    };
    let firsts = (0..marked.len()).step_by(width.max(1));
    // Along columns: cells to the next marked one below.
    for first in firsts.clone() {
        squared.read(first, &mut row);
        add_step(&mut row, &beside);
        squared.write(first, &row);
        std::mem::swap(&mut row, &mut beside);
    }
    // Above too; then along rows.
    let mut line = Line::new(width);
    beside.fill(u32::MAX);
    for first in firsts.rev() {
        squared.read(first, &mut row);
        add_step(&mut row, &beside);
        beside.copy_from_slice(&row);
        if row.iter().any(|cells| *cells != 0) {
            line.square(&mut row);
            squared.write(first, &row);
        }
    }
    squared
}

/// The nearest marked cell, for every cell; [`u32::MAX`] without a marked cell. Ties are broken the same way each time.
///
/// `marked` is row-major, `width` wide. Linear in cells.
///
/// # Source
/// As for [`squared_distances`].
pub fn nearest_marked(marked: &[bool], width: usize) -> Vec<u32> {
    let height = marked.len().checked_div(width).unwrap_or(0);
    let mut squared: Vec<u32> = marked.iter().map(|&m| if m { 0 } else { u32::MAX }).collect();
    let mut in_row = vec![u32::MAX; squared.len()];
    if squared.is_empty() {
        return in_row;
    }
    let mut line = Line::new(width.max(height));
    for (row, cells) in squared.chunks_exact_mut(width).enumerate() {
        let first = row * width;
        line.transform(cells, 1, |cell, nearest| in_row[first + cell] = (first + nearest) as u32);
    }
    let mut out = vec![u32::MAX; squared.len()];
    for column in 0..width {
        line.transform(&mut squared[column..], width, |row, nearest| {
            out[row * width + column] = in_row[nearest * width + column];
        });
    }
    out
}

/// Buffers for one pass over a row or a column.
struct Line {
    values: Vec<u32>,
    /// Columns of the parabolas of the lower envelope, and the start of each.
    vertex: Vec<usize>,
    from: Vec<f64>,
}

impl Line {
    fn new(length: usize) -> Self {
        Self {
            values: Vec::with_capacity(length),
            vertex: Vec::with_capacity(length),
            from: Vec::with_capacity(length),
        }
    }

    /// Makes squared distances in two dimensions of a row of distances along columns.
    fn square(&mut self, row: &mut [u32]) {
        row.iter_mut().filter(|cells| **cells != u32::MAX).for_each(|cells| *cells = cells.saturating_mul(*cells));
        self.transform(row, 1, |_, _| {});
    }

    /// Adds squared distances along the line; calls `tell` with every cell and the nearest one to it.
    fn transform(&mut self, cells: &mut [u32], step: usize, mut tell: impl FnMut(usize, usize)) {
        self.values.clear();
        self.values.extend(cells.iter().step_by(step));
        self.vertex.clear();
        self.from.clear();
        for (q, &f) in self.values.iter().enumerate().filter(|(_, f)| **f != u32::MAX) {
            // Of neighbours that are both marked the parabolas meet halfway: no need to compute it.
            if f == 0 && 0 < q && self.values[q - 1] == 0 {
                self.vertex.push(q);
                self.from.push(q as f64 - 0.5);
                continue;
            }
            let height = |p: usize| f64::from(self.values[p]) + (p * p) as f64;
            let mut begin = f64::NEG_INFINITY;
            while let Some(&p) = self.vertex.last() {
                let above = f64::from(f) + (q * q) as f64 - height(p);
                // Mostly the parabola before is that of the cell before: a division less.
                begin = if q - p == 1 { above * 0.5 } else { above / (2 * (q - p)) as f64 };
                if begin > self.from[self.from.len() - 1] {
                    break;
                }
                self.vertex.pop();
                self.from.pop();
                begin = f64::NEG_INFINITY;
            }
            self.vertex.push(q);
            self.from.push(begin);
        }
        if self.vertex.is_empty() {
            return;
        }
        let mut k = 0;
        for (q, cell) in cells.iter_mut().step_by(step).enumerate() {
            while k + 1 < self.vertex.len() && self.from[k + 1] < q as f64 {
                k += 1;
            }
            let p = self.vertex[k];
            tell(q, p);
            *cell = self.values[p].saturating_add((q.abs_diff(p) * q.abs_diff(p)) as u32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn without_a_marked_cell_everything_is_far() {
        assert_eq!(squared_distances(&[false; 6], 3), [u32::MAX; 6]);
        assert!(squared_distances(&[], 0).is_empty());
    }

    proptest! {
        #[test]
        fn distances_agree_with_trying_every_cell(width in 1..12usize, marked in prop::collection::vec(prop::bool::weighted(0.2), 1..100)) {
            let marked = &marked[..marked.len() / width * width];
            let at = |i: usize| ((i % width) as i64, (i / width) as i64);
            let found = squared_distances(marked, width);
            let layer = sparse_distances(marked, width);
            prop_assert!((0..marked.len()).all(|cell| layer[cell] == found[cell]));
            for (i, d) in found.iter().enumerate() {
                let slow = (0..marked.len()).filter(|&j| marked[j])
                    .map(|j| (at(i).0 - at(j).0).pow(2) + (at(i).1 - at(j).1).pow(2)).min();
                prop_assert_eq!(i64::from(*d), slow.unwrap_or(i64::from(u32::MAX)));
                let nearest = nearest_marked(marked, width)[i] as usize;
                match slow {
                    None => prop_assert_eq!(nearest, u32::MAX as usize),
                    Some(d) => {
                        prop_assert!(marked[nearest]);
                        prop_assert_eq!((at(i).0 - at(nearest).0).pow(2) + (at(i).1 - at(nearest).1).pow(2), d);
                    }
                }
            }
        }
    }
}
