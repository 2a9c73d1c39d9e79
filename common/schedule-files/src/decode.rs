//! Bytes of a file as text.

use crate::PlanFileError;
use chardetng::EncodingDetector;
use encoding_rs::{Encoding, UTF_8};
use std::borrow::Cow;

/// Characters of the example that shows how a guessed encoding reads.
const MAX_EXAMPLE_CHARS: usize = 40;

/// A text, and what has to be said about its encoding.
#[derive(Debug)]
pub(crate) struct Decoded<'a> {
    pub(crate) text: Cow<'a, str>,
    /// The encoding was guessed: a sentence with an example.
    pub(crate) guess: Option<String>,
}

/// The text in the encoding of its byte order mark, else in the one that it declares, else in UTF-8; where it is not that, in the one of
/// the rules, or in the one that its bytes look most like.
///
/// # Errors
/// An encoding that is not known, or that the bytes are not in.
pub(crate) fn decode<'a>(
    bytes: &'a [u8],
    declared: Option<&str>,
    of_rules: Option<&str>,
) -> Result<Decoded<'a>, PlanFileError> {
    let named =
        |label: &str| Encoding::for_label(label.as_bytes()).ok_or_else(|| PlanFileError::Encoding(label.to_owned()));
    let ((encoding, skip), is_guess) = match (Encoding::for_bom(bytes), declared, of_rules) {
        (Some(marked), ..) => (marked, false),
        (None, Some(label), _) => ((named(label)?, 0), false),
        (None, None, _) if is_utf_8(bytes) => ((UTF_8, 0), false),
        (None, None, Some(label)) => ((named(label)?, 0), false),
        (None, None, None) => ((guessed(bytes), 0), true),
    };
    let (text, is_malformed) = encoding.decode_without_bom_handling(&bytes[skip..]);
    if is_malformed {
        return Err(PlanFileError::Encoding(encoding.name().to_owned()));
    }
    let guess = is_guess.then(|| {
        format!(
            "its encoding is not written in it and was guessed to be {}, in which it reads {:?}; if that is wrong, say which with encoding in \
             the schedule rules",
            encoding.name(),
            example(&text)
        )
    });
    Ok(Decoded { text, guess })
}

/// True for UTF-8, also where the end of the file is cut off within a character.
fn is_utf_8(bytes: &[u8]) -> bool {
    match std::str::from_utf8(bytes) {
        Ok(_) => true,
        Err(error) => error.error_len().is_none() && !bytes[..error.valid_up_to()].is_ascii(),
    }
}

fn guessed(bytes: &[u8]) -> &'static Encoding {
    let mut detector = EncodingDetector::new();
    detector.feed(bytes, true);
    detector.guess(None, false)
}

/// The first cell that is not in ASCII; of a long one, what is around its first such character.
fn example(text: &str) -> String {
    let cell = text.split(['\t', '\n', '\r', ',', ';', '<', '>']).find(|cell| !cell.is_ascii()).unwrap_or("");
    let at = cell.chars().position(|c| !c.is_ascii()).unwrap_or(0);
    cell.chars().skip(at.saturating_sub(MAX_EXAMPLE_CHARS / 2)).take(MAX_EXAMPLE_CHARS).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8], declared: Option<&str>, of_rules: Option<&str>) -> String {
        decode(bytes, declared, of_rules).unwrap().text.into_owned()
    }

    #[test]
    fn marks_declarations_and_utf_8_rank_before_rules() {
        assert_eq!(text(b"\xef\xbb\xbfT\xc3\xbcr", Some("windows-1252"), None), "Tür");
        assert_eq!(text(b"\xff\xfeT\0\xfc\0r\0", None, Some("big5")), "Tür");
        assert_eq!(text(b"T\xc3\xbcr", None, Some("windows-1251")), "Tür");
        assert_eq!(text(b"T\xfcr", Some("ISO-8859-1"), Some("windows-1251")), "Tür");
        assert_eq!(text(b"\xd1\xf2\xe5\xed\xe0", None, Some("windows-1251")), "Стена");
    }

    #[test]
    fn a_guess_is_told_with_an_example() {
        let read = decode(b"A\tOuter T\xfcr\tB\n", None, None).unwrap();
        assert_eq!(read.text, "A\tOuter Tür\tB\n");
        let expected = "its encoding is not written in it and was guessed to be windows-1252, in which it reads \"Outer Tür\"; \
                        if that is wrong, say which with encoding in the schedule rules";
        assert_eq!(read.guess.as_deref(), Some(expected));
        for (bytes, declared, rules) in
            [(&b"T\xfcr"[..], Some("latin1"), None), (b"T\xfcr", None, Some("latin1")), (b"T\xc3\xbcr", None, None)]
        {
            assert_eq!(decode(bytes, declared, rules).unwrap().guess, None);
        }
    }

    #[test]
    fn names_of_activities_are_read_in_the_code_page_of_their_country() {
        let check = |label: &str, names: &[&str]| {
            let names = names.join("\n%R\t");
            let encoding = Encoding::for_label(label.as_bytes()).unwrap();
            let (bytes, _, is_lossy) = encoding.encode(&names);
            assert!(!is_lossy);
            let bytes = [b"ERMHDR\t19.12\n%T\tTASK\n%F\ttask_name\n%R\t", &*bytes, b"\n%E\n"].concat();
            let read = decode(&bytes, None, None).unwrap();
            assert!(read.text.contains(&names), "{label}: {}", read.text);
            assert!(read.guess.unwrap().contains(encoding.name()));
        };
        check("big5", &["開挖土方工程", "混凝土澆置", "鋼筋綁紮"]);
        check("gbk", &["基坑开挖", "混凝土浇筑", "墙体砌筑"]);
        check("windows-1251", &["Монтаж стен", "Устройство полов"]);
        check("shift_jis", &["壁の施工", "コンクリート打設"]);
        check("windows-1252", &["Stützen im Erdgeschoß", "Wände"]);
    }

    #[test]
    fn an_unknown_encoding_and_wrong_bytes_are_errors() {
        let error = |bytes: &[u8], declared, rules| match decode(bytes, declared, rules) {
            Err(PlanFileError::Encoding(name)) => name,
            other => panic!("{other:?}"),
        };
        assert_eq!(error(b"x", Some("EBCDIC"), None), "EBCDIC");
        assert_eq!(error(b"T\xfcr", Some("utf-8"), None), "UTF-8");
        assert_eq!(error(b"T\xff\xffr", None, Some("big5")), "Big5");
        assert_eq!(error(b"T\xc3\xbcr is cut \xc3", None, None), "UTF-8");
    }
}
