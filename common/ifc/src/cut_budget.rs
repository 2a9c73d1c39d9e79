//! Leaves out what would keep the kernel busy for minutes: cuts that it makes because `own_cuts` does not, booleans, and items
//! of very many points.
//!
//! The kernel has no limit of its own where detailed bodies meet. Its work is estimated from the records, in pairs of faces,
//! so that what is left out depends on the file alone. On the machine of the benchmarks a pair is half a microsecond: the
//! limit is about two seconds for an element.

use rustc_hash::FxHashMap;

use crate::boolean_chain::{BooleanChain, has_operator};
use crate::bounding_boxes::{Extent, mapped_items};
use crate::crossing_cutters::{CrossingCutters, Cutter, FaceCount, most_work};
use crate::face_counts::FaceCounts;
use crate::kernel::{File, Patch, Record};
use crate::prism_axes::axis_of;
use nalgebra::Vector3;

/// Limit of an element's work, in pairs of faces.
const WORK_MAX: u64 = 4_000_000;

/// Work, in pairs of faces, and triangles of a body and what cuts it, above which the element is meshed apart: it may take
/// longer than it is estimated, up to all pairs of triangles.
const WORK_APART: u64 = 2_000_000;
const TRIANGLES_APART: u64 = 1_200;

/// Work for a face of an operand that meets a body of few faces.
const WORK_PER_FACE: u64 = 150;

/// Corners of a profile that has no list of them, and faces of an item that has no profile.
const CORNERS_OF_OTHERS: u64 = 10;
const FACES_OF_OTHERS: u64 = 36;

/// Pairs of corners of a profile that are as much work as a pair of faces: 10,000 corners are meshed in a second, 30,000 in
/// 40 s.
const CORNERS_PER_PAIR: u64 = 25;

/// Work for a point of the line along which a disk is swept.
const WORK_PER_SWEPT_POINT: u64 = 200;

/// Deepest nesting of items.
const DEPTH_MAX: usize = 48;

/// An opening that cuts an element: its id and the items of its body.
pub(crate) type Cut<'p> = (u32, &'p [u32]);

/// Estimates of the kernel's work.
pub(crate) struct CutBudget<'f, 'a> {
    file: &'f File<'a>,
    /// Faces, and the work of the booleans inside, of items that were counted.
    known: FxHashMap<u32, ItemWork>,
    face_counts: FaceCounts<'f, 'a>,
    /// Triangles and inner bounds of items that were counted.
    known_counts: FxHashMap<u32, FaceCount>,
}

/// Openings that are too much work, and what is left.
pub(crate) struct Excess {
    /// Openings that are not to be cut.
    pub(crate) openings: Vec<u32>,
    /// The others may be far more work than they are estimated.
    pub(crate) is_costly: bool,
}

/// What is done with the booleans of an item.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ItemCuts {
    /// They are evaluated, or it has none.
    Plain,
    /// They are evaluated, and may be far more work than they are estimated.
    Costly,
    /// They are not evaluated.
    LeftOut,
}

/// Where an opening is in the world: its box, and its axis if it is a prism.
pub(crate) type CutPlace = (Option<Extent>, Option<Vector3<f64>>);

/// Replaces the differences of an item by what they cut. True if it has any.
pub(crate) fn replace_by_base(file: &File<'_>, item: u32, patch: &mut Patch) -> bool {
    let base = base_of(file, item);
    let has_differences = base.is_some();
    base.into_iter().for_each(|(_, written)| patch.replace(item, written));
    has_differences
}

/// What the differences of an item cut, and that as the file writes it; `None` of an item that is no difference.
fn base_of(file: &File<'_>, item: u32) -> Option<(u32, String)> {
    let base = BooleanChain::of(file, item, |boolean| has_operator(boolean, "DIFFERENCE")).base;
    let base = base.filter(|base| *base != item)?;
    let keyword = file.record(base)?.keyword;
    Some((base, format!("{keyword}{}", file.arguments_as_written(base)?)))
}

/// What an item costs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
struct ItemWork {
    faces: u64,
    /// Pairs of faces of its own booleans, or work that is as much.
    pairs: u64,
}

impl<'f, 'a> CutBudget<'f, 'a> {
    pub(crate) fn new(file: &'f File<'a>) -> Self {
        Self {
            file,
            known: FxHashMap::default(),
            face_counts: FaceCounts::new(file),
            known_counts: FxHashMap::default(),
        }
    }

    /// The openings of an element that are too much work, the most detailed ones. `place_of` gives where an opening is, if that
    /// is known: openings that lie apart do not meet.
    pub(crate) fn excess(
        &mut self,
        body: &[u32],
        cuts: &[Cut<'_>],
        mut place_of: impl FnMut(&Cut<'_>) -> CutPlace,
    ) -> Excess {
        if cuts.is_empty() {
            return Excess { openings: Vec::new(), is_costly: false };
        }
        let own = self.of_items(body, 0);
        let host = self.count_of(body, 0);
        let mut cuts: Vec<(u64, FaceCount, &Cut<'_>)> =
            cuts.iter().map(|cut| (self.of_items(cut.1, 0).faces, self.count_of(cut.1, 0), cut)).collect();
        cuts.sort_by_key(|(faces, _, cut)| (*faces, cut.0));
        let per_face = WORK_PER_FACE.saturating_add(own.faces);
        let all = cuts.iter().fold(0u64, |sum, (faces, ..)| sum.saturating_add(*faces));
        let all_counts = cuts.iter().fold(FaceCount::default(), |sum, (_, count, _)| sum.and(*count));
        let is_costly = |work: u64, triangles: u64| work > WORK_APART || triangles > TRIANGLES_APART;
        if own.pairs.saturating_add(all.saturating_mul(per_face.saturating_add(all))) <= WORK_MAX
            && !is_costly(most_work(host, all_counts), host.and(all_counts).triangles)
        {
            return Excess { openings: Vec::new(), is_costly: false };
        }
        let mut work = own.pairs;
        let mut admitted: Vec<(u64, Option<Extent>)> = Vec::new();
        let mut cutters = CrossingCutters::of(host);
        let mut openings = Vec::new();
        for (k, (faces, count, cut)) in cuts.iter().enumerate() {
            let (extent, axis) = place_of(cut);
            let meets = |other: Option<Extent>| extent.zip(other).is_none_or(|(a, b)| a.meets(&b));
            let met: u64 = admitted.iter().filter(|(_, other)| meets(*other)).map(|(faces, _)| faces).sum();
            work = work.saturating_add(faces.saturating_mul(per_face.saturating_add(met)));
            if work > WORK_MAX || !cutters.admit(Cutter { count: *count, extent, axis }) {
                openings.extend(cuts[k..].iter().map(|(.., cut)| cut.0));
                break;
            }
            admitted.push((*faces, extent));
        }
        Excess { openings, is_costly: is_costly(cutters.work(), cutters.triangles()) }
    }

    /// The work of the booleans of an item: `None` if it is too much, else whether it may be far more than it is estimated.
    /// `extent_of` gives the box of an operand.
    fn of_booleans(&mut self, item: u32, mut extent_of: impl FnMut(u32) -> Option<Extent>) -> Option<bool> {
        let BooleanChain { booleans, base } = BooleanChain::of(self.file, item, |_| true);
        let operands: Vec<u32> = booleans.iter().rev().filter_map(|boolean| boolean.at(2).reference()).collect();
        if booleans.is_empty() {
            return Some(false);
        }
        let host = base.map_or(FaceCount::default(), |base| self.count_of(&[base], 0));
        let counts: Vec<FaceCount> = operands.iter().map(|operand| self.count_of(&[*operand], 0)).collect();
        let all = counts.iter().fold(FaceCount::default(), |sum, count| sum.and(*count));
        let triangles = host.and(all).triangles;
        if most_work(host, all) <= WORK_APART {
            return Some(triangles > TRIANGLES_APART);
        }
        let mut cutters = CrossingCutters::of(host);
        for (operand, count) in std::iter::zip(operands, counts) {
            let axis = axis_of(self.file, &[operand]);
            if !cutters.admit(Cutter { count, extent: extent_of(operand), axis }) {
                return None;
            }
        }
        Some(cutters.work() > WORK_APART || triangles > TRIANGLES_APART)
    }

    /// Replaces the booleans of an item by what they cut, if it is too much work; what has none is left to its box.
    pub(crate) fn uncut(
        &mut self,
        item: u32,
        patch: &mut Patch,
        extent_of: impl FnMut(u32) -> Option<Extent>,
    ) -> ItemCuts {
        if self.of_item(item, 0).pairs <= WORK_MAX {
            match self.of_booleans(item, extent_of) {
                Some(false) => return ItemCuts::Plain,
                Some(true) => return ItemCuts::Costly,
                None => {}
            }
        }
        // What is no difference, or has too much work inside its first operand, is emptied: its box stands in.
        let is_cheap = |budget: &mut Self, base: u32| budget.of_item(base, 0).pairs <= WORK_MAX;
        let base = base_of(self.file, item).filter(|(base, _)| is_cheap(self, *base));
        patch.replace(item, base.map_or_else(|| "IFCBOOLEANRESULT($,$,$)".to_owned(), |(_, written)| written));
        ItemCuts::LeftOut
    }

    /// How long items take to mesh, in pairs of faces or so.
    pub(crate) fn work(&mut self, items: &[u32]) -> u64 {
        let ItemWork { faces, pairs } = self.of_items(items, 0);
        faces.saturating_add(pairs)
    }

    /// Triangles and inner bounds of items.
    fn count_of(&mut self, items: &[u32], depth: usize) -> FaceCount {
        items.iter().fold(FaceCount::default(), |sum, item| sum.and(self.count_of_item(*item, depth)))
    }

    fn count_of_item(&mut self, item: u32, depth: usize) -> FaceCount {
        if let Some(known) = self.known_counts.get(&item) {
            return *known;
        }
        let record = self.file.record(item).filter(|_| depth <= DEPTH_MAX);
        let count = record.map_or(FaceCount::default(), |record| match record.keyword.to_ascii_uppercase().as_str() {
            "IFCCSGSOLID" => self.count_of(record.at(0).reference().as_slice(), depth + 1),
            "IFCMAPPEDITEM" => self.count_of(&mapped_items(self.file, item).collect::<Vec<u32>>(), depth + 1),
            "IFCBOOLEANRESULT" | "IFCBOOLEANCLIPPINGRESULT" => {
                let BooleanChain { booleans, base } = BooleanChain::of(self.file, item, |_| true);
                let operands = booleans.iter().filter_map(|boolean| boolean.at(2).reference()).chain(base);
                self.count_of(&operands.collect::<Vec<u32>>(), depth + 1)
            }
            "IFCFACETEDBREP" | "IFCFACETEDBREPWITHVOIDS" | "IFCFACEBASEDSURFACEMODEL" | "IFCSHELLBASEDSURFACEMODEL" => {
                let shells = record.at(0);
                let shells = shells.reference().map_or_else(|| shells.references(), |shell| vec![shell]);
                shells.into_iter().fold(FaceCount::default(), |sum, shell| sum.and(self.face_counts.of_shell(shell)))
            }
            "IFCPOLYGONALFACESET" => self.face_counts.of_shell(item),
            _ => FaceCount { triangles: self.of_item(item, depth).faces, ring_corners: 0 },
        });
        self.known_counts.insert(item, count);
        count
    }

    fn of_items(&mut self, items: &[u32], depth: usize) -> ItemWork {
        items.iter().fold(ItemWork::default(), |sum, &item| {
            let more = self.of_item(item, depth);
            ItemWork { faces: sum.faces.saturating_add(more.faces), pairs: sum.pairs.saturating_add(more.pairs) }
        })
    }

    fn of_item(&mut self, item: u32, depth: usize) -> ItemWork {
        if let Some(known) = self.known.get(&item) {
            return *known;
        }
        if depth > DEPTH_MAX {
            return ItemWork { faces: FACES_OF_OTHERS, pairs: 0 };
        }
        let work = self.file.record(item).map_or(ItemWork::default(), |record| self.of_record(&record, depth));
        self.known.insert(item, work);
        work
    }

    /// Of booleans along first operands. Each is known afterwards.
    fn of_chain(&mut self, item: u32, depth: usize) -> ItemWork {
        let BooleanChain { booleans, base } = BooleanChain::of(self.file, item, |_| true);
        let inner =
            |id: Option<u32>, budget: &mut Self| id.map_or(ItemWork::default(), |id| budget.of_item(id, depth + 1));
        let base = inner(base, self);
        booleans.iter().rev().fold(base, |a, boolean| {
            let b = inner(boolean.at(2).reference(), self);
            let pairs = a.faces.saturating_mul(b.faces).saturating_add(b.faces.saturating_mul(WORK_PER_FACE));
            let pairs = pairs.saturating_add(a.pairs).saturating_add(b.pairs);
            let work = ItemWork { faces: a.faces.saturating_add(b.faces), pairs };
            self.known.insert(boolean.id, work);
            work
        })
    }

    /// Of an extrusion: its sides and both ends, of which every pair of corners is work.
    fn of_extrusion(&self, record: &Record<'_>) -> ItemWork {
        let n_corners = record.at(0).reference().map_or(0, |profile| self.n_corners(profile, 0));
        ItemWork {
            faces: (4 * n_corners).saturating_sub(4),
            pairs: n_corners.saturating_mul(n_corners) / CORNERS_PER_PAIR,
        }
    }

    /// Corners of a profile, or points of a line.
    fn n_corners(&self, id: u32, depth: usize) -> u64 {
        let Some(record) = self.file.record(id) else { return 0 };
        if depth > DEPTH_MAX {
            return CORNERS_OF_OTHERS;
        }
        let of = |inner: Option<u32>| inner.map_or(0, |inner| self.n_corners(inner, depth + 1));
        let of_all = |inner: Vec<u32>| inner.into_iter().fold(0u64, |sum, inner| sum.saturating_add(of(Some(inner))));
        match record.keyword.to_ascii_uppercase().as_str() {
            "IFCRECTANGLEPROFILEDEF" => 4,
            "IFCARBITRARYCLOSEDPROFILEDEF" => of(record.at(2).reference()),
            "IFCARBITRARYPROFILEDEFWITHVOIDS" => {
                of(record.at(2).reference()).saturating_add(of_all(record.at(3).references()))
            }
            "IFCCOMPOSITEPROFILEDEF" => of_all(record.at(2).references()),
            "IFCDERIVEDPROFILEDEF" | "IFCMIRROREDPROFILEDEF" => of(record.at(2).reference()),
            "IFCPOLYLINE" | "IFCCARTESIANPOINTLIST2D" | "IFCCARTESIANPOINTLIST3D" => record.at(0).list().len() as u64,
            "IFCINDEXEDPOLYCURVE" | "IFCTRIMMEDCURVE" => of(record.at(0).reference()),
            "IFCCOMPOSITECURVE" | "IFCCOMPOSITECURVEONSURFACE" | "IFCBOUNDARYCURVE" => {
                of_all(record.at(0).references())
            }
            "IFCCOMPOSITECURVESEGMENT" | "IFCREPARAMETRISEDCOMPOSITECURVESEGMENT" => of(record.at(2).reference()),
            name if name.starts_with("IFCBSPLINECURVE") || name.starts_with("IFCRATIONALBSPLINECURVE") => {
                CORNERS_OF_OTHERS.saturating_mul(record.at(1).list().len() as u64)
            }
            _ => CORNERS_OF_OTHERS,
        }
    }

    fn of_record(&mut self, record: &Record<'_>, depth: usize) -> ItemWork {
        let mut inner = |id: Option<u32>| id.map_or(ItemWork::default(), |id| self.of_item(id, depth + 1));
        let n_members = |at: usize| record.at(at).list().len() as u64;
        let faces = match record.keyword.to_ascii_uppercase().as_str() {
            "IFCCSGSOLID" => return inner(record.at(0).reference()),
            "IFCMAPPEDITEM" => {
                let items: Vec<u32> = mapped_items(self.file, record.id).collect();
                return self.of_items(&items, depth + 1);
            }
            "IFCFACETEDBREP" | "IFCFACETEDBREPWITHVOIDS" => inner(record.at(0).reference()).faces,
            "IFCFACEBASEDSURFACEMODEL" | "IFCSHELLBASEDSURFACEMODEL" => {
                return self.of_items(&record.at(0).references(), depth + 1);
            }
            "IFCCLOSEDSHELL" | "IFCOPENSHELL" | "IFCCONNECTEDFACESET" => n_members(0),
            "IFCTRIANGULATEDFACESET" => n_members(3),
            "IFCPOLYGONALFACESET" => n_members(2),
            "IFCBOOLEANRESULT" | "IFCBOOLEANCLIPPINGRESULT" => return self.of_chain(record.id, depth),
            "IFCEXTRUDEDAREASOLID" | "IFCEXTRUDEDAREASOLIDTAPERED" => return self.of_extrusion(record),
            "IFCSWEPTDISKSOLID" | "IFCSWEPTDISKSOLIDPOLYGONAL" => {
                let n_points = record.at(0).reference().map_or(0, |line| self.n_corners(line, 0));
                let pairs = n_points.saturating_mul(WORK_PER_SWEPT_POINT);
                return ItemWork { faces: n_points.saturating_mul(FACES_OF_OTHERS), pairs };
            }
            name if name.contains("HALFSPACE") => 1,
            _ => FACES_OF_OTHERS,
        };
        ItemWork { faces, pairs: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BASICS, file, read, with_file};
    use crate::{CutPath, Element, GeometryStatus};
    use std::fmt::Write as _;
    use std::sync::atomic::{AtomicU32, Ordering};

    /// A closed shell of 2 n triangles around (x, 0, 0) with this id; ids up to `id + 4 n + 2` are used.
    fn ball(id: u32, n: u32, x: f64) -> String {
        let mut text = String::new();
        let (first_face, first_point) = (id + 2, id + 2 + 6 * n);
        let angle = |k: u32| std::f64::consts::TAU * f64::from(k) / f64::from(n);
        for k in 0..n {
            let (sin, cos) = libm::sincos(angle(k));
            writeln!(text, "#{}=IFCCARTESIANPOINT(({:.6},{:.6},0.));", first_point + k, x + cos, sin).unwrap();
        }
        let poles = [first_point + n, first_point + n + 1];
        for (pole, z) in poles.into_iter().zip([-1.0, 1.0]) {
            writeln!(text, "#{pole}=IFCCARTESIANPOINT(({x:.6},0.,{z:.6}));").unwrap();
        }
        let mut faces = Vec::new();
        for k in 0..n {
            let (a, b) = (first_point + k, first_point + (k + 1) % n);
            for (side, corners) in [[b, a, poles[0]], [a, b, poles[1]]].into_iter().enumerate() {
                let face = first_face + 3 * (2 * k + side as u32);
                let [p, q, r] = corners;
                writeln!(text, "#{}=IFCPOLYLOOP((#{p},#{q},#{r}));", face + 2).unwrap();
                writeln!(text, "#{}=IFCFACEOUTERBOUND(#{},.T.);#{face}=IFCFACE((#{}));", face + 1, face + 2, face + 1)
                    .unwrap();
                faces.push(format!("#{face}"));
            }
        }
        write!(text, "#{}=IFCCLOSEDSHELL(({}));#{id}=IFCFACETEDBREP(#{});", id + 1, faces.join(","), id + 1).unwrap();
        text
    }

    fn wall_with_openings(faces: &[u32]) -> String {
        let mut text = format!("{BASICS}#1=IFCWALL('wall',$,'W',$,$,#103,#121,$,.STANDARD.);");
        for (k, n) in (0..).zip(faces) {
            let (id, shell) = (1_000 * (k + 1), 1_000_000 * (k + 1));
            write!(
                text,
                "#{id}=IFCOPENINGELEMENT('o{k}',$,$,$,$,#103,#{},$,$);#{}=IFCPRODUCTDEFINITIONSHAPE($,$,(#{}));
                 #{}=IFCSHAPEREPRESENTATION(#101,'Body','Brep',(#{shell}));#{}=IFCRELVOIDSELEMENT('r{k}',$,$,$,#1,#{id});{}",
                id + 1, id + 1, id + 2, id + 2, id + 3, ball(shell, n / 2, 0.0)
            )
            .unwrap();
        }
        file(&text)
    }

    #[test]
    fn faces_and_pairs_are_counted_through_maps_and_booleans() {
        let text = file(&format!(
            "{BASICS}{}{}#1=IFCBOOLEANRESULT(.DIFFERENCE.,#1000000,#2000000);#2=IFCBOOLEANRESULT(.DIFFERENCE.,#1,#110);",
            ball(1_000_000, 50, 0.0),
            ball(2_000_000, 100, 0.5)
        ));
        let work = with_file(&text, |file| CutBudget::new(file).of_item(2, 0));
        let of_block = ItemWork { faces: 4 * 4 - 4, pairs: 4 * 4 / CORNERS_PER_PAIR };
        let pairs = 100 * 200 + 200 * WORK_PER_FACE + (300 + WORK_PER_FACE) * of_block.faces + of_block.pairs;
        assert_eq!(work, ItemWork { faces: 300 + of_block.faces, pairs });
    }

    #[test]
    fn a_chain_of_cuts_is_counted_to_its_end() {
        let link = |k: u32| format!("#{}=IFCBOOLEANRESULT(.UNION.,#{},#110);", 1_000 + k, 1_001 + k);
        let n = 3_000;
        let text = file(&format!(
            "{BASICS}{}#{}=IFCBOOLEANRESULT(.UNION.,#110,#110);",
            (0..n).map(link).collect::<String>(),
            1_000 + n
        ));
        let work = with_file(&text, |file| CutBudget::new(file).of_item(1_000, 0));
        assert_eq!(work.faces, 12 * u64::from(n + 2));
        assert!(work.pairs > WORK_MAX);
    }

    #[test]
    fn profiles_and_lines_of_very_many_points_are_too_much_work() {
        let work = |points: usize, item: &str| {
            let line = format!("#2=IFCPOLYLINE(({}));", vec!["#107"; points].join(","));
            let profile = "#3=IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#4);#4=IFCCOMPOSITECURVE((#5),.F.);
                #5=IFCCOMPOSITECURVESEGMENT(.CONTINUOUS.,.T.,#2);";
            with_file(&file(&format!("{BASICS}{line}{profile}#1={item};")), |file| {
                CutBudget::new(file).of_item(1, 0).pairs > WORK_MAX
            })
        };
        for item in ["IFCEXTRUDEDAREASOLID(#3,#102,#112,3.)", "IFCSWEPTDISKSOLID(#4,0.05,$,$,$)"] {
            assert!(!work(9_000, item) && work(40_000, item), "{item}");
        }
    }

    #[test]
    fn a_boolean_inside_itself_ends() {
        let text = file(&format!("{BASICS}#1=IFCBOOLEANRESULT(.DIFFERENCE.,#1,#1);"));
        assert!(with_file(&text, |file| CutBudget::new(file).of_item(1, 0).faces) > 0);
    }

    #[test]
    fn the_most_detailed_openings_are_left_out_and_told() {
        let (model, diagnostics) = read(&wall_with_openings(&[200, 60_000, 60_002])).unwrap();
        let Element { geometry, .. } = &model.elements[0];
        assert_eq!(geometry.status, GeometryStatus::Meshed);
        let told: Vec<_> = diagnostics.iter().filter(|d| d.code.name() == "openings_not_cut").collect();
        let [told] = told[..] else { panic!("{diagnostics:?}") };
        assert!(told.message.starts_with("2 of its 3 openings not cut: #2000, #3000"), "{}", told.message);
        assert_eq!(geometry.cut, CutPath::LeftOut);
        // The other is: half the wall of 1 x 0.5 x 3 in units of half a metre is inside them.
        let volume: f32 = geometry.parts.iter().map(crate::testing::volume_m3).sum();
        let (uncut, _) = read(&wall_with_openings(&[])).unwrap();
        let whole: f32 = uncut.elements[0].geometry.parts.iter().map(crate::testing::volume_m3).sum();
        assert!(volume < 0.95 * whole, "{volume} of {whole}");
    }

    #[test]
    fn a_difference_that_is_too_much_work_is_drawn_without_it() {
        let text = file(&format!(
            "{BASICS}#1=IFCWALL('wall',$,'W',$,$,#103,#2,$,$);#2=IFCPRODUCTDEFINITIONSHAPE($,$,(#3));
             #3=IFCSHAPEREPRESENTATION(#101,'Body','CSG',(#4));#4=IFCBOOLEANRESULT(.DIFFERENCE.,#110,#1000000);{}",
            ball(1_000_000, 40_000, 0.0)
        ));
        let (model, diagnostics) = read(&text).unwrap();
        assert_eq!(model.elements[0].geometry.status, GeometryStatus::Meshed);
        assert_eq!(model.elements[0].geometry.parts[0].positions_m.len(), 8, "a box");
        assert!(diagnostics.iter().any(|d| d.code.name() == "openings_not_cut"), "{diagnostics:?}");
    }

    #[test]
    fn a_union_that_is_too_much_work_is_its_box() {
        let text = file(&format!(
            "{BASICS}#1=IFCWALL('wall',$,'W',$,$,#103,#2,$,$);#2=IFCPRODUCTDEFINITIONSHAPE($,$,(#3));
             #3=IFCSHAPEREPRESENTATION(#101,'Body','CSG',(#4));#4=IFCBOOLEANRESULT(.UNION.,#110,#1000000);{}",
            ball(1_000_000, 40_000, 0.0)
        ));
        let (model, _) = read(&text).unwrap();
        assert!(matches!(model.elements[0].geometry.status, GeometryStatus::BoundingBox { .. }));
    }

    /// A wall with openings that all meet, each a box whose axis leans by so much more than that of the one before.
    fn wall_with_crossing_openings(n: u32, lean: f64) -> String {
        let mut text = format!("{BASICS}#1=IFCWALL('wall',$,'W',$,$,#103,#121,$,.STANDARD.);");
        for k in 0..n {
            let id = 1_000 + 10 * k;
            write!(
                text,
                "#{id}=IFCOPENINGELEMENT('o{k}',$,$,$,$,#103,#{},$,$);#{}=IFCPRODUCTDEFINITIONSHAPE($,$,(#{}));
                 #{}=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',(#{}));#{}=IFCEXTRUDEDAREASOLID(#90,#{},#112,4.);
                 #{}=IFCAXIS2PLACEMENT3D(#107,#{},#112);#{}=IFCDIRECTION(({:.3},1.,0.));#{}=IFCRELVOIDSELEMENT('r{k}',$,$,$,#1,#{id});",
                id + 1, id + 1, id + 2, id + 2, id + 3, id + 3, id + 4, id + 4, id + 5, id + 5,
                lean * f64::from(k), id + 6
            )
            .unwrap();
        }
        file(&format!(
            "{text}#90=IFCRECTANGLEPROFILEDEF(.AREA.,$,#91,1.,0.2);#91=IFCAXIS2PLACEMENT2D(#92,$);
            #92=IFCCARTESIANPOINT((1.5,0.));"
        ))
    }

    /// The same of a wall without a top, which only the kernel cuts.
    fn open_wall_with_crossing_openings(n: u32, lean: f64) -> String {
        let corner = |k: u32| [k & 1, k >> 1 & 1, k >> 2].map(|bit| f64::from(bit) - 0.5);
        let points = (0..8).map(|k| {
            let [x, y, z] = corner(k);
            format!("#{}=IFCCARTESIANPOINT(({:?},{:?},{:?}));", 20 + k, 2.0 * x, y, 3.0 * (z + 0.5))
        });
        let faces = [[0, 2, 3, 1], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces = (30..).step_by(3).zip(faces).map(|(id, [a, b, c, d])| {
            let ring = format!("#{}=IFCPOLYLOOP((#{},#{},#{},#{}));", id + 2, 20 + a, 20 + b, 20 + c, 20 + d);
            format!("#{id}=IFCFACE((#{}));#{}=IFCFACEOUTERBOUND(#{},.T.);{ring}", id + 1, id + 1, id + 2)
        });
        let shell = "#50=IFCOPENSHELL((#30,#33,#36,#39,#42));#51=IFCSHELLBASEDSURFACEMODEL((#50));
            #52=IFCSHAPEREPRESENTATION(#101,'Body','SurfaceModel',(#51));#53=IFCPRODUCTDEFINITIONSHAPE($,$,(#52));";
        let records: String = points.chain(faces).chain([shell.to_owned()]).collect();
        let text = wall_with_crossing_openings(n, lean).replace("'W',$,$,#103,#121,", "'W',$,$,#103,#53,");
        text.replace("#1=IFCWALL(", &format!("{records}#1=IFCWALL("))
    }

    #[test]
    fn openings_that_cross_are_counted_where_the_kernel_cuts_and_parallel_ones_are_cut() {
        let not_cut = |text: &str| {
            // What is left is not cut either, which costs no time.
            let (_, diagnostics, _) = asked_of_process(text);
            let told = diagnostics.into_iter().find(|d| d.code.name() == "openings_not_cut");
            told.map(|d| d.message.split(':').next().unwrap_or_default().to_owned())
        };
        assert_eq!(not_cut(&wall_with_crossing_openings(40, 0.01)), None);
        assert_eq!(not_cut(&open_wall_with_crossing_openings(40, 0.0)), None);
        let told = not_cut(&open_wall_with_crossing_openings(40, 0.01));
        assert_eq!(told.as_deref(), Some("28 of its 40 openings not cut"));
    }

    /// The number of bodies that the other process is asked for, which makes none that has openings.
    fn asked_of_process(text: &str) -> (Vec<Element>, Vec<diagnostics::Diagnostic>, u32) {
        let n_asked = AtomicU32::new(0);
        let process = |task: &[&[u8]], _: Option<f64>, take: &mut dyn FnMut(&[u8])| {
            let task = task.concat();
            n_asked.fetch_add(u32::from(task[0]), Ordering::Relaxed);
            if memchr::memmem::find(&task, b"IFCRELVOIDSELEMENT").is_some() {
                return (0.0, Err("it takes too long".to_owned()));
            }
            let mut answer = Vec::new();
            let end = crate::mesh_task(&task, &mut |bytes| answer.extend_from_slice(bytes));
            take(&answer);
            (0.0, end.map_err(|error| error.to_string()))
        };
        let options = crate::ReadOptions { isolation: Some(&process), ..crate::ReadOptions::default() };
        let (model, diagnostics) = crate::read(text.as_bytes(), &options).unwrap();
        (model.elements, diagnostics, n_asked.into_inner())
    }

    #[test]
    fn costly_cuts_are_made_apart_and_a_body_whose_cuts_are_given_up_is_whole() {
        assert_eq!(asked_of_process(&open_wall_with_crossing_openings(3, 0.1)).2, 0);
        let (elements, diagnostics, n_asked) = asked_of_process(&open_wall_with_crossing_openings(9, 0.1));
        assert_eq!(n_asked, 2, "once with its cuts and once without");
        let Element { geometry, .. } = &elements[0];
        assert_eq!(geometry.status, GeometryStatus::Meshed);
        assert_eq!(geometry.parts[0].positions_m.len(), 8, "a box");
        let [told] = &diagnostics[..] else { panic!("{diagnostics:?}") };
        assert_eq!(
            (told.code.name(), told.entity.as_ref().map(|id| &*id.global_id)),
            ("openings_not_cut", Some("wall"))
        );
        assert_eq!(told.message, "its openings and other cuts are not cut: it takes too long");
    }
}
