//! Texts of an archive to be.

use crate::archive::{Text, TextList};
use rustc_hash::FxHashMap;

/// Texts of an archive, each stored once.
#[derive(Debug, Default)]
pub struct TextPool {
    bytes: String,
    known: FxHashMap<String, Text>,
    listed: Vec<Text>,
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

    /// The place of a list of texts.
    pub fn add_list<'t>(&mut self, texts: impl IntoIterator<Item = &'t str>) -> TextList {
        let first = self.listed.len();
        for text in texts {
            let text = self.add(text);
            self.listed.push(text);
        }
        TextList { first: first as u32, count: (self.listed.len() - first) as u32 }
    }

    /// The texts of all lists.
    pub(crate) fn listed(&self) -> &[Text] {
        &self.listed
    }

    /// All bytes.
    pub(crate) fn bytes(&self) -> &[u8] {
        self.bytes.as_bytes()
    }
}
