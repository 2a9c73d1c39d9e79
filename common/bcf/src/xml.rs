//! Elements with text, and numbers as texts.

use quick_xml::Writer;
use quick_xml::events::{BytesDecl, BytesText, Event};
use std::io::Result;

pub(crate) type Xml = Writer<Vec<u8>>;

/// A document with its declaration.
pub(crate) fn document() -> Result<Xml> {
    let mut xml = Writer::new(Vec::new());
    xml.write_event(Event::Decl(BytesDecl::new("1.0", Some("UTF-8"), None)))?;
    Ok(xml)
}

/// An element that holds a text.
pub(crate) fn text(xml: &mut Xml, name: &str, content: &str) -> Result<()> {
    // XML has no way to write most control characters.
    let is_bad = |c: char| (c < ' ' && !matches!(c, '\t' | '\n' | '\r')) || matches!(c, '\u{fffe}' | '\u{ffff}');
    let written = content.replace(is_bad, "\u{fffd}");
    xml.create_element(name).write_text_content(BytesText::new(&written)).map(|_| ())
}

/// A place or direction, to a tenth of a millimetre and a millionth.
pub(crate) fn vector(xml: &mut Xml, name: &str, at: [f64; 3]) -> Result<()> {
    xml.create_element(name).write_inner_content(|xml| {
        ["X", "Y", "Z"].iter().zip(at).try_for_each(|(axis, c)| text(xml, axis, &number(c)))
    })?;
    Ok(())
}

/// A number with at most six decimals.
pub(crate) fn number(value: f64) -> String {
    // Absurd numbers of absurd files stay finite; zero has no sign.
    let rounded = ((value * 1e6).round() / 1e6).clamp(f64::MIN, f64::MAX);
    format!("{}", rounded + 0.0)
}
