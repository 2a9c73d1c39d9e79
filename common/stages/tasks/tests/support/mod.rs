//! Sites without geometry, and schedule files that link with them.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]
#![allow(dead_code, reason = "every test file uses a part of this")]

use bytemuck::Zeroable;
use messages::*;
use schedule_files::{PlanFile, PlanTask};
use tasks::{Effect, Link, LinkRules, LinkRulesToml, Links, ScheduleFile, TableLink, Target, link, tasks_of};

/// A site before it is written.
pub(crate) struct Building {
    pub(crate) builder: SiteBuilder,
}

impl Building {
    pub(crate) fn new() -> Self {
        let mut builder = SiteBuilder::default();
        let file = builder.texts.add("site.ifc");
        builder.sources.push(SourceRecord { file, ..SourceRecord::zeroed() });
        Self { builder }
    }

    pub(crate) fn storey(&mut self, name: &str) -> u32 {
        let name = self.builder.texts.add(name);
        self.builder.storeys.push(StoreyRecord { name, global_id: name, map_storey: NONE, ..StoreyRecord::zeroed() });
        self.builder.storeys.len() as u32 - 1
    }

    /// A space whose GlobalId is its name.
    pub(crate) fn space(&mut self, name: &str, storey: u32) -> u32 {
        let name = self.builder.texts.add(name);
        let record = SpaceRecord { global_id: name, name, map_storey: NONE, storey, ..SpaceRecord::zeroed() };
        self.builder.spaces.push(record);
        self.builder.spaces.len() as u32 - 1
    }

    /// An element of this entity whose GlobalId is its name; its middle is at `place_m`.
    pub(crate) fn element(&mut self, entity: &str, name: &str, [storey, space]: [u32; 2], place_m: [f64; 2]) -> usize {
        let supertypes = self.builder.texts.add_list([entity, "IfcElement"]);
        let [ifc_type, name] = [entity, name].map(|text| self.builder.texts.add(text));
        // Every element has a part of its own, which is empty.
        self.builder.parts.push(PartRecord::zeroed());
        let [x, y] = place_m.map(|metres| (metres * 10_000.0) as i32);
        self.builder.elements.push(ElementRecord {
            global_id: name,
            name,
            ifc_type,
            supertypes,
            min_tenths: [x - 1000, y - 1000, 0],
            max_tenths: [x + 1000, y + 1000, 1000],
            first_part: self.builder.parts.len() as u32 - 1,
            n_parts: 1,
            whole: NONE,
            storey,
            space,
            door: NONE,
            stair: NONE,
            ..ElementRecord::zeroed()
        });
        self.builder.elements.len() - 1
    }

    /// An element that is a wall, somewhere.
    pub(crate) fn wall(&mut self, name: &str) -> usize {
        self.element("IfcWall", name, [NONE, NONE], [0.0, 0.0])
    }

    /// Text properties of an element; all of one element in one go.
    pub(crate) fn properties(&mut self, element: usize, properties: &[[&str; 3]]) {
        let first = self.add_properties(properties);
        let record = &mut self.builder.elements[element];
        (record.first_attribute, record.n_attributes) = (first, properties.len() as u32);
    }

    pub(crate) fn space_properties(&mut self, space: u32, properties: &[[&str; 3]]) {
        let first = self.add_properties(properties);
        let record = &mut self.builder.spaces[space as usize];
        (record.first_attribute, record.n_attributes) = (first, properties.len() as u32);
    }

    /// A number as a property of an element that has none.
    pub(crate) fn number(&mut self, element: usize, [set, name]: [&str; 2], number: f64) {
        let [set, name] = [set, name].map(|text| self.builder.texts.add(text));
        let record = &mut self.builder.elements[element];
        (record.first_attribute, record.n_attributes) = (self.builder.attributes.len() as u32, 1);
        let kind = AttributeKind::Number.into();
        self.builder.attributes.push(AttributeRecord { set, name, number, kind, ..AttributeRecord::zeroed() });
    }

    fn add_properties(&mut self, properties: &[[&str; 3]]) -> u32 {
        let first = self.builder.attributes.len() as u32;
        for texts in properties {
            let [set, name, text] = texts.map(|text| self.builder.texts.add(text));
            let kind = AttributeKind::Text.into();
            self.builder.attributes.push(AttributeRecord { set, name, text, kind, ..AttributeRecord::zeroed() });
        }
        first
    }

    pub(crate) fn link(&self, plans: &[ScheduleFile], rules: &LinkRules, table: &[TableLink]) -> Links {
        let bytes = self.builder.finish();
        link(&Site::open(bytes.bytes()).unwrap(), plans, rules, table).unwrap()
    }

    /// Links as `code effect GlobalId`.
    pub(crate) fn linked(&self, plans: &[ScheduleFile], rules: &LinkRules, table: &[TableLink]) -> Vec<String> {
        let bytes = self.builder.finish();
        let site = Site::open(bytes.bytes()).unwrap();
        let tasks: Vec<&PlanTask> = plans.iter().flat_map(|plan| &plan.plan.tasks).collect();
        let line = |l: &Link| {
            let target = match l.target {
                Target::Element(k) => site.text(site.elements[k as usize].global_id),
                Target::Space(k) => site.text(site.spaces[k as usize].global_id),
            };
            format!("{} {} {target}", tasks[l.task].code, l.effect.name())
        };
        link(&site, plans, rules, table).unwrap().links.iter().map(line).collect()
    }

    /// Looks at the site with the tasks of the files in the place of its own, and at the archive of these.
    pub(crate) fn with_tasks<T>(
        &self,
        plans: &[ScheduleFile],
        rules: &LinkRules,
        look: impl FnOnce(&Site<'_>, &Tasks<'_>) -> T,
    ) -> T {
        let bytes = self.builder.finish();
        let site = Site::open(bytes.bytes()).unwrap();
        let links = link(&site, plans, rules, &[]).unwrap();
        let archive = tasks_of(&site, plans, rules, &links).finish();
        let tasks = Tasks::open(archive.bytes()).unwrap();
        look(&site.with_tasks(&tasks).unwrap(), &tasks)
    }
}

/// A schedule file with these tasks.
pub(crate) fn plan(file: &str, tasks: Vec<PlanTask>) -> ScheduleFile {
    ScheduleFile { file: file.to_owned(), sha256: [0; 32], plan: PlanFile { tasks, ..PlanFile::default() } }
}

/// A task of this code, whose id is the same.
pub(crate) fn task(code: &str) -> PlanTask {
    PlanTask { uid: code.to_owned(), code: code.to_owned(), name: format!("Task {code}"), ..PlanTask::default() }
}

/// A task with a field.
pub(crate) fn task_with(code: &str, field: &str, value: &str) -> PlanTask {
    PlanTask { fields: vec![(field.to_owned(), value.to_owned())], ..task(code) }
}

/// Rules of a rules file.
pub(crate) fn rules(text: &str) -> LinkRules {
    LinkRules::of(toml::from_str::<LinkRulesToml>(text).unwrap()).unwrap()
}

/// A row of a table of links.
pub(crate) fn row(line: u64, global_id: &str, task: &str, effect: Effect) -> TableLink {
    TableLink { line, global_id: global_id.to_owned(), task: task.to_owned(), effect }
}
