//! The elements of a comparison, which an operator may confirm to be absent.

use daemon::ConfirmedElement;
use messages::{Deviations, ElementDeviationRecord, Observation, Site};
use std::collections::BTreeMap;

/// The elements of the last comparison, by GlobalId.
pub(crate) type ComparedElements = BTreeMap<String, ComparedElement>;

/// An element of a comparison.
#[derive(Debug, Clone)]
pub(crate) struct ComparedElement {
    pub(crate) element: ConfirmedElement,
    pub(crate) observation: Observation,
}

/// The elements of a comparison.
pub(crate) fn compared_elements(site: &Site<'_>, deviations: &Deviations<'_>) -> ComparedElements {
    let storey = site.text(site.map_storeys[deviations.head.map_storey as usize].name);
    let compared = |record: &ElementDeviationRecord| {
        let element = &site.elements[record.element as usize];
        let global_id = site.text(element.global_id).to_owned();
        let element = ConfirmedElement {
            global_id: global_id.clone(),
            ifc_type: site.text(element.ifc_type).to_owned(),
            name: site.text(element.name).to_owned(),
            storey: storey.to_owned(),
            confirmed: None,
        };
        (global_id, ComparedElement { element, observation: record.observation.get() })
    };
    deviations.elements.iter().map(compared).collect()
}
