//! Order of records that does not depend on where a file has them: STEP gives its lines no order, and exporters shuffle them.
//!
//! Records with a GlobalId are in the order of it. Those that share one are in the order of their content, with what it refers
//! to, but without ids: the same model has the same order, however its records are numbered.

use rustc_hash::FxHashMap;
use xxhash_rust::xxh3::xxh3_64;

use super::Record;
use super::record_index::{RecordIndex, Span};
use crate::segments::{Segment, segments};

/// Characters of a GlobalId.
const GLOBAL_ID_LENGTH: usize = 22;

/// Places of `spans` in the order of their GlobalIds, then of their content, then of the file.
pub(super) fn in_order(bytes: &[u8], index: &RecordIndex, spans: &[Span]) -> Vec<usize> {
    let mut keyed: Vec<([u8; GLOBAL_ID_LENGTH], usize)> =
        spans.iter().enumerate().map(|(place, span)| (global_id(&bytes[span.start..span.end]), place)).collect();
    keyed.sort_unstable();
    let mut order: Vec<usize> = Vec::with_capacity(keyed.len());
    let mut contents = Contents { bytes, index, known: FxHashMap::default() };
    for same in keyed.chunk_by(|a, b| a.0 == b.0) {
        let first = order.len();
        order.extend(same.iter().map(|(_, place)| *place));
        if same.len() > 1 {
            order[first..].sort_by_cached_key(|place| (contents.hash(spans[*place].id), *place));
        }
    }
    order
}

/// The first argument if it is a text, cut or filled up to the length of a GlobalId.
fn global_id(record: &[u8]) -> [u8; GLOBAL_ID_LENGTH] {
    let mut id = [0; GLOBAL_ID_LENGTH];
    let behind = memchr::memchr(b'(', record).map_or(&[][..], |at| record[at + 1..].trim_ascii_start());
    let parsed;
    let text = match behind.split_first() {
        Some((b'\'', text)) => &text[..memchr::memchr(b'\'', text).unwrap_or(0)],
        _ => {
            // A comment may stand before the text.
            parsed = Record::parse(record).map(|record| record.text(0)).unwrap_or_default();
            parsed.as_bytes()
        }
    };
    let n = text.len().min(GLOBAL_ID_LENGTH);
    id[..n].copy_from_slice(&text[..n]);
    id
}

/// Hashes of records with all that they refer to.
struct Contents<'f> {
    bytes: &'f [u8],
    index: &'f RecordIndex,
    /// Hash of each record that was met; `None` while those that it refers to are followed.
    known: FxHashMap<u32, Option<u64>>,
}

impl Contents<'_> {
    /// Hash of the text of a record with the hashes of other records in the place of their ids. A record that refers to itself,
    /// through others too, counts as nothing there.
    fn hash(&mut self, id: u32) -> u64 {
        let mut waiting = vec![id];
        while let Some(&id) = waiting.last() {
            let record = self.index.range_of(id).map_or(&[][..], |(start, end)| &self.bytes[start..end]);
            if self.known.get(&id).is_some_and(Option::is_some) {
                waiting.pop();
                continue;
            }
            let is_met_again = self.known.insert(id, None).is_some();
            let before = waiting.len();
            if !is_met_again {
                let known = &self.known;
                let pieces =
                    pieces(record).filter_map(|piece| if let Piece::Reference(id) = piece { Some(id) } else { None });
                waiting.extend(pieces.filter(|id| !known.contains_key(id)));
            }
            if waiting.len() == before {
                let hash = self.hash_of(record);
                self.known.insert(id, Some(hash));
                waiting.pop();
            }
        }
        self.known.get(&id).copied().flatten().unwrap_or(0)
    }

    fn hash_of(&self, record: &[u8]) -> u64 {
        let mut content = Vec::with_capacity(record.len());
        for piece in pieces(record) {
            match piece {
                Piece::Reference(id) => {
                    let hash = self.known.get(&id).copied().flatten().unwrap_or(0);
                    content.extend_from_slice(&hash.to_le_bytes());
                }
                Piece::Text(text) => content.extend_from_slice(text),
            }
        }
        xxh3_64(&content)
    }
}

pub(super) enum Piece<'a> {
    Text(&'a [u8]),
    Reference(u32),
}

/// The arguments of a record: what it refers to, and what stands between that. Its own id is not among them.
pub(super) fn pieces(record: &[u8]) -> impl Iterator<Item = Piece<'_>> {
    let behind = memchr::memchr(b'=', record).map_or(record, |at| &record[at + 1..]);
    segments(behind).flat_map(|segment| {
        let is_code = matches!(segment, Segment::Code(_));
        let mut parts = segment.bytes().split(move |b| is_code && *b == b'#');
        let first = parts.next().map(Piece::Text);
        first.into_iter().chain(parts.flat_map(|part| {
            let n = part.iter().position(|b| !b.is_ascii_digit()).unwrap_or(part.len());
            let id = std::str::from_utf8(&part[..n]).ok().and_then(|digits| digits.parse().ok());
            [id.map_or(Piece::Text(&part[..n]), Piece::Reference), Piece::Text(&part[n..])]
        }))
    })
}

#[cfg(test)]
mod tests {
    use crate::testing::{file, with_file};
    use diagnostics::Report;

    /// Names of the walls of a file with these records, in their order.
    fn names(records: &[&str]) -> Vec<String> {
        let walls = |file: &crate::kernel::File<'_>| {
            file.records("IfcWall", &mut Report::default()).iter().map(|record| record.text(2)).collect()
        };
        with_file(&file(&records.join("\n")), walls)
    }

    #[test]
    fn records_are_in_the_order_of_their_global_ids_wherever_they_stand() {
        let walls = [
            "#1=IFCWALL('b',$,'B',$,$,$,$,$,$);",
            "#2=IFCWALLSTANDARDCASE( 'a',$,'A',$,$,$,$,$,$);",
            "#3=IFCWALL(/* ( */'c',$,'C',$,$,$,$,$,$);",
        ];
        assert_eq!(names(&walls), ["A", "B", "C"]);
        assert_eq!(names(&[walls[2], walls[0], walls[1]]), ["A", "B", "C"]);
    }

    #[test]
    fn records_with_one_global_id_are_in_the_order_of_their_content() {
        let placed = |id: u32, name: &str, x: u32| {
            format!(
                "#{id}=IFCWALL('w',$,'W',$,$,#{},$,'{name}',$);#{}=IFCLOCALPLACEMENT($,#{});#{}=IFCCARTESIANPOINT(({x}.,#{id}));",
                id + 1,
                id + 1,
                id + 2,
                id + 2
            )
        };
        let tags = |records: &[String]| -> Vec<String> {
            let walls = |file: &crate::kernel::File<'_>| {
                file.records("IfcWall", &mut Report::default()).iter().map(|record| record.text(7)).collect()
            };
            with_file(&file(&records.concat()), walls)
        };
        let one = tags(&[placed(10, "t", 1), placed(20, "u", 2), placed(30, "v", 3)]);
        assert_eq!(tags(&[placed(70, "v", 3), placed(10, "t", 1), placed(40, "u", 2)]), one);
        assert_eq!(tags(&[placed(90, "u", 2), placed(20, "v", 3), placed(30, "t", 1)]), one);
    }
}
