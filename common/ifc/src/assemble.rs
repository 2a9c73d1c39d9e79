//! Builds the `Model` of a file from its parts.

use nalgebra::Affine3;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::affine::placement;
use crate::kernel::{File, Record};
use crate::materials::Materials;
use crate::placement::Placements;
use crate::product_body::ProductBody;
use crate::products::{Product, Products};
use crate::property_sets::PropertySets;
use crate::relations::Relations;
use crate::representations::{Bodies, Body};
use crate::spatial::Storeys;
use crate::units::LengthUnit;
use crate::{
    Element, Geometry, GeometryStatus, Model, Opening, Progress, ReadError, ReadOptions, Source, Space, SpaceBoundary,
    Stage, Terrain, doors, geometry, georeference, memberships, schedule, spatial, stairs, units,
};
use diagnostics::{DiagnosticCode, Report, Severity};

/// An aggregation deeper than this is not followed.
const PARTS_DEPTH_MAX: usize = 16;

/// Reads the model of a file.
pub(crate) fn model(
    file: &File<'_>,
    schema: String,
    options: &ReadOptions<'_>,
    report: &mut Report,
) -> Result<Model, ReadError> {
    let relations = Relations::read(file, report);
    let products = Products::read(file, &relations, report);
    let mut bodies = Bodies::new(file);
    let voids = voids(file, &relations);
    let doors = doors_of_openings(&relations, &products);
    let bodied: Vec<ProductBody<'_, '_>> = products
        .all()
        .map(|product| ProductBody {
            id: &product.id,
            record: &product.record,
            // Reinforcement is built at a date, but lies inside what it reinforces: it is not meshed.
            body: if product.class.is("IfcReinforcingElement") {
                Body::default()
            } else if product.class.is_ground() {
                bodies.of_ground(&product.record)
            } else {
                bodies.of_product(&product.record)
            },
            openings: voids.get(&product.record.id).map_or(&[], Vec::as_slice),
            is_ground: product.class.is_ground(),
            cuts: product.class.is("IfcOpeningElement"),
            doors: doors.get(&product.record.id).map_or(&[], Vec::as_slice),
        })
        .collect();
    let unit = unit(file, bodied.iter().any(|b| !b.body.items.is_empty()), report)?;
    let unit_m = unit.as_ref().map_or(0.0, |unit| unit.metres);
    let mut placements = Placements::new(file, unit_m);
    let frames = frames(&products, unit.is_some().then_some(&mut placements), report);
    let storeys = spatial::storeys(file, unit.is_some().then_some(&mut placements), unit_m, report);
    options.report(Progress { stage: Stage::Reading, done: 1, total: 1, waits_for: None });
    let mut geometries = geometry::mesh(file, unit.as_ref(), &bodied, &frames, options, report)?;
    let finder = Storeys::new(file, &storeys, &relations);
    let mut reader = Reader {
        file,
        unit_m,
        relations: &relations,
        products: &products,
        storeys: &finder,
        frames: &frames,
        psets: PropertySets::new(file),
        materials: Materials::new(file),
    };
    let mut geometry = |id: u32| geometries.remove(&id).unwrap_or_default();
    let mut elements: Vec<Element> = std::iter::zip(&products.elements, &bodied)
        .map(|(product, bodied)| reader.element(product, &bodied.body.items, geometry(product.record.id)))
        .collect();
    fill_by_parts(&mut elements);
    let wholes: FxHashSet<u32> =
        products.spaces.iter().filter_map(|space| relations.whole.get(&space.record.id).copied()).collect();
    let mut spaces: Vec<Space> =
        products.spaces.iter().map(|p| reader.space(p, &wholes, geometry(p.record.id))).collect();
    memberships::add(file, &relations, &products, &mut elements, &mut spaces, report);
    let terrains = products.terrains.iter().map(|p| reader.terrain(p, geometry(p.record.id)));
    let terrains = terrains.filter(|terrain| terrain.geometry.status != GeometryStatus::None).collect();
    let openings = products.openings.iter().map(|p| reader.opening(p, geometry(p.record.id))).collect();
    let schedule = schedule::read(file, &relations, &products, &storeys, report);
    Ok(Model {
        source: Source { schema, length_unit_m: unit_m },
        georeference: georeference::read(file, &relations, unit.as_ref(), report),
        container: spatial::container(file, report),
        storeys,
        elements,
        spaces,
        openings,
        terrains,
        boundaries: boundaries(&relations, &products),
        schedule,
    })
}

/// Element -> its openings, in their order: the body depends on it.
fn voids(file: &File<'_>, relations: &Relations) -> FxHashMap<u32, Vec<u32>> {
    let mut voids: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    for (opening, _) in file.all("IfcFeatureElementSubtraction") {
        if let Some(&host) = relations.host.get(&opening.id) {
            voids.entry(host).or_default().push(opening.id);
        }
    }
    voids
}

/// Opening of a wall -> the doors that fill it, then the parts of doors that do.
fn doors_of_openings(relations: &Relations, products: &Products<'_, '_>) -> FxHashMap<u32, Vec<u32>> {
    let is_a = |id: u32, entity: &str| {
        products.element_idx.get(&id).is_some_and(|&index| products.elements[index].class.is(entity))
    };
    let mut doors: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    let mut parts: Vec<u32> = products.elements.iter().map(|product| product.record.id).collect();
    parts.sort_by_key(|&id| !is_a(id, "IfcDoor"));
    for part in parts {
        let whole = |id: &u32| relations.whole.get(id).copied();
        let door = std::iter::successors(Some(part), whole).take(PARTS_DEPTH_MAX).find(|&id| is_a(id, "IfcDoor"));
        let opening = door.and_then(|door| relations.fills.get(&door).or_else(|| relations.fills.get(&part)));
        if let Some(&opening) = opening
            && relations.host.get(&opening).is_some_and(|&host| is_a(host, "IfcWall"))
        {
            doors.entry(opening).or_default().push(part);
        }
    }
    doors
}

/// A door of which a part fills an opening fills it.
fn fill_by_parts(elements: &mut [Element]) {
    for part in 0..elements.len() {
        let (Some(opening), None) = (elements[part].fills, &elements[part].door) else { continue };
        let wholes = std::iter::successors(elements[part].whole, |&whole| elements[whole].whole);
        let door = wholes.take(PARTS_DEPTH_MAX).find(|&whole| elements[whole].door.is_some());
        if let Some(door) = door {
            elements[door].fills.get_or_insert(opening);
            elements[part].fills = None;
        }
    }
}

/// The length unit; a file without one is refused if it has geometry.
fn unit(file: &File<'_>, has_geometry: bool, report: &mut Report) -> Result<Option<LengthUnit>, ReadError> {
    match units::length_unit(file) {
        Ok(unit) => Ok(Some(unit)),
        Err(why) if has_geometry => Err(ReadError::UnknownLengthUnit { why }),
        Err(why) => {
            let message = format!("the length unit is unknown ({why}); there is no geometry that needs it");
            report.add(Severity::Warning, DiagnosticCode::LengthUnitUnknown, None, message);
            Ok(None)
        }
    }
}

/// Placements of all products in the world.
fn frames(
    products: &Products<'_, '_>,
    placements: Option<&mut Placements<'_, '_>>,
    report: &mut Report,
) -> FxHashMap<u32, Affine3<f64>> {
    let Some(placements) = placements else { return FxHashMap::default() };
    let mut frames = FxHashMap::default();
    for product in products.all() {
        match placements.of_product(&product.record) {
            Ok(frame) => drop(frame.map(|frame| frames.insert(product.record.id, frame))),
            Err(why) => {
                report.add(Severity::Error, DiagnosticCode::PlacementUnusable, Some(product.id.clone()), why.to_owned())
            }
        }
    }
    frames
}

fn boundaries(relations: &Relations, products: &Products<'_, '_>) -> Vec<SpaceBoundary> {
    let index = |&(space, element): &(u32, u32)| {
        let (space, element) = (products.space_idx.get(&space)?, products.element_idx.get(&element)?);
        Some(SpaceBoundary { space: *space, element: *element })
    };
    let mut boundaries: Vec<SpaceBoundary> = relations.boundaries.iter().filter_map(index).collect();
    boundaries.sort_unstable();
    boundaries.dedup();
    boundaries
}

/// Shared inputs of reading products.
struct Reader<'r, 'f, 'a> {
    file: &'f File<'a>,
    unit_m: f64,
    relations: &'r Relations,
    products: &'r Products<'f, 'a>,
    storeys: &'r Storeys<'r>,
    frames: &'r FxHashMap<u32, Affine3<f64>>,
    psets: PropertySets<'f, 'a>,
    materials: Materials<'f, 'a>,
}

impl Reader<'_, '_, '_> {
    fn element(&mut self, product: &Product<'_, '_>, items: &[u32], geometry: Geometry) -> Element {
        let (record, relations) = (&product.record, self.relations);
        let frame = self.frames.get(&record.id).copied();
        let door = product.class.is("IfcDoor");
        let stair = product.class.is("IfcStairFlight") || product.class.is("IfcStair");
        let element = |id: &u32| self.products.element_idx.get(id).copied();
        let opening = |id: &u32| self.products.opening_idx.get(id).copied();
        Element {
            id: product.id.clone(),
            ifc_type: product.class.lineage[0],
            supertypes: product.class.lineage.clone(),
            predefined_type: self.predefined_type(record),
            object_type: self.object_type(record),
            storey: self.storeys.of(record.id),
            space: relations.container.get(&record.id).and_then(|id| self.products.space_idx.get(id).copied()),
            whole: relations.whole.get(&record.id).and_then(element),
            fills: relations.fills.get(&record.id).and_then(opening),
            placement: frame.as_ref().and_then(placement),
            geometry,
            door: door.then(|| doors::read(self.file, record, relations, frame, items, self.unit_m)),
            stair: stair.then(|| stairs::read(self.file, record, self.unit_m)).flatten(),
            properties: self.psets.of(record.id, relations),
            materials: self.materials.of(record.id, relations),
        }
    }

    fn terrain(&self, product: &Product<'_, '_>, geometry: Geometry) -> Terrain {
        Terrain {
            id: product.id.clone(),
            ifc_type: product.class.lineage[0],
            predefined_type: self.predefined_type(&product.record),
            geometry,
        }
    }

    fn space(&mut self, product: &Product<'_, '_>, wholes: &FxHashSet<u32>, geometry: Geometry) -> Space {
        let record = &product.record;
        let kind = ["PredefinedType", "InteriorOrExteriorSpace"]
            .into_iter()
            .find_map(|name| self.file.attribute(record, name).enumeration());
        let kind = match kind {
            Some(kind) if !kind.eq_ignore_ascii_case("USERDEFINED") => kind.to_owned(),
            _ => self.predefined_type(record),
        };
        Space {
            id: product.id.clone(),
            long_name: self.file.attribute(record, "LongName").text().unwrap_or_default().trim().to_owned(),
            predefined_type: kind,
            object_type: self.object_type(record),
            has_parts: wholes.contains(&record.id),
            storey: self.storeys.of(record.id),
            has_boundaries: self.relations.bounded.contains(&record.id),
            geometry,
            properties: self.psets.of(record.id, self.relations),
        }
    }

    /// ObjectType of the occurrence, else the name of its type; of elements and spaces.
    fn object_type(&self, record: &Record<'_>) -> String {
        let type_record = self.relations.type_of.get(&record.id).and_then(|&id| self.file.record(id));
        let text = |record: &Record<'_>, name: &str| {
            self.file.attribute(record, name).text().map(|t| t.trim().to_owned()).filter(|t| !t.is_empty())
        };
        text(record, "ObjectType").or_else(|| text(&type_record?, "Name")).unwrap_or_default()
    }

    fn opening(&self, product: &Product<'_, '_>, geometry: Geometry) -> Opening {
        let element = |id: &u32| self.products.element_idx.get(id).copied();
        let id = product.record.id;
        Opening {
            id: product.id.clone(),
            host: self.relations.host.get(&id).and_then(element),
            filling: self.relations.filling.get(&id).and_then(element),
            geometry,
        }
    }

    /// Of the occurrence, else of its type; the text where that is user-defined.
    fn predefined_type(&self, record: &Record<'_>) -> String {
        let own = self.defined(record, "ObjectType");
        if own.as_deref().is_some_and(|kind| kind != "NOTDEFINED") {
            return own.unwrap_or_default();
        }
        let type_record = self.relations.type_of.get(&record.id).and_then(|&id| self.file.record(id));
        type_record.and_then(|record| self.defined(&record, "ElementType")).or(own).unwrap_or_default()
    }

    fn defined(&self, record: &Record<'_>, text: &str) -> Option<String> {
        let kind = self.file.attribute(record, "PredefinedType").enumeration()?.to_ascii_uppercase();
        let said = || self.file.attribute(record, text).text().map(|t| t.trim().to_owned()).filter(|t| !t.is_empty());
        Some(if kind == "USERDEFINED" { said().unwrap_or(kind) } else { kind })
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{BASICS, file, read};
    use crate::{GeometryStatus, ReadError};

    const WALL: &str = "#1=IFCWALL('wall',$,'W',$,$,#103,#121,$,.STANDARD.);";

    #[test]
    fn unknown_length_unit_is_an_error() {
        let text = file(&format!("{BASICS}{WALL}")).replace("(#105,#106)", "(#106)");
        assert!(matches!(read(&text), Err(ReadError::UnknownLengthUnit { .. })));
    }

    #[test]
    fn without_geometry_the_length_unit_does_not_matter() {
        let (model, diagnostics) = read(&file(BASICS).replace("(#105,#106)", "(#106)")).unwrap();
        assert!(model.source.length_unit_m == 0.0);
        assert_eq!(diagnostics[0].code.name(), "length_unit_unknown");
    }

    #[test]
    fn a_conversion_factor_beats_the_name_of_the_unit() {
        let inch =
            "#105=IFCCONVERSIONBASEDUNIT(#130,.LENGTHUNIT.,'INCH',#131);#130=IFCDIMENSIONALEXPONENTS(1,0,0,0,0,0,0);
            #131=IFCMEASUREWITHUNIT(IFCREAL(0.5),#132);#132=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);";
        let text = file(&format!("{BASICS}{WALL}")).replace("#105=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);", inch);
        let (model, _) = read(&text).unwrap();
        let part = &model.elements[0].geometry.parts[0];
        let z = part.positions_m.iter().map(|p| p[2]).fold(f32::MIN, f32::max);
        assert!((part.origin_m[2] + f64::from(z) - 1.5).abs() < 1e-6, "{part:?}");
    }

    #[test]
    fn openings_are_no_elements_reinforcement_has_no_body_and_aggregates_are_elements() {
        let (model, _) = read(&file(&format!(
            "{BASICS}{WALL}
             #3=IFCREINFORCINGBAR('b',$,$,$,$,#103,#121,$,$,$,$,$,$,$);#4=IFCVIRTUALELEMENT('v',$,$,$,$,#103,#121,$);
             #5=IFCOPENINGELEMENT('o',$,$,$,$,#103,#121,$,$);#6=IFCCURTAINWALL('c',$,$,$,$,#103,$,$,$);
             #7=IFCBUILDINGELEMENTPROXY('p',$,$,$,'Kiosk',#103,#121,$,.USERDEFINED.);#8=IFCGRID('g',$,$,$,$,#103,$,$,$,$,$);"
        )))
        .unwrap();
        let found: Vec<(&str, bool)> =
            model.elements.iter().map(|e| (e.ifc_type, e.geometry.status == GeometryStatus::Meshed)).collect();
        let expected = [
            ("IfcReinforcingBar", false),
            ("IfcCurtainWall", false),
            ("IfcBuildingElementProxy", true),
            ("IfcWall", true),
        ];
        assert_eq!(found, expected);
        assert_eq!(model.elements[2].predefined_type, "Kiosk");
        assert!(model.openings.is_empty(), "it voids nothing");
    }

    #[test]
    fn boundaries_join_spaces_and_elements_once() {
        let (model, _) = read(&file(&format!(
            "{BASICS}{WALL}#2=IFCSPACE('s',$,$,$,$,#103,#121,$,.ELEMENT.,.SPACE.,$);
             #3=IFCRELSPACEBOUNDARY('a',$,$,$,#2,#1,$,.PHYSICAL.,.INTERNAL.);
             #4=IFCRELSPACEBOUNDARY2NDLEVEL('b',$,$,$,#2,#1,$,.PHYSICAL.,.INTERNAL.,$,$);
             #5=IFCRELSPACEBOUNDARY('c',$,$,$,#2,#999,$,.PHYSICAL.,.INTERNAL.);#6=IFCTASK('t',$,$,$,$,$,$,$,$,.F.,$,$,$);"
        )))
        .unwrap();
        assert_eq!(model.boundaries.len(), 1);
        assert_eq!((model.boundaries[0].space, model.boundaries[0].element), (0, 0));
        assert_eq!(model.schedule.tasks.len(), 1);
        assert_eq!(model.spaces[0].geometry.status, GeometryStatus::Meshed);
    }
}
