//! Property sets of occurrences and types.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::kernel::{File, Record, Value};
use crate::relations::Relations;
use crate::{Property, PropertyValue};

/// Property sets; those of several objects are read once.
pub(crate) struct PropertySets<'f, 'a> {
    file: &'f File<'a>,
    known: FxHashMap<u32, Vec<Property>>,
}

impl<'f, 'a> PropertySets<'f, 'a> {
    pub(crate) fn new(file: &'f File<'a>) -> Self {
        Self { file, known: FxHashMap::default() }
    }

    /// Properties of the occurrence, then those of its type that the occurrence does not override.
    pub(crate) fn of(&mut self, object: u32, relations: &Relations) -> Vec<Property> {
        let mut properties = Vec::new();
        for definition in relations.definitions.get(&object).into_iter().flatten() {
            if definition.shared {
                properties.extend_from_slice(self.shared(definition.set));
            } else {
                properties.extend(read(self.file, definition.set));
            }
        }
        // Their relations get new GlobalIds in each export of some programs.
        properties.sort_by(|a: &Property, b| a.set.cmp(&b.set));
        let sets = relations.type_of.get(&object).map(|&id| type_sets(self.file, id)).unwrap_or_default();
        let own: FxHashSet<(&str, &str)> = properties.iter().map(|p| (p.set.as_str(), p.name.as_str())).collect();
        let mut inherited = Vec::new();
        for set in sets {
            let new = self.shared(set).iter().filter(|p| !own.contains(&(p.set.as_str(), p.name.as_str())));
            inherited.extend(new.cloned());
        }
        properties.extend(inherited);
        properties
    }

    fn shared(&mut self, id: u32) -> &[Property] {
        let file = self.file;
        self.known.entry(id).or_insert_with(|| read(file, id))
    }
}

/// Properties of an IfcPropertySet; none of any other definition.
fn read(file: &File<'_>, id: u32) -> Vec<Property> {
    file.record_of(id, "IFCPROPERTYSET").map(|set| read_set(file, &set)).unwrap_or_default()
}

/// HasPropertySets of a type.
pub(crate) fn type_sets(file: &File<'_>, type_id: u32) -> Vec<u32> {
    file.record(type_id).map(|record| record.at(5).references()).unwrap_or_default()
}

fn read_set(file: &File<'_>, set: &Record<'_>) -> Vec<Property> {
    let name = set.text(2);
    let properties = set.at(4).references().into_iter().filter_map(|id| file.record(id));
    properties
        .filter_map(|record| {
            let value = value(&record)?;
            Some(Property { set: name.clone(), name: record.text(0), value })
        })
        .collect()
}

fn value(record: &Record<'_>) -> Option<PropertyValue> {
    if record.is("IFCPROPERTYSINGLEVALUE") {
        single(record.at(2))
    } else if record.is("IFCPROPERTYENUMERATEDVALUE") || record.is("IFCPROPERTYLISTVALUE") {
        joined(record.at(2).list())
    } else if record.is("IFCPROPERTYBOUNDEDVALUE") {
        single(record.at(5)).or_else(|| joined(&[record.at(3).clone(), record.at(2).clone()]))
    } else {
        None
    }
}

fn single(value: &Value<'_>) -> Option<PropertyValue> {
    if let Some(text) = value.text() {
        return Some(PropertyValue::Text(text.into_owned()));
    }
    if let Some(number) = value.number() {
        return Some(PropertyValue::Number(number));
    }
    let boolean = value.boolean().map(PropertyValue::Boolean);
    boolean.or_else(|| value.enumeration().map(|name| PropertyValue::Text(name.to_owned())))
}

/// One value stays what it is; several become a text.
fn joined(values: &[Value<'_>]) -> Option<PropertyValue> {
    let mut values: Vec<PropertyValue> = values.iter().filter_map(single).collect();
    if values.len() <= 1 {
        return values.pop();
    }
    let texts: Vec<String> = values
        .into_iter()
        .map(|value| match value {
            PropertyValue::Text(text) => text,
            PropertyValue::Number(number) => number.to_string(),
            PropertyValue::Boolean(boolean) => boolean.to_string(),
        })
        .collect();
    Some(PropertyValue::Text(texts.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{file, with_file};
    use diagnostics::Report;

    #[test]
    fn occurrence_properties_come_first_and_override_those_of_the_type() {
        let text = file(
            "#1=IFCRELDEFINESBYPROPERTIES('a',$,$,$,(#10),#2);#2=IFCPROPERTYSET('b',$,'P',$,(#3,#4,#5,#6));
             #3=IFCPROPERTYSINGLEVALUE('IsExternal',$,IFCBOOLEAN(.T.),$);
             #4=IFCPROPERTYENUMERATEDVALUE('Status',$,(IFCLABEL('NEW'),IFCLABEL('EXISTING')),$);
             #5=IFCPROPERTYBOUNDEDVALUE('Width',$,IFCREAL(2.),IFCREAL(1.),$,$);
             #6=IFCPROPERTYREFERENCEVALUE('Skipped',$,$,$);
             #7=IFCRELDEFINESBYTYPE('c',$,$,$,(#10),#8);#8=IFCWALLTYPE('d',$,$,$,$,(#9),$,$,$,.STANDARD.);
             #9=IFCPROPERTYSET('e',$,'P',$,(#11,#12));
             #11=IFCPROPERTYSINGLEVALUE('IsExternal',$,IFCBOOLEAN(.F.),$);
             #12=IFCPROPERTYSINGLEVALUE('FireRating',$,IFCLABEL('F90'),$);",
        );
        let properties = with_file(&text, |file| {
            let relations = Relations::read(file, &mut Report::default());
            PropertySets::new(file).of(10, &relations)
        });
        let text = |t: &str| PropertyValue::Text(t.to_owned());
        let found: Vec<(&str, PropertyValue)> = properties.iter().map(|p| (p.name.as_str(), p.value.clone())).collect();
        let expected = [
            ("IsExternal", PropertyValue::Boolean(true)),
            ("Status", text("NEW, EXISTING")),
            ("Width", text("1, 2")),
            ("FireRating", text("F90")),
        ];
        assert_eq!(found, expected);
    }
}
