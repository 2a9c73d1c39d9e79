//! Values that elements and tasks share, counted for every value of both in one pass over the elements.

use crate::folded::fold;
use crate::links::{Target, targets};
use crate::matches::squashed;
use crate::target_values::{TargetValue, attributes, texts};
use crate::task_values::{PlannedTask, TaskValue};
use messages::{MEMBERSHIP_SETS, Site};
use std::collections::{BTreeMap, BTreeSet, HashMap};

/// Signs of a text before which a prefix of it is looked for.
const MAX_PREFIXES: usize = 6;

/// A value of tasks, as rules write it, and who has which text.
#[derive(Debug)]
pub(super) struct TaskTexts {
    /// `code`, `field:Zone`.
    pub(super) written: String,
    pub(super) value: TaskValue,
    /// Tasks by folded text.
    pub(super) tasks: BTreeMap<String, Vec<usize>>,
}

/// A value of elements and spaces.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Compared {
    /// A property by its name.
    Property(String),
    /// The key of a rule.
    Key(&'static str),
}

/// Counts for a value of elements and one of tasks.
#[derive(Debug, Clone, Default)]
pub(super) struct Pair {
    /// Elements and spaces with a text that tasks have.
    pub(super) n_hit: usize,
    /// Elements and spaces with no such text, but one that differs in spaces, signs, leading zeros or what follows a sign.
    pub(super) n_near: usize,
    /// Elements and spaces by shared text.
    pub(super) shared: BTreeMap<usize, usize>,
}

/// All counts.
#[derive(Debug, Default)]
pub(super) struct Counts {
    /// Values of elements, and how many elements and spaces have each.
    pub(super) compared: Vec<(Compared, usize)>,
    /// By indices of both values.
    pub(super) pairs: BTreeMap<(usize, usize), Pair>,
    /// Texts of tasks by the index in [`Pair::shared`].
    pub(super) texts: Vec<String>,
}

impl Compared {
    pub(super) fn value(&self) -> TargetValue {
        match self {
            // A point in a name would be that between set and property.
            Self::Property(name) if name.contains('.') => TargetValue::property(&format!("*.{name}")),
            Self::Property(name) => TargetValue::property(name),
            Self::Key(key) => KEYS.iter().find(|(name, _)| name == key).map_or(TargetValue::Name, |(_, value)| value()),
        }
    }
}

type MakeValue = fn() -> TargetValue;

/// Keys of rules whose values are compared, but for properties.
const KEYS: [(&str, MakeValue); 8] = [
    ("global_id", || TargetValue::GlobalId),
    ("name", || TargetValue::Name),
    ("classification", || TargetValue::Classification),
    ("group", || TargetValue::Group),
    ("zone", || TargetValue::Zone),
    ("space", || TargetValue::Space),
    ("storey", || TargetValue::Storey),
    ("class", || TargetValue::Class),
];

/// All values of tasks that are not switched off, each of them once.
pub(super) fn task_texts(tasks: &[PlannedTask<'_>]) -> Vec<TaskTexts> {
    let mut fields: BTreeMap<String, &str> = BTreeMap::new();
    for (name, _) in tasks.iter().flat_map(|planned| &planned.task.fields) {
        fields.entry(fold(name)).or_insert(name.trim());
    }
    let named = ["code", "wbs", "name", "id"].map(str::to_owned).into_iter();
    let written = named
        .chain(fields.into_iter().filter(|(folded, _)| !folded.is_empty()).map(|(_, name)| format!("field:{name}")));
    let mut all: Vec<TaskTexts> = Vec::new();
    for written in written {
        let Ok(value) = TaskValue::parse(&written) else { continue };
        let mut of: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        for (k, planned) in tasks.iter().enumerate().filter(|(_, planned)| !planned.task.is_inactive) {
            let texts: BTreeSet<String> = value.of(planned.task).into_iter().collect();
            texts.into_iter().for_each(|text| of.entry(text).or_default().push(k));
        }
        // The id of a CSV is its code.
        if !of.is_empty() && all.iter().all(|other| other.tasks != of) {
            all.push(TaskTexts { written, value, tasks: of });
        }
    }
    all
}

/// Looks up every text of every element and space among those of tasks.
pub(super) fn count(site: &Site<'_>, tasks: &[TaskTexts]) -> Counts {
    let index = Index::of(tasks);
    let mut counter = Counter { index: &index, found: HashMap::new(), n_with: Vec::new() };
    let mut compared: Vec<Compared> = KEYS.iter().map(|(key, _)| Compared::Key(key)).collect();
    let mut properties: HashMap<String, usize> = HashMap::new();
    let keys: Vec<TargetValue> = KEYS.iter().map(|(_, value)| value()).collect();
    for target in targets(site) {
        for (k, value) in keys.iter().enumerate() {
            counter.add(k, value.of(site, target));
        }
        for (name, texts) in property_texts(site, target) {
            let next = compared.len();
            let k = *properties.entry(fold(name)).or_insert(next);
            if k == next {
                compared.push(Compared::Property(name.trim().to_owned()));
            }
            counter.add(k, texts);
        }
    }
    let Counter { found, mut n_with, .. } = counter;
    n_with.resize(compared.len(), 0);
    let texts = index.texts.iter().map(|text| (*text).to_owned()).collect();
    Counts { compared: compared.into_iter().zip(n_with).collect(), pairs: found.into_iter().collect(), texts }
}

/// Texts of a target by property; those of one name in several sets together.
fn property_texts<'s>(site: &Site<'s>, target: Target) -> Vec<(&'s str, Vec<String>)> {
    let mut all: Vec<(&str, Vec<String>)> = Vec::new();
    for attribute in attributes(site, target).iter().filter(|a| !MEMBERSHIP_SETS.contains(&site.text(a.set))) {
        let name = site.text(attribute.name);
        let texts = texts(site, attribute);
        match all.iter_mut().find(|(other, _)| *other == name) {
            Some((_, of)) => of.extend(texts),
            None if name.trim().is_empty() => {}
            None => all.push((name, texts)),
        }
    }
    all
}

/// Texts of tasks, and the values that have them.
struct Index<'t> {
    texts: Vec<&'t str>,
    by_text: HashMap<&'t str, (usize, Vec<usize>)>,
    by_squashed: HashMap<String, Vec<usize>>,
}

impl<'t> Index<'t> {
    fn of(tasks: &'t [TaskTexts]) -> Self {
        let mut index = Self { texts: Vec::new(), by_text: HashMap::new(), by_squashed: HashMap::new() };
        for (k, of) in tasks.iter().enumerate() {
            for text in of.tasks.keys() {
                let next = index.texts.len();
                let (id, values) = index.by_text.entry(text).or_insert((next, Vec::new()));
                values.push(k);
                if *id == next {
                    index.texts.push(text);
                }
                let near = index.by_squashed.entry(squashed(text)).or_default();
                if near.last() != Some(&k) {
                    near.push(k);
                }
            }
        }
        // A text of signs only is near to nothing.
        index.by_squashed.remove("");
        index
    }
}

struct Counter<'i, 't> {
    index: &'i Index<'t>,
    found: HashMap<(usize, usize), Pair>,
    n_with: Vec<usize>,
}

impl Counter<'_, '_> {
    /// Counts the texts of a value of one target.
    fn add(&mut self, compared: usize, mut texts: Vec<String>) {
        if texts.is_empty() {
            return;
        }
        texts.sort_unstable();
        texts.dedup();
        if self.n_with.len() <= compared {
            self.n_with.resize(compared + 1, 0);
        }
        self.n_with[compared] += 1;
        let mut hit = BTreeSet::new();
        let mut near = BTreeSet::new();
        for text in &texts {
            if let Some((id, values)) = self.index.by_text.get(text.as_str()) {
                for value in values {
                    *self.found.entry((compared, *value)).or_default().shared.entry(*id).or_default() += 1;
                    hit.insert(*value);
                }
            }
            near.extend(self.index.by_squashed.get(&squashed(text)).into_iter().flatten());
            let signs = text.char_indices().filter(|(_, c)| !c.is_alphanumeric()).take(MAX_PREFIXES);
            let before = signs.filter_map(|(at, _)| self.index.by_text.get(&text[..at]));
            near.extend(before.flat_map(|(_, values)| values));
        }
        for value in &hit {
            self.found.entry((compared, *value)).or_default().n_hit += 1;
        }
        for value in near.difference(&hit) {
            self.found.entry((compared, *value)).or_default().n_near += 1;
        }
    }
}
