//! Index of a file: where the record of each id lies, in eight to twelve bytes a record.

use std::sync::Arc;

use ifc_lite_core::{ColumnarEntityIndex, DenseEntityIndex, EntityDecoder};

/// Position of a record in the bytes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Span {
    pub(crate) id: u32,
    pub(crate) start: usize,
    pub(crate) end: usize,
}

/// Id, first byte and length of a record.
pub(super) type Row = [u32; 3];

/// Where the record of each id lies. Of records with one id it is the last.
pub(super) enum RecordIndex {
    /// Ids with few gaps, as almost all files have: looked up directly.
    Dense(Arc<DenseEntityIndex>),
    /// Any ids: looked up by bisection.
    Sorted(Arc<ColumnarEntityIndex>),
}

impl RecordIndex {
    /// The index of records, and those of them whose ids are used again further down, in the order in which that is met. The
    /// rows are in the order of the file.
    pub(super) fn of(mut rows: Vec<Row>) -> (Self, Vec<Span>) {
        if !rows.is_sorted_by(|a, b| a[0] < b[0]) {
            rows.sort_unstable_by_key(|[id, start, _]| (*id, *start));
        }
        let mut superseded: Vec<(u32, Span)> = rows
            .windows(2)
            .filter(|pair| pair[0][0] == pair[1][0])
            .map(|pair| (pair[1][1], span_of(pair[0])))
            .collect();
        superseded.sort_unstable_by_key(|(again, _)| *again);
        if !superseded.is_empty() {
            rows.dedup_by(|later, earlier| {
                let is_again = later[0] == earlier[0];
                if is_again {
                    *earlier = *later;
                }
                is_again
            });
        }
        let column = |k: usize| rows.iter().map(|row| row[k]).collect::<Vec<u32>>();
        let [ids, starts, lengths] = [0, 1, 2].map(column);
        drop(rows);
        let index = match DenseEntityIndex::try_from_columns(&ids, &starts, &lengths) {
            Some(index) => Self::Dense(Arc::new(index)),
            None => {
                let index = ColumnarEntityIndex::from_owned_columns(ids, starts, lengths);
                Self::Sorted(Arc::new(index.expect("each column has a number for each row")))
            }
        };
        (index, superseded.into_iter().map(|(_, span)| span).collect())
    }

    /// First byte of the record of an id, and the byte behind it.
    pub(super) fn range_of(&self, id: u32) -> Option<(usize, usize)> {
        match self {
            Self::Dense(index) => index.lookup(id),
            Self::Sorted(index) => index.lookup(id),
        }
    }

    /// The kernel's decoder of the file.
    pub(super) fn decoder<'a>(&self, bytes: &'a [u8]) -> EntityDecoder<'a> {
        let mut decoder = EntityDecoder::new(bytes);
        match self {
            Self::Dense(index) => decoder.set_dense_index(Arc::clone(index)),
            Self::Sorted(index) => decoder.set_columnar_index(Arc::clone(index)),
        }
        decoder
    }
}

fn span_of([id, start, length]: Row) -> Span {
    Span { id, start: start as usize, end: start as usize + length as usize }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(rows: &[Row], is_dense: bool, found: &[(u32, usize)], superseded: &[(u32, usize)]) {
        let (index, again) = RecordIndex::of(rows.to_vec());
        assert_eq!(matches!(index, RecordIndex::Dense(_)), is_dense);
        for &(id, start) in found {
            assert_eq!(index.range_of(id), Some((start, start + 5)), "#{id}");
        }
        assert_eq!(index.range_of(77), None);
        assert_eq!(again.iter().map(|span| (span.id, span.start)).collect::<Vec<_>>(), superseded);
    }

    /// Records with these ids, five bytes each, one after the other.
    fn rows(ids: impl IntoIterator<Item = u32>) -> Vec<Row> {
        ids.into_iter().zip(0..).map(|(id, place)| [id, 10 * place, 5]).collect()
    }

    #[test]
    fn records_are_found_in_any_order_and_with_any_gaps() {
        check(&rows(1..=20), true, &[(1, 0), (2, 10), (20, 190)], &[]);
        check(&rows((1..=20).rev()), true, &[(20, 0), (2, 180), (1, 190)], &[]);
        check(&rows([u32::MAX, 5_000]), false, &[(u32::MAX, 0), (5_000, 10)], &[]);
    }

    #[test]
    fn the_last_record_of_an_id_counts_and_the_others_are_told_where_the_next_is_met() {
        let superseded = [(1, 10), (2, 0), (1, 20)];
        check(&rows([2, 1, 1, 2, 1, 3]), false, &[(1, 40), (2, 30), (3, 50)], &superseded);
        check(&rows([2, 1, 1, 2, 1].into_iter().chain(3..=20)), true, &[(1, 40), (2, 30), (3, 50)], &superseded);
    }
}
