//! The instances of a STEP file by their places in its bytes, so that single ones can be changed and nothing else.

use crate::AsBuiltError;
use memchr::{memchr, memchr3, memmem};
use std::collections::BTreeMap;
use std::ops::Range;

/// The schemas by which instances are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Schema {
    Ifc2x3,
    Ifc4,
    Ifc4x3,
}

impl Schema {
    /// The schema of a FILE_SCHEMA label; `None` for others than IFC2X3, IFC4 (to IFC4X2) and IFC4X3.
    fn of_label(label: &str) -> Option<Self> {
        let label = label.trim().to_ascii_uppercase();
        match label {
            _ if label.starts_with("IFC2X3") => Some(Self::Ifc2x3),
            _ if label.starts_with("IFC4X3") => Some(Self::Ifc4x3),
            _ if label.starts_with("IFC4") => Some(Self::Ifc4),
            _ => None,
        }
    }
}

/// A file, with an index of its instances.
pub(crate) struct StepFile<'a> {
    pub(crate) bytes: &'a [u8],
    pub(crate) schema: Schema,
    /// Instances with their places, from `#` to the semicolon, by id.
    places: BTreeMap<u64, Range<usize>>,
    /// Ids by entity, as the file spells it.
    entities: BTreeMap<&'a str, Vec<u64>>,
    /// Ids by GlobalId.
    roots: BTreeMap<&'a [u8], u64>,
    /// Where the last data section ends.
    pub(crate) end_of_data: usize,
    /// What ends its lines.
    pub(crate) line_end: &'static str,
}

/// An instance.
#[derive(Debug, Clone)]
pub(crate) struct Instance<'a> {
    pub(crate) id: u64,
    pub(crate) entity: &'a str,
    /// Places of its arguments in the file, without blanks around them.
    pub(crate) arguments: Vec<Range<usize>>,
}

impl Instance<'_> {
    pub(crate) fn is(&self, entity: &str) -> bool {
        self.entity.eq_ignore_ascii_case(entity)
    }
}

/// Greatest id of a file to which instances are added.
const ID_MAX: u64 = u64::MAX / 2;

impl<'a> StepFile<'a> {
    /// Indexes a file.
    ///
    /// # Errors
    /// No STEP file in one byte for a character, a schema that cannot be written, a file without an end.
    pub(crate) fn of(bytes: &'a [u8]) -> Result<Self, AsBuiltError> {
        let start = bytes.strip_prefix(b"\xef\xbb\xbf").map_or(0, |_| 3);
        if !bytes[start..].trim_ascii_start().starts_with(b"ISO-10303-21") {
            return Err(AsBuiltError::NotStep);
        }
        let mut file = Self {
            bytes,
            schema: Schema::Ifc4,
            places: BTreeMap::new(),
            entities: BTreeMap::new(),
            roots: BTreeMap::new(),
            end_of_data: 0,
            line_end: line_end(bytes),
        };
        let (mut label, mut is_data) = (None, false);
        let mut at = start;
        while let Some(place) = statement(bytes, at) {
            let text = &bytes[place.clone()];
            at = place.end;
            if text.first() == Some(&b'#') {
                file.index(place);
            } else if text.starts_with(b"FILE_SCHEMA") {
                label = Some(quoted(text).ok_or(AsBuiltError::NoSchema)?);
            } else if text.starts_with(b"DATA") {
                is_data = true;
            } else if text.starts_with(b"ENDSEC") && is_data {
                (file.end_of_data, is_data) = (place.start, false);
            }
        }
        let label = label.ok_or(AsBuiltError::NoSchema)?;
        let known = Schema::of_label(&label);
        file.schema = known.ok_or_else(|| AsBuiltError::Schema { label: label.into_owned() })?;
        if file.end_of_data == 0 || is_data {
            return Err(AsBuiltError::Cut);
        }
        if file.max_id() > ID_MAX {
            return Err(AsBuiltError::Ids { id: file.max_id() });
        }
        Ok(file)
    }

    fn index(&mut self, place: Range<usize>) {
        let bytes = self.bytes;
        let text = &bytes[place.clone()];
        let Some(id) = leading_number(&text[1..]) else { return };
        let Some(open) = memchr(b'(', text) else { return };
        let entity =
            text[..open].rsplit(|b| *b == b'=' || b.is_ascii_whitespace() || *b == b'/').find(|t| !t.is_empty());
        if let Some(entity) = entity.and_then(|entity| std::str::from_utf8(entity).ok()) {
            self.entities.entry(entity).or_default().push(id);
        }
        let first = text[open + 1..].trim_ascii_start();
        if let [b'\'', id_text @ .., b'\''] = first.get(..24).unwrap_or_default() {
            self.roots.entry(id_text).or_insert(id);
        }
        self.places.insert(id, place);
    }

    /// The greatest id.
    pub(crate) fn max_id(&self) -> u64 {
        self.places.keys().next_back().copied().unwrap_or(0)
    }

    /// The place of an instance, from `#` to the semicolon.
    pub(crate) fn place(&self, id: u64) -> Option<Range<usize>> {
        self.places.get(&id).cloned()
    }

    /// Ids of an entity, in the order of the file.
    pub(crate) fn ids_of(&self, entity: &str) -> Vec<u64> {
        let of_name = self.entities.iter().filter(|(name, _)| name.eq_ignore_ascii_case(entity));
        of_name.flat_map(|(_, ids)| ids).copied().collect()
    }

    /// Instances of an entity, in the order of the file.
    pub(crate) fn all(&self, entity: &str) -> Vec<Instance<'a>> {
        self.ids_of(entity).into_iter().filter_map(|id| self.instance(id)).collect()
    }

    /// Ids of all that has a GlobalId, in the order of these.
    pub(crate) fn roots(&self) -> impl Iterator<Item = u64> {
        self.roots.values().copied()
    }

    /// The id of what has a GlobalId.
    pub(crate) fn root(&self, global_id: &str) -> Option<u64> {
        self.roots.get(global_id.as_bytes()).copied()
    }

    /// An instance with its arguments; `None` if there is none, or it is no simple one.
    pub(crate) fn instance(&self, id: u64) -> Option<Instance<'a>> {
        let place = self.place(id)?;
        let text = &self.bytes[place.clone()];
        let equals = memchr(b'=', text)?;
        let name_at = equals + 1 + skip_blanks(&text[equals + 1..]);
        let n = text[name_at..].iter().position(|b| !(b.is_ascii_alphanumeric() || *b == b'_'))?;
        let entity = std::str::from_utf8(&text[name_at..name_at + n]).ok().filter(|name| !name.is_empty())?;
        let open = name_at + n + skip_blanks(&text[name_at + n..]);
        let arguments = members(text, open)?;
        let from = place.start;
        let arguments = arguments.into_iter().map(|range| range.start + from..range.end + from).collect();
        Some(Instance { id, entity, arguments })
    }

    /// An argument as the file writes it; `$` where there are less.
    pub(crate) fn argument(&self, instance: &Instance<'_>, k: usize) -> &'a [u8] {
        instance.arguments.get(k).map_or(b"$", |place| &self.bytes[place.clone()])
    }

    /// The id that an argument refers to.
    pub(crate) fn reference(&self, instance: &Instance<'_>, k: usize) -> Option<u64> {
        reference(self.argument(instance, k))
    }

    /// The ids that an argument refers to, in a list or alone.
    pub(crate) fn references(&self, instance: &Instance<'_>, k: usize) -> Vec<u64> {
        references(self.argument(instance, k))
    }

    /// The instance that an argument refers to.
    pub(crate) fn referred(&self, instance: &Instance<'_>, k: usize) -> Option<Instance<'a>> {
        self.instance(self.reference(instance, k)?)
    }

    /// A number, also of a typed value.
    pub(crate) fn number(&self, instance: &Instance<'_>, k: usize) -> Option<f64> {
        number(self.argument(instance, k))
    }

    /// The GlobalId of an instance, if its first argument can be one.
    pub(crate) fn global_id(&self, instance: &Instance<'_>) -> Option<&'a str> {
        match self.argument(instance, 0) {
            [b'\'', id @ .., b'\''] if id.len() == 22 => std::str::from_utf8(id).ok(),
            _ => None,
        }
    }
}

/// The id of a reference.
pub(crate) fn reference(text: &[u8]) -> Option<u64> {
    let digits = text.strip_prefix(b"#")?;
    let id = leading_number(digits)?;
    digits.iter().all(u8::is_ascii_digit).then_some(id)
}

/// The ids of a list of references, or of one.
pub(crate) fn references(text: &[u8]) -> Vec<u64> {
    match members(text, 0) {
        Some(places) => places.into_iter().filter_map(|place| reference(&text[place])).collect(),
        None => reference(text).into_iter().collect(),
    }
}

/// A number, also within a typed value.
pub(crate) fn number(text: &[u8]) -> Option<f64> {
    let inner = match memchr(b'(', text) {
        Some(open) => text[open + 1..].strip_suffix(b")")?,
        None => text,
    };
    std::str::from_utf8(inner.trim_ascii()).ok()?.parse().ok().filter(|number: &f64| number.is_finite())
}

fn leading_number(text: &[u8]) -> Option<u64> {
    let n = text.iter().position(|b| !b.is_ascii_digit()).unwrap_or(text.len());
    std::str::from_utf8(&text[..n]).ok()?.parse().ok()
}

/// What ends lines: that of the first line.
fn line_end(bytes: &[u8]) -> &'static str {
    match memchr::memchr2(b'\n', b'\r', bytes) {
        Some(at) if bytes[at] == b'\n' => "\n",
        Some(at) if bytes.get(at + 1) == Some(&b'\n') => "\r\n",
        Some(_) => "\r",
        None => "\n",
    }
}

/// The first text in quotes.
fn quoted(text: &[u8]) -> Option<std::borrow::Cow<'_, str>> {
    let open = memchr(b'\'', text)? + 1;
    let length = memchr(b'\'', &text[open..])?;
    Some(String::from_utf8_lossy(&text[open..open + length]))
}

/// Bytes of blanks and comments at the beginning.
fn skip_blanks(text: &[u8]) -> usize {
    let mut at = 0;
    while let Some(byte) = text.get(at) {
        match byte {
            _ if byte.is_ascii_whitespace() => at += 1,
            b'/' if text.get(at + 1) == Some(&b'*') => at = after_comment(text, at),
            _ => break,
        }
    }
    at
}

fn after_comment(text: &[u8], at: usize) -> usize {
    memmem::find(&text[at + 2..], b"*/").map_or(text.len(), |end| at + 2 + end + 2)
}

/// Behind a text that begins at a quote. Two quotes are one of the text; so is the operand of `\S\`.
fn after_text(text: &[u8], quote: usize) -> usize {
    let from = quote + 1;
    let mut at = from;
    while let Some(found) = text.get(at..).and_then(|rest| memchr(b'\'', rest)) {
        at += found;
        if at >= from + 3 && &text[at - 3..at] == br"\S\" {
            at += 1;
        } else if text.get(at + 1) == Some(&b'\'') {
            at += 2;
        } else {
            return at + 1;
        }
    }
    text.len()
}

/// The next statement, with its semicolon; `None` at the end, or where it has none.
fn statement(bytes: &[u8], at: usize) -> Option<Range<usize>> {
    let start = at + skip_blanks(&bytes[at..]);
    let mut at = start;
    loop {
        at += memchr3(b'\'', b';', b'/', bytes.get(at..)?)?;
        match bytes[at] {
            b';' => return Some(start..at + 1),
            b'\'' => at = after_text(bytes, at),
            _ if bytes.get(at + 1) == Some(&b'*') => at = after_comment(bytes, at),
            _ => at += 1,
        }
    }
}

/// Places of the members of a list whose parenthesis opens at `open`; `None` if there is no list.
pub(crate) fn members(text: &[u8], open: usize) -> Option<Vec<Range<usize>>> {
    if text.get(open) != Some(&b'(') {
        return None;
    }
    let (mut found, mut depth, mut start, mut at) = (Vec::new(), 0usize, open + 1, open + 1);
    loop {
        match *text.get(at)? {
            b'\'' => {
                at = after_text(text, at);
                continue;
            }
            b'/' if text.get(at + 1) == Some(&b'*') => {
                at = after_comment(text, at);
                continue;
            }
            b'(' => depth += 1,
            b')' if depth > 0 => depth -= 1,
            byte @ (b',' | b')') if depth == 0 => {
                let place = trimmed(text, start..at);
                if byte == b',' || !place.is_empty() || !found.is_empty() {
                    found.push(place);
                }
                if byte == b')' {
                    return Some(found);
                }
                start = at + 1;
            }
            _ => {}
        }
        at += 1;
    }
}

/// A place without blanks and comments around it.
fn trimmed(text: &[u8], place: Range<usize>) -> Range<usize> {
    let start = (place.start + skip_blanks(&text[place.clone()])).min(place.end);
    let mut end = place.end;
    loop {
        let part = text[start..end].trim_ascii_end();
        end = start + part.len();
        match memmem::rfind(part, b"/*") {
            Some(comment) if part.ends_with(b"*/") && memchr(b'\'', &part[comment..]).is_none() => {
                end = start + comment
            }
            _ => return start..end,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(data: &str) -> String {
        format!("ISO-10303-21;\nHEADER;\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n{data}\nENDSEC;\nEND-ISO-10303-21;\n")
    }

    #[test]
    fn instances_are_found_between_texts_and_comments() {
        let text = file(
            "#2 /* a ; '*/ = IfcThing('it''s; #3',$,( 1. , #3 ),IFCLABEL('a,b') /* x */);#3=IFCB();\n#4=(IFCA()IFCB());\n#5=IFCC('\\S\\'',$);",
        );
        let file = StepFile::of(text.as_bytes()).unwrap();
        let thing = file.instance(2).unwrap();
        let arguments: Vec<&str> = (0..5).map(|k| std::str::from_utf8(file.argument(&thing, k)).unwrap()).collect();
        assert_eq!(arguments, ["'it''s; #3'", "$", "( 1. , #3 )", "IFCLABEL('a,b')", "$"]);
        assert_eq!((thing.entity, file.references(&thing, 2)), ("IfcThing", vec![3]));
        assert!(file.instance(3).unwrap().arguments.is_empty() && file.instance(4).is_none());
        assert_eq!(file.argument(&file.instance(5).unwrap(), 1), b"$");
        assert_eq!((file.max_id(), file.ids_of("IFCTHING")), (5, vec![2]));
        assert!(text[file.end_of_data..].starts_with("ENDSEC;\nEND-ISO"));
    }

    #[test]
    fn what_is_no_ifc_in_step_is_refused_with_the_reason() {
        let check = |text: &[u8], why: &str| {
            let error = StepFile::of(text).err().unwrap().to_string();
            assert!(error.contains(why), "{error}");
        };
        check(b"PK\x03\x04", "STEP");
        check(b"\xff\xfeI\0S\0O\0", "STEP");
        check(b"ISO-10303-21;HEADER;ENDSEC;DATA;ENDSEC;", "FILE_SCHEMA");
        check(b"ISO-10303-21;HEADER;FILE_SCHEMA(('IFC5'));ENDSEC;DATA;ENDSEC;", "IFC5");
        check(b"ISO-10303-21;HEADER;FILE_SCHEMA(('IFC4'));ENDSEC;DATA;#1=IFCA(", "cut off");
        check(file("#18446744073709551615=IFCA();").as_bytes(), "#18446744073709551615 leaves no room");
    }

    #[test]
    fn lines_end_as_the_first_does() {
        for (text, expected) in [("a\r\nb\n", "\r\n"), ("a\nb\r\n", "\n"), ("a\rb", "\r"), ("a", "\n")] {
            assert_eq!(line_end(text.as_bytes()), expected, "{text:?}");
        }
    }
}
