//! Activity codes and user-defined fields of P6 XML.

use super::element::Element;
use crate::PlanFileError;
use crate::assemble::WrittenPlan;
use crate::p6::Record;
use crate::plan::FindingKind;
use crate::xml::Xml;
use std::borrow::Cow;
use std::collections::HashMap;

/// Names of values that a user-defined field can have.
const VALUES: [&str; 7] =
    ["TextValue", "DoubleValue", "IntegerValue", "CostValue", "StartDateValue", "FinishDateValue", "IndicatorValue"];

/// A code or field of a task.
#[derive(Debug)]
pub(super) struct Assigned<'a> {
    /// Index of the task.
    pub(super) task: usize,
    type_id: Cow<'a, str>,
    /// Identity of the value of a code.
    code_id: Cow<'a, str>,
    /// Value of a field.
    value: Cow<'a, str>,
}

impl<'a> Assigned<'a> {
    /// Reads `Code` or `UDF` within a task that is not known yet.
    ///
    /// # Errors
    /// XML that is not well-formed.
    pub(super) fn read(xml: &mut Xml<'a>) -> Result<Self, PlanFileError> {
        let mut element = Element::flat(xml)?;
        let value = VALUES.iter().find(|name| element.given(name).is_some());
        let value = value.map_or(Cow::Borrowed(""), |name| element.take(name));
        Ok(Self { task: 0, type_id: element.take("TypeObjectId"), code_id: element.take("ValueObjectId"), value })
    }
}

/// Codes and fields that are defined anywhere in the file.
#[derive(Debug, Default)]
pub(super) struct Definitions<'a> {
    code_names: HashMap<Cow<'a, str>, Cow<'a, str>>,
    code_values: HashMap<Cow<'a, str>, Cow<'a, str>>,
    field_names: HashMap<Cow<'a, str>, Cow<'a, str>>,
}

impl<'a> Definitions<'a> {
    /// Reads the definition of a code, of a value of one, or of a field; returns whether the element is that.
    ///
    /// # Errors
    /// XML that is not well-formed.
    pub(super) fn read(&mut self, name: &str, xml: &mut Xml<'a>) -> Result<bool, PlanFileError> {
        let (definitions, column) = match name {
            "ActivityCodeType" => (&mut self.code_names, "Name"),
            "ActivityCode" => (&mut self.code_values, "CodeValue"),
            "UDFType" => (&mut self.field_names, "Title"),
            _ => return Ok(false),
        };
        let mut element = Element::flat(xml)?;
        let (id, text) = (element.take("ObjectId"), element.take(column));
        definitions.entry(id).or_insert(text);
        Ok(true)
    }

    /// Adds codes and fields to their tasks: the name of the code or field, and the value.
    ///
    /// # Errors
    /// Too many of them.
    pub(super) fn assign(&self, assigned: &[Assigned<'_>], plan: &mut WrittenPlan) -> Result<(), PlanFileError> {
        for Assigned { task, type_id, code_id, value } in assigned {
            let is_code = !code_id.is_empty();
            let names = if is_code { &self.code_names } else { &self.field_names };
            let value = if is_code { self.code_values.get(code_id) } else { Some(value) };
            match (names.get(type_id), value) {
                (Some(name), Some(value)) => plan.add_field(*task, name, value)?,
                _ => {
                    let what = if is_code { "activity code" } else { "user-defined field" };
                    let message =
                        format!("its {what} {:?} is not in the file", if is_code { code_id } else { type_id });
                    plan.find(Some(*task), FindingKind::MissingReference, message);
                    plan.check_findings()?;
                }
            }
        }
        Ok(())
    }
}
