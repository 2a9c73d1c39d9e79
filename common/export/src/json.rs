//! JSON writer with one item per line, for diffs between versions.

use serde::Serialize;
use serde_json::Serializer;
use serde_json::ser::Formatter;
use std::io::{Result, Write};

/// Items of the document and of what it holds have lines of their own; what is deeper stays on its item's line.
const LINE_DEPTH: usize = 2;

/// JSON with a line feed at the end. Numbers are finite and shortest, keys in the order of fields or of the alphabet.
pub fn text<T: Serialize>(value: &T) -> Vec<u8> {
    let mut out = Vec::new();
    let written = value.serialize(&mut Serializer::with_formatter(&mut out, LinePerItem::default()));
    written.expect("our types serialise: keys are strings and numbers, memory does not fail");
    out.push(b'\n');
    out
}

#[derive(Default)]
struct LinePerItem {
    depth: usize,
    /// False until the innermost list or object has an item: empty ones stay closed.
    has_items: bool,
}

impl LinePerItem {
    fn open<W: ?Sized + Write>(&mut self, out: &mut W, bracket: &[u8]) -> Result<()> {
        self.depth += 1;
        self.has_items = false;
        out.write_all(bracket)
    }

    fn item<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> Result<()> {
        let comma: &[u8] = if first { b"" } else { b"," };
        out.write_all(comma)?;
        if self.depth <= LINE_DEPTH { self.line(out) } else { Ok(()) }
    }

    fn close<W: ?Sized + Write>(&mut self, out: &mut W, bracket: &[u8]) -> Result<()> {
        self.depth -= 1;
        if self.has_items && self.depth < LINE_DEPTH {
            self.line(out)?;
        }
        self.has_items = true;
        out.write_all(bracket)
    }

    fn line<W: ?Sized + Write>(&self, out: &mut W) -> Result<()> {
        out.write_all(b"\n")?;
        (0..self.depth).try_for_each(|_| out.write_all(b"  "))
    }
}

impl Formatter for LinePerItem {
    fn begin_array<W: ?Sized + Write>(&mut self, out: &mut W) -> Result<()> {
        self.open(out, b"[")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> Result<()> {
        self.item(out, first)
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, _: &mut W) -> Result<()> {
        self.has_items = true;
        Ok(())
    }

    fn end_array<W: ?Sized + Write>(&mut self, out: &mut W) -> Result<()> {
        self.close(out, b"]")
    }

    fn begin_object<W: ?Sized + Write>(&mut self, out: &mut W) -> Result<()> {
        self.open(out, b"{")
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> Result<()> {
        self.item(out, first)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> Result<()> {
        let colon: &[u8] = if self.depth <= LINE_DEPTH { b": " } else { b":" };
        out.write_all(colon)
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, _: &mut W) -> Result<()> {
        self.has_items = true;
        Ok(())
    }

    fn end_object<W: ?Sized + Write>(&mut self, out: &mut W) -> Result<()> {
        self.close(out, b"}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_item_of_an_item_stays_on_one_line() {
        let value = serde_json::json!({"a": 1.5, "b": [{"c": [1, 2], "d": {}}, []], "e": {}, "f": []});
        let expected =
            "{\n  \"a\": 1.5,\n  \"b\": [\n    {\"c\":[1,2],\"d\":{}},\n    []\n  ],\n  \"e\": {},\n  \"f\": []\n}\n";
        assert_eq!(String::from_utf8(text(&value)).unwrap(), expected);
    }
}
