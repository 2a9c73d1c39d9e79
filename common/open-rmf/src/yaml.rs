//! YAML as the tools of Open-RMF write it: maps as blocks, one item of a list on a line.
//!
//! Texts and keys are quoted as JSON quotes them, which every YAML reads as they are: unquoted, a storey named `1` would be a number,
//! and one named `no` a truth value.

use serde::Serialize;
use serde_json::ser::Formatter;
use serde_json::{Serializer, Value};
use std::io::{Result, Write};

/// The text of a map, after lines of comments.
pub(crate) fn text(comments: &[String], value: &Value) -> Vec<u8> {
    let mut out: String = comments.iter().map(|comment| format!("# {comment}\n")).collect();
    block(value, 0, &mut out);
    out.into_bytes()
}

/// A map or list that is not empty begins on a line of its own; everything else stays behind its key.
fn block(value: &Value, depth: usize, out: &mut String) {
    let indent = "  ".repeat(depth);
    match value {
        Value::Object(map) => {
            for (key, value) in map {
                out.push_str(&format!("{indent}{}:", Value::from(key.as_str())));
                if is_empty(value) {
                    out.push_str(&format!(" {}\n", line(value)));
                } else {
                    out.push('\n');
                    block(value, depth + 1, out);
                }
            }
        }
        Value::Array(items) => items.iter().for_each(|item| out.push_str(&format!("{indent}- {}\n", line(item)))),
        scalar => out.push_str(&format!("{indent}{}\n", line(scalar))),
    }
}

/// A value on one line, with spaces behind colons and commas, as all versions of YAML want them.
fn line(value: &Value) -> String {
    let mut out = Vec::new();
    let written = value.serialize(&mut Serializer::with_formatter(&mut out, Spaced));
    written.expect("a value of JSON serialises, and memory does not fail");
    String::from_utf8(out).expect("JSON is UTF-8")
}

struct Spaced;

impl Formatter for Spaced {
    fn begin_array_value<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> Result<()> {
        if first { Ok(()) } else { out.write_all(b", ") }
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, out: &mut W, first: bool) -> Result<()> {
        if first { Ok(()) } else { out.write_all(b", ") }
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, out: &mut W) -> Result<()> {
        out.write_all(b": ")
    }
}

/// True for what has no block of its own.
fn is_empty(value: &Value) -> bool {
    match value {
        Value::Object(map) => map.is_empty(),
        Value::Array(items) => items.is_empty(),
        _ => true,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn maps_are_blocks_and_items_lines() {
        let value = serde_json::json!({"a": {"no": 1.5, "e": {}}, "l": [[0, 1, {"n": [1, "ä \"x\""]}], []], "m": []});
        let expected = "# c\n\"a\":\n  \"e\": {}\n  \"no\": 1.5\n\"l\":\n  - [0, 1, {\"n\": [1, \"ä \\\"x\\\"\"]}]\n  - []\n\"m\": []\n";
        assert_eq!(String::from_utf8(text(&["c".to_owned()], &value)).unwrap_or_default(), expected);
    }
}
