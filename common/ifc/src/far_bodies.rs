//! Bodies far from the origin of their product's frame, as with coordinates of a national grid in their points: the kernel is shown
//! them near it.
//!
//! Where coordinates of a body are large the kernel does not cut it, and rounds swept solids to a quarter of a metre; large
//! placements lose nothing. Therefore all that
//! places the body in the product's frame is moved by whole units, and the product's placement by the same the other way: where
//! it is in the world stays as it is. Each body is moved by its own distance, so that openings and hosts may have frames that
//! are turned against each other. Moved are the products alone, not the placements that others are relative to.
//!
//! A body of which an entity is not known here stays where it is, and so do those that share its items. The kernel has one origin
//! for the whole file, near most of its first products; what is far from that may not be cut either. A door is judged by what
//! is left of its wall, so that it is closed then.

use rustc_hash::{FxHashMap, FxHashSet};
use std::borrow::Cow;
use std::cell::RefCell;

use crate::affine::axes;
use crate::boolean_chain::is_boolean;
use crate::bounding_boxes::mapped_items;
use crate::kernel::{File, Patch, Record, members};
use crate::placement::{axis2_placement, operator};
use crate::product_body::ProductBody;
use crate::representations::references;
use nalgebra::Vector3;

/// A body this far from the origin of its frame is moved, in metres: the kernel's own bound for large coordinates.
const FAR_M: f64 = 1_000.0;

/// Items that the kernel meshes exactly wherever they are, as long as nothing cuts them.
const EXACT: [&str; 9] = [
    "IFCTRIANGULATEDFACESET",
    "IFCTRIANGULATEDIRREGULARNETWORK",
    "IFCPOLYGONALFACESET",
    "IFCFACETEDBREP",
    "IFCFACETEDBREPWITHVOIDS",
    "IFCADVANCEDBREP",
    "IFCADVANCEDBREPWITHVOIDS",
    "IFCSHELLBASEDSURFACEMODEL",
    "IFCFACEBASEDSURFACEMODEL",
];

/// Deepest nesting of the records of an item.
const DEPTH_MAX: usize = 300;

/// Most records that are looked at for the place of an item; ordinary ones take ten.
const STEPS_MAX: usize = 300;

/// Most bytes of copies, as a multiple of those of the file. Items of one group take less than all records; more come of many
/// bodies of which each has the same large part.
const COPIES_MAX: usize = 4;

/// Bodies that are moved.
pub(crate) struct FarBodies<'p, 'a> {
    groups: Vec<Group<'p, 'a>>,
    unit_m: f64,
}

/// Products that share items.
struct Group<'p, 'a> {
    products: Vec<&'p Record<'a>>,
    items: Vec<u32>,
    /// Where the bodies lie in their products' frames, in whole units of the file.
    middle: Vector3<f64>,
}

/// What of a record places it in the frame that it is given in.
enum Placed {
    /// Its own coordinates.
    Point,
    /// A list of coordinates.
    Points,
    /// Nothing: a direction.
    Nowhere,
    /// What these arguments refer to.
    By(&'static [usize]),
    /// What any argument refers to.
    ByAll,
    /// A position, which may be missing, the arguments that are given in its frame, and others that are not.
    InPosition(usize, &'static [usize], &'static [usize]),
    /// The target of an IfcMappedItem, and what is mapped.
    Mapped,
}

impl Placed {
    /// `None` for what is not known here.
    fn of(keyword: &str) -> Option<Self> {
        Some(match keyword {
            "IFCCARTESIANPOINT" => Self::Point,
            "IFCCARTESIANPOINTLIST2D" | "IFCCARTESIANPOINTLIST3D" => Self::Points,
            "IFCDIRECTION" | "IFCVECTOR" => Self::Nowhere,
            "IFCEXTRUDEDAREASOLID" => Self::InPosition(1, &[0], &[]),
            "IFCEXTRUDEDAREASOLIDTAPERED" => Self::InPosition(1, &[0, 4], &[]),
            "IFCREVOLVEDAREASOLID" => Self::InPosition(1, &[0, 2], &[]),
            "IFCREVOLVEDAREASOLIDTAPERED" => Self::InPosition(1, &[0, 2, 4], &[]),
            "IFCSURFACECURVESWEPTAREASOLID"
            | "IFCFIXEDREFERENCESWEPTAREASOLID"
            | "IFCSURFACEOFLINEAREXTRUSION"
            | "IFCSURFACEOFREVOLUTION" => Self::InPosition(1, &[], &[]),
            "IFCMAPPEDITEM" => Self::Mapped,
            "IFCAXIS1PLACEMENT"
            | "IFCAXIS2PLACEMENT2D"
            | "IFCAXIS2PLACEMENT3D"
            | "IFCPLANE"
            | "IFCCYLINDRICALSURFACE"
            | "IFCSPHERICALSURFACE"
            | "IFCTOROIDALSURFACE"
            | "IFCCIRCLE"
            | "IFCELLIPSE"
            | "IFCPCURVE"
            | "IFCRECTANGULARTRIMMEDSURFACE"
            | "IFCCURVEBOUNDEDPLANE"
            | "IFCHALFSPACESOLID"
            | "IFCBOUNDINGBOX"
            | "IFCBLOCK"
            | "IFCRECTANGULARPYRAMID"
            | "IFCRIGHTCIRCULARCONE"
            | "IFCRIGHTCIRCULARCYLINDER"
            | "IFCSPHERE"
            | "IFCTRIANGULATEDFACESET"
            | "IFCTRIANGULATEDIRREGULARNETWORK"
            | "IFCPOLYGONALFACESET"
            | "IFCINDEXEDPOLYCURVE" => Self::By(&[0]),
            "IFCBOXEDHALFSPACE" => Self::By(&[0, 2]),
            "IFCCARTESIANTRANSFORMATIONOPERATOR2D"
            | "IFCCARTESIANTRANSFORMATIONOPERATOR2DNONUNIFORM"
            | "IFCCARTESIANTRANSFORMATIONOPERATOR3D"
            | "IFCCARTESIANTRANSFORMATIONOPERATOR3DNONUNIFORM"
            | "IFCRECTANGLEPROFILEDEF"
            | "IFCROUNDEDRECTANGLEPROFILEDEF"
            | "IFCRECTANGLEHOLLOWPROFILEDEF"
            | "IFCCIRCLEPROFILEDEF"
            | "IFCCIRCLEHOLLOWPROFILEDEF"
            | "IFCELLIPSEPROFILEDEF"
            | "IFCTRAPEZIUMPROFILEDEF"
            | "IFCISHAPEPROFILEDEF"
            | "IFCASYMMETRICISHAPEPROFILEDEF"
            | "IFCLSHAPEPROFILEDEF"
            | "IFCTSHAPEPROFILEDEF"
            | "IFCUSHAPEPROFILEDEF"
            | "IFCCSHAPEPROFILEDEF"
            | "IFCZSHAPEPROFILEDEF" => Self::By(&[2]),
            "IFCDERIVEDPROFILEDEF" => Self::By(&[3]),
            "IFCPOLYGONALBOUNDEDHALFSPACE" => Self::InPosition(2, &[3], &[0]),
            "IFCFACETEDBREP"
            | "IFCFACETEDBREPWITHVOIDS"
            | "IFCADVANCEDBREP"
            | "IFCADVANCEDBREPWITHVOIDS"
            | "IFCMANIFOLDSOLIDBREP"
            | "IFCCLOSEDSHELL"
            | "IFCOPENSHELL"
            | "IFCCONNECTEDFACESET"
            | "IFCSHELLBASEDSURFACEMODEL"
            | "IFCFACEBASEDSURFACEMODEL"
            | "IFCFACE"
            | "IFCFACESURFACE"
            | "IFCADVANCEDFACE"
            | "IFCFACEBOUND"
            | "IFCFACEOUTERBOUND"
            | "IFCPOLYLOOP"
            | "IFCEDGELOOP"
            | "IFCVERTEXLOOP"
            | "IFCORIENTEDEDGE"
            | "IFCEDGE"
            | "IFCEDGECURVE"
            | "IFCVERTEXPOINT"
            | "IFCPOLYLINE"
            | "IFCCOMPOSITECURVE"
            | "IFCCOMPOSITECURVESEGMENT"
            | "IFCTRIMMEDCURVE"
            | "IFCLINE"
            | "IFCSURFACECURVE"
            | "IFCSEAMCURVE"
            | "IFCINTERSECTIONCURVE"
            | "IFCBSPLINECURVE"
            | "IFCBSPLINECURVEWITHKNOTS"
            | "IFCRATIONALBSPLINECURVEWITHKNOTS"
            | "IFCBSPLINESURFACEWITHKNOTS"
            | "IFCRATIONALBSPLINESURFACEWITHKNOTS"
            | "IFCSWEPTDISKSOLID"
            | "IFCSWEPTDISKSOLIDPOLYGONAL"
            | "IFCBOOLEANRESULT"
            | "IFCBOOLEANCLIPPINGRESULT"
            | "IFCCSGSOLID"
            | "IFCARBITRARYCLOSEDPROFILEDEF"
            | "IFCARBITRARYPROFILEDEFWITHVOIDS"
            | "IFCARBITRARYOPENPROFILEDEF"
            | "IFCCENTERLINEPROFILEDEF"
            | "IFCCOMPOSITEPROFILEDEF" => Self::ByAll,
            _ => return None,
        })
    }

    fn has(&self, argument: usize) -> bool {
        match self {
            Self::By(arguments) => arguments.contains(&argument),
            Self::ByAll => true,
            _ => false,
        }
    }
}

impl<'p, 'a> FarBodies<'p, 'a> {
    /// Finds the bodies that are far and that the kernel would cut or mesh wrongly there, openings included.
    pub(crate) fn of(file: &File<'a>, products: &'p [ProductBody<'p, 'a>], unit_m: f64) -> Self {
        let records = Records::new(file, FxHashMap::default(), unit_m);
        let parts = parts_of_cut(file, products);
        let is_lost = |product: &ProductBody<'_, '_>| {
            let is_cut = product.cuts || !product.openings.is_empty() || parts.contains(&product.record.id);
            is_cut || !product.body.items.iter().all(|item| has_keyword(file, *item, &EXACT))
        };
        let middle_of = |product: &ProductBody<'_, '_>| {
            let starts = product.body.items.iter().filter_map(|item| records.start(*item, &mut steps()));
            starts.into_iter().find(|start| records.is_far(start)).map(|start| start.map(f64::round))
        };
        let far: Vec<(usize, Vector3<f64>)> = (products.iter().enumerate())
            .filter(|(_, product)| is_lost(product))
            .filter_map(|(k, product)| Some((k, middle_of(product)?)))
            .collect();
        if far.is_empty() {
            return Self { groups: Vec::new(), unit_m };
        }
        let (mut users, mut inner): (FxHashMap<u32, Vec<usize>>, _) = (FxHashMap::default(), FxHashSet::default());
        for (k, product) in products.iter().enumerate() {
            for &item in &product.body.items {
                users.entry(item).or_default().push(k);
                inner_items(file, item, 0, &mut inner);
            }
        }
        let (mut groups, mut met) = (Vec::new(), FxHashSet::default());
        for (first, middle) in far {
            let (mut waiting, mut items, mut of_group) = (vec![first], Vec::new(), Vec::new());
            while let Some(k) = waiting.pop() {
                if met.insert(k) {
                    of_group.push(products[k].record);
                    items.extend(&products[k].body.items);
                    let items = products[k].body.items.iter();
                    waiting.extend(items.filter_map(|item| users.remove(item)).flatten());
                }
            }
            items.sort_unstable();
            items.dedup();
            // What is also a part of another item would move there as well.
            if !of_group.is_empty() && !items.iter().any(|item| inner.contains(item)) {
                groups.push(Group { products: of_group, items, middle });
            }
        }
        Self { groups, unit_m }
    }

    /// The patch with the bodies near the origins of their frames.
    pub(crate) fn brought_near<'q>(&self, file: &File<'_>, patch: &'q Patch) -> Cow<'q, Patch> {
        if self.groups.is_empty() {
            return Cow::Borrowed(patch);
        }
        let mut records = Records::new(file, patch.by_id(), self.unit_m);
        for style in file.all("IfcStyledItem").into_iter().filter_map(|(span, _)| file.record(span.id)) {
            if let Some(item) = style.at(0).reference() {
                records.styles.entry(item).or_default().push(style.id);
            }
        }
        let mut copies = Copies {
            records: &records,
            patch: patch.clone(),
            known: FxHashMap::default(),
            n_bytes_left: COPIES_MAX * file.bytes.len(),
        };
        for group in &self.groups {
            if let Some(Replacements { items, products }) = group.moved(&mut copies) {
                items.into_iter().for_each(|(id, record)| copies.patch.replace(id, record));
                products.into_iter().for_each(|(id, record)| copies.patch.replace_in_place(id, record));
            }
        }
        Cow::Owned(copies.patch)
    }
}

/// Records of the items and products of a group.
struct Replacements {
    items: Vec<(u32, String)>,
    products: Vec<(u32, String)>,
}

impl Group<'_, '_> {
    fn moved(&self, copies: &mut Copies<'_, '_, '_>) -> Option<Replacements> {
        let records = copies.records;
        let moved = |item: &u32| Some((*item, copies.moved(*item, self.middle, 0)?));
        let items = self.items.iter().map(moved).collect::<Option<Vec<_>>>()?;
        let frame = copies.frame(self.middle)?;
        let mut products = Vec::new();
        for product in &self.products {
            // A product that is replaced has another body there.
            if records.replaced.contains_key(&product.id) {
                continue;
            }
            let placement = product.at(5).reference();
            if placement.is_some_and(|id| records.file.record_of(id, "IFCLOCALPLACEMENT").is_none()) {
                return None;
            }
            let (keyword, arguments) = records.file.bytes_of(product.id)?;
            let mut arguments: Vec<Cow<'_, str>> =
                members(arguments).into_iter().map(String::from_utf8_lossy).collect();
            let whole = arguments.get(5)?.clone();
            let placement = copies.add(format!("IFCLOCALPLACEMENT({whole},#{frame})"))?;
            arguments[5] = format!("#{placement}").into();
            products.push((product.id, format!("{keyword}({})", arguments.join(","))));
        }
        Some(Replacements { items, products })
    }
}

/// Products that openings of what they are parts of cut.
fn parts_of_cut(file: &File<'_>, products: &[ProductBody<'_, '_>]) -> FxHashSet<u32> {
    let mut parts: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    let is_cut = |product: &&ProductBody<'_, '_>| !product.openings.is_empty();
    let mut waiting: Vec<u32> = products.iter().filter(is_cut).map(|product| product.record.id).collect();
    if !waiting.is_empty() {
        for record in file.all("IfcRelAggregates").into_iter().filter_map(|(span, _)| file.record(span.id)) {
            if let Some(whole) = record.at(4).reference() {
                parts.entry(whole).or_default().extend(record.at(5).references());
            }
        }
    }
    let mut found = FxHashSet::default();
    while let Some(whole) = waiting.pop() {
        let new = parts.remove(&whole).unwrap_or_default();
        found.extend(new.iter().copied());
        waiting.extend(new);
    }
    found
}

/// True for an item of one of these entities.
fn has_keyword(file: &File<'_>, item: u32, keywords: &[&str]) -> bool {
    let keyword = file.bytes_of(item).map_or("", |(keyword, _)| keyword);
    keywords.iter().any(|known| keyword.eq_ignore_ascii_case(known))
}

/// Collects the items that an item is made of.
fn inner_items(file: &File<'_>, item: u32, depth: usize, found: &mut FxHashSet<u32>) {
    let parts: Vec<u32> = if has_keyword(file, item, &["IFCMAPPEDITEM"]) {
        mapped_items(file, item).collect()
    } else if has_keyword(file, item, &["IFCBOOLEANRESULT", "IFCBOOLEANCLIPPINGRESULT", "IFCCSGSOLID"]) {
        let record = file.record(item);
        let operands = |record: &Record<'_>| if is_boolean(record) { [1, 2] } else { [0, 0] };
        record.iter().flat_map(|r| operands(r).into_iter().filter_map(|at| r.at(at).reference())).collect()
    } else {
        Vec::new()
    };
    for part in parts {
        if found.insert(part) && depth < DEPTH_MAX {
            inner_items(file, part, depth + 1, found);
        }
    }
}

/// The records of a file with their replacements.
struct Records<'f, 'a> {
    file: &'f File<'a>,
    replaced: FxHashMap<u32, &'f str>,
    unit_m: f64,
    /// Places of items that are mapped, which may be large and are used many times.
    mapped_starts: RefCell<FxHashMap<u32, Option<Vector3<f64>>>>,
    /// IfcStyledItem by the items that they colour, for copies.
    styles: FxHashMap<u32, Vec<u32>>,
}

impl<'f, 'a> Records<'f, 'a> {
    fn new(file: &'f File<'a>, replaced: FxHashMap<u32, &'f str>, unit_m: f64) -> Self {
        Self { file, replaced, unit_m, mapped_starts: RefCell::default(), styles: FxHashMap::default() }
    }
}

impl Records<'_, '_> {
    /// Keyword in capitals, and the arguments as written.
    fn get(&self, id: u32) -> Option<(String, Vec<&[u8]>)> {
        let (keyword, arguments) = match self.replaced.get(&id) {
            Some(record) => {
                let (keyword, _) = record.split_once('(')?;
                (keyword, &record.as_bytes()[keyword.len()..])
            }
            None => self.file.bytes_of(id)?,
        };
        Some((keyword.trim().to_ascii_uppercase(), members(arguments)))
    }

    fn is_far(&self, place: &Vector3<f64>) -> bool {
        place.amax() * self.unit_m > FAR_M
    }

    /// The first place that the record names, in the frame that it is given in and in units of the file.
    fn start(&self, id: u32, left: &mut usize) -> Option<Vector3<f64>> {
        *left = left.checked_sub(1)?;
        let (keyword, arguments) = self.get(id)?;
        match Placed::of(&keyword)? {
            Placed::Nowhere => None,
            Placed::Point => coordinates(arguments.first()?),
            Placed::Points => coordinates(members(arguments.first()?).first()?),
            Placed::InPosition(position, inside, _) => {
                let inside = self.inside(&arguments, inside, left);
                let position = arguments.get(position).and_then(|written| reference(written));
                position
                    .map_or(Some(inside), |id| Some(self.start(id, left)? + turned(&self.axes_of(id, inside)?, inside)))
            }
            Placed::Mapped => {
                let (source, target) = (reference(arguments.first()?)?, reference(arguments.get(1)?)?);
                Some(self.start(target, left)? + self.mapped(source, target, left)?.image)
            }
            placed => {
                let placing = arguments.iter().enumerate().filter(|(k, _)| placed.has(*k));
                placing.flat_map(|(_, written)| references_in(written)).find_map(|id| self.start(id, left))
            }
        }
    }

    /// How far what lies in the frame of a position is from its origin, in whole units; zero if it is near.
    fn inside(&self, arguments: &[&[u8]], inside: &[usize], left: &mut usize) -> Vector3<f64> {
        let first = inside.first().and_then(|at| reference(arguments.get(*at)?));
        let start = first.and_then(|id| self.start(id, left)).filter(|start| self.is_far(start));
        start.map_or_else(Vector3::zeros, |start| start.map(f64::round))
    }

    /// Axes of the frame in which something is moved so far.
    fn axes_of(&self, position: u32, inside: Vector3<f64>) -> Option<[Vector3<f64>; 3]> {
        if inside == Vector3::zeros() {
            return Some([Vector3::x(), Vector3::y(), Vector3::z()]);
        }
        Some(axes(&axis2_placement(self.file, &self.file.record(position)?, 1.0)?))
    }

    /// The place of an item that is mapped.
    fn mapped_start(&self, item: u32, left: &mut usize) -> Option<Vector3<f64>> {
        let known = self.mapped_starts.borrow().get(&item).copied();
        known.unwrap_or_else(|| {
            let start = self.start(item, left);
            if *left > 0 {
                self.mapped_starts.borrow_mut().insert(item, start);
            }
            start
        })
    }

    /// What of a mapped item is far in the frame of what is mapped.
    fn mapped(&self, source: u32, target: u32, left: &mut usize) -> Option<FarSource> {
        let (_, map) = self.get(source)?;
        let representation = reference(map.get(1)?)?;
        let (_, shape) = self.get(representation)?;
        let items: Vec<u32> = references_in(shape.get(3)?).collect();
        let start = items.iter().find_map(|item| self.mapped_start(*item, left)).filter(|start| self.is_far(start));
        let Some(inside) = start.map(|start| start.map(f64::round)) else {
            return Some(FarSource { items, inside: Vector3::zeros(), image: Vector3::zeros() });
        };
        // Readers differ on what a turned origin means.
        let origin = axis2_placement(self.file, &self.file.record(reference(map.first()?)?)?, 1.0)?;
        if axes(&origin) != [Vector3::x(), Vector3::y(), Vector3::z()] {
            return None;
        }
        let image = turned(&axes(&operator(self.file, &self.file.record(target)?, 1.0)?), inside);
        Some(FarSource { items, inside, image })
    }
}

/// What is mapped: its items, how far they are in whole units (zero if they are near), and what becomes of that.
struct FarSource {
    items: Vec<u32>,
    inside: Vector3<f64>,
    image: Vector3<f64>,
}

/// How many records may still be looked at.
fn steps() -> usize {
    STEPS_MAX
}

fn turned(axes: &[Vector3<f64>; 3], v: Vector3<f64>) -> Vector3<f64> {
    axes[0] * v.x + axes[1] * v.y + axes[2] * v.z
}

/// Moved copies of records, each made once for each distance.
struct Copies<'c, 'f, 'a> {
    records: &'c Records<'f, 'a>,
    patch: Patch,
    known: FxHashMap<(u32, [u64; 3]), u32>,
    n_bytes_left: usize,
}

impl Copies<'_, '_, '_> {
    fn add(&mut self, record: String) -> Option<u32> {
        self.n_bytes_left = self.n_bytes_left.checked_sub(record.len())?;
        self.patch.add(record)
    }

    /// A copy of a record, moved by `-offset`; the record itself if it is a direction.
    fn copy(&mut self, id: u32, offset: Vector3<f64>, depth: usize) -> Option<u32> {
        let key = (id, <[f64; 3]>::from(offset).map(f64::to_bits));
        if let Some(known) = self.known.get(&key) {
            return Some(*known);
        }
        let (keyword, _) = self.records.get(id)?;
        let copy = match Placed::of(&keyword)? {
            Placed::Nowhere => id,
            _ => {
                let record = self.moved(id, offset, depth)?;
                let copy = self.add(record)?;
                self.style(id, copy)?;
                copy
            }
        };
        self.known.insert(key, copy);
        Some(copy)
    }

    /// Gives the copy of an item its colours.
    fn style(&mut self, item: u32, copy: u32) -> Option<()> {
        let records = self.records;
        for &style in records.styles.get(&item).into_iter().flatten() {
            let (keyword, arguments) = records.get(style)?;
            let rest: Vec<Cow<'_, str>> = arguments.iter().skip(1).map(|a| String::from_utf8_lossy(a)).collect();
            self.add(format!("{keyword}(#{copy},{})", rest.join(",")))?;
        }
        Some(())
    }

    /// The record moved by `-offset`, as `KEYWORD(..)`.
    fn moved(&mut self, id: u32, offset: Vector3<f64>, depth: usize) -> Option<String> {
        let records = self.records;
        let (keyword, arguments) = records.get(id).filter(|_| depth < DEPTH_MAX)?;
        let mut written: Vec<Cow<'_, str>> = arguments.iter().map(|a| String::from_utf8_lossy(a)).collect();
        match Placed::of(&keyword)? {
            Placed::Nowhere => {}
            Placed::Point => written[0] = point_moved(arguments.first()?, offset)?.into(),
            Placed::Points => {
                let points = members(arguments.first()?).into_iter();
                let points = points.map(|point| point_moved(point, offset)).collect::<Option<Vec<_>>>()?;
                written[0] = format!("({})", points.join(",")).into();
            }
            Placed::InPosition(position, inside, beside) => {
                let far = records.inside(&arguments, inside, &mut steps());
                let moved = match reference(arguments.get(position)?) {
                    Some(id) => self.copy(id, offset - turned(&records.axes_of(id, far)?, far), depth + 1)?,
                    None => self.frame(far - offset)?,
                };
                written[position] = format!("#{moved}").into();
                for &at in inside.iter().filter(|_| far != Vector3::zeros()) {
                    written[at] = self.references_moved(arguments.get(at)?, far, depth)?.into();
                }
                for &at in beside {
                    written[at] = self.references_moved(arguments.get(at)?, offset, depth)?.into();
                }
            }
            Placed::Mapped => {
                let (source, target) = (reference(arguments.first()?)?, reference(arguments.get(1)?)?);
                let far = records.mapped(source, target, &mut steps())?;
                written[1] = format!("#{}", self.copy(target, offset - far.image, depth + 1)?).into();
                if far.inside != Vector3::zeros() {
                    written[0] = format!("#{}", self.source_moved(source, &far, depth)?).into();
                }
            }
            placed => {
                for at in (0..arguments.len()).filter(|at| placed.has(*at)) {
                    written[at] = self.references_moved(arguments[at], offset, depth)?.into();
                }
            }
        }
        Some(format!("{keyword}({})", written.join(",")))
    }

    /// A copy of an IfcRepresentationMap whose items are moved.
    fn source_moved(&mut self, source: u32, far: &FarSource, depth: usize) -> Option<u32> {
        let (_, map) = self.records.get(source)?;
        let (keyword, shape) = self.records.get(reference(map.get(1)?)?)?;
        let items: Option<Vec<u32>> = far.items.iter().map(|item| self.copy(*item, far.inside, depth + 1)).collect();
        let mut written: Vec<Cow<'_, str>> = shape.iter().map(|a| String::from_utf8_lossy(a)).collect();
        *written.get_mut(3)? = format!("({})", references(&items?)).into();
        let shape = self.add(format!("{keyword}({})", written.join(",")))?;
        self.add(format!("IFCREPRESENTATIONMAP({},#{shape})", String::from_utf8_lossy(map.first()?)))
    }

    /// An argument with moved copies of what it refers to.
    fn references_moved(&mut self, written: &[u8], offset: Vector3<f64>, depth: usize) -> Option<String> {
        let text = std::str::from_utf8(written).ok()?;
        let mut parts = text.split('#');
        let mut moved = parts.next()?.to_owned();
        if moved.contains('\'') {
            // A name: no argument of these records has texts and references.
            return Some(text.to_owned());
        }
        for part in parts {
            let n_digits = part.bytes().take_while(u8::is_ascii_digit).count();
            let (id, rest) = part.split_at(n_digits);
            moved += &format!("#{}{rest}", self.copy(id.parse().ok()?, offset, depth + 1)?);
        }
        Some(moved)
    }

    /// A frame at this place, with the axes of the one that it is in.
    fn frame(&mut self, at: Vector3<f64>) -> Option<u32> {
        let point = self.add(format!("IFCCARTESIANPOINT(({}))", listed(at.as_slice())))?;
        self.add(format!("IFCAXIS2PLACEMENT3D(#{point},$,$)"))
    }
}

/// The reference that an argument is.
fn reference(written: &[u8]) -> Option<u32> {
    std::str::from_utf8(written.strip_prefix(b"#")?).ok()?.parse().ok()
}

/// What an argument refers to; texts have no references.
fn references_in(written: &[u8]) -> impl Iterator<Item = u32> {
    let is_text = written.starts_with(b"'");
    let parts = written.split(|byte| *byte == b'#').skip(1).filter(move |_| !is_text);
    parts.filter_map(|part| {
        let digits = part.iter().take_while(|byte| byte.is_ascii_digit()).count();
        std::str::from_utf8(&part[..digits]).ok()?.parse().ok()
    })
}

fn numbers(tuple: &[u8]) -> Option<Vec<f64>> {
    let number = |written: &[u8]| std::str::from_utf8(written).ok()?.parse().ok().filter(|x: &f64| x.is_finite());
    members(tuple).into_iter().map(number).collect()
}

/// A point of one to three coordinates; those that it lacks are zero.
fn coordinates(tuple: &[u8]) -> Option<Vector3<f64>> {
    let numbers = numbers(tuple).filter(|numbers| !numbers.is_empty())?;
    Some(Vector3::from_fn(|k, _| numbers.get(k).copied().unwrap_or(0.0)))
}

/// A point, written in as many coordinates, moved by `-offset`.
fn point_moved(tuple: &[u8], offset: Vector3<f64>) -> Option<String> {
    let numbers = numbers(tuple).filter(|numbers| numbers.len() <= 3)?;
    let moved: Vec<f64> = std::iter::zip(numbers, offset.iter()).map(|(x, by)| x - by).collect();
    Some(format!("({})", listed(&moved)))
}

/// Numbers as STEP has them, so that the same are read again.
fn listed(numbers: &[f64]) -> String {
    let written = |x: &f64| if x.fract() == 0.0 { format!("{x}.") } else { format!("{x}") };
    numbers.iter().map(written).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::{Records, steps};
    use crate::bounding_boxes::{self, Extent};
    use crate::testing::{BASICS, file, read, volume_m3, with_file};
    use crate::{GeometryStatus, Model};
    use nalgebra::Vector3;
    use rustc_hash::FxHashMap;

    const NATIONAL: [f64; 2] = [4_467_812.25, 5_331_234.5];
    /// Boxes from corner to corner: a wall, an opening that cuts 1.2 m3 out of it.
    const WALL: [[f64; 3]; 2] = [[-1.0, -0.5, 0.0], [1.0, 0.5, 3.0]];
    const OPENING: [[f64; 3]; 2] = [[-0.3, -0.8, 0.0], [0.3, 0.8, 2.0]];
    const LEFT_M3: f32 = 6.0 - 1.2;

    const FORMS: [&str; 9] =
        ["faces", "polygons", "brep", "position", "profile", "outline", "indexed", "mapped", "mapped outline"];

    /// Records of a box as the item `#{first}`, moved in plan.
    fn item(form: &str, first: usize, [low, high]: [[f64; 3]; 2], by: [f64; 2]) -> String {
        let at = |k: usize| first + k;
        let corner = |k: usize| {
            let side = |axis: usize, bit: usize| if k >> bit & 1 == 0 { low[axis] } else { high[axis] };
            format!("({:?},{:?},{:?})", side(0, 0) + by[0], side(1, 1) + by[1], side(2, 2))
        };
        let corners: Vec<String> = (0..8).map(corner).collect();
        let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let outline: Vec<String> = [[0, 0], [1, 0], [1, 1], [0, 1], [0, 0]]
            .map(|[x, y]| format!("({:?},{:?})", [low, high][x][0] + by[0], [low, high][y][1] + by[1]))
            .to_vec();
        let (size, middle) = ([0, 1, 2].map(|k| high[k] - low[k]), [0, 1].map(|k| (low[k] + high[k]) / 2.0 + by[k]));
        let solid = |solid: usize, profile: usize, position: &str| {
            format!("#{solid}=IFCEXTRUDEDAREASOLID(#{profile},{position},#112,{:?});", size[2])
        };
        let outlined = |profile: usize| {
            let points: String =
                (0..4).map(|k| format!("#{}=IFCCARTESIANPOINT({});", profile + 2 + k, outline[k])).collect();
            let [curve, a, b, c, d] = [1, 2, 3, 4, 5].map(|k| profile + k);
            format!(
                "{points}#{curve}=IFCPOLYLINE((#{a},#{b},#{c},#{d},#{a}));
                 #{profile}=IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#{curve});"
            )
        };
        let rectangle = |profile: usize, position: &str| {
            format!("#{profile}=IFCRECTANGLEPROFILEDEF(.AREA.,$,{position},{:?},{:?});", size[0], size[1])
        };
        match form {
            "faces" => {
                let triangles: Vec<String> = faces
                    .iter()
                    .flat_map(|f| [[f[0], f[1], f[2]], [f[0], f[2], f[3]]])
                    .map(|[a, b, c]| format!("({},{},{})", a + 1, b + 1, c + 1))
                    .collect();
                format!(
                    "#{first}=IFCTRIANGULATEDFACESET(#{},$,.T.,({}),$);#{}=IFCCARTESIANPOINTLIST3D(({}));",
                    at(1),
                    triangles.join(","),
                    at(1),
                    corners.join(",")
                )
            }
            "polygons" => {
                let polygons: String = faces
                    .iter()
                    .enumerate()
                    .map(|(k, [a, b, c, d])| {
                        format!("#{}=IFCINDEXEDPOLYGONALFACE(({},{},{},{}));", at(2 + k), a + 1, b + 1, c + 1, d + 1)
                    })
                    .collect();
                let list: Vec<String> = (0..6).map(|k| format!("#{}", at(2 + k))).collect();
                format!(
                    "{polygons}#{first}=IFCPOLYGONALFACESET(#{},.T.,({}),$);#{}=IFCCARTESIANPOINTLIST3D(({}));",
                    at(1),
                    list.join(","),
                    at(1),
                    corners.join(",")
                )
            }
            "brep" => {
                let points: String =
                    (0..8).map(|k| format!("#{}=IFCCARTESIANPOINT({});", at(40 + k), corners[k])).collect();
                let bounds: String = faces
                    .iter()
                    .enumerate()
                    .map(|(k, face)| {
                        let [a, b, c, d] = face.map(|corner| at(40 + corner));
                        let (polygon, bound, face) = (at(10 + k), at(20 + k), at(30 + k));
                        format!(
                            "#{polygon}=IFCPOLYLOOP((#{a},#{b},#{c},#{d}));
                             #{bound}=IFCFACEOUTERBOUND(#{polygon},.T.);#{face}=IFCFACE((#{bound}));"
                        )
                    })
                    .collect();
                let list: Vec<String> = (0..6).map(|k| format!("#{}", at(30 + k))).collect();
                let (shell, list) = (at(1), list.join(","));
                format!("{points}{bounds}#{first}=IFCFACETEDBREP(#{shell});#{shell}=IFCCLOSEDSHELL(({list}));")
            }
            "position" => format!(
                "{}{}#{}=IFCAXIS2PLACEMENT3D(#{},$,$);#{}=IFCCARTESIANPOINT(({:?},{:?},0.));",
                solid(first, at(1), &format!("#{}", at(2))),
                rectangle(at(1), "#113"),
                at(2),
                at(3),
                at(3),
                middle[0],
                middle[1]
            ),
            "profile" => format!(
                "{}{}#{}=IFCAXIS2PLACEMENT2D(#{},$);#{}=IFCCARTESIANPOINT(({:?},{:?}));",
                solid(first, at(1), "$"),
                rectangle(at(1), &format!("#{}", at(2))),
                at(2),
                at(3),
                at(3),
                middle[0],
                middle[1]
            ),
            "outline" => solid(first, at(1), "#102") + &outlined(at(1)),
            "indexed" => format!(
                "{}#{}=IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#{});#{}=IFCINDEXEDPOLYCURVE(#{},$,.F.);
                 #{}=IFCCARTESIANPOINTLIST2D(({}));",
                solid(first, at(1), "$"),
                at(1),
                at(2),
                at(2),
                at(3),
                at(3),
                outline.join(",")
            ),
            "mapped" | "mapped outline" => {
                let far = form == "mapped";
                let (target, source) =
                    if far { (middle, rectangle(at(10), "#113")) } else { ([0.0; 2], outlined(at(10))) };
                format!(
                    "#{first}=IFCMAPPEDITEM(#{},#{});#{}=IFCREPRESENTATIONMAP(#102,#{});
                     #{}=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',(#{}));{}{source}
                     #{}=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#{},1.,$);#{}=IFCCARTESIANPOINT(({:?},{:?},0.));",
                    at(1),
                    at(2),
                    at(1),
                    at(3),
                    at(3),
                    at(4),
                    solid(at(4), at(10), "#102"),
                    at(2),
                    at(5),
                    at(5),
                    target[0],
                    target[1]
                )
            }
            _ => panic!("{form}"),
        }
    }

    /// A wall and its opening, of these items and placements.
    fn building(items: &str, placements: [&str; 2]) -> String {
        let [wall, opening] = placements;
        file(&format!(
            "{BASICS}#1=IFCWALL('wall',$,'it''s, (a) #wall',$,$,{wall},#2,$,$);#2=IFCPRODUCTDEFINITIONSHAPE($,$,(#3));
             #3=IFCSHAPEREPRESENTATION(#101,'Body','SolidModel',(#200));
             #10=IFCOPENINGELEMENT('o',$,$,$,$,{opening},#11,$,$);#11=IFCPRODUCTDEFINITIONSHAPE($,$,(#12));
             #12=IFCSHAPEREPRESENTATION(#101,'Body','SolidModel',(#300));#13=IFCRELVOIDSELEMENT('v',$,$,$,#1,#10);{items}"
        ))
    }

    fn check(model: &Model, expected: Extent, what: &str) {
        let wall = &model.elements[0].geometry;
        assert_eq!(wall.status, GeometryStatus::Meshed, "{what}");
        let volume: f32 = wall.parts.iter().map(volume_m3).sum();
        assert!((volume - LEFT_M3).abs() < 1e-3, "{what}: {volume}");
        let found = bounding_boxes::of_parts(&wall.parts).unwrap();
        for (found, expected) in [(found.low, expected.low), (found.high, expected.high)] {
            assert!((found - expected).amax() < 1e-4, "{what}: {found:?} instead of {expected:?}");
        }
    }

    fn extent([low, high]: [[f64; 3]; 2], by: [f64; 2]) -> Extent {
        let moved = |p: [f64; 3]| [p[0] + by[0], p[1] + by[1], p[2]].into();
        Extent { low: moved(low), high: moved(high) }
    }

    #[test]
    fn walls_are_cut_in_every_form_of_a_body_with_coordinates_of_a_national_grid() {
        for wall in FORMS {
            for opening in FORMS {
                let items = item(wall, 200, WALL, NATIONAL) + &item(opening, 300, OPENING, NATIONAL);
                for [wall_in, opening_in] in [["#103", "#103"], ["$", "#103"]] {
                    let (model, _) = read(&building(&items, [wall_in, opening_in])).unwrap();
                    check(&model, extent(WALL, NATIONAL), &format!("{wall} {opening} {wall_in}"));
                }
            }
        }
    }

    #[test]
    fn an_opening_whose_frame_is_turned_against_that_of_its_wall_cuts_it() {
        // The opening's x axis is along the wall's y, and that along the world's -x.
        let frames = "#20=IFCLOCALPLACEMENT($,#21);#21=IFCAXIS2PLACEMENT3D(#107,$,#22);#22=IFCDIRECTION((0.,1.,0.));
            #23=IFCLOCALPLACEMENT(#20,#21);";
        let turned = [[-0.8, -0.3, 0.0], [0.8, 0.3, 2.0]];
        for form in FORMS {
            let opening = item(form, 300, turned, [NATIONAL[1], -NATIONAL[0]]);
            let items = item(form, 200, WALL, NATIONAL) + &opening + frames;
            let (model, _) = read(&building(&items, ["#20", "#23"])).unwrap();
            let world = [[-0.5, -1.0, 0.0], [0.5, 1.0, 3.0]];
            check(&model, extent(world, [-NATIONAL[1], NATIONAL[0]]), form);
        }
    }

    #[test]
    fn a_body_near_its_frame_that_is_far_itself_is_cut() {
        let site = format!(
            "#20=IFCLOCALPLACEMENT($,#21);#21=IFCAXIS2PLACEMENT3D(#22,$,$);#22=IFCCARTESIANPOINT(({:?},{:?},0.));",
            NATIONAL[0], NATIONAL[1]
        );
        for form in FORMS {
            let items = item(form, 200, WALL, [0.0; 2]) + &item(form, 300, OPENING, [0.0; 2]) + &site;
            let (model, _) = read(&building(&items, ["#20", "#20"])).unwrap();
            check(&model, extent(WALL, NATIONAL), form);
        }
    }

    #[test]
    fn a_body_that_a_half_space_cuts_is_cut_far_away_too() {
        let [x, y] = NATIONAL;
        let plane = format!(
            "#400=IFCPLANE(#401);#401=IFCAXIS2PLACEMENT3D(#402,$,$);#402=IFCCARTESIANPOINT(({x:?},{y:?},2.4));"
        );
        let bounded = format!(
            "#420=IFCPOLYGONALBOUNDEDHALFSPACE(#400,.F.,#102,#421);#421=IFCPOLYLINE((#422,#423,#424,#425,#422));{}",
            [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]]
                .iter()
                .zip(422..)
                .map(|([dx, dy], id)| format!("#{id}=IFCCARTESIANPOINT(({:?},{:?}));", x + dx, y + dy))
                .collect::<String>()
        );
        for half_space in ["#420=IFCHALFSPACESOLID(#400,.F.);", &bounded] {
            for form in ["position", "outline", "brep"] {
                let wall = item(form, 500, [WALL[0], [1.0, 0.5, 9.0]], NATIONAL);
                let tree = "#200=IFCBOOLEANCLIPPINGRESULT(.DIFFERENCE.,#500,#420);";
                let text = file(&format!(
                    "{BASICS}#1=IFCWALL('wall',$,'W',$,$,#103,#2,$,$);#2=IFCPRODUCTDEFINITIONSHAPE($,$,(#3));
                     #3=IFCSHAPEREPRESENTATION(#101,'Body','Clipping',(#200));{tree}{wall}{plane}{half_space}"
                ));
                let (model, _) = read(&text).unwrap();
                // What is left is as much as the wall with its opening.
                check(&model, extent([WALL[0], [1.0, 0.5, 2.4]], NATIONAL), form);
            }
        }
    }

    #[test]
    fn a_body_in_millimetres_is_cut() {
        let scaled = |corners: [[f64; 3]; 2]| corners.map(|corner| corner.map(|x| x * 1e3));
        let by = NATIONAL.map(|x| x * 1e3 + 0.125);
        for form in FORMS {
            let items = item(form, 200, scaled(WALL), by) + &item(form, 300, scaled(OPENING), by);
            let text =
                building(&items, ["#103", "#103"]).replace(".LENGTHUNIT.,$,.METRE.", ".LENGTHUNIT.,.MILLI.,.METRE.");
            let (model, _) = read(&text).unwrap();
            check(&model, extent(WALL, by.map(|x| x / 1e3)), form);
        }
    }

    #[test]
    fn a_wall_far_away_that_its_opening_only_touches_is_cut_where_its_door_stands() {
        let beside = OPENING.map(|[x, y, z]| [x, y + 1.3, z]);
        let items = item("faces", 200, WALL, NATIONAL) + &item("faces", 300, beside, NATIONAL);
        let door = "#30=IFCDOOR('xdoor',$,'D',$,$,#103,#31,$,2.,0.6,$,$,$);#31=IFCPRODUCTDEFINITIONSHAPE($,$,(#32));
            #32=IFCSHAPEREPRESENTATION(#101,'Body','SolidModel',(#400));#33=IFCRELFILLSELEMENT('f',$,$,$,#10,#30);";
        let leaf = item("faces", 400, [[-0.3, 0.2, 0.0], [0.3, 0.4, 2.0]], NATIONAL);
        let (model, diagnostics) = read(&building(&(items + door + &leaf), ["#103", "#103"])).unwrap();
        assert_eq!(diagnostics[0].code.name(), "opening_beside_wall", "{diagnostics:?}");
        check(&model, extent(WALL, NATIONAL), "beside");
    }

    #[test]
    fn a_body_that_nothing_cuts_has_its_shape_far_away_too() {
        for form in FORMS {
            let text = file(&format!(
                "{BASICS}#1=IFCWALL('wall',$,'',$,$,#103,#2,$,$);#2=IFCPRODUCTDEFINITIONSHAPE($,$,(#3));
                 #3=IFCSHAPEREPRESENTATION(#101,'Body','SolidModel',(#200));{}",
                item(form, 200, WALL, NATIONAL)
            ));
            let (model, _) = read(&text).unwrap();
            let parts = &model.elements[0].geometry.parts;
            let (found, expected) = (bounding_boxes::of_parts(parts).unwrap(), extent(WALL, NATIONAL));
            let off = (found.low - expected.low).amax().max((found.high - expected.high).amax());
            assert!(off < 1e-4, "{form}: {found:?} instead of {expected:?}");
            let volume: f32 = parts.iter().map(volume_m3).sum();
            assert!((volume - 6.0).abs() < 1e-3, "{form}: {volume}");
        }
    }

    #[test]
    fn a_styled_body_keeps_its_colour() {
        // The item itself, or what is mapped.
        for (styled, forms) in [(200, &FORMS[..]), (204, &FORMS[7..])] {
            let style = format!(
                "#50=IFCSTYLEDITEM(#{styled},(#51),$);#51=IFCSURFACESTYLE($,.BOTH.,(#52));
                 #52=IFCSURFACESTYLESHADING(#53,0.);#53=IFCCOLOURRGB($,1.,0.,0.);"
            );
            for form in forms {
                let items = item(form, 200, WALL, NATIONAL) + &item(form, 300, OPENING, NATIONAL) + &style;
                let (model, _) = read(&building(&items, ["#103", "#103"])).unwrap();
                check(&model, extent(WALL, NATIONAL), form);
                let colours: Vec<_> = model.elements[0].geometry.parts.iter().map(|part| part.colour).collect();
                assert_eq!(colours, [Some([255, 0, 0, 255])], "{form} {styled}");
            }
        }
    }

    #[test]
    fn a_part_of_a_wall_is_cut_by_the_openings_of_the_whole() {
        let items = item("faces", 200, WALL, NATIONAL) + &item("outline", 300, OPENING, NATIONAL);
        let whole = "#103,$,$,$);#30=IFCBUILDINGELEMENTPART('a part',$,'',$,$,#103,#2,$,$);
            #31=IFCRELAGGREGATES('a',$,$,$,#1,(#30));";
        let text = building(&items, ["#103", "#103"]).replace("#103,#2,$,$);", whole);
        let (model, _) = read(&text).unwrap();
        check(&model, extent(WALL, NATIONAL), "part");
    }

    #[test]
    fn a_body_of_an_unknown_form_is_not_moved_and_what_takes_many_steps_is_given_up() {
        let [x, y] = NATIONAL;
        let wall = item("brep", 500, WALL, NATIONAL);
        // Each boolean has the one before twice.
        let tree: String = (601..900).map(|id| format!("#{id}=IFCBOOLEANRESULT(.UNION.,#{0},#{0});", id - 1)).collect();
        let sectioned =
            format!("#200=IFCSECTIONEDSOLIDHORIZONTAL(#201,(),());#201=IFCCARTESIANPOINT(({x:?},{y:?},0.));");
        let deep = "#200=IFCBOOLEANRESULT(.DIFFERENCE.,#899,#500);#600=IFCDIRECTION((0.,0.,1.));";
        for body in [sectioned.as_str(), &(deep.to_owned() + &tree)] {
            let text = building(&(wall.clone() + body + &item("faces", 300, OPENING, NATIONAL)), ["#103", "#103"]);
            let mut near = Vec::new();
            with_file(&text, |file| {
                let records = Records::new(file, FxHashMap::default(), 1.0);
                near.push(records.start(200, &mut steps()));
                near.push(records.start(300, &mut steps()));
            });
            assert_eq!(near[0], None);
            assert!((near[1].unwrap() - Vector3::new(x, y, 0.0)).amax() < 1.0);
        }
    }

    #[test]
    fn products_that_share_an_item_with_a_wall_that_is_cut_stay_where_they_are() {
        let items = item("faces", 200, WALL, NATIONAL) + &item("faces", 300, OPENING, NATIONAL);
        let plain = "#30=IFCWALL('xother',$,'other',$,$,#31,#2,$,$);#31=IFCLOCALPLACEMENT($,#32);
            #32=IFCAXIS2PLACEMENT3D(#33,$,$);#33=IFCCARTESIANPOINT((5.,0.,0.));";
        let (model, _) = read(&building(&(items + plain), ["#103", "#103"])).unwrap();
        check(&model, extent(WALL, NATIONAL), "cut");
        let other = bounding_boxes::of_parts(&model.elements[1].geometry.parts).unwrap();
        let expected = extent(WALL, [NATIONAL[0] + 5.0, NATIONAL[1]]);
        assert!((other.low - expected.low).amax() < 1e-3, "{other:?}");
        assert!((other.high - expected.high).amax() < 1e-3, "{other:?}");
    }
}
