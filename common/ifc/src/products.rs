//! Selects the elements, spaces, openings and terrains of a file.

use rustc_hash::FxHashMap;

use crate::kernel::{Class, File, Record};
use crate::relations::Relations;
use diagnostics::{DiagnosticCode, Named, Report, Severity};

/// A product with its record at hand.
pub(crate) struct Product<'f, 'a> {
    pub(crate) id: Named,
    pub(crate) record: Record<'a>,
    pub(crate) class: &'f Class,
}

/// The products that make the model, each list by GlobalId.
pub(crate) struct Products<'f, 'a> {
    pub(crate) elements: Vec<Product<'f, 'a>>,
    pub(crate) spaces: Vec<Product<'f, 'a>>,
    pub(crate) openings: Vec<Product<'f, 'a>>,
    /// Sites, roads and parts of roads that have a shape of their own.
    pub(crate) terrains: Vec<Product<'f, 'a>>,
    pub(crate) element_idx: FxHashMap<u32, usize>,
    pub(crate) space_idx: FxHashMap<u32, usize>,
    pub(crate) opening_idx: FxHashMap<u32, usize>,
}

/// Spatial structure whose shape is ground.
const GROUND_STRUCTURE: [&str; 3] = ["IfcSite", "IfcRoad", "IfcRoadPart"];

/// Elements that are nothing by themselves: neither obstacles nor built at a date.
const NO_ELEMENTS: [&str; 2] = ["IfcFeatureElement", "IfcVirtualElement"];

impl<'f, 'a> Products<'f, 'a> {
    pub(crate) fn read(file: &'f File<'a>, relations: &Relations, report: &mut Report) -> Self {
        let mut elements = products(file, "IfcElement", report);
        // Terrain that is an element is also an obstacle where it rises into the slab; the site's own shape is ground alone.
        elements.retain(|p| !NO_ELEMENTS.iter().any(|entity| p.class.is(entity)));
        report_proxies(file, report);
        report_earthworks_cuts(file, relations, report);
        let spaces = products(file, "IfcSpace", report);
        let mut openings = products(file, "IfcOpeningElement", report);
        openings.retain(|p| relations.host.contains_key(&p.record.id));
        let mut terrains: Vec<Product<'_, '_>> =
            GROUND_STRUCTURE.iter().flat_map(|entity| products(file, entity, report)).collect();
        terrains.retain(|p| p.record.at(6).reference().is_some());
        report_repeated_ids(&elements, report);
        let index = |products: &[Product<'_, '_>]| products.iter().enumerate().map(|(i, p)| (p.record.id, i)).collect();
        let (element_idx, space_idx, opening_idx) = (index(&elements), index(&spaces), index(&openings));
        Self { elements, spaces, openings, terrains, element_idx, space_idx, opening_idx }
    }

    /// Elements, spaces, openings, terrains.
    pub(crate) fn all(&self) -> impl Iterator<Item = &Product<'f, 'a>> {
        self.elements.iter().chain(&self.spaces).chain(&self.openings).chain(&self.terrains)
    }
}

/// Elements whose surfaces are ground: their shapes are often named otherwise than `Body`.
const GROUND_ELEMENTS: [&str; 5] =
    ["IfcGeographicElement", "IfcGeotechnicalElement", "IfcPavement", "IfcCourse", "IfcEarthworksElement"];

impl Class {
    /// True for terrain, roads and earthworks.
    pub(crate) fn is_ground(&self) -> bool {
        GROUND_STRUCTURE.iter().chain(&GROUND_ELEMENTS).any(|entity| self.is(entity))
    }
}

/// Identity of an IfcRoot.
pub(crate) fn named(file: &File<'_>, record: &Record<'_>) -> Named {
    Named { step_id: file.written_id(record.id), global_id: record.text(0), name: record.text(2) }
}

fn products<'f, 'a>(file: &'f File<'a>, entity: &str, report: &mut Report) -> Vec<Product<'f, 'a>> {
    let parsed = file.all(entity).into_iter().filter_map(|(span, class)| {
        let record = file.parse(span, report)?;
        Some(Product { id: named(file, &record), record, class })
    });
    parsed.collect()
}

/// An IfcProxy is an object that its exporter could not classify. It is no IfcElement.
fn report_proxies(file: &File<'_>, report: &mut Report) {
    let proxies = products(file, "IfcProxy", report);
    for proxy in proxies.into_iter().filter(|p| p.record.at(6).reference().is_some()) {
        let message = "an IfcProxy is no IfcElement: its shape is not drawn".to_owned();
        report.add(Severity::Warning, DiagnosticCode::ProxyNotDrawn, Some(proxy.id), message);
    }
}

/// A cut of earthworks that voids an element is taken out of its body; one that voids none is nowhere.
fn report_earthworks_cuts(file: &File<'_>, relations: &Relations, report: &mut Report) {
    let cuts = products(file, "IfcEarthworksCut", report);
    let is_left_out =
        |cut: &Product<'_, '_>| cut.record.at(6).reference().is_some() && !relations.host.contains_key(&cut.record.id);
    for cut in cuts.into_iter().filter(is_left_out) {
        let message = "this cut voids no element: it is not taken out of the ground".to_owned();
        report.add(Severity::Warning, DiagnosticCode::EarthworksNotCut, Some(cut.id), message);
    }
}

fn report_repeated_ids(elements: &[Product<'_, '_>], report: &mut Report) {
    let mut seen: FxHashMap<&str, u64> = FxHashMap::default();
    for element in elements {
        if let Some(first) = seen.insert(&element.id.global_id, element.id.step_id) {
            let message = format!("GlobalId {} is used by #{first} as well", element.id.global_id);
            report.add(Severity::Warning, DiagnosticCode::DuplicateGlobalId, Some(element.id.clone()), message);
        }
    }
}
