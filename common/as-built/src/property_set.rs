//! The property set of what was observed of an element or task; that of an earlier run is brought up to date.

use crate::editor::Editor;
use crate::global_id::global_id_of;
use crate::owner_history::OwnerHistory;
use crate::step_file::{Instance, StepFile};
use crate::step_text::{list, reference, text};
use std::collections::BTreeMap;

/// Name of the property set.
pub const PROPERTY_SET: &str = "Groundplan_AsBuilt";

/// A property: its name, its value as STEP writes it, and what it means where its name does not tell.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Property {
    pub(crate) name: &'static str,
    pub(crate) value: String,
    pub(crate) description: Option<String>,
}

/// The property sets of ours that a file has, by the ids of their objects.
pub(crate) struct KnownSets {
    of: BTreeMap<u64, u64>,
}

impl KnownSets {
    pub(crate) fn of(file: &StepFile<'_>) -> Self {
        let name = text(PROPERTY_SET);
        let is_ours = |id: &u64| {
            let set = file.instance(*id);
            set.is_some_and(|set| file.argument(&set, 2) == name.as_bytes())
        };
        let sets: Vec<u64> = file.ids_of("IFCPROPERTYSET").into_iter().filter(is_ours).collect();
        if sets.is_empty() {
            return Self { of: BTreeMap::new() };
        }
        let relations = file.all("IFCRELDEFINESBYPROPERTIES");
        let of = relations.iter().filter_map(|r| Some((r, file.reference(r, 5).filter(|set| sets.contains(set))?)));
        Self {
            of: of.flat_map(|(r, set)| file.references(r, 4).into_iter().map(move |object| (object, set))).collect(),
        }
    }

    /// A value that an object has already, as STEP writes it.
    pub(crate) fn value(&self, file: &StepFile<'_>, object: u64, name: &str) -> Option<String> {
        let set = file.instance(*self.of.get(&object)?)?;
        let mut properties = file.references(&set, 4).into_iter().filter_map(|id| file.instance(id));
        let property = properties.find(|property| file.argument(property, 0) == text(name).as_bytes())?;
        Some(String::from_utf8_lossy(file.argument(&property, 2)).into_owned())
    }

    /// Gives an object these properties. Properties of an earlier run that are stale leave its set.
    pub(crate) fn write(
        &self,
        editor: &mut Editor<'_, '_>,
        owner: &mut OwnerHistory,
        (object, global_id): (u64, &str),
        properties: &[Property],
        stale: &[&str],
    ) {
        let file = editor.file;
        if let Some(set) = self.of.get(&object).and_then(|id| file.instance(*id)) {
            let before = editor.n_changes();
            let known: Vec<_> = file.references(&set, 4).into_iter().filter_map(|id| file.instance(id)).collect();
            let is_stale =
                |property: &Instance<'_>| stale.iter().any(|name| file.argument(property, 0) == text(name).as_bytes());
            let mut all: Vec<u64> = known.iter().filter(|known| !is_stale(known)).map(|property| property.id).collect();
            for property in properties {
                match known.iter().find(|known| file.argument(known, 0) == text(property.name).as_bytes()) {
                    Some(known) => {
                        editor.set(known, 2, property.value.clone());
                        if let Some(description) = &property.description {
                            editor.set(known, 1, text(description));
                        }
                    }
                    None => all.push(added(editor, property)),
                }
            }
            editor.set(&set, 4, list(&all));
            if editor.n_changes() > before {
                owner.mark_changed(editor, &set);
            }
            return;
        }
        let all: Vec<u64> = properties.iter().map(|property| added(editor, property)).collect();
        let (history, none) = (owner.of_added(editor), || "$".to_owned());
        let id = global_id_of(&["property set", global_id]);
        let set = [history.clone(), text(PROPERTY_SET), none(), list(&all)];
        let set = editor.add_root("IFCPROPERTYSET", &id, &set);
        let id = global_id_of(&["properties", global_id]);
        let relation = [history, none(), none(), list(&[object]), reference(set)];
        editor.add_root("IFCRELDEFINESBYPROPERTIES", &id, &relation);
    }
}

fn added(editor: &mut Editor<'_, '_>, property: &Property) -> u64 {
    let description = property.description.as_deref().map_or("$".to_owned(), text);
    editor.add("IFCPROPERTYSINGLEVALUE", &[text(property.name), description, property.value.clone(), "$".to_owned()])
}
