//! Writes observations into a model: tasks, then elements, then what is no element of it.

use crate::AsBuiltError;
use crate::additional;
use crate::change_list::{ChangeList, FileEntry, NotWritten, WrittenObservation};
use crate::editor::Editor;
use crate::observations::{
    AdditionalElement, ElementFinding, ElementObservation, Observations, Provenance, TaskObservation,
};
use crate::owner_history::OwnerHistory;
use crate::placement::{Dependents, move_element, rounded};
use crate::property_set::{KnownSets, Property};
use crate::step_file::{Instance, Schema, StepFile};
use crate::step_text::{date_text, text};
use crate::tasks::{Built, Progress, add_task, is_task, write_task};
use crate::units::length_unit_m;
use frames::PlanTime;
use nalgebra::Vector3;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;

/// A model with what was observed.
#[derive(Debug, Clone, PartialEq)]
pub struct AsBuilt {
    /// The file.
    pub bytes: Vec<u8>,
    /// What is other than in the model.
    pub changes: ChangeList,
}

/// Writes observations into a model. Names are base names of the files, for the list of changes.
///
/// # Errors
/// No IFC file in STEP of a schema that is written.
pub fn write(
    model: &[u8],
    [model_name, name]: [&str; 2],
    observations: &Observations,
) -> Result<AsBuilt, AsBuiltError> {
    let file = StepFile::of(model)?;
    let mut writer = Writer {
        observations,
        editor: Editor::new(&file),
        owner: OwnerHistory::new(newest(observations)),
        sets: KnownSets::of(&file),
        dependents: None,
        unit_m: None,
        properties: BTreeMap::new(),
        written: Vec::new(),
        not_written: observations.not_written.clone(),
    };
    observations.tasks.iter().for_each(|task| writer.task(task));
    observations.elements.iter().for_each(|element| writer.element(element));
    observations.additional.iter().for_each(|element| writer.additional(element));
    writer.property_sets();
    let Writer { editor, written, not_written, .. } = writer;
    let (bytes, lines) = editor.finish();
    let schema = match file.schema {
        Schema::Ifc2x3 => "IFC2X3",
        Schema::Ifc4 => "IFC4",
        Schema::Ifc4x3 => "IFC4X3",
    };
    let entry = |name: &str, bytes: &[u8]| FileEntry { file: name.to_owned(), sha256: sha256_hex(bytes) };
    let changes = ChangeList {
        model: entry(model_name, model),
        as_built: entry(name, &bytes),
        schema: schema.to_owned(),
        sources: observations.sources.clone(),
        observations: written,
        lines,
        not_written,
    };
    Ok(AsBuilt { bytes, changes })
}

/// sha256 of bytes, in hex.
pub fn sha256_hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The time of the newest observation; 1970 if none has a time.
fn newest(observations: &Observations) -> PlanTime {
    let tasks = observations.tasks.iter().map(|task| (&task.provenance, task.start.max(task.finish)));
    let elements = observations.elements.iter().map(|element| match element.what {
        ElementFinding::Progress { start, finish, .. } => (&element.provenance, start.max(finish)),
        _ => (&element.provenance, None),
    });
    let additional = observations.additional.iter().map(|element| (&element.provenance, None));
    let all = tasks.chain(elements).chain(additional);
    let newest = all.filter_map(|(provenance, at)| provenance.at.max(at)).max();
    newest.or_else(|| PlanTime::from_civil_seconds(0)).unwrap_or(PlanTime::LAST)
}

/// Properties of an object, with the observations that they come from.
#[derive(Default)]
struct ObjectProperties {
    object: u64,
    observations: Vec<usize>,
    values: Vec<Property>,
    provenance: Vec<Provenance>,
    /// It is said whether and when the object came to be: dates of an earlier run that are not among the values hold no more.
    has_dates: bool,
}

/// Property with the hashes of the evidence by which an element was moved.
const MOVED_BY: &str = "DisplacementEvidence";
/// Properties with dates.
const DATES: [&str; 2] = ["ActualStart", "ActualFinish"];

struct Writer<'w, 'a> {
    observations: &'w Observations,
    editor: Editor<'w, 'a>,
    owner: OwnerHistory,
    sets: KnownSets,
    dependents: Option<Dependents>,
    unit_m: Option<Option<f64>>,
    /// By GlobalId.
    properties: BTreeMap<String, ObjectProperties>,
    written: Vec<WrittenObservation>,
    not_written: Vec<NotWritten>,
}

impl<'a> Writer<'_, 'a> {
    fn task(&mut self, task: &TaskObservation) {
        let TaskObservation { global_id, start, finish, completion, provenance } = task;
        let found = self.object(global_id).filter(is_task);
        let Some(found) = found else {
            return self.refuse(provenance, Some(global_id), "the model has no task of this GlobalId");
        };
        let number = self.begin(global_id);
        let progress = Progress { start: *start, finish: *finish, completion: *completion, at: provenance.at };
        match write_task(&mut self.editor, &mut self.owner, &found, &progress) {
            Ok(()) => {
                self.done("task", global_id, provenance, Vec::new());
                let mut values = self.dates(*start, *finish);
                let done = if finish.is_some() { Some(1.0) } else { *completion };
                values.extend(done.map(|done| property("Completion", format!("IFCREAL({})", rounded(done)))));
                self.give((found.id, global_id), number, values, provenance);
            }
            Err(why) => self.refuse(provenance, Some(global_id), &why),
        }
    }

    fn element(&mut self, element: &ElementObservation) {
        let ElementObservation { global_id, what, provenance } = element;
        let found = self.object(global_id).filter(|found| is_product(found));
        let Some(found) = found else {
            return self.refuse(provenance, Some(global_id), "the model has no element of this GlobalId");
        };
        let number = self.begin(global_id);
        let written = match what {
            ElementFinding::Progress { start, finish, needs_task } => {
                self.progress(&found, global_id, [*start, *finish], (*needs_task, provenance))
            }
            ElementFinding::Absent => Ok(("absent", vec![observed("absent")], Vec::new())),
            ElementFinding::Displaced { by_m, deviation_m } => self.displaced(&found, *by_m, *deviation_m, provenance),
        };
        match written {
            Ok((kind, values, notes)) => {
                self.done(kind, global_id, provenance, notes);
                self.give((found.id, global_id), number, values, provenance);
                if let Some(properties) = self.properties.get_mut(global_id) {
                    properties.has_dates |= !matches!(what, ElementFinding::Displaced { .. });
                }
            }
            Err(why) => self.refuse(provenance, Some(global_id), &why),
        }
    }

    fn progress(
        &mut self,
        element: &Instance<'a>,
        global_id: &str,
        [start, finish]: [Option<PlanTime>; 2],
        (needs_task, provenance): (bool, &Provenance),
    ) -> Result<(&'static str, Vec<Property>, Vec<String>), String> {
        let mut notes = Vec::new();
        if needs_task {
            let name = self.editor.argument(element, 2);
            let progress = Progress { start, finish, completion: None, at: provenance.at };
            let built = Built { element: element.id, global_id, name };
            add_task(&mut self.editor, &mut self.owner, &built, &progress)?;
            notes.push("no task of the model builds it: one is added".to_owned());
        }
        let kind = if finish.is_some() { "built" } else { "in_progress" };
        let mut values = vec![observed(kind)];
        // A date that is not known any more is not one of an earlier run.
        values.extend(self.dates(start, finish));
        Ok((kind, values, notes))
    }

    fn displaced(
        &mut self,
        element: &Instance<'a>,
        by_m: [f64; 2],
        deviation_m: f64,
        provenance: &Provenance,
    ) -> Result<(&'static str, Vec<Property>, Vec<String>), String> {
        let evidence = self.observations.sources.get(provenance.source).map(|source| source.sha256.as_str());
        let evidence = evidence.unwrap_or_default();
        let known = |name: &str| self.sets.value(self.editor.file, element.id, name).unwrap_or_default();
        let moved_by = hashes_in(&known(MOVED_BY));
        if moved_by.iter().any(|sha256| sha256 == evidence) {
            return Err("it was moved by this evidence before".to_owned());
        }
        let file = self.editor.file;
        let unit_m = *self.unit_m.get_or_insert_with(|| length_unit_m(file));
        let unit_m = unit_m.ok_or("the model does not define its length unit")?;
        let by = Vector3::new(by_m[0], by_m[1], 0.0) / unit_m;
        let dependents = self.dependents.get_or_insert_with(|| Dependents::of(file));
        let along = move_element(&mut self.editor, &mut self.owner, dependents, element, by)?;
        let notes = match along.as_slice() {
            [] => Vec::new(),
            along => vec![format!("openings, what fills them and parts move along: {}", along.join(", "))],
        };
        let length = |metres: f64| format!("IFCLENGTHMEASURE({})", rounded(metres / unit_m));
        let described = |name, value, description: &str| Property {
            description: Some(description.to_owned()),
            ..property(name, value)
        };
        let [x, y] = by_m.map(length);
        let values = vec![
            observed("displaced"),
            described(
                "Displacement",
                format!("IFCTEXT('{x}, {y}')").replace("IFCLENGTHMEASURE", ""),
                "Along x and y of the world, in units of the file; the placement has it",
            ),
            described("DisplacementDeviation", length(deviation_m), "Standard deviation"),
            described(
                MOVED_BY,
                format!("IFCTEXT({})", text(&[&moved_by[..], &[evidence.to_owned()]].concat().join("; "))),
                "Evidence of all displacements that the placement has, none of which moves it again",
            ),
        ];
        Ok(("displaced", values, notes))
    }

    fn additional(&mut self, element: &AdditionalElement) {
        let provenance = &element.provenance;
        let source = self.observations.sources.get(provenance.source);
        let evidence = source.map(|source| source.sha256.clone()).unwrap_or_default();
        let key = ["additional", evidence.as_str(), provenance.row.as_str()];
        let name = format!("Not in the model: {}", provenance.row);
        self.editor.because_of(&[self.written.len()], None);
        let file = self.editor.file;
        let unit_m = *self.unit_m.get_or_insert_with(|| length_unit_m(file));
        let added = unit_m
            .ok_or_else(|| "the model does not define its length unit".to_owned())
            .and_then(|unit_m| additional::add(&mut self.editor, &mut self.owner, element, (&key, &name), unit_m));
        match added {
            Ok(added) => {
                let number = self.begin(&added.global_id);
                let height = format!(
                    "Seen at the height of the lidar alone, {} m above the floor: the body ends there, what is above is not known",
                    rounded(element.top_z_m - element.bottom_z_m)
                );
                self.done("additional", &added.global_id, provenance, vec![height.clone()]);
                // It stands from when it was seen on.
                let mut values = vec![Property { description: Some(height), ..observed("additional") }];
                values.extend(self.dates(None, provenance.at));
                self.give((added.id, &added.global_id), number, values, provenance);
            }
            Err(why) => self.refuse(provenance, None, &why),
        }
    }

    /// Writes the property sets of all objects.
    fn property_sets(&mut self) {
        let all = std::mem::take(&mut self.properties);
        for (global_id, ObjectProperties { object, observations, mut values, provenance, has_dates }) in all {
            let stale: &[&str] = if has_dates { &DATES } else { &[] };
            let stale: Vec<&str> =
                stale.iter().copied().filter(|name| values.iter().all(|value| value.name != *name)).collect();
            let joined = |texts: Vec<&str>| {
                let mut once: Vec<&str> = Vec::new();
                texts.into_iter().for_each(|text| {
                    if !once.contains(&text) {
                        once.push(text)
                    }
                });
                format!("IFCTEXT({})", text(&once.join("; ")))
            };
            let observers = provenance.iter().map(|p| p.observer.as_str()).collect();
            values.push(property("Observer", joined(observers)));
            if let Some(at) = provenance.iter().filter_map(|p| p.at).max() {
                values.push(property("ObservedAt", self.date(at)));
            }
            let evidence = provenance.iter().filter_map(|p| self.observations.sources.get(p.source));
            values.push(property("EvidenceSha256", joined(evidence.map(|source| source.sha256.as_str()).collect())));
            self.editor.because_of(&observations, Some(&global_id));
            self.sets.write(&mut self.editor, &mut self.owner, (object, &global_id), &values, &stale);
        }
    }

    fn object(&self, global_id: &str) -> Option<Instance<'a>> {
        self.editor.file.instance(self.editor.file.root(global_id)?)
    }

    /// The number of the observation whose changes follow.
    fn begin(&mut self, global_id: &str) -> usize {
        let number = self.written.len();
        self.editor.because_of(&[number], Some(global_id));
        number
    }

    fn done(&mut self, kind: &str, global_id: &str, provenance: &Provenance, notes: Vec<String>) {
        let Provenance { source, row, observer, at } = provenance;
        self.written.push(WrittenObservation {
            kind: kind.to_owned(),
            global_id: global_id.to_owned(),
            source: *source,
            row: row.clone(),
            observer: observer.clone(),
            at: at.map(|at| at.to_string()),
            notes,
        });
    }

    fn refuse(&mut self, provenance: &Provenance, id: Option<&str>, reason: &str) {
        let Provenance { source, row, .. } = provenance;
        let (id, reason) = (id.map(str::to_owned), reason.to_owned());
        self.not_written.push(NotWritten { source: *source, row: row.clone(), id, reason });
    }

    /// Properties that an object gets; the last of a name counts.
    fn give(
        &mut self,
        (object, global_id): (u64, &str),
        observation: usize,
        values: Vec<Property>,
        provenance: &Provenance,
    ) {
        let properties = self.properties.entry(global_id.to_owned()).or_default();
        properties.object = object;
        properties.observations.push(observation);
        properties.provenance.push(provenance.clone());
        for value in values {
            properties.values.retain(|known| known.name != value.name);
            properties.values.push(value);
        }
    }

    fn dates(&self, start: Option<PlanTime>, finish: Option<PlanTime>) -> Vec<Property> {
        DATES.into_iter().zip([start, finish]).filter_map(|(name, at)| Some(property(name, self.date(at?)))).collect()
    }

    /// A date as a value; IFC2X3 has no type for it.
    fn date(&self, at: PlanTime) -> String {
        let kind = if self.editor.file.schema == Schema::Ifc2x3 { "IFCLABEL" } else { "IFCDATETIME" };
        format!("{kind}({})", date_text(at))
    }
}

fn property(name: &'static str, value: String) -> Property {
    Property { name, value, description: None }
}

/// The sha256, in hexadecimal, in a text as STEP writes it.
fn hashes_in(written: &str) -> Vec<String> {
    let is_hash = |word: &&str| word.len() == 64;
    written.split(|c: char| !c.is_ascii_hexdigit()).filter(is_hash).map(str::to_owned).collect()
}

fn observed(what: &str) -> Property {
    property("Observation", format!("IFCLABEL({})", text(what)))
}

/// True for what can be an element: neither relation, nor task, nor what has no place.
fn is_product(instance: &Instance<'_>) -> bool {
    let entity = instance.entity.to_ascii_uppercase();
    let is_other = entity.starts_with("IFCREL") || entity.starts_with("IFCPROPERTY") || entity.ends_with("TYPE");
    !is_other && !is_task(instance) && instance.arguments.len() > crate::placement::OBJECT_PLACEMENT + 1
}
