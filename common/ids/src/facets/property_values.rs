//! Values of properties of all kinds, and whether they match.

use ifc::Record;

use super::Finding;
use super::attribute::plain;
use crate::document::PropertyFacet;
use crate::model::Model;
use crate::schema::Base;
use crate::value::{Actual, Constraint, double};

/// Values of a property.
pub(super) enum Values {
    /// `$`.
    None,
    /// An empty text or list, or a logical that is unknown.
    Empty,
    /// A kind that IDS does not read; the text names it.
    Unsupported(&'static str),
    Some(Vec<Value>),
}

/// One value in the file's own unit.
pub(super) struct Value {
    type_name: String,
    actual: Actual,
    /// The unit of the value, where it has one of its own.
    unit: Option<u32>,
    role: Role,
}

/// What a value is to its property.
#[derive(Clone, Copy, PartialEq)]
enum Role {
    /// The value, or one of several.
    Plain,
    LowerBound,
    UpperBound,
    SetPoint,
}

impl Value {
    pub(super) fn new(type_name: &str, actual: Actual, unit: Option<u32>) -> Self {
        Self { type_name: type_name.to_owned(), actual, unit, role: Role::Plain }
    }

    /// In units of SI; `None` if the file does not say in which unit it is.
    fn in_si(&self, model: &Model<'_>) -> Option<Actual> {
        match self.actual {
            Actual::Real(x) => {
                model.units.conversion(model.file, &self.type_name, self.unit).map(|c| Actual::Real(c.apply(x)))
            }
            _ => Some(self.actual.clone()),
        }
    }
}

/// The values of a record that is a property or a quantity.
pub(super) fn of<'a>(model: &Model<'a>, record: &Record<'a>) -> Values {
    let unit = |name: &str| model.attribute(record, name).reference();
    let one = |name: &str, unit: Option<u32>| typed(model, model.attribute(record, name), unit);
    let list = |name: &str, unit: Option<u32>| -> Vec<Option<Option<Value>>> {
        model.attribute(record, name).list().iter().map(|value| typed(model, value, unit)).collect()
    };
    match record.keyword.to_ascii_uppercase().as_str() {
        "IFCPROPERTYSINGLEVALUE" => collected(vec![one("NominalValue", unit("Unit"))]),
        "IFCPROPERTYENUMERATEDVALUE" => {
            let reference = model.attribute(record, "EnumerationReference").reference();
            let unit =
                reference.and_then(|id| model.file.record(id)).and_then(|e| model.attribute(&e, "Unit").reference());
            collected(list("EnumerationValues", unit))
        }
        "IFCPROPERTYLISTVALUE" => collected(list("ListValues", unit("Unit"))),
        "IFCPROPERTYTABLEVALUE" => {
            let mut values = list("DefiningValues", unit("DefiningUnit"));
            values.extend(list("DefinedValues", unit("DefinedUnit")));
            collected(values)
        }
        "IFCPROPERTYBOUNDEDVALUE" => {
            let roles = [
                ("LowerBoundValue", Role::LowerBound),
                ("UpperBoundValue", Role::UpperBound),
                ("SetPointValue", Role::SetPoint),
            ];
            let bounds = roles.into_iter().map(|(name, role)| {
                let value = one(name, unit("Unit"))?;
                Some(value.map(|value| Value { role, ..value }))
            });
            collected(bounds.collect())
        }
        "IFCCOMPLEXPROPERTY" => Values::Unsupported("a complex property"),
        "IFCPROPERTYREFERENCEVALUE" => Values::Unsupported("a reference to an object"),
        "IFCPHYSICALCOMPLEXQUANTITY" => Values::Unsupported("a complex quantity"),
        _ => quantity(model, record),
    }
}

/// The value of a simple quantity, whose attribute says of what type it is.
fn quantity<'a>(model: &Model<'a>, record: &Record<'a>) -> Values {
    let named = model.attributes(record).find(|(attribute, _)| attribute.name.ends_with("Value"));
    let Some((attribute, value)) = named else { return Values::Unsupported("no property") };
    let base = model.schema.base(attribute.type_name).unwrap_or(Base::Other);
    let unit = model.attribute(record, "Unit").reference();
    match plain(value, base) {
        Some(actual) => Values::Some(vec![Value::new(attribute.type_name, actual, unit)]),
        None => Values::None,
    }
}

/// A value with the name of its type; outer `None` for `$`, inner for an empty one.
fn typed(model: &Model<'_>, value: &ifc::Value<'_>, unit: Option<u32>) -> Option<Option<Value>> {
    let ifc::Value::Typed(name, inner) = value else {
        // Without its type, as careless exporters write it.
        let text = value.text()?;
        return Some((!text.is_empty()).then(|| Value::new("", Actual::Text(text.into_owned()), None)));
    };
    if **inner == ifc::Value::Null {
        return None;
    }
    let actual = plain(inner, model.schema.base(name).unwrap_or(Base::Text));
    let actual = actual.filter(|actual| *actual != Actual::Text(String::new()));
    Some(actual.map(|actual| Value::new(name, actual, unit)))
}

fn collected(values: Vec<Option<Option<Value>>>) -> Values {
    let there: Vec<Option<Value>> = values.into_iter().flatten().collect();
    if there.is_empty() {
        return Values::None;
    }
    let found: Vec<Value> = there.into_iter().flatten().collect();
    if found.is_empty() { Values::Empty } else { Values::Some(found) }
}

pub(super) fn finding(model: &Model<'_>, place: &str, values: &[Value], facet: &PropertyFacet) -> Finding {
    let is_of_type =
        |value: &&Value| facet.data_type.as_ref().is_none_or(|name| name.eq_ignore_ascii_case(&value.type_name));
    let of_type: Vec<&Value> = values.iter().filter(is_of_type).collect();
    let Some(first) = of_type.first() else {
        let type_name = values.first().map_or("", |value| &value.type_name);
        let wanted = facet.data_type.as_deref().unwrap_or_default();
        return Finding::Mismatch(format!("{place} is of type {}, not {wanted}", type_name.to_ascii_uppercase()));
    };
    let Some(wanted) = &facet.value else { return Finding::Match };
    let converted: Option<Vec<(Role, Actual)>> =
        of_type.iter().map(|value| Some((value.role, value.in_si(model)?))).collect();
    let Some(converted) = converted else {
        return Finding::Mismatch(format!("{place} is {} in a unit that the file does not define", first.actual));
    };
    let matches = if converted.iter().all(|(role, _)| *role == Role::Plain) {
        some_or_all(wanted, &converted)
    } else {
        bounded(wanted, &converted)
    };
    if matches {
        return Finding::Match;
    }
    let texts: Vec<String> = converted.iter().map(|(_, actual)| actual.to_string()).collect();
    Finding::Mismatch(format!("{place} is {}, not {wanted}", texts.join(", ")))
}

/// Of several values one must match, or all of them a range.
fn some_or_all(wanted: &Constraint, values: &[(Role, Actual)]) -> bool {
    if wanted.is_range() {
        values.iter().all(|(_, actual)| wanted.matches(actual))
    } else {
        values.iter().any(|(_, actual)| wanted.matches(actual))
    }
}

/// Bounds match a range that has both of them inside, and a value that they do not exclude; with a set point, the value is that
/// point or a bound.
///
/// # Source
/// The table of bounded values in the user manual of IDS 1.0, and its test case of a bounded property with a set point.
fn bounded(wanted: &Constraint, values: &[(Role, Actual)]) -> bool {
    let of = |role: Role| values.iter().find(|(of, _)| *of == role).map(|(_, actual)| actual);
    let (lower, upper) = (of(Role::LowerBound), of(Role::UpperBound));
    let value = match wanted {
        Constraint::Simple(value) => value,
        Constraint::Restriction(restriction) if wanted.is_range() => {
            // An end that is open lies beyond a bound of the range on its side.
            return restriction
                .bounds
                .iter()
                .all(|bound| if bound.kind.is_least() { lower.is_some() } else { upper.is_some() })
                && values.iter().all(|(_, actual)| wanted.matches(actual));
        }
        Constraint::Restriction(_) => return some_or_all(wanted, values),
    };
    if values.iter().any(|(_, actual)| wanted.matches(actual)) {
        return true;
    }
    let Some(value) = double(value).filter(|_| of(Role::SetPoint).is_none()) else { return false };
    let number = |actual: Option<&Actual>| match actual {
        Some(Actual::Real(x) | Actual::Integer(x)) => Some(*x),
        _ => None,
    };
    let (lower, upper) = (number(lower), number(upper));
    lower.or(upper).is_some() && lower.is_none_or(|lower| lower <= value) && upper.is_none_or(|upper| value <= upper)
}
