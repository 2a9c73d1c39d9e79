//! An element of P6 XML with its children as cells.

use crate::PlanFileError;
use crate::p6::Record;
use crate::xml::Xml;
use std::borrow::Cow;
use std::collections::HashMap;

/// The texts of the children of an element by their names; the first of several with a name.
#[derive(Debug, Default)]
pub(super) struct Element<'a> {
    cells: HashMap<&'a str, Cow<'a, str>>,
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
        let mut cells = HashMap::new();
        while let Some(name) = xml.child()? {
            if !nested(name, xml)? {
                let text = xml.text()?;
                cells.entry(name).or_insert(text);
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
        self.cells.remove(name).unwrap_or_default()
    }
}

impl Record for Element<'_> {
    fn cell(&self, name: &str) -> &str {
        self.cells.get(name).map_or("", |text| &**text)
    }
}
