//! An element of P6 XML with its children as cells.

use crate::PlanFileError;
use crate::p6::Record;
use crate::xml::Xml;
use std::borrow::Cow;

/// The texts of the children of an element with their names; of several with a name, the first that is not empty counts.
///
/// They are few, so that searching them is faster than hashing their names.
#[derive(Debug)]
pub(super) struct Element<'a> {
    cells: Vec<(&'a str, Cow<'a, str>)>,
}

impl<'a> Element<'a> {
    /// Reads the element that was entered, and leaves it. What holds more than text is read by `nested`, which returns whether it did.
    ///
    /// # Errors
    /// XML that is not well-formed; what `nested` returns.
    pub(super) fn read(
        xml: &mut Xml<'a>,
        mut nested: impl FnMut(&'a str, &mut Xml<'a>) -> Result<bool, PlanFileError>,
    ) -> Result<Self, PlanFileError> {
        let mut cells = Vec::new();
        while let Some(name) = xml.child()? {
            if !nested(name, xml)? {
                let text = xml.text()?;
                if !text.is_empty() {
                    cells.push((name, text));
                }
            }
        }
        Ok(Self { cells })
    }

    /// Reads an element that holds texts alone.
    ///
    /// # Errors
    /// XML that is not well-formed.
    pub(super) fn flat(xml: &mut Xml<'a>) -> Result<Self, PlanFileError> {
        Self::read(xml, |_, _| Ok(false))
    }

    /// Takes a text out.
    pub(super) fn take(&mut self, name: &str) -> Cow<'a, str> {
        let cell = self.cells.iter_mut().find(|(of, _)| *of == name);
        cell.map_or(Cow::Borrowed(""), |(_, text)| std::mem::take(text))
    }
}

impl Record for Element<'_> {
    fn cell(&self, name: &str) -> &str {
        self.cells.iter().find(|(of, _)| *of == name).map_or("", |(_, text)| &**text)
    }
}
