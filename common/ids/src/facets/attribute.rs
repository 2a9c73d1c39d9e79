//! Attributes of the record itself.

use ifc::{Record, Value};

use super::Finding;
use super::finding::with_values;
use crate::document::AttributeFacet;
use crate::model::Model;
use crate::schema::{Attribute, Base};
use crate::value::Actual;

pub(super) fn findings(model: &Model<'_>, record: &Record<'_>, facet: &AttributeFacet) -> Vec<Finding> {
    let named = model.attributes(record).filter(|(attribute, _)| facet.name.matches_text(attribute.name));
    let findings: Vec<Finding> = named.map(|(attribute, value)| finding(model, attribute, value, facet)).collect();
    if findings.is_empty() {
        return vec![Finding::Absent(format!("its class has no attribute {}", facet.name))];
    }
    with_values(findings)
}

fn finding(model: &Model<'_>, attribute: Attribute, value: &Value<'_>, facet: &AttributeFacet) -> Finding {
    let name = attribute.name;
    let base = model.schema.base(attribute.type_name).unwrap_or(Base::Other);
    match value {
        Value::Null => return Finding::Absent(format!("{name} has no value")),
        Value::Text(b"") => return Finding::Empty(format!("{name} is empty")),
        Value::List(items) if items.is_empty() => return Finding::Empty(format!("{name} is an empty list")),
        Value::Enum(b"U" | b"u") if base == Base::Boolean => return Finding::Empty(format!("{name} is unknown")),
        _ => {}
    }
    let Some(wanted) = &facet.value else { return Finding::Match };
    match actual(model, attribute, base, value) {
        Ok(actual) if wanted.matches(&actual) => Finding::Match,
        Ok(actual) => Finding::Mismatch(format!("{name} is {actual}, not {wanted}")),
        Err(what) => Finding::Mismatch(format!("{name} is {what}, which IDS compares with nothing")),
    }
}

/// The value in units of SI; if it is none to compare, what it is.
fn actual(model: &Model<'_>, attribute: Attribute, base: Base, value: &Value<'_>) -> Result<Actual, &'static str> {
    if base == Base::Other {
        return Err("an object or a list");
    }
    let actual = plain(value, base).ok_or("no value of its type")?;
    if let Actual::Real(x) = actual {
        let conversion = model.units.conversion(model.file, attribute.type_name, None);
        return conversion.map(|c| Actual::Real(c.apply(x))).ok_or("in a unit that the file does not define");
    }
    Ok(actual)
}

/// A value of the file as one of its kind, in the file's own unit.
pub(super) fn plain(value: &Value<'_>, base: Base) -> Option<Actual> {
    match base {
        Base::Text => {
            let text = value.text().map(|text| text.into_owned());
            text.or_else(|| value.enumeration().map(str::to_owned)).map(Actual::Text)
        }
        Base::Real => value.number().map(Actual::Real),
        Base::Integer => value.number().map(Actual::Integer),
        Base::Boolean => value.boolean().map(Actual::Boolean),
        Base::Other => None,
    }
}
