//! Changes of single arguments and new instances at the end, with the observations that are behind each.

use crate::change_list::{LineChange, LineChangeKind};
use crate::step_file::{Instance, StepFile};
use crate::step_text::ascii;
use std::collections::{BTreeMap, BTreeSet};

/// A file that is being changed.
pub(crate) struct Editor<'f, 'a> {
    pub(crate) file: &'f StepFile<'a>,
    /// New texts of arguments, by instance and argument.
    changed: BTreeMap<u64, BTreeMap<usize, String>>,
    /// New instances, `ENTITY(..)`, from the first new id on.
    added: Vec<String>,
    first_new: u64,
    /// GlobalIds of new instances.
    new_roots: BTreeMap<String, u64>,
    /// The observations whose changes are made.
    because: Vec<usize>,
    /// Observations behind each line, and the GlobalId of what it is about.
    reasons: BTreeMap<u64, (BTreeSet<usize>, Option<String>)>,
    about: Option<String>,
}

impl<'f, 'a> Editor<'f, 'a> {
    pub(crate) fn new(file: &'f StepFile<'a>) -> Self {
        Self {
            file,
            changed: BTreeMap::new(),
            added: Vec::new(),
            first_new: file.max_id() + 1,
            new_roots: BTreeMap::new(),
            because: Vec::new(),
            reasons: BTreeMap::new(),
            about: None,
        }
    }

    /// What follows is because of these observations, and about this element or task.
    pub(crate) fn because_of(&mut self, observations: &[usize], about: Option<&str>) {
        self.because = observations.to_vec();
        self.about = about.map(str::to_owned);
    }

    fn note(&mut self, id: u64) {
        let entry = self.reasons.entry(id).or_insert_with(|| (BTreeSet::new(), self.about.clone()));
        entry.0.extend(&self.because);
    }

    /// An argument as it is now, with escapes for what is not ASCII.
    pub(crate) fn argument(&self, instance: &Instance<'_>, k: usize) -> String {
        let changed = self.changed.get(&instance.id).and_then(|arguments| arguments.get(&k)).cloned();
        changed.unwrap_or_else(|| ascii(self.file.argument(instance, k)))
    }

    /// Changes an argument; what is so already is no change. An argument that an instance has not is left alone.
    pub(crate) fn set(&mut self, instance: &Instance<'_>, k: usize, text: String) {
        if k < instance.arguments.len() && self.argument(instance, k) != text {
            self.changed.entry(instance.id).or_default().insert(k, text);
            self.note(instance.id);
        }
    }

    /// How much was changed and added so far.
    pub(crate) fn n_changes(&self) -> usize {
        self.changed.values().map(std::collections::BTreeMap::len).sum::<usize>() + self.added.len()
    }

    /// Adds an instance; its id.
    pub(crate) fn add(&mut self, entity: &str, arguments: &[String]) -> u64 {
        let id = self.first_new + self.added.len() as u64;
        self.added.push(format!("{entity}({})", arguments.join(",")));
        self.note(id);
        id
    }

    /// Adds an instance with a GlobalId.
    pub(crate) fn add_root(&mut self, entity: &str, global_id: &str, behind: &[String]) -> u64 {
        let arguments: Vec<String> = std::iter::once(format!("'{global_id}'")).chain(behind.iter().cloned()).collect();
        let id = self.add(entity, &arguments);
        self.new_roots.insert(global_id.to_owned(), id);
        id
    }

    /// The id of what has a GlobalId, in the file or new.
    pub(crate) fn root(&self, global_id: &str) -> Option<u64> {
        self.file.root(global_id).or_else(|| self.new_roots.get(global_id).copied())
    }

    /// The bytes with all changes, and the list of them by id.
    pub(crate) fn finish(self) -> (Vec<u8>, Vec<LineChange>) {
        let file = self.file;
        let mut edits: Vec<(std::ops::Range<usize>, &str)> = Vec::new();
        for (id, arguments) in &self.changed {
            let Some(instance) = file.instance(*id) else { continue };
            edits.extend(arguments.iter().map(|(k, text)| (instance.arguments[*k].clone(), text.as_str())));
        }
        edits.sort_by_key(|(place, _)| place.start);
        let (mut bytes, mut copied) = (Vec::with_capacity(file.bytes.len() + 128 * self.added.len()), 0);
        for (place, text) in edits {
            bytes.extend_from_slice(&file.bytes[copied..place.start]);
            bytes.extend_from_slice(text.as_bytes());
            copied = place.end;
        }
        bytes.extend_from_slice(&file.bytes[copied..file.end_of_data]);
        for (id, instance) in (self.first_new..).zip(&self.added) {
            bytes.extend_from_slice(format!("#{id}={instance};{}", file.line_end).as_bytes());
        }
        bytes.extend_from_slice(&file.bytes[file.end_of_data..]);
        let lines = self.lines();
        (bytes, lines)
    }

    fn lines(&self) -> Vec<LineChange> {
        let reasons = |id: u64| self.reasons.get(&id).cloned().unwrap_or_default();
        let changed = self.changed.iter().filter_map(|(id, arguments)| {
            let place = self.file.place(*id)?;
            let instance = self.file.instance(*id)?;
            let old = &self.file.bytes[place.clone()];
            let mut new = old.to_vec();
            for (k, text) in arguments.iter().rev() {
                let argument = instance.arguments[*k].clone();
                new.splice(argument.start - place.start..argument.end - place.start, text.bytes());
            }
            let [old, new] = [old, &new].map(|line| String::from_utf8_lossy(line).into_owned());
            let (observations, element) = reasons(*id);
            Some(LineChange { id: *id, change: LineChangeKind::Changed, element, old: Some(old), new, observations })
        });
        let added = (self.first_new..).zip(&self.added).map(|(id, instance)| {
            let (observations, element) = reasons(id);
            let new = format!("#{id}={instance};");
            LineChange { id, change: LineChangeKind::Added, element, old: None, new, observations }
        });
        changed.chain(added).collect()
    }
}
