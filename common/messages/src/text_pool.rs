//! The texts of an archive: read in place, and gathered for an archive to be.

use crate::archive::{Archive, ArchiveError, Text, TextList};
use rustc_hash::FxHashMap;

/// The texts of an archive and its lists of texts, read in place. A view checks those that its records have; then they are there.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Texts<'a> {
    strings: &'a str,
    listed: &'a [Text],
}

impl<'a> Texts<'a> {
    /// Those of an archive without lists, from its section of strings.
    pub(crate) fn of(archive: Archive<'a>, strings: u32) -> Result<Self, ArchiveError> {
        Ok(Self { strings: archive.strings(strings)?, listed: &[] })
    }

    /// Those of an archive with lists, from its two sections.
    pub(crate) fn with_lists(archive: Archive<'a>, strings: u32, listed: u32) -> Result<Self, ArchiveError> {
        Ok(Self { listed: archive.section(listed)?, ..Self::of(archive, strings)? })
    }

    /// True if a text lies in the section.
    pub(crate) fn has(&self, text: Text) -> bool {
        self.find(text).is_some()
    }

    /// True if a list lies in its section.
    pub(crate) fn has_list(&self, list: TextList) -> bool {
        self.find_list(list).is_some()
    }

    /// The texts of all lists.
    pub(crate) fn listed(&self) -> &'a [Text] {
        self.listed
    }

    /// A text that was checked.
    pub(crate) fn get(&self, text: Text) -> &'a str {
        self.find(text).expect("texts were checked when the archive was opened")
    }

    /// The texts of a list that was checked.
    pub(crate) fn list(&self, list: TextList) -> impl Iterator<Item = &'a str> + Clone + use<'a> {
        let texts = *self;
        let listed = self.find_list(list).expect("lists were checked when the archive was opened");
        listed.iter().map(move |&text| texts.get(text))
    }

    fn find(&self, text: Text) -> Option<&'a str> {
        let start = text.offset as usize;
        self.strings.get(start..start.saturating_add(text.length as usize))
    }

    fn find_list(&self, list: TextList) -> Option<&'a [Text]> {
        self.listed.get(list.first as usize..)?.get(..list.count as usize)
    }
}

/// Texts of an archive to be, each stored once.
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
