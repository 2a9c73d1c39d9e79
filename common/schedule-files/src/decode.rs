//! Bytes of a file as text.

use crate::PlanFileError;
use encoding_rs::{Encoding, UTF_8, WINDOWS_1252};
use std::borrow::Cow;

/// The text in the encoding of its byte order mark, else in the declared one, else in UTF-8, or Windows-1252 where it is not that.
///
/// # Errors
/// An encoding that is not known, or that the bytes are not in.
pub(crate) fn decode<'a>(bytes: &'a [u8], declared: Option<&str>) -> Result<Cow<'a, str>, PlanFileError> {
    let named =
        |label: &str| Encoding::for_label(label.as_bytes()).ok_or_else(|| PlanFileError::Encoding(label.to_owned()));
    let (encoding, skip) = match (Encoding::for_bom(bytes), declared) {
        (Some(marked), _) => marked,
        (None, Some(label)) => (named(label)?, 0),
        (None, None) if std::str::from_utf8(bytes).is_ok() => (UTF_8, 0),
        (None, None) => (WINDOWS_1252, 0),
    };
    let (text, is_malformed) = encoding.decode_without_bom_handling(&bytes[skip..]);
    if is_malformed { Err(PlanFileError::Encoding(encoding.name().to_owned())) } else { Ok(text) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mark_ranks_before_the_declaration_and_old_windows_files_are_read() {
        assert_eq!(decode(b"\xef\xbb\xbfT\xc3\xbcr", Some("windows-1252")).unwrap(), "Tür");
        assert_eq!(decode(b"\xff\xfeT\0\xfc\0r\0", None).unwrap(), "Tür");
        assert_eq!(decode(b"T\xfcr", None).unwrap(), "Tür");
        assert_eq!(decode(b"T\xc3\xbcr", None).unwrap(), "Tür");
        assert_eq!(decode(b"T\xfcr", Some("ISO-8859-1")).unwrap(), "Tür");
    }

    #[test]
    fn an_unknown_encoding_and_wrong_bytes_are_errors() {
        assert!(matches!(decode(b"x", Some("EBCDIC")), Err(PlanFileError::Encoding(name)) if name == "EBCDIC"));
        assert!(matches!(decode(b"T\xfcr", Some("utf-8")), Err(PlanFileError::Encoding(_))));
    }
}
