//! The elements that are structure at the plan time: those that are sampled as points, and those that occupy cells of an octree.

use export::ExportInput;
use grid::Class;
use messages::{ElementRecord, ElementState, Site, element_flags};
use schemars::JsonSchema;
use serde::Serialize;

/// Elements by class and entity.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Selection {
    /// Classes of elements.
    classes: Vec<Class>,
    /// Entities whose elements are among them, whatever their class.
    entities: &'static [&'static str],
}

/// A name that no class has.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no class {name:?}: the classes are {}", all_names())]
pub struct UnknownClass {
    /// The name.
    name: String,
}

/// Names of the classes of elements.
fn all_names() -> String {
    let names: Vec<&str> = Class::ALL.into_iter().filter(|class| *class != Class::None).map(Class::name).collect();
    names.join(", ")
}

/// Entities beside the usual classes, of the class `other`: what a lidar sees of slabs and walls that it covers, and what carries them.
const ENTITIES: [&str; 2] = ["IfcCovering", "IfcFooting"];

/// Classes where none are given: what stays where it is, and what no one sees through.
const CLASSES: [Class; 7] =
    [Class::Wall, Class::Column, Class::Stair, Class::Ramp, Class::CurtainWall, Class::Slab, Class::Beam];

/// Why an element of the selection is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub(crate) enum LeftOut {
    /// A lidar sees through it.
    Glass,
    /// A box stands in for its body.
    BoundingBox,
    /// It has a body that could not be made.
    NoBody,
    /// Work on it is not finished.
    InProgress,
    /// It is being removed.
    BeingRemoved,
}

impl Selection {
    /// The elements of these classes; the usual ones where there are none.
    ///
    /// # Errors
    /// A class that there is not.
    pub(crate) fn of(classes: &[String]) -> Result<Self, UnknownClass> {
        let class_of = |name: &String| {
            let known = Class::ALL.into_iter().find(|class| *class != Class::None && class.name() == name);
            known.ok_or_else(|| UnknownClass { name: name.clone() })
        };
        let (classes, entities): (_, &[&str]) = match classes {
            [] => (CLASSES.to_vec(), &ENTITIES),
            named => (named.iter().map(class_of).collect::<Result<_, _>>()?, &[]),
        };
        Ok(Self { classes, entities })
    }

    /// True for a class that is selected by name.
    pub(crate) fn has_class(&self, class: Class) -> bool {
        self.classes.contains(&class)
    }

    fn has(&self, site: &Site<'_>, element: &ElementRecord) -> bool {
        self.has_class(element.class()) || self.entities.iter().any(|entity| site.is_a(element, entity))
    }

    /// Elements that are structure, and those of the selection that are left out, with the reason.
    pub(crate) fn structure(&self, input: &ExportInput<'_>) -> (Vec<u32>, Vec<(u32, LeftOut)>) {
        let (mut chosen, mut left_out) = (Vec::new(), Vec::new());
        for (k, element) in input.site.elements.iter().enumerate().filter(|(_, e)| self.has(input.site, e)) {
            let state = input.schedule_state.effective(k);
            let why = match state {
                ElementState::NotStarted | ElementState::Removed => continue,
                _ if element.has(element_flags::FAILED) => LeftOut::NoBody,
                // An assembly of parts that are elements of their own.
                _ if element.n_parts == 0 => continue,
                _ if element.has(element_flags::BOUNDING_BOX) => LeftOut::BoundingBox,
                _ if element.has(element_flags::GLASS) => LeftOut::Glass,
                ElementState::InProgress => LeftOut::InProgress,
                ElementState::BeingRemoved => LeftOut::BeingRemoved,
                ElementState::Built => {
                    chosen.push(k as u32);
                    continue;
                }
            };
            left_out.push((k as u32, why));
        }
        (chosen, left_out)
    }
}
