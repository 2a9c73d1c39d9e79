//! One STEP record, split into its arguments.
//!
//! Borrowing and bounded: a text is decoded when it is asked for, nesting beyond [`DEPTH_MAX`] is refused.

use std::borrow::Cow;

/// Deepest nesting of lists and typed values in one record; real files stay below six.
const DEPTH_MAX: usize = 32;

/// One argument as the file wrote it.
#[derive(Debug, Clone, PartialEq)]
pub enum Value<'a> {
    /// `$`, `*`, a binary, or a reference that cannot be one (wider than u32).
    Null,
    /// An integer or a real.
    Number(f64),
    /// Bytes between the quotes, still encoded.
    Text(&'a [u8]),
    /// `.NAME.`, without the dots.
    Enum(&'a [u8]),
    /// `#1`.
    Ref(u32),
    /// `(..)`.
    List(Vec<Value<'a>>),
    /// `IFCLABEL('x')`: the name as the file spells it, and the value inside.
    Typed(&'a str, Box<Value<'a>>),
}

impl<'a> Value<'a> {
    /// The value inside a typed value.
    pub fn plain(&self) -> &Value<'a> {
        let mut value = self;
        while let Value::Typed(_, inner) = value {
            value = inner;
        }
        value
    }

    /// The id of a reference.
    pub fn reference(&self) -> Option<u32> {
        match self.plain() {
            Value::Ref(id) => Some(*id),
            _ => None,
        }
    }

    /// A finite number.
    pub fn number(&self) -> Option<f64> {
        match self.plain() {
            Value::Number(x) if x.is_finite() => Some(*x),
            _ => None,
        }
    }

    /// A text, decoded.
    pub fn text(&self) -> Option<Cow<'a, str>> {
        match self.plain() {
            Value::Text(raw) => Some(decode_text(raw)),
            _ => None,
        }
    }

    /// The name of an enumeration's value, without its dots.
    pub fn enumeration(&self) -> Option<&'a str> {
        match self.plain() {
            Value::Enum(name) => std::str::from_utf8(name).ok(),
            _ => None,
        }
    }

    /// `.T.` or `.F.`; `.U.` is none.
    pub fn boolean(&self) -> Option<bool> {
        match self.plain() {
            Value::Enum(b"T" | b"t") => Some(true),
            Value::Enum(b"F" | b"f") => Some(false),
            _ => None,
        }
    }

    /// The members of a list; empty for other values.
    pub fn list(&self) -> &[Value<'a>] {
        match self.plain() {
            Value::List(items) => items,
            _ => &[],
        }
    }

    /// The references of a list, or the one reference that stands instead of a list.
    pub fn references(&self) -> Vec<u32> {
        match self.plain() {
            Value::Ref(id) => vec![*id],
            Value::List(items) => items.iter().filter_map(Value::reference).collect(),
            _ => Vec::new(),
        }
    }
}

/// One record; an argument that is not there reads as `$`.
#[derive(Debug, Clone)]
pub struct Record<'a> {
    /// The number under which it is read.
    pub id: u32,
    /// The file's own spelling.
    pub keyword: &'a str,
    arguments: Vec<Value<'a>>,
}

impl<'a> Record<'a> {
    /// Parses `#1=KEYWORD(..);`. `None` if it is not of this shape.
    pub fn parse(bytes: &'a [u8]) -> Option<Self> {
        let mut reader = Reader { bytes, at: 0 };
        let id = match reader.value(0)? {
            Value::Ref(id) => id,
            _ => return None,
        };
        reader.expect(b'=')?;
        let keyword = reader.name()?;
        reader.expect(b'(')?;
        let arguments = reader.list(1)?;
        Some(Self { id, keyword, arguments })
    }

    /// Parses `KEYWORD(..)` as the record of this id. `None` if it is not of this shape.
    pub(super) fn parse_shown(id: u32, text: &'a str) -> Option<Self> {
        let mut reader = Reader { bytes: text.as_bytes(), at: 0 };
        let keyword = reader.name()?;
        reader.expect(b'(')?;
        let arguments = reader.list(1)?;
        Some(Self { id, keyword, arguments })
    }

    /// True if its entity is this one, not a subtype of it.
    pub fn is(&self, entity: &str) -> bool {
        self.keyword.eq_ignore_ascii_case(entity)
    }

    /// The argument at a place; `$` behind the last.
    pub fn at(&self, argument: usize) -> &Value<'a> {
        self.arguments.get(argument).unwrap_or(&Value::Null)
    }

    /// All arguments.
    pub fn arguments(&self) -> &[Value<'a>] {
        &self.arguments
    }

    /// Text with surrounding blanks removed; empty if absent.
    pub fn text(&self, argument: usize) -> String {
        self.at(argument).text().map(|t| t.trim().to_owned()).unwrap_or_default()
    }
}

/// Decodes the bytes between the quotes of a STEP string.
pub(crate) fn decode_text(raw: &[u8]) -> Cow<'_, str> {
    let text = String::from_utf8_lossy(raw);
    let text = if raw.contains(&b'\'') { Cow::Owned(text.replace("''", "'")) } else { text };
    if !raw.contains(&b'\\') {
        return text;
    }
    Cow::Owned(ifc_lite_core::decode_ifc_string(&text).into_owned())
}

/// The members of a list with its parentheses, as written, without blanks around them.
pub(crate) fn members(list: &[u8]) -> Vec<&[u8]> {
    let Some(inside) = list.strip_prefix(b"(").and_then(|list| list.strip_suffix(b")")) else { return Vec::new() };
    let (mut found, mut depth, mut start, mut in_text) = (Vec::new(), 0, 0, false);
    for (k, byte) in inside.iter().enumerate() {
        match byte {
            b'\'' => in_text = !in_text,
            _ if in_text => {}
            b'(' => depth += 1,
            b')' => depth -= 1,
            b',' if depth == 0 => {
                found.push(inside[start..k].trim_ascii());
                start = k + 1;
            }
            _ => {}
        }
    }
    let last = inside[start..].trim_ascii();
    if !last.is_empty() || !found.is_empty() {
        found.push(last);
    }
    found
}

struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Reader<'a> {
    fn skip_blanks(&mut self) {
        loop {
            match self.bytes.get(self.at) {
                Some(b) if b.is_ascii_whitespace() => self.at += 1,
                Some(b'/') if self.bytes.get(self.at + 1) == Some(&b'*') => {
                    let rest = &self.bytes[self.at + 2..];
                    let end = memchr::memmem::find(rest, b"*/").unwrap_or(rest.len());
                    self.at = (self.at + 2 + end + 2).min(self.bytes.len());
                }
                _ => return,
            }
        }
    }

    fn peek(&mut self) -> Option<u8> {
        self.skip_blanks();
        self.bytes.get(self.at).copied()
    }

    fn expect(&mut self, wanted: u8) -> Option<()> {
        (self.peek()? == wanted).then(|| self.at += 1)
    }

    fn take_while(&mut self, keep: impl Fn(u8) -> bool) -> &'a [u8] {
        let rest = &self.bytes[self.at..];
        let n = rest.iter().position(|&b| !keep(b)).unwrap_or(rest.len());
        self.at += n;
        &rest[..n]
    }

    fn name(&mut self) -> Option<&'a str> {
        self.skip_blanks();
        let name = self.take_while(|b| b.is_ascii_alphanumeric() || b == b'_');
        (!name.is_empty()).then(|| std::str::from_utf8(name).ok()).flatten()
    }

    /// The members after an opening parenthesis, up to and with the closing one.
    fn list(&mut self, depth: usize) -> Option<Vec<Value<'a>>> {
        let mut items = Vec::new();
        if self.peek()? == b')' {
            self.at += 1;
            return Some(items);
        }
        loop {
            items.push(self.value(depth)?);
            match self.peek()? {
                b',' => self.at += 1,
                b')' => {
                    self.at += 1;
                    return Some(items);
                }
                _ => return None,
            }
        }
    }

    fn value(&mut self, depth: usize) -> Option<Value<'a>> {
        if depth > DEPTH_MAX {
            return None;
        }
        match self.peek()? {
            b'$' | b'*' => {
                self.at += 1;
                Some(Value::Null)
            }
            b'#' => {
                self.at += 1;
                let digits = self.take_while(|b| b.is_ascii_digit());
                let id = std::str::from_utf8(digits).ok().and_then(|d| d.parse().ok());
                (!digits.is_empty()).then(|| id.map_or(Value::Null, Value::Ref))
            }
            b'\'' => self.string().map(Value::Text),
            b'"' => {
                self.at += 1;
                self.take_while(|b| b != b'"');
                self.expect(b'"')?;
                Some(Value::Null)
            }
            b'.' => {
                self.at += 1;
                let name = self.take_while(|b| b != b'.' && b != b',' && b != b')');
                self.expect(b'.')?;
                Some(Value::Enum(name))
            }
            b'(' => {
                self.at += 1;
                self.list(depth + 1).map(Value::List)
            }
            b if b.is_ascii_digit() || matches!(b, b'+' | b'-') => self.number(),
            b if b.is_ascii_alphabetic() => {
                let name = self.name()?;
                self.expect(b'(')?;
                let inner = self.list(depth + 1)?;
                Some(Value::Typed(name, Box::new(inner.into_iter().next().unwrap_or(Value::Null))))
            }
            _ => None,
        }
    }

    fn number(&mut self) -> Option<Value<'a>> {
        let digits = self.take_while(|b| b.is_ascii_alphanumeric() || matches!(b, b'+' | b'-' | b'.'));
        std::str::from_utf8(digits).ok()?.parse().ok().map(Value::Number)
    }

    /// The bytes between two quotes. `''` is a quote; so is the operand of `\S\`, which ends nothing.
    fn string(&mut self) -> Option<&'a [u8]> {
        let from = self.at + 1;
        let mut at = from;
        loop {
            at += memchr::memchr(b'\'', self.bytes.get(at..)?)?;
            if at >= from + 3 && &self.bytes[at - 3..at] == b"\\S\\" {
                at += 1;
            } else if self.bytes.get(at + 1) == Some(&b'\'') {
                at += 2;
            } else {
                self.at = at + 1;
                return Some(&self.bytes[from..at]);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_split_and_typed_values_seen_through() {
        let record =
            Record::parse(b"#12 /* c;'*/ = IfcThing('a''b',$,*,.T.,(1.,-2.5E1,#3),IFCLABEL('x'),#99999999999,.NAME.);")
                .unwrap();
        assert_eq!((record.id, record.keyword), (12, "IfcThing"));
        assert_eq!(record.text(0), "a'b");
        assert_eq!(record.at(3).boolean(), Some(true));
        assert_eq!(record.at(4).list()[1].number(), Some(-25.0));
        assert_eq!(record.at(4).references(), [3]);
        assert_eq!(record.text(5), "x");
        assert_eq!(record.at(6), &Value::Null);
        assert_eq!(record.at(7).enumeration(), Some("NAME"));
        assert_eq!(record.at(99), &Value::Null);
    }

    #[test]
    fn encoded_text_is_decoded() {
        let record = Record::parse(br"#1=IFCX('T\X2\00FC\X0\r','\S\'');").unwrap();
        assert_eq!(record.text(0), "Tür");
    }

    #[test]
    fn broken_and_deeply_nested_records_are_refused() {
        for text in ["", "#1", "#1=", "#1=IFCX(", "#1=IFCX(1,,2);", "#1=IFCX('a);", "#1=(IFCA()IFCB());", "#x=IFCX();"]
        {
            assert!(Record::parse(text.as_bytes()).is_none(), "{text}");
        }
        let deep = format!("#1=IFCX({}{});", "(".repeat(100_000), ")".repeat(100_000));
        assert!(Record::parse(deep.as_bytes()).is_none());
    }
}
