//! Properties and quantities: of the element, and of its type where the element has none of that name.

use ifc::{Record, Value};

use super::Finding;
use super::attribute::plain;
use super::finding::with_values;
use super::property_values::{self, Values};
use crate::document::PropertyFacet;
use crate::model::Model;
use crate::schema::{Attribute, Base};

/// A property of a set.
enum Item<'a> {
    /// A record: `IfcProperty`, `IfcPhysicalQuantity`.
    Record(Record<'a>),
    /// An attribute of a predefined set.
    Attribute(Attribute, Value<'a>),
}

/// A set with the properties that count, by name.
struct Set<'a> {
    name: String,
    items: Vec<(String, Item<'a>)>,
}

pub(super) fn findings<'a>(model: &Model<'a>, record: &Record<'_>, facet: &PropertyFacet) -> Vec<Finding> {
    let mut found = Vec::new();
    let sets = sets_of(model, record, facet);
    if sets.is_empty() {
        return vec![Finding::Absent(format!("it has no property set {}", facet.set))];
    }
    for set in sets {
        if set.items.is_empty() {
            found.push(Finding::Absent(format!("{} has no property {}", set.name, facet.name)));
            continue;
        }
        let items = set.items.iter().map(|(name, item)| {
            let place = format!("{}.{name}", set.name);
            match values(model, item) {
                Values::None => Finding::Null(format!("{place} has no value")),
                Values::Empty => Finding::Empty(format!("{place} is empty or unknown")),
                Values::Unsupported(what) => Finding::Mismatch(format!("{place} is {what}, which IDS does not read")),
                Values::Some(values) => property_values::finding(model, &place, &values, facet),
            }
        });
        found.extend(with_values(items.collect()));
    }
    found
}

/// Sets whose names match, with the properties whose names match; those of the element come in place of those of its type.
fn sets_of<'a>(model: &Model<'a>, record: &Record<'_>, facet: &PropertyFacet) -> Vec<Set<'a>> {
    let mut sets: Vec<Set<'a>> = Vec::new();
    if let Some(type_object) = model.type_of(record.id) {
        add_sets(model, &sets_of_type(model, &type_object), facet, &mut sets);
    }
    for set in &mut sets {
        // What the type says of a property holds until the element says otherwise.
        set.items.sort_by(|(a, _), (b, _)| a.cmp(b));
    }
    let mut own: Vec<Set<'a>> = Vec::new();
    add_sets(model, &sets_of_type(model, record), facet, &mut own);
    add_sets(model, model.sets_of(record.id), facet, &mut own);
    for set in own {
        match sets.iter_mut().find(|inherited| inherited.name == set.name) {
            None => sets.push(set),
            Some(inherited) => {
                inherited.items.retain(|(name, _)| !set.items.iter().any(|(own, _)| own == name));
                inherited.items.extend(set.items);
            }
        }
    }
    sets
}

/// Sets that a type object has itself; none for another object.
fn sets_of_type(model: &Model<'_>, record: &Record<'_>) -> Vec<u32> {
    let at = model.entity_of(record).and_then(|entity| entity.position("HasPropertySets"));
    at.map_or(Vec::new(), |at| record.at(at).references())
}

fn add_sets<'a>(model: &Model<'a>, ids: &[u32], facet: &PropertyFacet, sets: &mut Vec<Set<'a>>) {
    for id in ids {
        let Some(record) = model.file.record(*id) else { continue };
        let Some(name) = model.text(&record, "Name").filter(|name| facet.set.matches_text(name)) else { continue };
        let items = items(model, &record, facet);
        match sets.iter_mut().find(|set| set.name == name) {
            Some(set) => set.items.extend(items),
            None => sets.push(Set { name, items }),
        }
    }
}

/// Attributes of the kinds of sets that have records for their properties.
const LISTS: [&str; 4] = ["HasProperties", "Quantities", "Properties", "ExtendedProperties"];

/// Attributes of a predefined set that are not its own.
const OF_ROOT: [&str; 4] = ["GlobalId", "OwnerHistory", "Name", "Description"];

fn items<'a>(model: &Model<'a>, set: &Record<'a>, facet: &PropertyFacet) -> Vec<(String, Item<'a>)> {
    let Some(entity) = model.entity_of(set) else { return Vec::new() };
    if LISTS.iter().any(|list| entity.position(list).is_some()) {
        let ids = LISTS.iter().flat_map(|list| model.attribute(set, list).references());
        let records = ids.filter_map(|id| model.file.record(id));
        let named = records.filter_map(|record| Some((model.text(&record, "Name")?, record)));
        return named
            .filter(|(name, _)| facet.name.matches_text(name))
            .map(|(name, record)| (name, Item::Record(record)))
            .collect();
    }
    let own = model.attributes(set).filter(|(attribute, _)| !OF_ROOT.contains(&attribute.name));
    own.filter(|(attribute, _)| facet.name.matches_text(attribute.name))
        .map(|(attribute, value)| (attribute.name.to_owned(), Item::Attribute(attribute, value.clone())))
        .collect()
}

fn values<'a>(model: &Model<'a>, item: &Item<'a>) -> Values {
    match item {
        Item::Record(record) => property_values::of(model, record),
        Item::Attribute(attribute, value) => {
            let base = model.schema.base(attribute.type_name).unwrap_or(Base::Other);
            match value {
                Value::Null => Values::None,
                _ if base == Base::Other => Values::Unsupported("an object or a list"),
                value => match plain(value, base) {
                    Some(actual) => Values::Some(vec![property_values::Value::new(attribute.type_name, actual, None)]),
                    None => Values::Empty,
                },
            }
        }
    }
}
