//! Another status for a topic in the markup of somebody else: event by event, so that nothing else changes.

use crate::markup::comment as write_comment;
use crate::topic::{BcfVersion, Comment};
use crate::xml::{Xml, text};
use quick_xml::events::{BytesStart, Event};
use quick_xml::{Reader, Writer};

/// Elements of a topic that come before the time of its last change.
const BEFORE_MODIFIED: [&str; 9] =
    ["ReferenceLink", "ReferenceLinks", "Title", "Priority", "Index", "Labels", "CreationDate", "CreationAuthor", ""];

/// The markup with the status, the time and author of the comment as those of the last change, and the comment behind all others.
pub(crate) fn closed(bytes: &[u8], version: BcfVersion, status: &str, comment: &Comment) -> Result<Vec<u8>, String> {
    let mut reader = Reader::from_reader(bytes);
    let mut edit = Edit { xml: Writer::new(Vec::new()), comment, has_modified: false, has_comment: false };
    let (mut path, mut skipped): (Vec<String>, Option<usize>) = (Vec::new(), None);
    loop {
        let event = reader.read_event().map_err(|e| e.to_string())?;
        match event {
            Event::Eof => break,
            Event::Start(start) => {
                let name = start.local_name().as_ref().to_owned();
                if skipped.is_none() {
                    edit.before(&path, &name, version)?;
                }
                path.push(name);
                if skipped.is_none() && is_modified(&path) {
                    skipped = Some(path.len());
                }
                if skipped.is_none() {
                    let is_topic = path == ["Markup", "Topic"];
                    let start = if is_topic { with_status(&start, status)? } else { start };
                    edit.event(Event::Start(start))?;
                }
            }
            Event::End(end) => {
                let at_end = path.len();
                if skipped.is_none() {
                    edit.at_end(&path, version)?;
                    edit.event(Event::End(end))?;
                }
                if skipped == Some(at_end) {
                    skipped = None;
                }
                path.pop();
            }
            Event::Empty(start) => {
                let name = start.local_name().as_ref().to_owned();
                if skipped.is_none() {
                    edit.before(&path, &name, version)?;
                    let whole = [path.clone(), vec![name]].concat();
                    if version == BcfVersion::V3_0 && whole == ["Markup", "Topic", "Comments"] {
                        edit.comments(true)?;
                    } else if !is_modified(&whole) {
                        edit.event(Event::Empty(start))?;
                    }
                }
            }
            other if skipped.is_none() => edit.event(other)?,
            _ => {}
        }
    }
    if edit.has_comment { Ok(edit.xml.into_inner()) } else { Err("it has no Topic".to_owned()) }
}

fn is_modified(path: &[String]) -> bool {
    path.len() == 3
        && path[..2] == ["Markup", "Topic"]
        && ["ModifiedDate", "ModifiedAuthor"].contains(&path[2].as_str())
}

fn with_status(start: &BytesStart<'_>, status: &str) -> Result<BytesStart<'static>, String> {
    let name = start.name().as_ref().to_owned();
    let mut with = BytesStart::new(name);
    for attribute in start.attributes() {
        let attribute = attribute.map_err(|e| e.to_string())?;
        if attribute.key.local_name().as_ref() != "TopicStatus" {
            with.push_attribute(attribute);
        }
    }
    with.push_attribute(("TopicStatus", status));
    Ok(with.into_owned())
}

/// The markup that is written.
struct Edit<'a> {
    xml: Xml,
    comment: &'a Comment,
    has_modified: bool,
    has_comment: bool,
}

impl Edit<'_> {
    fn event(&mut self, event: Event<'_>) -> Result<(), String> {
        self.xml.write_event(event).map_err(|e| e.to_string())
    }

    /// Before an element: what belongs there.
    fn before(&mut self, path: &[String], name: &str, version: BcfVersion) -> Result<(), String> {
        if path == ["Markup", "Topic"] {
            if !BEFORE_MODIFIED.contains(&name) {
                self.modified()?;
            }
            if version == BcfVersion::V3_0 && name == "Viewpoints" && !self.has_comment {
                self.comments(true)?;
            }
        }
        // Comments of version 2.1 come between topic and viewpoints.
        if version == BcfVersion::V2_1 && path == ["Markup"] && name == "Viewpoints" {
            self.comments(false)?;
        }
        Ok(())
    }

    /// Before the end of an element: what is not there yet.
    fn at_end(&mut self, path: &[String], version: BcfVersion) -> Result<(), String> {
        match version {
            BcfVersion::V3_0 if path == ["Markup", "Topic", "Comments"] => self.comments(false)?,
            _ if path == ["Markup", "Topic"] => {
                self.modified()?;
                if version == BcfVersion::V3_0 {
                    self.comments(true)?;
                }
            }
            BcfVersion::V2_1 if path == ["Markup"] => self.comments(false)?,
            _ => {}
        }
        Ok(())
    }

    fn modified(&mut self) -> Result<(), String> {
        if self.has_modified {
            return Ok(());
        }
        self.has_modified = true;
        let written = text(&mut self.xml, "ModifiedDate", &self.comment.date)
            .and_then(|()| text(&mut self.xml, "ModifiedAuthor", &self.comment.author));
        written.map_err(|e| e.to_string())
    }

    /// The comment, once, with the list that it is in, where there is none yet.
    fn comments(&mut self, with_list: bool) -> Result<(), String> {
        if self.has_comment {
            return Ok(());
        }
        self.has_comment = true;
        let comment = self.comment;
        let written = if with_list {
            self.xml.create_element("Comments").write_inner_content(|xml| write_comment(xml, comment)).map(|_| ())
        } else {
            write_comment(&mut self.xml, comment)
        };
        written.map_err(|e| e.to_string())
    }
}
