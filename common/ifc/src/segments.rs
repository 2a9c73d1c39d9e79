//! Splits the bytes of a STEP file into code, quoted texts and comments.

use memchr::{memchr, memchr3, memmem};

/// Stretch of a file. All stretches, one after the other, are the file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Segment<'a> {
    /// Everything but texts and comments: names, numbers, references.
    Code(&'a [u8]),
    /// A text with its quotes; a quote within it, which is written twice, ends one text and begins the next.
    Text(&'a [u8]),
    /// A comment with its marks, or binary data with its quotes.
    Other(&'a [u8]),
}

impl<'a> Segment<'a> {
    /// Its bytes.
    pub(crate) fn bytes(self) -> &'a [u8] {
        match self {
            Self::Code(bytes) | Self::Text(bytes) | Self::Other(bytes) => bytes,
        }
    }
}

/// The segments of a file, or of a record.
pub(crate) fn segments(bytes: &[u8]) -> impl Iterator<Item = Segment<'_>> {
    let mut rest = bytes;
    std::iter::from_fn(move || {
        let (segment, after) = next(rest)?;
        rest = after;
        Some(segment)
    })
}

/// The first segment and the rest; a text or comment without an end goes to the end.
fn next(bytes: &[u8]) -> Option<(Segment<'_>, &[u8])> {
    let (&first, behind) = bytes.split_first()?;
    let is_comment = bytes.starts_with(b"/*");
    let end = |found: Option<usize>| found.map_or(bytes.len(), |at| at + 2);
    let (is_text, n) = match first {
        b'\'' => (true, end(memchr(b'\'', behind))),
        b'"' => (false, end(memchr(b'"', behind))),
        _ if is_comment => (false, memmem::find(&bytes[2..], b"*/").map_or(bytes.len(), |at| at + 4)),
        _ => {
            let (code, rest) = bytes.split_at(code_length(bytes));
            return Some((Segment::Code(code), rest));
        }
    };
    let (found, rest) = bytes.split_at(n);
    Some((if is_text { Segment::Text(found) } else { Segment::Other(found) }, rest))
}

/// Bytes up to the next text, binary data or comment.
fn code_length(bytes: &[u8]) -> usize {
    let mut at = 0;
    while let Some(found) = memchr3(b'\'', b'"', b'/', &bytes[at..]) {
        at += found;
        if bytes[at] != b'/' || bytes.get(at + 1) == Some(&b'*') {
            return at;
        }
        at += 1;
    }
    bytes.len()
}

#[cfg(test)]
mod tests {
    use super::Segment::{Code, Other, Text};
    use super::*;

    #[test]
    fn texts_comments_and_code_are_told_apart_and_nothing_is_lost() {
        let check = |bytes: &[u8], expected: &[Segment<'_>]| {
            let found: Vec<Segment<'_>> = segments(bytes).collect();
            assert_eq!(found, expected);
            assert_eq!(found.iter().flat_map(|s| s.bytes()).copied().collect::<Vec<u8>>(), bytes);
        };
        check(b"#1=A('x #2',1/2);", &[Code(b"#1=A("), Text(b"'x #2'"), Code(b",1/2);")]);
        check(
            b"'it''s'/* isn't #3 */\"0'1\"",
            &[Text(b"'it'"), Text(b"'s'"), Other(b"/* isn't #3 */"), Other(b"\"0'1\"")],
        );
        check(b"#1=A('open", &[Code(b"#1=A("), Text(b"'open")]);
        check(b"/* open", &[Other(b"/* open")]);
        check(b"", &[]);
    }
}
