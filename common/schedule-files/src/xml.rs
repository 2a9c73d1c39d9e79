//! XML of schedule files, element by element, without entities of its own and without a tree in memory.

use crate::PlanFileError;
use quick_xml::events::{BytesRef, BytesStart, Event};
use quick_xml::{Reader, escape};
use std::borrow::Cow;

/// Elements nest at most so deep; those of the products reach about ten.
const MAX_DEPTH: usize = 64;

/// The encoding that the XML declaration names.
///
/// A declaration that can be read byte by byte and says UTF-16 is wrong, as programs for Windows write it that save a text as UTF-8; it
/// counts as none.
pub(crate) fn declared_encoding(bytes: &[u8]) -> Option<&str> {
    let start = &bytes[..bytes.len().min(256)];
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let end = memchr::memmem::find(start, b"?>").filter(|_| start.starts_with(b"<?xml"))?;
    let (_, value) = std::str::from_utf8(&start[..end]).ok()?.split_once("encoding")?;
    let value = value.trim_start().strip_prefix('=')?.trim_start();
    let quote = value.chars().next().filter(|quote| ['"', '\''].contains(quote))?;
    let label = value[1..].split(quote).next()?.trim();
    (!label.to_ascii_lowercase().starts_with("utf-16")).then_some(label)
}

/// A place in the text: inside an element, before its next child.
///
/// ```text
/// while let Some(name) = xml.child()? {
///     match name {
///         "Name" => task.name = xml.text()?.into_owned(),
///         "ExtendedAttribute" => extended_attribute(xml)?,
///         _ => xml.skip()?,
///     }
/// }
/// ```
pub(crate) struct Xml<'a> {
    text: &'a str,
    reader: Reader<&'a [u8]>,
    depth: usize,
    root: &'a str,
    namespace: String,
}

impl<'a> Xml<'a> {
    /// Enters the root element.
    ///
    /// # Errors
    /// A text that is no XML up to the root element, or that has a document type.
    pub(crate) fn open(text: &'a str) -> Result<Self, PlanFileError> {
        let mut reader = Reader::from_str(text);
        reader.config_mut().expand_empty_elements = true;
        let mut xml = Self { text, reader, depth: 0, root: "", namespace: String::new() };
        let Some((name, start)) = xml.next_start()? else { return Err(xml.error("it has no element")) };
        let (prefix, local_name) = name.split_once(':').unwrap_or(("", name));
        let declaration = if prefix.is_empty() { "xmlns".to_owned() } else { format!("xmlns:{prefix}") };
        let namespace = start.try_get_attribute(declaration.as_str()).map_err(|error| xml.error(error.to_string()))?;
        xml.namespace = namespace.map_or_else(String::new, |attribute| attribute.value.into_owned());
        xml.root = local_name;
        Ok(xml)
    }

    /// Name of the root element, without a prefix.
    pub(crate) fn root(&self) -> &'a str {
        self.root
    }

    /// Namespace of the root element; empty if it has none.
    pub(crate) fn namespace(&self) -> &str {
        &self.namespace
    }

    /// Enters the next child element and returns its name, without a prefix; at the end of the element leaves that, with `None`.
    ///
    /// # Errors
    /// A text that is not well-formed, ends too early or nests too deep.
    pub(crate) fn child(&mut self) -> Result<Option<&'a str>, PlanFileError> {
        let start = self.next_start()?;
        Ok(start.map(|(name, _)| name.split_once(':').map_or(name, |(_, local_name)| local_name)))
    }

    /// The text of the element, which is left; without spaces around it, and without that of elements in it.
    ///
    /// # Errors
    /// As [`Xml::child`], and an entity that XML does not define.
    pub(crate) fn text(&mut self) -> Result<Cow<'a, str>, PlanFileError> {
        // Spaces beside an entity belong to the text.
        self.reader.config_mut().trim_text_start = false;
        let mut text = Cow::Borrowed("");
        loop {
            match self.event()? {
                Event::Start(_) => {
                    self.enter()?;
                    self.skip()?;
                    self.reader.config_mut().trim_text_start = false;
                }
                Event::End(_) => {
                    self.depth -= 1;
                    return Ok(trimmed(text));
                }
                Event::Text(part) => append(&mut text, part.xml10_content()),
                Event::CData(part) => append(&mut text, part.xml10_content()),
                Event::GeneralRef(entity) => {
                    let character = resolved(&entity).ok_or_else(|| self.undefined(&entity))?;
                    append(&mut text, character.into());
                }
                _ => {}
            }
        }
    }

    /// Leaves the element.
    ///
    /// # Errors
    /// As [`Xml::child`].
    pub(crate) fn skip(&mut self) -> Result<(), PlanFileError> {
        let outside = self.depth - 1;
        while self.depth > outside {
            self.next_start()?;
        }
        Ok(())
    }

    /// What is wrong at this place.
    pub(crate) fn error(&self, why: impl Into<String>) -> PlanFileError {
        let line = 1 + memchr::memchr_iter(b'\n', &self.text.as_bytes()[..self.position()]).count();
        PlanFileError::Xml { line, why: why.into() }
    }

    fn undefined(&self, entity: &BytesRef<'_>) -> PlanFileError {
        self.error(format!("it uses the entity {:?}, which XML does not define", &**entity))
    }

    fn position(&self) -> usize {
        usize::try_from(self.reader.buffer_position()).map_or(self.text.len(), |at| at.min(self.text.len()))
    }

    /// Enters the next element, or leaves the one around it with `None`.
    fn next_start(&mut self) -> Result<Option<(&'a str, BytesStart<'a>)>, PlanFileError> {
        self.reader.config_mut().trim_text_start = true;
        loop {
            let before = self.position();
            match self.event()? {
                Event::Start(start) => {
                    self.enter()?;
                    let tag = &self.text.as_bytes()[before..];
                    let from = before + 1 + memchr::memchr(b'<', tag).expect("a tag begins so");
                    return Ok(Some((&self.text[from..from + start.name().0.len()], start)));
                }
                Event::End(_) => {
                    self.depth -= 1;
                    return Ok(None);
                }
                _ => {}
            }
        }
    }

    fn event(&mut self) -> Result<Event<'a>, PlanFileError> {
        match self.reader.read_event() {
            Ok(Event::Eof) if self.depth == 0 => Err(self.error("it has no element")),
            Ok(Event::Eof) => Err(self.error("it ends within an element")),
            Ok(Event::DocType(_)) => Err(self.error("it has a document type, which no schedule file has")),
            Ok(event) => Ok(event),
            Err(error) => Err(self.error(error.to_string())),
        }
    }

    fn enter(&mut self) -> Result<(), PlanFileError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH { Err(self.error(format!("elements nest deeper than {MAX_DEPTH}"))) } else { Ok(()) }
    }
}

/// What a reference to an entity stands for: a character by number, or one of the five that XML defines.
fn resolved(entity: &BytesRef<'_>) -> Option<String> {
    match entity.resolve_char_ref() {
        Ok(Some(character)) => Some(character.to_string()),
        Ok(None) => escape::resolve_predefined_entity(entity).map(str::to_owned),
        Err(_) => None,
    }
}

fn append<'a>(text: &mut Cow<'a, str>, part: Cow<'a, str>) {
    if text.is_empty() {
        *text = part;
    } else {
        text.to_mut().push_str(&part);
    }
}

fn trimmed(text: Cow<'_, str>) -> Cow<'_, str> {
    match text {
        Cow::Borrowed(text) => Cow::Borrowed(text.trim()),
        Cow::Owned(text) if text.trim().len() < text.len() => Cow::Owned(text.trim().to_owned()),
        owned => owned,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        let all = || {
            let mut xml = Xml::open(text)?;
            while xml.child()?.is_some() {
                xml.text()?;
            }
            Ok(())
        };
        all().map_or_else(|error: PlanFileError| error.to_string(), |()| String::new())
    }

    #[test]
    fn elements_are_entered_read_and_passed_over() {
        let text = "<?xml version=\"1.0\"?><!-- a -->\n<p:A xmlns:p=\"n/s\"><p:B x=\"1\"> a &amp; <b>no</b> c &#xfc;<![CDATA[<]]> </p:B>\
                    <C><D>1</D></C><E/><F><D>2</D><G/></F></p:A>";
        let mut xml = Xml::open(text).unwrap();
        assert_eq!((xml.root(), xml.namespace()), ("A", "n/s"));
        assert_eq!(xml.child().unwrap(), Some("B"));
        assert_eq!(xml.text().unwrap(), "a &  c ü<");
        assert_eq!(xml.child().unwrap(), Some("C"));
        xml.skip().unwrap();
        assert_eq!(xml.child().unwrap(), Some("E"));
        assert_eq!(xml.text().unwrap(), "");
        assert_eq!(xml.child().unwrap(), Some("F"));
        assert_eq!(xml.child().unwrap(), Some("D"));
        assert_eq!(xml.text().unwrap(), "2");
        assert_eq!(xml.child().unwrap(), Some("G"));
        assert_eq!(xml.child().unwrap(), None);
        assert_eq!(xml.child().unwrap(), None);
        assert_eq!(xml.child().unwrap(), None);
    }

    #[test]
    fn what_is_not_well_formed_is_an_error_with_its_line() {
        assert_eq!(message("<a>\n<b>&amp;</b></a>"), "");
        assert_eq!(message("<a>\n<b>\n"), "line 3: it ends within an element");
        assert!(message("<a>\n<b></a>").starts_with("line 2: "));
        assert_eq!(message("<a><b>&lol;</b></a>"), "line 1: it uses the entity \"lol\", which XML does not define");
        assert_eq!(message("text"), "line 1: it has no element");
    }

    #[test]
    fn document_types_and_endless_nesting_are_errors() {
        let bomb = "<!DOCTYPE a [<!ENTITY b \"bb\"><!ENTITY c \"&b;&b;\">]>\n<a>&c;</a>";
        assert!(message(bomb).contains("document type"));
        assert!(message(&"<a>".repeat(100_000)).contains("nest deeper"));
    }

    #[test]
    fn the_declaration_names_the_encoding_unless_it_cannot_be_right() {
        let check = |text: &str, expected: Option<&str>| assert_eq!(declared_encoding(text.as_bytes()), expected);
        check("<?xml version=\"1.0\" encoding=\"windows-1252\"?><a/>", Some("windows-1252"));
        check("\u{feff}<?xml version='1.0' encoding = 'utf-8' standalone='yes'?>", Some("utf-8"));
        check("<?xml version=\"1.0\" encoding=\"UTF-16\"?><a/>", None);
        check("<?xml version=\"1.0\"?><a encoding=\"x\"/>", None);
        check("<a/>", None);
    }
}
