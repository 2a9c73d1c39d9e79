//! Texts of an archive to be.

use crate::archive::Text;
use std::collections::HashMap;

/// Texts of an archive, each kept once.
#[derive(Debug, Default)]
pub struct TextPool {
    bytes: String,
    known: HashMap<String, Text>,
}

impl TextPool {
    /// The place of a text.
    pub fn add(&mut self, text: &str) -> Text {
        if text.is_empty() {
            return Text::default();
        }
        if let Some(&known) = self.known.get(text) {
            return known;
        }
        let at = Text { offset: self.bytes.len() as u32, length: text.len() as u32 };
        self.bytes.push_str(text);
        self.known.insert(text.to_owned(), at);
        at
    }

    /// All bytes.
    pub(crate) fn bytes(&self) -> &[u8] {
        self.bytes.as_bytes()
    }
}
