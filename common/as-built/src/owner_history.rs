//! The IfcOwnerHistory of new and changed entities, with an application and a person of our own.

use crate::editor::Editor;
use crate::step_file::{Instance, Schema};
use crate::step_text::{reference, text};
use frames::PlanTime;
use std::collections::BTreeMap;

const NAME: &str = "groundplan";

/// The histories that were added.
pub(crate) struct OwnerHistory {
    /// Time of what is written: that of the newest observation, so that the same input gives the same bytes.
    at: PlanTime,
    user: Option<[u64; 2]>,
    of_added: Option<u64>,
    /// Of changed entities, by the history that they had.
    of_changed: BTreeMap<u64, u64>,
}

impl OwnerHistory {
    pub(crate) fn new(at: PlanTime) -> Self {
        Self { at, user: None, of_added: None, of_changed: BTreeMap::new() }
    }

    /// The reference that new entities have.
    pub(crate) fn of_added(&mut self, editor: &mut Editor<'_, '_>) -> String {
        if let Some(id) = self.of_added {
            return reference(id);
        }
        let [user, application] = self.user(editor);
        let at = self.at.civil_seconds().to_string();
        let [user, application] = [user, application].map(reference);
        let arguments =
            [user.clone(), application.clone(), "$".into(), ".ADDED.".into(), at.clone(), user, application, at];
        let id = editor.add("IFCOWNERHISTORY", &arguments);
        self.of_added = Some(id);
        reference(id)
    }

    /// Says of an entity that it was changed: its history with who changed it. One without a history keeps none, where the schema
    /// lets it have none.
    pub(crate) fn mark_changed(&mut self, editor: &mut Editor<'_, '_>, entity: &Instance<'_>) {
        let Some(old) = editor.file.referred(entity, 1).filter(|old| old.is("IFCOWNERHISTORY")) else {
            if editor.file.schema == Schema::Ifc2x3 && editor.argument(entity, 1) == "$" {
                let history = self.of_added(editor);
                editor.set(entity, 1, history);
            }
            return;
        };
        let id = match self.of_changed.get(&old.id) {
            Some(id) => *id,
            None => {
                let [user, application] = self.user(editor).map(reference);
                let at = self.at.civil_seconds().to_string();
                let kept = |k: usize| editor.argument(&old, k);
                let [owner, owning, state, created] = [0, 1, 2, 7].map(kept);
                let arguments = [owner, owning, state, ".MODIFIED.".into(), at, user, application, created];
                let id = editor.add("IFCOWNERHISTORY", &arguments);
                self.of_changed.insert(old.id, id);
                id
            }
        };
        editor.set(entity, 1, reference(id));
    }

    /// The person in its organisation, and the application; those of an earlier run where it was the same version.
    fn user(&mut self, editor: &mut Editor<'_, '_>) -> [u64; 2] {
        if let Some(user) = self.user {
            return user;
        }
        let version = env!("CARGO_PKG_VERSION");
        let identifier = text(&format!("{NAME} {version}"));
        let none = || "$".to_owned();
        let file = editor.file;
        let earlier = file.all("IFCAPPLICATION").into_iter().find(|a| file.argument(a, 3) == identifier.as_bytes());
        let (organisation, application) = match earlier.and_then(|a| Some((file.reference(&a, 0)?, a.id))) {
            Some(known) => known,
            None => {
                let organisation = editor.add("IFCORGANIZATION", &[text(NAME), text(NAME), none(), none(), none()]);
                let arguments = [reference(organisation), text(version), text(NAME), identifier];
                (organisation, editor.add("IFCAPPLICATION", &arguments))
            }
        };
        let known = file.all("IFCPERSONANDORGANIZATION").into_iter().find(|p| {
            let person = file.referred(p, 0);
            file.reference(p, 1) == Some(organisation)
                && person.is_some_and(|person| file.argument(&person, 0) == text(NAME).as_bytes())
        });
        let person = known.map_or_else(
            || {
                let person = [text(NAME), text(NAME), none(), none(), none(), none(), none(), none()];
                let person = editor.add("IFCPERSON", &person);
                editor.add("IFCPERSONANDORGANIZATION", &[reference(person), reference(organisation), none()])
            },
            |known| known.id,
        );
        *self.user.insert([person, application])
    }
}
