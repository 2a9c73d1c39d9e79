//! Materials, layers, profiles and constituents, by name or category.

use ifc::Record;

use super::Finding;
use crate::document::MaterialFacet;
use crate::model::Model;

/// Deepest nesting of what a material consists of: usage, set, layer, material.
const DEPTH_MAX: usize = 6;

/// Attributes that name a material or a part of one.
const NAMES: [&str; 3] = ["Name", "LayerSetName", "Category"];

/// Attributes that lead to what a material consists of.
const PARTS: [&str; 8] = [
    "ForLayerSet",
    "ForProfileSet",
    "MaterialLayers",
    "MaterialProfiles",
    "MaterialConstituents",
    "Materials",
    "Material",
    "Layers",
];

pub(super) fn finding(model: &Model<'_>, record: &Record<'_>, facet: &MaterialFacet) -> Finding {
    let own = model.materials_of(record.id);
    let type_object = model.type_of(record.id).filter(|_| own.is_empty());
    let materials = type_object.map_or(own, |type_object| model.materials_of(type_object.id));
    if materials.is_empty() {
        return Finding::Absent("it has no material".to_owned());
    }
    let Some(wanted) = &facet.value else { return Finding::Match };
    let mut names = Vec::new();
    materials.iter().for_each(|id| collect_names(model, *id, 0, &mut names));
    if names.iter().any(|name| wanted.matches_text(name)) {
        return Finding::Match;
    }
    names.sort();
    names.dedup();
    let names = if names.is_empty() { "without a name".to_owned() } else { names.join(", ") };
    Finding::Mismatch(format!("its material is {names}, not {wanted}"))
}

fn collect_names(model: &Model<'_>, id: u32, depth: usize, names: &mut Vec<String>) {
    let Some(record) = model.file.record(id).filter(|_| depth < DEPTH_MAX) else { return };
    names.extend(NAMES.iter().filter_map(|name| model.text(&record, name)));
    for part in PARTS {
        for id in model.attribute(&record, part).references() {
            collect_names(model, id, depth + 1, names);
        }
    }
}
