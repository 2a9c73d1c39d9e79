//! Selects the representations of a product that are its body.
//!
//! `Body`, else `Facetation`, else `Body-Fallback`, else every representation in a model context that is not known to be
//! something else. Of terrain and roads also what is named as a surface, or has faces under the name of something else: no two
//! exporters call it the same. The kernel has a rule of its own, by RepresentationType; where it would choose otherwise it is shown
//! other records.

use rustc_hash::FxHashMap;

use crate::kernel::{File, Patch, Record};

/// Identifiers that never name a body.
const NOT_BODY: [&str; 14] = [
    "axis",
    "footprint",
    "box",
    "clearance",
    "profile",
    "annotation",
    "plan",
    "reference",
    "cog",
    "lighting",
    "walkingline",
    "boundary",
    "surface",
    "symbol",
];

/// Identifiers that do name the faces of terrain where it has no body, in this order.
const GROUND_NAMES: [&str; 4] = ["surface", "footprint", "profile", "reference"];

/// Types that have no faces.
const CURVES: [&str; 8] =
    ["Curve", "Curve2D", "Curve3D", "Point", "PointCloud", "BoundingBox", "Annotation2D", "GeometricCurveSet"];

/// Types that the kernel meshes.
const KERNEL_TYPES: [&str; 12] = [
    "Body",
    "SweptSolid",
    "Brep",
    "CSG",
    "Clipping",
    "Tessellation",
    "MappedRepresentation",
    "SolidModel",
    "SurfaceModel",
    "Surface3D",
    "AdvancedSweptSolid",
    "AdvancedBrep",
];

/// The body of one IfcProductDefinitionShape.
#[derive(Debug, Clone, Default)]
pub(crate) struct Body {
    /// Items of the chosen representations, in file order. Empty: no body.
    pub(crate) items: Vec<u32>,
    /// IfcBoundingBox items of the shape: what to fall back on.
    pub(crate) boxes: Vec<u32>,
    chosen: Vec<Representation>,
    /// Ids of the representations that the kernel would take.
    of_kernel: Vec<u32>,
    shape: u32,
}

#[derive(Debug, Clone)]
struct Representation {
    id: u32,
    context: Option<u32>,
    identifier: String,
    kind: String,
    items: Vec<u32>,
    /// In a context of drawings.
    drawn: bool,
}

/// Bodies of the file's shapes, each chosen once.
pub(crate) struct Bodies<'f, 'a> {
    file: &'f File<'a>,
    known: FxHashMap<u32, Body>,
    drawn: FxHashMap<u32, bool>,
}

impl<'f, 'a> Bodies<'f, 'a> {
    pub(crate) fn new(file: &'f File<'a>) -> Self {
        Self { file, known: FxHashMap::default(), drawn: FxHashMap::default() }
    }

    /// The body of a product; one without items if it has none.
    pub(crate) fn of_product(&mut self, product: &Record<'_>) -> Body {
        self.of_shape(product, choose_body)
    }

    /// The body of terrain, a road or earthworks.
    pub(crate) fn of_ground(&mut self, product: &Record<'_>) -> Body {
        self.of_shape(product, choose_ground)
    }

    fn of_shape(&mut self, product: &Record<'_>, rule: fn(Vec<Representation>) -> Vec<Representation>) -> Body {
        let Some(shape) = product.at(6).reference() else { return Body::default() };
        if !self.known.contains_key(&shape) {
            let body = self.choose(shape, rule);
            self.known.insert(shape, body);
        }
        self.known[&shape].clone()
    }

    fn choose(&mut self, shape: u32, rule: fn(Vec<Representation>) -> Vec<Representation>) -> Body {
        let Some(record) = self.file.record(shape) else { return Body::default() };
        let all: Vec<Representation> =
            record.at(2).references().into_iter().filter_map(|id| self.representation(id)).collect();
        let of_kernel = kernel_choice(&all);
        let is_box = |r: &&Representation| r.kind == "BoundingBox";
        let boxes = all.iter().filter(is_box).flat_map(|r| r.items.iter().copied()).collect();
        let candidates: Vec<Representation> =
            all.into_iter().filter(|r| !r.items.is_empty() && !CURVES.contains(&r.kind.as_str())).collect();
        let chosen = rule(candidates);
        let items = chosen.iter().flat_map(|r| r.items.iter().copied()).collect();
        Body { items, boxes, chosen, of_kernel, shape }
    }

    fn representation(&mut self, id: u32) -> Option<Representation> {
        let record = self.file.record(id)?;
        let context = record.at(0).reference();
        let drawn = context.is_some_and(|context| self.is_drawn(context));
        let identifier = record.text(1).to_ascii_lowercase();
        Some(Representation { id, context, identifier, kind: record.text(2), items: record.at(3).references(), drawn })
    }

    fn is_drawn(&mut self, context: u32) -> bool {
        let file = self.file;
        *self.drawn.entry(context).or_insert_with(|| {
            let Some(record) = file.record(context) else { return false };
            let views = ["PLAN_VIEW", "REFLECTED_PLAN_VIEW", "SECTION_VIEW", "ELEVATION_VIEW"];
            let view = record.is("IFCGEOMETRICREPRESENTATIONSUBCONTEXT").then(|| record.at(8).enumeration()).flatten();
            record.text(1).eq_ignore_ascii_case("plan") || view.is_some_and(|view| views.contains(&view))
        })
    }
}

fn choose_body(candidates: Vec<Representation>) -> Vec<Representation> {
    for wanted in ["body", "facetation", "body-fallback"] {
        let named = |drawn: bool| move |r: &&Representation| r.identifier == wanted && (drawn || !r.drawn);
        for drawn in [false, true] {
            let chosen: Vec<Representation> = candidates.iter().filter(named(drawn)).cloned().collect();
            if !chosen.is_empty() {
                return chosen;
            }
        }
    }
    candidates.into_iter().filter(|r| !r.drawn && !NOT_BODY.contains(&r.identifier.as_str())).collect()
}

fn choose_ground(candidates: Vec<Representation>) -> Vec<Representation> {
    let body = choose_body(candidates.clone());
    if !body.is_empty() {
        return body;
    }
    let named = |wanted: &str| -> Vec<Representation> {
        candidates.iter().filter(|r| !r.drawn && r.identifier == wanted).cloned().collect()
    };
    GROUND_NAMES.iter().map(|wanted| named(wanted)).find(|chosen| !chosen.is_empty()).unwrap_or_default()
}

/// The kernel's rule: by type, by identifier where the type is blank; mapped ones only where there is nothing else.
fn kernel_choice(all: &[Representation]) -> Vec<u32> {
    let kind = |r: &Representation| {
        let identifier = KERNEL_TYPES.iter().find(|k| k.eq_ignore_ascii_case(&r.identifier)).map(|k| (*k).to_owned());
        if r.kind.is_empty() { identifier.unwrap_or_else(|| r.identifier.clone()) } else { r.kind.clone() }
    };
    let admitted = |kind: &str| kind.is_empty() || KERNEL_TYPES.contains(&kind);
    let direct = all.iter().map(kind).any(|k| k != "MappedRepresentation" && KERNEL_TYPES.contains(&k.as_str()));
    all.iter()
        .filter(|r| {
            let kind = kind(r);
            admitted(&kind) && !(kind == "MappedRepresentation" && direct)
        })
        .map(|r| r.id)
        .collect()
}

impl Body {
    /// Shows the kernel what we chose, if it would choose otherwise.
    pub(crate) fn correct(&self, patch: &mut Patch) {
        let chosen: Vec<u32> = self.chosen.iter().map(|r| r.id).collect();
        if chosen == self.of_kernel {
            return;
        }
        patch.replace(self.shape, format!("IFCPRODUCTDEFINITIONSHAPE($,$,({}))", references(&chosen)));
        for representation in &self.chosen {
            let items = references(&representation.items);
            let context = representation.context.map_or("$".to_owned(), |id| format!("#{id}"));
            // A type that the kernel always takes, next to others as well.
            let record = format!("IFCSHAPEREPRESENTATION({context},'Body','SolidModel',({items}))");
            patch.replace(representation.id, record);
        }
    }
}

/// `#1,#2,#3`
pub(crate) fn references(ids: &[u32]) -> String {
    ids.iter().map(|id| format!("#{id}")).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(representations: &[(&str, &str, bool)], expect: &[u32], kernel: &[u32]) {
        let all: Vec<Representation> = (1..)
            .zip(representations)
            .map(|(id, &(identifier, kind, drawn))| Representation {
                id,
                context: None,
                identifier: identifier.to_ascii_lowercase(),
                kind: kind.to_owned(),
                items: vec![id + 100],
                drawn,
            })
            .collect();
        assert_eq!(kernel_choice(&all), kernel, "{representations:?}");
        let candidates = all.into_iter().filter(|r| !CURVES.contains(&r.kind.as_str())).collect();
        let chosen: Vec<u32> = choose_body(candidates).iter().map(|r| r.id).collect();
        assert_eq!(chosen, expect, "{representations:?}");
    }

    #[test]
    fn clearance_is_never_drawn() {
        check(&[("Clearance", "SweptSolid", false)], &[], &[1]);
        check(&[("Body", "SweptSolid", false), ("Clearance", "SweptSolid", false)], &[1], &[1, 2]);
    }

    #[test]
    fn body_wins_over_everything_else_and_all_bodies_count() {
        check(&[("FootPrint", "Curve2D", false), ("Body", "Odd", false)], &[2], &[]);
        check(&[("Body", "Brep", false), ("Body", "MappedRepresentation", false)], &[1, 2], &[1]);
        check(&[("Facetation", "Brep", false), ("Other", "Brep", false)], &[1], &[1, 2]);
        check(&[("Body", "BoundingBox", false), ("Body-Fallback", "Brep", false)], &[2], &[2]);
    }

    #[test]
    fn without_a_body_unknown_representations_count_unless_they_are_drawings() {
        check(&[("Tessellation", "Tessellation", false), ("Solid", "Brep", true)], &[1], &[1, 2]);
        check(&[("Axis", "SweptSolid", false), ("Surface", "SurfaceModel", false)], &[], &[1, 2]);
        check(&[("", "", false)], &[1], &[1]);
    }
}
