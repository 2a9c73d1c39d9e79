//! Bytes of a file as UTF-8: some exporters write texts in the code page of their country.
//!
//! STEP wants ASCII, with escapes for everything else; many files have UTF-8, which is read as such. Any other encoding is
//! guessed from the texts that are not UTF-8, and told.

use std::borrow::Cow;

use chardetng::EncodingDetector;
use encoding_rs::Encoding;

use crate::segments::{Segment, segments};
use diagnostics::{DiagnosticCode, Report, Severity};

/// Bytes of texts from which an encoding is guessed.
const SAMPLE_BYTES_MAX: usize = 1 << 20;

/// Characters of the example that shows how a guessed encoding reads.
const EXAMPLE_CHARS_MAX: usize = 40;

/// The file in UTF-8; borrowed where it is that already.
pub(crate) fn as_utf_8<'a>(bytes: Cow<'a, [u8]>, report: &mut Report) -> Cow<'a, [u8]> {
    if let Some((encoding, skip)) = Encoding::for_bom(&bytes).filter(|(encoding, _)| *encoding != encoding_rs::UTF_8) {
        let (text, _) = encoding.decode_without_bom_handling(&bytes[skip..]);
        return Cow::Owned(text.into_owned().into_bytes());
    }
    if std::str::from_utf8(&bytes).is_ok() {
        return bytes;
    }
    let texts = || segments(&bytes).filter(|s| matches!(s, Segment::Text(_))).map(Segment::bytes);
    let foreign = || texts().filter(|text| !text.is_ascii());
    let is_utf_8 = |text: &&[u8]| std::str::from_utf8(text).is_ok();
    let (n_all, n_utf_8) = (foreign().count(), foreign().filter(is_utf_8).count());
    if n_all == n_utf_8 {
        // Comments and damage between the records; nothing of it is read.
        return bytes;
    }
    // A short text of another encoding can be UTF-8 by chance; a file of such texts is not.
    let keeps_utf_8 = 2 * n_utf_8 > n_all;
    let is_decoded = |text: &&[u8]| !(text.is_ascii() || keeps_utf_8 && is_utf_8(text));
    let encoding = guessed(foreign().filter(is_decoded));
    let mut decoded = Vec::with_capacity(bytes.len() + bytes.len() / 8);
    let (mut example, mut n_lossy) = (None, 0);
    for segment in segments(&bytes) {
        match segment {
            Segment::Text(text) if is_decoded(&text) => {
                let (text, is_lossy) = encoding.decode_without_bom_handling(text);
                n_lossy += usize::from(is_lossy);
                example.get_or_insert_with(|| shortened(&text));
                decoded.extend_from_slice(text.as_bytes());
            }
            _ => decoded.extend_from_slice(segment.bytes()),
        }
    }
    let n_decoded = foreign().filter(is_decoded).count();
    let message = message(encoding, n_decoded, n_lossy, &example.unwrap_or_default());
    report.add(Severity::Warning, DiagnosticCode::EncodingGuessed, None, message);
    Cow::Owned(decoded)
}

fn message(encoding: &'static Encoding, n_decoded: usize, n_lossy: usize, example: &str) -> String {
    let texts = diagnostics::counted(n_decoded, "text") + if n_decoded == 1 { " is" } else { " are" };
    let name = encoding.name();
    let lossy = if n_lossy == 0 {
        String::new()
    } else {
        format!("; {} with bytes that are no character of it", diagnostics::counted(n_lossy, "text"))
    };
    format!(
        "{texts} not in UTF-8; the encoding is not written in it and was guessed to be {name}, in which the first \
         reads {example:?}{lossy}; if that is wrong, export the file again in UTF-8"
    )
}

/// The encoding that the texts look most like.
fn guessed<'t>(texts: impl Iterator<Item = &'t [u8]>) -> &'static Encoding {
    let mut detector = EncodingDetector::new();
    let mut n_bytes = 0;
    for text in texts.take_while(|text| {
        n_bytes += text.len();
        n_bytes - text.len() < SAMPLE_BYTES_MAX
    }) {
        detector.feed(text, false);
        detector.feed(b"\n", false);
    }
    detector.feed(b"", true);
    detector.guess(None, false)
}

/// A text without its quotes; of a long one, what is around its first character that is not in ASCII.
fn shortened(text: &str) -> String {
    let text = text.trim_matches('\'');
    let at = text.chars().position(|c| !c.is_ascii()).unwrap_or(0);
    text.chars().skip(at.saturating_sub(EXAMPLE_CHARS_MAX / 2)).take(EXAMPLE_CHARS_MAX).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BASICS, file};

    /// Names of the walls of a file with these bytes, and the messages about its encoding.
    fn read(bytes: &[u8]) -> (Vec<String>, Vec<String>) {
        let (model, diagnostics) = crate::read(bytes, &crate::ReadOptions::default()).unwrap();
        let told = diagnostics.into_iter().filter(|d| d.code == DiagnosticCode::EncodingGuessed).map(|d| d.message);
        (model.elements.into_iter().map(|e| e.id.name).collect(), told.collect())
    }

    /// A file with a wall of each name.
    fn walls(names: &[&str]) -> String {
        let wall = |(k, name): (usize, &&str)| format!("#{}=IFCWALL('w{k:02}',$,'{name}',$,$,#103,#121,$,$);\n", k + 1);
        file(&format!("{BASICS}{}", names.iter().enumerate().map(wall).collect::<String>()))
    }

    fn check(label: &str, names: &[&str]) {
        let encoding = Encoding::for_label(label.as_bytes()).unwrap();
        let text = walls(names);
        let (bytes, _, is_lossy) = encoding.encode(&text);
        assert!(!is_lossy);
        let (found, told) = read(&bytes);
        assert_eq!(found, names, "{label}");
        assert!(told.len() == 1 && told[0].contains(encoding.name()), "{told:?}");
        assert!(told[0].contains(&format!("{:?}", names[0])), "{told:?}");
    }

    #[test]
    fn names_in_the_code_page_of_their_country_are_read_and_told_with_an_example() {
        check("shift_jis", &["事務室の間仕切り壁", "表示板", "コンクリート壁", "階段室の防火扉"]);
        check("windows-1252", &["Außenwand Süd", "Brüstung", "Dämmung"]);
        check("gbk", &["会议室隔墙", "混凝土剪力墙", "楼梯间防火门"]);
        check("big5", &["會議室隔間牆", "混凝土牆", "樓梯間防火門"]);
        check("windows-1251", &["Наружная стена", "Перегородка"]);
    }

    #[test]
    fn utf_8_and_utf_16_are_no_guess() {
        let text = walls(&["Außenwand", "表示板"]);
        assert_eq!(read(text.as_bytes()), (vec!["Außenwand".to_owned(), "表示板".to_owned()], Vec::new()));
        let utf_16: Vec<u8> = "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(u16::to_le_bytes).collect();
        assert_eq!(read(&utf_16), read(text.as_bytes()));
    }

    #[test]
    fn one_text_of_another_encoding_leaves_those_in_utf_8_alone() {
        let text = walls(&["Außenwand", "Tür", "Süd"]).into_bytes();
        let at = memchr::memmem::find(&text, "Tür".as_bytes()).unwrap();
        let bytes = [&text[..at], b"T\xfcr", &text[at + 4..]].concat();
        let (names, told) = read(&bytes);
        assert_eq!(names, ["Außenwand", "Tür", "Süd"]);
        assert!(told[0].starts_with("1 text is not in UTF-8") && told[0].contains("\"Tür\""), "{told:?}");
    }
}
