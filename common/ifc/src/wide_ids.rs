//! Ids above 32 bits: renumbers the records of a file for the kernel, and keeps the ids that the file has.

use std::borrow::Cow;

use memchr::{memchr, memchr_iter};

use crate::ReadError;
use crate::segments::{Segment, segments};

/// Digits of the largest number of 32 bits.
const DIGITS_OF_32_BITS: usize = 10;

/// A file whose ids fit in 32 bits, and what they were.
pub(crate) struct Renumbered {
    pub(crate) bytes: Vec<u8>,
    pub(crate) written_ids: WrittenIds,
}

/// The ids that the file has, by the numbers under which its records are read.
#[derive(Debug, Default, PartialEq)]
pub(crate) struct WrittenIds {
    /// At the place of each number; 0 is none. Empty where the numbers are those of the file.
    ids: Vec<u64>,
}

impl WrittenIds {
    /// What messages and outputs name.
    pub(crate) fn of(&self, number: u32) -> u64 {
        self.ids.get(number as usize).copied().unwrap_or(u64::from(number))
    }
}

/// The file with ids that fit in 32 bits, and what they were; borrowed where they fit already.
///
/// # Errors
/// More ids than 32 bits number.
pub(crate) fn narrowed(bytes: Cow<'_, [u8]>) -> Result<(Cow<'_, [u8]>, WrittenIds), ReadError> {
    if !has_wide_ids(&bytes) {
        return Ok((bytes, WrittenIds::default()));
    }
    let Renumbered { bytes, written_ids } = renumbered(&bytes)?;
    Ok((bytes.into(), written_ids))
}

/// True if the file has ids above 32 bits; also where only a text looks as if it had.
pub(crate) fn has_wide_ids(bytes: &[u8]) -> bool {
    memchr_iter(b'#', bytes).any(|at| {
        let digits = |end: usize| bytes.get(at + 1..end).filter(|digits| digits.iter().all(u8::is_ascii_digit));
        let is_long = |end: usize| bytes.get(end - 1).is_some_and(u8::is_ascii_digit);
        let end = at + 1 + DIGITS_OF_32_BITS;
        is_long(end)
            && digits(end).is_some_and(|ten| {
                let is_wide = std::str::from_utf8(ten).is_ok_and(|ten| ten.parse::<u32>().is_err());
                is_wide || bytes.get(end).is_some_and(u8::is_ascii_digit)
            })
    })
}

/// Gives each id of the file, defined or referred to, its place among all of them. What is in texts and comments stays, and so
/// does an id above 64 bits, which no table holds.
///
/// # Errors
/// More ids than 32 bits number.
pub(crate) fn renumbered(bytes: &[u8]) -> Result<Renumbered, ReadError> {
    let mut written_ids = vec![0];
    for_each_piece(bytes, |piece| {
        if let Piece::Id { id: Some(id), .. } = piece {
            written_ids.push(id);
        }
    });
    written_ids.sort_unstable();
    written_ids.dedup();
    if u32::try_from(written_ids.len()).is_err() {
        return Err(ReadError::TooLarge { bytes: bytes.len() });
    }
    let mut out = Vec::with_capacity(bytes.len());
    for_each_piece(bytes, |piece| match piece {
        Piece::Id { id, digits } => {
            let place = id.and_then(|id| written_ids.binary_search(&id).ok());
            let number = place.map_or(Cow::Borrowed(digits), |place| Cow::Owned(place.to_string().into_bytes()));
            out.push(b'#');
            out.extend_from_slice(&number);
        }
        Piece::Other(bytes) => out.extend_from_slice(bytes),
    });
    Ok(Renumbered { bytes: out, written_ids: WrittenIds { ids: written_ids } })
}

/// Piece of a file: an id with its sign, or what lies between ids.
enum Piece<'a> {
    Id { id: Option<u64>, digits: &'a [u8] },
    Other(&'a [u8]),
}

fn for_each_piece<'a>(bytes: &'a [u8], mut take: impl FnMut(Piece<'a>)) {
    for segment in segments(bytes) {
        let Segment::Code(mut code) = segment else {
            take(Piece::Other(segment.bytes()));
            continue;
        };
        while let Some(at) = memchr(b'#', code) {
            take(Piece::Other(&code[..at]));
            let behind = &code[at + 1..];
            let n = behind.iter().position(|b| !b.is_ascii_digit()).unwrap_or(behind.len());
            let digits = &behind[..n];
            let id = std::str::from_utf8(digits).ok().and_then(|digits| digits.parse().ok());
            take(Piece::Id { id, digits });
            code = &behind[n..];
        }
        take(Piece::Other(code));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::GeometryStatus;
    use crate::testing::{BASICS, file, read};

    #[test]
    fn ids_are_renumbered_and_texts_and_comments_are_not() {
        let text = "#5000000001=A('see #5000000001',#7,(#5000000001)); /* #7 */ #7=B(#18446744073709551615,#99999999999999999999);";
        let Renumbered { bytes, written_ids } = renumbered(text.as_bytes()).unwrap();
        let expected = "#2=A('see #5000000001',#1,(#2)); /* #7 */ #1=B(#3,#99999999999999999999);";
        assert_eq!(String::from_utf8(bytes).unwrap(), expected);
        assert_eq!(written_ids.ids, [0, 7, 5_000_000_001, u64::MAX]);
        assert!(
            has_wide_ids(text.as_bytes())
                && has_wide_ids(b"#4294967296")
                && !has_wide_ids(b"#4294967295=A(#1,#1234567890);")
        );
    }

    /// The text with five thousand million added to each id outside of texts.
    fn with_wide_ids(text: &str) -> String {
        let mut pieces = Vec::new();
        for_each_piece(text.as_bytes(), |piece| match piece {
            Piece::Id { id, .. } => pieces.extend(format!("#{}", id.unwrap() + 5_000_000_000).into_bytes()),
            Piece::Other(bytes) => pieces.extend_from_slice(bytes),
        });
        String::from_utf8(pieces).unwrap()
    }

    #[test]
    fn a_file_with_wide_ids_is_read_as_one_without_and_its_messages_name_its_own_ids() {
        let text = file(&format!(
            "{BASICS}#1=IFCWALL('wall',$,'see #1',$,$,#103,#121,$,$);#2=IFCDOOR('door',$,'D',$,$,#99,#121,$,2.,1.,$,$,$);
             #3=IFCRELASSIGNSTOGROUP('a',$,$,$,(#1),$,#98);"
        ));
        let (narrow, told) = read(&text).unwrap();
        let (wide, told_of_wide) = read(&with_wide_ids(&text)).unwrap();
        let found: Vec<(&str, u64)> = wide.elements.iter().map(|e| (&*e.id.name, e.id.step_id)).collect();
        assert_eq!(found, [("D", 5_000_000_002), ("see #1", 5_000_000_001)]);
        assert_eq!(wide.elements[1].geometry.status, GeometryStatus::Meshed);
        assert_eq!(format!("{:?}", wide.elements[1].geometry), format!("{:?}", narrow.elements[1].geometry));
        let entities = |told: &[crate::Diagnostic], more: u64| -> Vec<u64> {
            told.iter().map(|d| d.entity.as_ref().map_or(0, |e| e.step_id + more)).collect()
        };
        assert_eq!(entities(&told_of_wide, 0), entities(&told, 5_000_000_000));
        assert!(told_of_wide.iter().any(|d| d.message.contains("#5000000098")), "{told_of_wide:?}");
    }

    #[test]
    fn what_has_an_id_above_64_bits_is_left_out_and_told() {
        let text = file(&format!("{BASICS}#99999999999999999999=IFCWALL('wall',$,$,$,$,#103,#121,$,$);"));
        let (model, told) = read(&text).unwrap();
        assert!(model.elements.is_empty());
        let message = told.iter().find(|d| d.code.name() == "id_too_large").map(|d| d.message.as_str());
        assert_eq!(message, Some("1 record with an id above 18446744073709551615 left out"));
    }
}
