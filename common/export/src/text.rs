//! Values as files have them: rounded numbers, texts or null, sums, texts in XML.

use quick_xml::Writer;
use quick_xml::events::BytesText;
use std::borrow::Cow;

/// A text for JSON; `None`, which is written as null, if it is empty.
pub fn text_or_null(text: &str) -> Option<String> {
    (!text.is_empty()).then(|| text.to_owned())
}

/// Metres rounded to tenths of a millimetre: no more is known.
pub fn rounded(metres: f64) -> f64 {
    // Absurd numbers of absurd files stay finite, because JSON has no infinity.
    let rounded = ((metres * 1e4).round() / 1e4).clamp(f64::MIN, f64::MAX);
    // No negative zero in files.
    if rounded == 0.0 { 0.0 } else { rounded }
}

/// A share, rounded alike wherever it is told; `None` of nothing.
pub(crate) fn share(n: u32, of: u32) -> Option<f64> {
    (of > 0).then(|| rounded(f64::from(n) / f64::from(of)))
}

/// An element with a text, which keeps what XML allows.
pub(crate) fn xml_text(xml: &mut Writer<Vec<u8>>, name: &str, content: &str) -> std::io::Result<()> {
    let is_bad = |c: char| (c < ' ' && !matches!(c, '\t' | '\n' | '\r')) || matches!(c, '\u{fffe}' | '\u{ffff}');
    let content: Cow<'_, str> =
        if content.contains(is_bad) { content.replace(is_bad, "\u{fffd}").into() } else { content.into() };
    xml.create_element(name).write_text_content(BytesText::new(&content))?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_leaves_no_negative_zero() {
        assert_eq!(rounded(-0.000_01).to_bits(), 0.0f64.to_bits());
        assert_eq!(rounded(1.234_56), 1.2346);
        assert_eq!(rounded(-1e308), f64::MIN);
    }

    #[test]
    fn an_empty_text_is_null() {
        assert_eq!((text_or_null(""), text_or_null("a")), (None, Some("a".to_owned())));
    }
}
