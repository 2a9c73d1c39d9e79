//! An XML text as a tree of elements with their lines; without document types, bounded in size and depth.

use std::borrow::Cow;

use encoding_rs::{Encoding, UTF_8};
use quick_xml::events::{BytesRef, BytesStart, Event};
use quick_xml::name::ResolveResult;
use quick_xml::{NsReader, XmlVersion, escape};

use crate::IdsError;

/// Longest file that is read; real ones stay below a megabyte.
const BYTES_MAX: usize = 32 << 20;
/// Elements nest at most so deep; IDS reaches nine.
const DEPTH_MAX: usize = 32;

/// Namespace of IDS, of every version.
const IDS_NAMESPACE: &str = "http://standards.buildingsmart.org/IDS";
/// Namespace of `xs:restriction` and what is in it.
const XS_NAMESPACE: &str = "http://www.w3.org/2001/XMLSchema";

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Namespace {
    Ids,
    Xs,
    Other,
}

/// An element with all that is in it.
#[derive(Debug)]
pub(crate) struct Element {
    pub(crate) namespace: Namespace,
    /// Without a prefix.
    pub(crate) name: String,
    /// Those without a prefix.
    pub(crate) attributes: Vec<(String, String)>,
    pub(crate) children: Vec<Element>,
    /// Text of the element itself.
    pub(crate) text: String,
    /// Line of its tag, from 1.
    pub(crate) line: usize,
}

impl Element {
    pub(crate) fn attribute(&self, name: &str) -> Option<&str> {
        self.attributes.iter().find(|(key, _)| key == name).map(|(_, value)| value.as_str())
    }

    pub(crate) fn is(&self, namespace: Namespace, name: &str) -> bool {
        self.namespace == namespace && self.name == name
    }
}

/// The root element of a file.
pub(crate) fn parse(bytes: &[u8]) -> Result<Element, IdsError> {
    if bytes.len() > BYTES_MAX {
        return Err(IdsError::TooLarge { bytes: bytes.len(), max: BYTES_MAX });
    }
    let text = decoded(bytes)?;
    Builder { text: &text, reader: NsReader::from_str(&text), open: Vec::new(), counted: (0, 1) }.root()
}

/// The text, by its byte order mark, else by what it declares, else as UTF-8.
fn decoded(bytes: &[u8]) -> Result<Cow<'_, str>, IdsError> {
    let unknown = |encoding: &str| IdsError::Encoding { encoding: encoding.to_owned() };
    let (encoding, skip) = match Encoding::for_bom(bytes) {
        Some(marked) => marked,
        None => {
            let label = declared_encoding(bytes).unwrap_or("utf-8");
            (Encoding::for_label(label.as_bytes()).ok_or_else(|| unknown(label))?, 0)
        }
    };
    // A declaration that is read byte by byte and says UTF-16 is wrong.
    let encoding = if skip == 0 && encoding.name().starts_with("UTF-16") { UTF_8 } else { encoding };
    let (text, is_malformed) = encoding.decode_without_bom_handling(&bytes[skip..]);
    if is_malformed { Err(unknown(encoding.name())) } else { Ok(text) }
}

fn declared_encoding(bytes: &[u8]) -> Option<&str> {
    let start = std::str::from_utf8(&bytes[..bytes.len().min(256)]).unwrap_or_default();
    let (declaration, _) = start.strip_prefix("<?xml")?.split_once("?>")?;
    let value = declaration.split_once("encoding")?.1.trim_start().strip_prefix('=')?.trim_start();
    let quote = value.chars().next().filter(|quote| ['"', '\''].contains(quote))?;
    value[1..].split(quote).next()
}

struct Builder<'a> {
    text: &'a str,
    reader: NsReader<&'a [u8]>,
    open: Vec<Element>,
    /// Bytes whose lines are counted, and the line there.
    counted: (usize, usize),
}

impl<'a> Builder<'a> {
    fn root(mut self) -> Result<Element, IdsError> {
        self.reader.config_mut().expand_empty_elements = true;
        loop {
            let event = self.reader.read_resolved_event();
            let (namespace, event) = match event {
                Ok((namespace, event)) => (namespace_of(&namespace), event),
                Err(error) => return Err(self.error(error.to_string())),
            };
            match event {
                Event::Start(start) => self.enter(namespace, &start)?,
                Event::End(_) => {
                    let Some(element) = self.open.pop() else { continue };
                    match self.open.last_mut() {
                        Some(parent) => parent.children.push(element),
                        None => return Ok(element),
                    }
                }
                Event::Text(part) => self.append(&part.xml10_content()),
                Event::CData(part) => self.append(&part.xml10_content()),
                Event::GeneralRef(entity) => {
                    let Some(character) = resolved(&entity) else {
                        return Err(self.error(format!("it uses the entity {:?}, which XML does not define", &*entity)));
                    };
                    self.append(&character);
                }
                Event::DocType(_) => return Err(self.error("it has a document type".to_owned())),
                Event::Eof if self.open.is_empty() => return Err(self.error("it has no element".to_owned())),
                Event::Eof => return Err(self.error("it ends within an element".to_owned())),
                _ => {}
            }
        }
    }

    fn enter(&mut self, namespace: Namespace, start: &BytesStart<'a>) -> Result<(), IdsError> {
        if self.open.len() == DEPTH_MAX {
            return Err(self.error(format!("elements nest deeper than {DEPTH_MAX}")));
        }
        let mut attributes = Vec::new();
        for attribute in start.attributes() {
            let attribute = attribute.map_err(|error| self.error(error.to_string()))?;
            if attribute.key.prefix().is_some() || attribute.key.as_namespace_binding().is_some() {
                continue;
            }
            let value =
                attribute.normalized_value(XmlVersion::Explicit1_0).map_err(|error| self.error(error.to_string()))?;
            attributes.push((attribute.key.0.to_owned(), value.into_owned()));
        }
        let name = start.local_name().into_inner().to_owned();
        let line = self.line();
        self.open.push(Element { namespace, name, attributes, children: Vec::new(), text: String::new(), line });
        Ok(())
    }

    fn append(&mut self, part: &str) {
        if let Some(element) = self.open.last_mut() {
            element.text.push_str(part);
        }
    }

    fn line(&mut self) -> usize {
        let at = usize::try_from(self.reader.buffer_position()).map_or(self.text.len(), |at| at.min(self.text.len()));
        let (before, line) = self.counted;
        let line = line + memchr::memchr_iter(b'\n', &self.text.as_bytes()[before.min(at)..at]).count();
        self.counted = (at, line);
        line
    }

    fn error(&mut self, why: String) -> IdsError {
        IdsError::Xml { line: self.line(), why }
    }
}

fn namespace_of(namespace: &ResolveResult<'_>) -> Namespace {
    match namespace {
        ResolveResult::Bound(namespace) if namespace.0 == IDS_NAMESPACE => Namespace::Ids,
        ResolveResult::Bound(namespace) if namespace.0 == XS_NAMESPACE => Namespace::Xs,
        _ => Namespace::Other,
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tree_has_names_without_prefixes_texts_and_lines() {
        let text = "<?xml version='1.0' encoding='utf-8'?>\n<i:a xmlns:i='http://standards.buildingsmart.org/IDS' x='1 &amp; 2'\n\
                    xmlns:xs='http://www.w3.org/2001/XMLSchema'><xs:b>c &lt;&#xe9;<![CDATA[<]]></xs:b>\n<d/></i:a>";
        let root = parse(text.as_bytes()).unwrap();
        assert!(root.is(Namespace::Ids, "a") && root.line == 3);
        assert_eq!(root.attributes, [("x".to_owned(), "1 & 2".to_owned())]);
        let [b, d] = &root.children[..] else { panic!("{root:?}") };
        assert!(b.is(Namespace::Xs, "b") && d.is(Namespace::Other, "d"));
        assert_eq!((b.text.as_str(), d.line), ("c <é<", 4));
        let utf_16: Vec<u8> = format!("\u{feff}{text}").encode_utf16().flat_map(u16::to_le_bytes).collect();
        assert_eq!(parse(&utf_16).unwrap().children[0].text, "c <é<");
    }

    #[test]
    fn what_is_not_well_formed_is_an_error_with_its_line() {
        let check = |text: &str| parse(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(check("<a>\n<b>\n"), "line 3 of the IDS file: it ends within an element");
        assert!(check("<a>\n<b></a>").starts_with("line 2 of the IDS file: "));
        assert!(check("<a>&lol;</a>").contains("\"lol\""));
        assert!(check("<!DOCTYPE a []><a/>").contains("document type"));
        assert!(check(&"<a>".repeat(10_000)).contains("nest deeper"));
        assert!(check("").contains("no element"));
        assert!(check("<?xml version='1.0' encoding='nonsense'?><a/>").contains("nonsense"));
        assert!(parse(b"<a>\xff</a>").is_err());
    }
}
