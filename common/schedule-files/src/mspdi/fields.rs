//! Custom fields and outline codes: their names, and the values of their lookup tables.

use crate::PlanFileError;
use crate::xml::Xml;
use std::collections::HashMap;

/// Entries of lookup tables of all fields together.
const MAX_VALUES: usize = 1_000_000;

/// Levels of an outline code; MS Project has at most this many characters in one.
const MAX_LEVELS: usize = 255;

/// Definitions of the file.
#[derive(Debug, Default)]
pub(super) struct Fields {
    /// Name by `FieldID`.
    names: HashMap<String, String>,
    /// Values of lookup tables.
    values: Vec<LookupValue>,
    by_guid: HashMap<String, usize>,
    /// By `FieldID` and `ValueID`.
    by_id: HashMap<(String, String), usize>,
}

/// A value of a lookup table.
#[derive(Debug, Default)]
struct LookupValue {
    text: String,
    parent: Option<usize>,
}

/// A field of a task as it is written.
#[derive(Debug, Default)]
pub(super) struct WrittenField {
    field_id: String,
    value: String,
    value_id: String,
    value_guid: String,
}

impl Fields {
    /// The element `ExtendedAttributes` of the project.
    pub(super) fn read_extended_attributes(&mut self, xml: &mut Xml<'_>) -> Result<(), PlanFileError> {
        self.read_definitions(xml, "ExtendedAttribute", "ValueList")
    }

    /// The element `OutlineCodes` of the project.
    pub(super) fn read_outline_codes(&mut self, xml: &mut Xml<'_>) -> Result<(), PlanFileError> {
        self.read_definitions(xml, "OutlineCode", "Values")
    }

    fn read_definitions(&mut self, xml: &mut Xml<'_>, name: &str, list: &str) -> Result<(), PlanFileError> {
        while let Some(element) = xml.child()? {
            if element == name { self.read_definition(xml, list)? } else { xml.skip()? }
        }
        Ok(())
    }

    fn read_definition(&mut self, xml: &mut Xml<'_>, list: &str) -> Result<(), PlanFileError> {
        let (mut field_id, mut name, mut alias) = (String::new(), String::new(), String::new());
        let mut values = Vec::new();
        while let Some(element) = xml.child()? {
            match element {
                "FieldID" => field_id = xml.text()?.into_owned(),
                "FieldName" => name = xml.text()?.into_owned(),
                "Alias" => alias = xml.text()?.into_owned(),
                _ if element == list => {
                    while let Some(element) = xml.child()? {
                        if element != "Value" {
                            xml.skip()?;
                        } else if self.values.len() + values.len() == MAX_VALUES {
                            return Err(PlanFileError::TooMany { max: MAX_VALUES, what: "values in lookup tables" });
                        } else {
                            values.push(read_value(xml)?);
                        }
                    }
                }
                _ => xml.skip()?,
            }
        }
        self.add_values(&field_id, values);
        let shown = if alias.is_empty() { name } else { alias };
        if !shown.is_empty() {
            self.names.insert(field_id, shown);
        }
        Ok(())
    }

    /// Adds the values of a field: `[ValueID, FieldGUID, ParentValueID, Value]` of each.
    fn add_values(&mut self, field_id: &str, values: Vec<[String; 4]>) {
        let from = self.values.len();
        let mut parents = Vec::with_capacity(values.len());
        for [id, guid, parent, text] in values {
            let k = self.values.len();
            self.values.push(LookupValue { text, parent: None });
            self.by_id.insert((field_id.to_owned(), id), k);
            self.by_guid.insert(guid.to_ascii_lowercase(), k);
            parents.push((field_id.to_owned(), parent));
        }
        for (k, key) in parents.into_iter().enumerate() {
            self.values[from + k].parent = self.by_id.get(&key).copied();
        }
    }

    /// Name of a field of a task, and its value; `None` if that is in no lookup table.
    pub(super) fn resolve<'a>(&'a self, field: &'a WrittenField) -> (&'a str, Option<String>) {
        let name = self.names.get(&field.field_id).unwrap_or(&field.field_id);
        if !field.value.is_empty() || (field.value_id.is_empty() && field.value_guid.is_empty()) {
            return (name, Some(field.value.clone()));
        }
        let by_id = || self.by_id.get(&(field.field_id.clone(), field.value_id.clone()));
        let mut at = self.by_guid.get(&field.value_guid.to_ascii_lowercase()).or_else(by_id).copied();
        let mut path = Vec::new();
        while let Some(k) = at.filter(|_| path.len() < MAX_LEVELS) {
            path.push(self.values[k].text.as_str());
            at = self.values[k].parent;
        }
        path.reverse();
        (name, (!path.is_empty()).then(|| path.join(".")))
    }
}

fn read_value(xml: &mut Xml<'_>) -> Result<[String; 4], PlanFileError> {
    let [mut id, mut guid, mut parent, mut text]: [String; 4] = Default::default();
    while let Some(element) = xml.child()? {
        match element {
            "ValueID" | "ID" => id = xml.text()?.into_owned(),
            "FieldGUID" => guid = xml.text()?.into_owned(),
            "ParentValueID" => parent = xml.text()?.into_owned(),
            "Value" => text = xml.text()?.into_owned(),
            _ => xml.skip()?,
        }
    }
    Ok([id, guid, parent, text])
}

impl WrittenField {
    /// The element `ExtendedAttribute` or `OutlineCode` of a task.
    pub(super) fn read(xml: &mut Xml<'_>) -> Result<Self, PlanFileError> {
        let mut field = Self::default();
        while let Some(element) = xml.child()? {
            match element {
                "FieldID" => field.field_id = xml.text()?.into_owned(),
                "Value" => field.value = xml.text()?.into_owned(),
                "ValueID" => field.value_id = xml.text()?.into_owned(),
                "ValueGUID" => field.value_guid = xml.text()?.into_owned(),
                _ => xml.skip()?,
            }
        }
        Ok(field)
    }
}
