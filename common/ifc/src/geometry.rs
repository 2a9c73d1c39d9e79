//! Bodies of products: kernel meshes, bounding boxes where meshing fails, and a diagnostic for every failure.

use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::{BTreeMap, BTreeSet};

use crate::affine::normalised;
use crate::boolean_chain::is_boolean;
use crate::bounded_items::Bounds;
use crate::bounding_boxes::{self, Extent, Extents};
use crate::cut_budget::{self, Cut, CutBudget, Excess, ItemCuts};
use crate::door_cuts::door_cuts;
use crate::far_bodies::FarBodies;
use crate::kernel::{File, ItemMesh, MeshRequest, Meshed, Patch, Record, faces, mesh as mesh_by_kernel};
use crate::mesh_parts::{is_finite, merged};
use crate::own_cuts::{OwnCuts, remove_voids};
use crate::prism_axes::axis_of;
use crate::product_body::ProductBody;
use crate::units::{self, LengthUnit};
use crate::{
    CutPath, Geometry, GeometryStatus, MeshPart, Progress, ReadError, ReadOptions, Stage, substitutes, terrain_faces,
};
use diagnostics::{DiagnosticCode, Named, Report, Severity};
use nalgebra::{Affine3, Point3};

/// Items that have no faces: a body that consists of them is no body.
const CURVE_ITEMS: [&str; 5] = ["IfcCurve", "IfcPoint", "IfcAnnotationFillArea", "IfcTextLiteral", "IfcPlacement"];

/// Complaint of the kernel about an incomplete body.
const DROPPED: &str = "dropped representation items";

/// Bodies by step id; products without a body are not in the map.
pub(crate) fn mesh(
    file: &File<'_>,
    unit: Option<&LengthUnit>,
    products: &[ProductBody<'_, '_>],
    frames: &FxHashMap<u32, Affine3<f64>>,
    options: &ReadOptions<'_>,
    report: &mut Report,
) -> Result<BTreeMap<u32, Geometry>, ReadError> {
    let mut geometries = BTreeMap::new();
    let Some(unit) = unit else { return Ok(geometries) };
    let mut patch = Patch::new(file);
    units::pin(file, unit, &mut patch);
    substitutes::apply(file, &mut patch);
    terrain_faces::correct(file, products, &mut patch, report);
    let mut extents = Extents::new(file, unit.metres);
    let items_of_openings: FxHashMap<u32, &[u32]> =
        products.iter().filter(|p| p.cuts).map(|p| (p.record.id, p.body.items.as_slice())).collect();
    let mut bounds = Bounds::new(file);
    let (mut wanted, mut unbounded) = (Vec::new(), FxHashSet::default());
    for product in products {
        let has_body = !product.body.items.is_empty();
        if has_body && is_placed(product, frames) {
            wanted.push(product.record.id);
            let cuts = product.openings.iter().filter_map(|opening| items_of_openings.get(opening));
            let is_bounded =
                std::iter::once(&product.body.items.as_slice()).chain(cuts).all(|items| bounds.hold(items));
            unbounded.extend((!is_bounded).then_some(product.record.id));
        }
        // An opening without a body must not cut, so it is corrected as well; elements are simply not asked for.
        if has_body || product.cuts {
            product.body.correct(&mut patch);
        }
    }
    let mut work =
        CutWork { file, products, frames, items_of_openings: &items_of_openings, budget: CutBudget::new(file) };
    let Cuts { mut detailed, costly } = work.leave_out_costly_items((&mut extents, &mut patch), report);
    let is_wanted: FxHashSet<u32> = wanted.iter().copied().collect();
    detailed.retain(|id| is_wanted.contains(id));
    let apart = |ids: &FxHashSet<u32>, others: &FxHashSet<u32>| -> Vec<u32> {
        wanted.iter().copied().filter(|id| ids.contains(id) && !others.contains(id)).collect()
    };
    let (unbounded, costly) = (apart(&unbounded, &costly), apart(&costly, &FxHashSet::default()));
    let id_of: FxHashMap<u32, &Named> = products.iter().map(|product| (product.record.id, product.id)).collect();
    let progress = |done: usize, total: usize, detailed_left: Option<u32>| {
        let waits_for = detailed_left.and_then(|id| id_of.get(&id).copied());
        options.report(Progress { stage: Stage::Meshing, done, total, waits_for });
    };
    let far = FarBodies::of(file, products, unit.metres);
    // Bodies are meshed whole, and cut here where that can be done; the others the kernel meshes again with their openings.
    let own_cuts = OwnCuts::of(file, products);
    let uncut = own_cuts.without_voids(file, &patch);
    let request = MeshRequest {
        products: &wanted,
        unbounded: &unbounded,
        costly: &costly,
        detailed: &detailed,
        isolation: options.isolation,
        cache: options.cache,
        patch: &far.brought_near(file, &uncut),
        pool: options.pool,
        progress: &progress,
    };
    let mut meshed = mesh_by_kernel(file, &request)?;
    let left = own_cuts.cut(&mut meshed, options);
    let mut there = [unbounded, costly];
    let (mut by_kernel, mut partly) = (FxHashSet::default(), FxHashSet::default());
    let mut again = left;
    for has_door_cuts in [false, true] {
        if has_door_cuts {
            again = doors_cut(file, unit.metres, (products, frames), &meshed, &mut patch, report);
        }
        let left_out = work.leave_out_costly_cuts(&again, &own_cuts, (&mut extents, &mut patch), report);
        let costly = left_out.costly.into_iter().filter(|id| !there.iter().any(|list| list.contains(id)));
        let costly: Vec<u32> = costly.collect();
        there[1].extend(costly);
        partly.extend(left_out.partly_cut);
        mesh_again(file, &far, &again, options, &there, (&mut meshed, &patch))?;
        by_kernel.extend(std::mem::take(&mut again));
    }
    partly.extend(mesh_without_cuts(
        (file, &far),
        (products, &id_of),
        (options, &progress),
        (&mut meshed, &mut patch),
        report,
    )?);
    share_complaints(&meshed.meshes, &mut meshed.complaints);
    // Openings first: an element may lie wholly inside its own.
    let bodied = products.iter().filter(|product| !product.body.items.is_empty());
    let (openings, others): (Vec<_>, Vec<_>) = bodied.partition(|product| product.cuts);
    for product in openings.into_iter().chain(others) {
        let id = product.record.id;
        let outcome = KernelResult {
            meshes: meshed.meshes.remove(&id).unwrap_or_default(),
            complaint: meshed.complaints.remove(&id),
            frame: frames.get(&id).copied().unwrap_or_else(Affine3::identity),
        };
        let geometry = if !is_placed(product, frames) {
            unplaced(product, report)
        } else if outcome.meshes.is_empty()
            && !meshed.given_up.contains(&id)
            && is_swallowed(product, &outcome.frame, &geometries, &mut extents)
        {
            let message = "its openings leave nothing of it".to_owned();
            report.add(Severity::Info, DiagnosticCode::SwallowedByOpenings, Some(product.id.clone()), message);
            Geometry::default()
        } else {
            final_geometry(file, product, outcome, &mut extents, report)
        };
        let cut = match () {
            () if own_cuts.openings_of(id).is_empty() || geometry.parts.is_empty() => CutPath::None,
            () if partly.contains(&id) => CutPath::LeftOut,
            () if by_kernel.contains(&id) => CutPath::Kernel,
            () => CutPath::Polygons,
        };
        geometries.insert(id, Geometry { cut, ..geometry });
    }
    Ok(geometries)
}

/// Shows the kernel the openings of walls that their doors cut because the openings do not; the walls and openings to mesh again.
fn doors_cut(
    file: &File<'_>,
    unit_m: f64,
    (products, frames): (&[ProductBody<'_, '_>], &FxHashMap<u32, Affine3<f64>>),
    meshed: &Meshed,
    patch: &mut Patch,
    report: &mut Report,
) -> Vec<u32> {
    let mut again = Vec::new();
    for cut in door_cuts(products, frames, &meshed.meshes) {
        if cut.apply(file, unit_m, patch).is_some() {
            let [opening, wall] = [cut.opening, cut.wall].map(|product| &product.id.global_id);
            let message =
                format!("its opening {opening} only touches the wall {wall}, which is cut where the door stands in it");
            report.add(Severity::Warning, DiagnosticCode::OpeningBesideWall, Some(cut.door.id.clone()), message);
            again.extend([cut.wall.record.id, cut.opening.record.id]);
        }
    }
    again.sort_unstable();
    again.dedup();
    again
}

/// Meshes products again, as they are patched now.
fn mesh_again(
    file: &File<'_>,
    far: &FarBodies<'_, '_>,
    again: &[u32],
    options: &ReadOptions<'_>,
    [unbounded, costly]: &[Vec<u32>; 2],
    (meshed, patch): (&mut Meshed, &Patch),
) -> Result<(), ReadError> {
    let of_again = |list: &[u32]| -> Vec<u32> { list.iter().copied().filter(|id| again.contains(id)).collect() };
    let request = MeshRequest {
        products: again,
        unbounded: &of_again(unbounded),
        costly: &of_again(costly),
        detailed: &[],
        isolation: options.isolation,
        cache: options.cache,
        patch: &far.brought_near(file, patch),
        pool: options.pool,
        progress: &|_, _, _| {},
    };
    again.iter().for_each(|id| meshed.forget(*id));
    meshed.append(mesh_by_kernel(file, &request)?);
    Ok(())
}

/// Meshes what the other process has given up again, without its cuts, and reports that; those that had any.
fn mesh_without_cuts(
    (file, far): (&File<'_>, &FarBodies<'_, '_>),
    (products, id_of): (&[ProductBody<'_, '_>], &FxHashMap<u32, &Named>),
    (options, progress): (&ReadOptions<'_>, &(dyn Fn(usize, usize, Option<u32>) + Sync)),
    (meshed, patch): (&mut Meshed, &mut Patch),
    report: &mut Report,
) -> Result<Vec<u32>, ReadError> {
    let uncut = without_cuts(file, products, &meshed.given_up, patch);
    let request = MeshRequest {
        products: &uncut,
        unbounded: &uncut,
        costly: &[],
        detailed: &[],
        isolation: options.isolation,
        // Nothing of it is kept: it depends on what was given up.
        cache: None,
        patch: &far.brought_near(file, patch),
        pool: options.pool,
        progress,
    };
    let again = mesh_by_kernel(file, &request)?;
    report_uncut(id_of, &uncut, meshed, &again, report);
    meshed.replace(again);
    Ok(uncut)
}

/// What cutting the products is worth.
struct Cuts {
    /// The products from most to least work.
    detailed: Vec<u32>,
    /// Those whose cuts may be far more work than they are estimated.
    costly: FxHashSet<u32>,
}

/// What the kernel's cuts are estimated from.
struct CutWork<'w, 'p, 'a> {
    file: &'w File<'a>,
    products: &'w [ProductBody<'p, 'a>],
    frames: &'w FxHashMap<u32, Affine3<f64>>,
    items_of_openings: &'w FxHashMap<u32, &'w [u32]>,
    budget: CutBudget<'w, 'a>,
}

impl CutWork<'_, '_, '_> {
    /// Corrects the patch so that the kernel does not evaluate items that would take it too long, and reports that.
    fn leave_out_costly_items(
        &mut self,
        (extents, patch): (&mut Extents<'_, '_>, &mut Patch),
        report: &mut Report,
    ) -> Cuts {
        let work = self.products.iter().map(|product| (self.budget.work(&product.body.items), product.record.id));
        let mut detailed: Vec<(u64, u32)> = work.collect();
        detailed.sort_unstable_by_key(|&(work, id)| (std::cmp::Reverse(work), id));
        let detailed: Vec<u32> = detailed.into_iter().map(|(_, id)| id).collect();
        let mut costly = FxHashSet::default();
        for product in self.products {
            let mut uncut = Vec::new();
            for &item in &product.body.items {
                match self.budget.uncut(item, patch, |operand| extents.of_items(&[operand])) {
                    ItemCuts::Plain => {}
                    ItemCuts::Costly => _ = costly.insert(product.record.id),
                    ItemCuts::LeftOut => uncut.push(item),
                }
            }
            if let Some(item) = uncut.first() {
                let is_boolean = self.file.record(*item).is_some_and(|record| is_boolean(&record));
                let what = if is_boolean { "are booleans that are not evaluated" } else { "is not meshed" };
                report_left_out(product, &format!("its item #{} {what}", self.file.written_id(*item)), report);
            }
        }
        Cuts { detailed, costly }
    }

    /// Corrects the patch so that the kernel does not cut these products where that would take it too long, and reports that.
    fn leave_out_costly_cuts(
        &mut self,
        hosts: &[u32],
        own_cuts: &OwnCuts,
        (extents, patch): (&mut Extents<'_, '_>, &mut Patch),
        report: &mut Report,
    ) -> LeftOut {
        let Self { file, products, frames, items_of_openings, budget } = self;
        let (mut left_out, mut costly, mut partly_cut) = (FxHashSet::default(), Vec::new(), Vec::new());
        for product in products.iter().filter(|product| hosts.contains(&product.record.id)) {
            let openings = own_cuts.openings_of(product.record.id);
            let cuts: Vec<Cut<'_>> = openings
                .iter()
                .map(|&opening| (opening, items_of_openings.get(&opening).copied().unwrap_or_default()))
                .collect();
            let Excess { openings: mut excess, is_costly } =
                budget.excess(&product.body.items, &cuts, |(opening, items)| {
                    let frame = frames.get(opening).copied().unwrap_or_else(Affine3::identity);
                    let extent = extents.of_items(items).map(|extent| extent.moved(&frame));
                    (extent, axis_of(file, items).and_then(|axis| normalised(frame * axis)))
                });
            costly.extend(is_costly.then_some(product.record.id));
            if !excess.is_empty() {
                partly_cut.push(product.record.id);
                excess.sort_unstable();
                let list: Vec<String> =
                    excess.iter().take(8).map(|&opening| format!("#{}", file.written_id(opening))).collect();
                let (n, of) = (excess.len(), openings.len());
                report_left_out(product, &format!("{n} of its {of} openings not cut: {}", list.join(", ")), report);
            }
            left_out.extend(excess);
        }
        remove_voids(file, &left_out, patch);
        LeftOut { costly, partly_cut }
    }
}

/// What the kernel is not to cut.
struct LeftOut {
    /// Products whose cuts may be far more work than they are estimated.
    costly: Vec<u32>,
    /// Products that are not cut by some of their openings.
    partly_cut: Vec<u32>,
}

fn report_left_out(product: &ProductBody<'_, '_>, what: &str, report: &mut Report) {
    let message = format!("{what}; there is so much detail that it would take very long");
    report.add(Severity::Warning, DiagnosticCode::OpeningsNotCut, Some(product.id.clone()), message);
}

/// Takes the cuts of products that the other process has given up out of the patch: their openings, and the differences of
/// their bodies. Returns those of them that have any.
fn without_cuts(
    file: &File<'_>,
    products: &[ProductBody<'_, '_>],
    given_up: &BTreeSet<u32>,
    patch: &mut Patch,
) -> Vec<u32> {
    let (mut uncut, mut openings) = (Vec::new(), FxHashSet::default());
    for product in products.iter().filter(|product| given_up.contains(&product.record.id)) {
        let differences = product.body.items.iter().filter(|item| cut_budget::replace_by_base(file, **item, patch));
        if differences.count() > 0 || !product.openings.is_empty() {
            uncut.push(product.record.id);
        }
        openings.extend(product.openings.iter().copied());
    }
    remove_voids(file, &openings, patch);
    uncut
}

/// Reports the products that are drawn without their cuts.
fn report_uncut(id_of: &FxHashMap<u32, &Named>, uncut: &[u32], before: &Meshed, again: &Meshed, report: &mut Report) {
    for product in uncut.iter().filter(|product| !again.given_up.contains(product)) {
        let why = before.complaints.get(product).map_or("the kernel fails", String::as_str);
        let message = format!("its openings and other cuts are not cut: {why}");
        let id = id_of.get(product).map(|id| (*id).clone());
        report.add(Severity::Warning, DiagnosticCode::OpeningsNotCut, id, message);
    }
}

/// Shares complaints among products of equal shape: the kernel meshes equal shapes once and reports the first product, which
/// depends on its threads.
fn share_complaints(meshes: &BTreeMap<u32, Vec<ItemMesh>>, complaints: &mut BTreeMap<u32, String>) {
    for complaint in complaints.values_mut() {
        // The kernel names the product that it blames; the diagnostic has its own.
        if let Some((_, what)) = complaint.split_once(": ").filter(|(who, _)| who.starts_with("incomplete product #")) {
            *complaint = what.to_owned();
        }
    }
    let is_dropped = |(_, complaint): &(&u32, &String)| complaint.contains(DROPPED);
    let blamed = complaints.iter().filter(is_dropped);
    let dropped: BTreeMap<Vec<&[[u32; 3]]>, String> =
        blamed.filter_map(|(id, complaint)| Some((faces(meshes.get(id)?), complaint.clone()))).collect();
    for (id, its_meshes) in meshes.iter().filter(|(_, m)| !dropped.is_empty() && !m.is_empty()) {
        if let Some(complaint) = dropped.get(&faces(its_meshes)) {
            complaints.entry(*id).or_insert_with(|| complaint.clone());
        }
    }
}

/// True unless the product has a placement that cannot be resolved.
fn is_placed(product: &ProductBody<'_, '_>, frames: &FxHashMap<u32, Affine3<f64>>) -> bool {
    product.record.at(5).reference().is_none() || frames.contains_key(&product.record.id)
}

/// A product without a usable position gets no body.
fn unplaced(product: &ProductBody<'_, '_>, report: &mut Report) -> Geometry {
    let why = "its placement cannot be resolved".to_owned();
    report.add(
        Severity::Error,
        DiagnosticCode::GeometryFailed,
        Some(product.id.clone()),
        format!("{why}; it is not drawn"),
    );
    Geometry { status: GeometryStatus::Failed { why }, ..Geometry::default() }
}

/// Result of the kernel for a product.
struct KernelResult {
    meshes: Vec<ItemMesh>,
    complaint: Option<String>,
    frame: Affine3<f64>,
}

/// True if every corner of the body's box lies in the box of one of its openings.
fn is_swallowed(
    product: &ProductBody<'_, '_>,
    frame: &Affine3<f64>,
    geometries: &BTreeMap<u32, Geometry>,
    extents: &mut Extents<'_, '_>,
) -> bool {
    const MARGIN_M: f64 = 0.005;
    if product.openings.is_empty() {
        return false;
    }
    let Some(body) = extents.of_items(&product.body.items) else { return false };
    let openings: Vec<Extent> =
        product.openings.iter().filter_map(|id| bounding_boxes::of_parts(&geometries.get(id)?.parts)).collect();
    let inside = |p: Point3<f64>| openings.iter().any(|opening| opening.contains(p, MARGIN_M));
    body.corners().into_iter().all(|corner| inside(frame * corner))
}

/// The final body of a product, with its diagnostics.
fn final_geometry(
    file: &File<'_>,
    product: &ProductBody<'_, '_>,
    outcome: KernelResult,
    extents: &mut Extents<'_, '_>,
    report: &mut Report,
) -> Geometry {
    let KernelResult { meshes, complaint, frame } = outcome;
    let (usable, broken): (Vec<ItemMesh>, Vec<ItemMesh>) = meshes.into_iter().partition(|m| is_finite(&m.part));
    let why = complaint.unwrap_or_else(|| "its coordinates are not finite".to_owned());
    let items = &product.body.items;
    let lost: Vec<u32> = if usable.is_empty() {
        items.clone()
    } else {
        let doubtful = !broken.is_empty() || why.contains(DROPPED);
        items.iter().copied().filter(|&id| doubtful && !is_meshed(file, id, &usable)).collect()
    };
    let lost: Vec<u32> = lost.into_iter().filter(|&id| !is_curve(file, id)).collect();
    let mut parts: Vec<MeshPart> = merged(usable).into_iter().map(|mesh| mesh.part).collect();
    if lost.is_empty() {
        report_doubts(product, &why, parts.is_empty(), report);
        let status = if parts.is_empty() { GeometryStatus::None } else { GeometryStatus::Meshed };
        return Geometry { parts, status, ..Geometry::default() };
    }
    let why = describe(file, &lost, &why);
    let boxed = if parts.is_empty() {
        extents.of_boxes(&product.body.boxes).or_else(|| extents.of_items(&lost))
    } else {
        extents.of_items(&lost)
    };
    let status = match boxed.and_then(|b| bounding_boxes::mesh(b, &frame)) {
        Some(part) => {
            parts.push(part);
            GeometryStatus::BoundingBox { why: why.clone() }
        }
        None if parts.is_empty() => GeometryStatus::Failed { why: why.clone() },
        None => GeometryStatus::Meshed,
    };
    let severity = if status == GeometryStatus::Meshed { Severity::Warning } else { Severity::Error };
    let drawn = match status {
        GeometryStatus::BoundingBox { .. } => "its bounding box stands in",
        GeometryStatus::Failed { .. } => "nothing is known of its extent",
        _ => "the rest of it is drawn",
    };
    report.add(severity, DiagnosticCode::GeometryFailed, Some(product.id.clone()), format!("{why}; {drawn}"));
    Geometry { parts, status, ..Geometry::default() }
}

/// Reports complaints of the kernel about a body that seems complete.
fn report_doubts(product: &ProductBody<'_, '_>, why: &str, empty: bool, report: &mut Report) {
    let id = || Some(product.id.clone());
    if empty {
        let message = "its body consists of curves and points only and is not drawn".to_owned();
        report.add(Severity::Info, DiagnosticCode::BodyWithoutFaces, id(), message);
    } else if why.contains(DROPPED) || why.contains("refused") {
        report.add(
            Severity::Warning,
            DiagnosticCode::GeometryIncomplete,
            id(),
            format!("part of its body is missing: {why}"),
        );
    } else if why.contains("CSG") {
        let message = "a cut or boolean of its body needed a fallback and may be missing".to_owned();
        report.add(Severity::Info, DiagnosticCode::BooleanDoubtful, id(), message);
    }
}

fn describe(file: &File<'_>, lost: &[u32], why: &str) -> String {
    let Some(record) = lost.first().and_then(|&id| file.record(id)) else {
        return format!("item #{} of its body is missing or malformed", file.written_id(lost[0]));
    };
    let entity =
        file.schema.lineage(record.keyword).first().map_or(record.keyword.to_owned(), |name| (*name).to_owned());
    let others = if lost.len() > 1 {
        format!(" and {}", diagnostics::counted(lost.len() - 1, "other item"))
    } else {
        String::new()
    };
    format!("{entity} #{}{others} cannot be meshed ({why})", file.written_id(record.id))
}

/// True if a mesh comes from the item, or from something inside it.
fn is_meshed(file: &File<'_>, item: u32, meshes: &[ItemMesh]) -> bool {
    let known = |id: u32| meshes.iter().any(|mesh| mesh.item == Some(id));
    if known(item) {
        return true;
    }
    let mapped = file.record_of(item, "IFCMAPPEDITEM");
    // A mapped item whose meshes carry no item is taken as meshed.
    mapped.is_some()
        && (meshes.iter().any(|mesh| mesh.item.is_none()) || bounding_boxes::mapped_items(file, item).any(known))
}

fn is_curve(file: &File<'_>, item: u32) -> bool {
    let Some(record) = file.record(item) else { return false };
    if record.is("IFCMAPPEDITEM") {
        let mut inner = bounding_boxes::mapped_items(file, item).peekable();
        return inner.peek().is_some() && inner.all(|id| file.record(id).is_some_and(|r| is_curve_record(file, &r)));
    }
    is_curve_record(file, &record)
}

fn is_curve_record(file: &File<'_>, record: &Record<'_>) -> bool {
    if record.is("IFCGEOMETRICSET") || record.is("IFCGEOMETRICCURVESET") {
        return record
            .at(0)
            .references()
            .into_iter()
            .all(|id| file.record(id).is_some_and(|r| is_plain_curve(file, &r)));
    }
    is_plain_curve(file, record)
}

fn is_plain_curve(file: &File<'_>, record: &Record<'_>) -> bool {
    let lineage = file.schema.lineage(record.keyword);
    CURVE_ITEMS.iter().any(|entity| lineage.contains(entity))
}

#[cfg(test)]
mod tests {
    use crate::testing::{BASICS, file, read, volume_m3};
    use crate::{Geometry, GeometryStatus};

    fn wall(representations: &str, records: &str) -> (Geometry, Vec<diagnostics::Diagnostic>) {
        let text = file(&format!(
            "{BASICS}#1=IFCWALL('wall',$,'W',$,$,#103,#2,$,$);#2=IFCPRODUCTDEFINITIONSHAPE($,$,({representations}));{records}"
        ));
        let (mut model, diagnostics) = read(&text).unwrap();
        (model.elements.remove(0).geometry, diagnostics)
    }

    /// A box of 9 m in a representation of this name and type.
    fn tall(identifier: &str, kind: &str) -> String {
        format!(
            "#3=IFCSHAPEREPRESENTATION(#101,'{identifier}','{kind}',(#4));#4=IFCEXTRUDEDAREASOLID(#111,#102,#112,9.);"
        )
    }

    fn height(geometry: &Geometry) -> f64 {
        let z = |part: &crate::MeshPart| part.positions_m.iter().map(|p| part.origin_m[2] + f64::from(p[2])).collect();
        geometry.parts.iter().flat_map(|part| -> Vec<f64> { z(part) }).fold(0.0, f64::max)
    }

    #[test]
    fn clearance_beside_a_body_is_not_meshed() {
        let (geometry, _) = wall("#3,#120", &tall("Clearance", "SweptSolid"));
        assert!((height(&geometry) - 3.0).abs() < 1e-6);
        let (geometry, diagnostics) = wall("#3", &tall("Clearance", "SweptSolid"));
        assert_eq!((geometry.status, diagnostics.len()), (GeometryStatus::None, 0));
    }

    #[test]
    fn a_body_of_an_unusual_type_is_meshed() {
        for kind in ["Solid", "", "Odd"] {
            let (geometry, _) = wall("#3", &tall("Body", kind));
            assert!((height(&geometry) - 9.0).abs() < 1e-6, "{kind}");
        }
    }

    #[test]
    fn several_bodies_are_all_meshed() {
        let mapped = "#3=IFCSHAPEREPRESENTATION(#101,'Body','MappedRepresentation',(#5));#5=IFCMAPPEDITEM(#6,#7);
            #6=IFCREPRESENTATIONMAP(#102,#120);#7=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#8,1.,$);
            #8=IFCCARTESIANPOINT((0.,0.,20.));";
        let (geometry, _) = wall("#120,#3", mapped);
        assert_eq!(geometry.parts.len(), 2, "{geometry:?}");
        assert!((height(&geometry) - 23.0).abs() < 1e-6);
    }

    #[test]
    fn a_sweep_that_the_kernel_gets_wrong_becomes_its_box() {
        let sweep = "#3=IFCSHAPEREPRESENTATION(#101,'Body','AdvancedSweptSolid',(#4));
            #4=IFCSURFACECURVESWEPTAREASOLID(#111,#102,#5,0.,1.,#7);#5=IFCPOLYLINE((#107,#6));
            #6=IFCCARTESIANPOINT((0.,0.,5.));#7=IFCPLANE(#102);";
        let (geometry, diagnostics) = wall("#3", sweep);
        assert!(matches!(geometry.status, GeometryStatus::BoundingBox { .. }));
        assert!(height(&geometry) >= 5.0);
        assert_eq!((diagnostics.len(), diagnostics[0].code.name()), (1, "geometry_failed"));
    }

    #[test]
    fn a_product_without_a_usable_placement_is_drawn_nowhere() {
        for placement in ["#2=IFCLOCALPLACEMENT(#2,#102);", "#2=IFCLOCALPLACEMENT(#998,#102);", ""] {
            let (model, diagnostics) =
                read(&file(&format!("{BASICS}#1=IFCWALL('wall',$,'W',$,$,#2,#121,$,$);{placement}"))).unwrap();
            assert!(matches!(model.elements[0].geometry.status, GeometryStatus::Failed { .. }), "{placement}");
            let codes: Vec<&str> = diagnostics.iter().map(|d| d.code.name()).collect();
            assert!(codes.ends_with(&["placement_unusable", "geometry_failed"]), "{codes:?}");
        }
    }

    #[test]
    fn a_body_that_fails_takes_the_box_of_its_box_representation() {
        let (geometry, _) = wall(
            "#3,#5",
            "#3=IFCSHAPEREPRESENTATION(#101,'Body','Brep',(#999));
             #5=IFCSHAPEREPRESENTATION(#101,'Box','BoundingBox',(#6));#6=IFCBOUNDINGBOX(#107,1.,2.,4.);",
        );
        assert!(matches!(geometry.status, GeometryStatus::BoundingBox { .. }));
        assert!((height(&geometry) - 4.0).abs() < 1e-6);
    }

    #[test]
    fn a_wall_that_its_opening_swallows_is_no_failure() {
        let (geometry, diagnostics) = wall(
            "#120",
            "#10=IFCOPENINGELEMENT('o',$,$,$,$,#103,#11,$,$);#11=IFCPRODUCTDEFINITIONSHAPE($,$,(#12));
             #12=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',(#13));#13=IFCEXTRUDEDAREASOLID(#14,#102,#112,3.);
             #14=IFCRECTANGLEPROFILEDEF(.AREA.,$,#113,2.,1.);#15=IFCRELVOIDSELEMENT('v',$,$,$,#1,#10);",
        );
        assert_eq!(geometry.status, GeometryStatus::None);
        assert_eq!(diagnostics[0].code.name(), "swallowed_by_openings");
    }

    #[test]
    fn a_turned_site_far_out_keeps_its_coordinates() {
        let text = file(&format!(
            "{BASICS}#1=IFCWALL('wall',$,'W',$,$,#2,#121,$,$);#2=IFCLOCALPLACEMENT(#3,#102);#3=IFCLOCALPLACEMENT($,#4);
             #4=IFCAXIS2PLACEMENT3D(#5,$,#6);#5=IFCCARTESIANPOINT((2600000.125,1200000.25,400.5));
             #6=IFCDIRECTION((0.,1.,0.));#7=IFCSITE('s',$,$,$,$,#3,$,$,.ELEMENT.,$,$,$,$,$);"
        ));
        let (model, _) = read(&text).unwrap();
        let element = &model.elements[0];
        assert_eq!(element.placement.unwrap().axes[0], [0.0, 1.0, 0.0]);
        let extent = crate::bounding_boxes::of_parts(&element.geometry.parts).unwrap();
        let expected = ([2_599_999.625, 1_199_999.25, 400.5], [2_600_000.625, 1_200_001.25, 403.5]);
        for (found, expected) in [(extent.low, expected.0), (extent.high, expected.1)] {
            let off = std::iter::zip(found.iter(), expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-4, "{found:?} instead of {expected:?}");
        }
        let largest = element.geometry.parts[0].positions_m.iter().flatten().fold(0.0, |a: f32, x| a.max(x.abs()));
        assert!(largest < 10.0, "positions are small against their origin: {largest}");
    }

    #[test]
    fn faces_look_outward_even_where_the_kernel_turns_them() {
        let block = "#3=IFCSHAPEREPRESENTATION(#101,'Body','CSG',(#4));#4=IFCBLOCK(#102,1.,2.,3.);";
        let (geometry, _) = wall("#3", block);
        let part = &geometry.parts[0];
        let volume = volume_m3(part);
        assert!((volume - 6.0).abs() < 1e-3, "{volume}");
    }
}
