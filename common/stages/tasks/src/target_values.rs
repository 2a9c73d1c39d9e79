//! Values of elements and spaces that rules compare.

use crate::folded::fold;
use crate::links::Target;
use crate::selector::Pattern;
use crate::task_values::parts;
use messages::{AttributeKind, AttributeRecord, NONE, Site};

/// What is compared of an element or space.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum TargetValue {
    GlobalId,
    /// Its entity and the supertypes of that.
    Class,
    Name,
    /// Name or GlobalId of the storey that contains it, or its space.
    Storey,
    /// Name, long name or GlobalId of the space that contains it, or that it is.
    Space,
    /// Names of its zones, or of those of its space.
    Zone,
    /// Names of its groups and systems.
    Group,
    /// Identifications in classification systems.
    Classification,
    /// A property, in all sets or in those that fit.
    Property {
        set: Option<Pattern>,
        name: Pattern,
    },
}

/// Sets in which the site keeps zones, groups and classifications; see [`messages::MEMBERSHIP_SETS`].
const ZONES: &[&str] = &["IfcZone", "IfcSpatialZone"];
const GROUPS: &[&str] = &["IfcGroup", "IfcSystem"];
const CLASSIFICATIONS: &[&str] = &["IfcClassification"];

impl TargetValue {
    /// `Property`, or `Set.Property`; both may have `*` and `?`.
    pub(crate) fn property(text: &str) -> Self {
        match text.split_once('.') {
            Some((set, name)) => Self::Property { set: Some(Pattern::new(set)), name: Pattern::new(name) },
            None => Self::Property { set: None, name: Pattern::new(text) },
        }
    }

    /// The values of a target, folded, without empty ones.
    pub(crate) fn of(&self, site: &Site<'_>, target: Target) -> Vec<String> {
        let whole = |texts: Vec<&str>| texts.into_iter().map(fold).filter(|text| !text.is_empty()).collect();
        let own = attributes(site, target);
        match self {
            Self::GlobalId => whole(vec![global_id(site, target)]),
            Self::Class => whole(classes(site, target)),
            Self::Name => whole(names(site, target)),
            Self::Storey => {
                let storey = storey(site, target).map(|k| &site.storeys[k as usize]);
                whole(storey.map(|s| vec![site.text(s.name), site.text(s.global_id)]).unwrap_or_default())
            }
            Self::Space => whole(space(site, target).map(|k| space_names(site, k)).unwrap_or_default()),
            Self::Zone => {
                let of_space = space(site, target).map(|k| attributes(site, Target::Space(k))).unwrap_or_default();
                own.iter().chain(of_space).filter(|a| is_in(site, a, ZONES)).flat_map(|a| texts(site, a)).collect()
            }
            Self::Group => own.iter().filter(|a| is_in(site, a, GROUPS)).flat_map(|a| texts(site, a)).collect(),
            Self::Classification => {
                own.iter().filter(|a| is_in(site, a, CLASSIFICATIONS)).flat_map(|a| texts(site, a)).collect()
            }
            Self::Property { set, name } => {
                let fits = |a: &&AttributeRecord| {
                    name.fits(&fold(site.text(a.name)))
                        && set.as_ref().is_none_or(|set| set.fits(&fold(site.text(a.set))))
                };
                own.iter().filter(fits).flat_map(|a| texts(site, a)).collect()
            }
        }
    }
}

/// GlobalId of a target.
pub(crate) fn global_id<'s>(site: &Site<'s>, target: Target) -> &'s str {
    match target {
        Target::Element(k) => site.text(site.elements[k as usize].global_id),
        Target::Space(k) => site.text(site.spaces[k as usize].global_id),
    }
}

/// Where a target is in `map`, in metres: the middle of its box, or of its floor; `None` without a body.
pub(crate) fn place_m(site: &Site<'_>, target: Target) -> Option<[f64; 2]> {
    match target {
        Target::Element(k) => {
            let element = &site.elements[k as usize];
            let middle = |axis: usize| f64::from(element.min_tenths[axis] / 2 + element.max_tenths[axis] / 2) * 1e-4;
            (element.n_parts > 0).then(|| [middle(0), middle(1)])
        }
        Target::Space(k) => Some(site.spaces[k as usize].centroid_m).filter(|c| c.iter().all(|x| x.is_finite())),
    }
}

pub(crate) fn attributes<'s>(site: &Site<'s>, target: Target) -> &'s [AttributeRecord] {
    match target {
        Target::Element(k) => site.element_attributes(&site.elements[k as usize]),
        Target::Space(k) => site.space_attributes(&site.spaces[k as usize]),
    }
}

fn classes<'s>(site: &Site<'s>, target: Target) -> Vec<&'s str> {
    match target {
        Target::Element(k) => site.supertypes(&site.elements[k as usize]).collect(),
        Target::Space(_) => vec!["IfcSpace", "IfcSpatialStructureElement", "IfcSpatialElement"],
    }
}

fn names<'s>(site: &Site<'s>, target: Target) -> Vec<&'s str> {
    match target {
        Target::Element(k) => vec![site.text(site.elements[k as usize].name)],
        Target::Space(k) => {
            let space = &site.spaces[k as usize];
            vec![site.text(space.name), site.text(space.long_name)]
        }
    }
}

fn space_names<'s>(site: &Site<'s>, space: u32) -> Vec<&'s str> {
    let mut names = names(site, Target::Space(space));
    names.push(global_id(site, Target::Space(space)));
    names
}

fn space(site: &Site<'_>, target: Target) -> Option<u32> {
    match target {
        Target::Element(k) => Some(site.elements[k as usize].space).filter(|space| *space != NONE),
        Target::Space(k) => Some(k),
    }
}

fn storey(site: &Site<'_>, target: Target) -> Option<u32> {
    let own = match target {
        Target::Element(k) => site.elements[k as usize].storey,
        Target::Space(k) => site.spaces[k as usize].storey,
    };
    let of_space = || space(site, target).map(|k| site.spaces[k as usize].storey);
    Some(own).filter(|k| *k != NONE).or_else(of_space).filter(|k| *k != NONE)
}

fn is_in(site: &Site<'_>, attribute: &AttributeRecord, sets: &[&str]) -> bool {
    sets.contains(&site.text(attribute.set))
}

/// The value of a property as texts; a number is written without a fraction where it has none.
pub(crate) fn texts(site: &Site<'_>, attribute: &AttributeRecord) -> Vec<String> {
    match attribute.kind.get() {
        AttributeKind::Text => parts([site.text(attribute.text)]),
        AttributeKind::Number => vec![attribute.number.to_string()],
        AttributeKind::Boolean => vec![(attribute.number != 0.0).to_string()],
    }
}
