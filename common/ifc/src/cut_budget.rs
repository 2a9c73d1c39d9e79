//! Leaves out what would keep the kernel busy for minutes: cuts, booleans, and items of very many points.
//!
//! The kernel has no limit of its own where detailed bodies meet. Its work is estimated from the records, in pairs of faces,
//! so that what is left out depends on the file alone. On the machine of the benchmarks a pair is half a microsecond: the
//! limit is about two seconds for an element.

use rustc_hash::FxHashMap;

use crate::boolean_chain::{BooleanChain, has_operator};
use crate::bounding_boxes::{Extent, mapped_items};
use crate::kernel::{File, Patch, Record};

/// Limit of an element's work, in pairs of faces.
const WORK_MAX: u64 = 4_000_000;

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
        Self { file, known: FxHashMap::default() }
    }

    /// The openings of an element that are too much work, the most detailed ones. `extent_of` gives the box of an opening in the
    /// world, if it is known: openings that lie apart do not meet.
    pub(crate) fn excess(
        &mut self,
        body: &[u32],
        cuts: &[Cut<'_>],
        mut extent_of: impl FnMut(&Cut<'_>) -> Option<Extent>,
    ) -> Vec<u32> {
        let own = self.of_items(body, 0);
        let mut cuts: Vec<(u64, &Cut<'_>)> = cuts.iter().map(|cut| (self.of_items(cut.1, 0).faces, cut)).collect();
        cuts.sort_by_key(|(faces, cut)| (*faces, cut.0));
        let per_face = WORK_PER_FACE.saturating_add(own.faces);
        let all = cuts.iter().fold(0u64, |sum, (faces, _)| sum.saturating_add(*faces));
        if own.pairs.saturating_add(all.saturating_mul(per_face.saturating_add(all))) <= WORK_MAX {
            return Vec::new();
        }
        let mut work = own.pairs;
        let mut admitted: Vec<(u64, Option<Extent>)> = Vec::new();
        for (k, (faces, cut)) in cuts.iter().enumerate() {
            let extent = extent_of(cut);
            let meets = |other: Option<Extent>| extent.zip(other).is_none_or(|(a, b)| a.meets(&b));
            let met: u64 = admitted.iter().filter(|(_, other)| meets(*other)).map(|(faces, _)| faces).sum();
            work = work.saturating_add(faces.saturating_mul(per_face.saturating_add(met)));
            if work > WORK_MAX {
                return cuts[k..].iter().map(|(_, cut)| cut.0).collect();
            }
            admitted.push((*faces, extent));
        }
        Vec::new()
    }

    /// Replaces the booleans of an item by what they cut, if it is too much work; what has none is left to its box. True if
    /// it did.
    pub(crate) fn uncut(&mut self, item: u32, patch: &mut Patch) -> bool {
        if self.of_item(item, 0).pairs <= WORK_MAX {
            return false;
        }
        let operand = BooleanChain::of(self.file, item, |boolean| has_operator(boolean, "DIFFERENCE")).base;
        let operand = operand.unwrap_or(item);
        let record = self.file.record(operand).filter(|_| operand != item);
        let written = record.and_then(|r| Some(format!("{}{}", r.keyword, self.file.arguments_as_written(operand)?)));
        // What is no difference, or has too much work inside its first operand, is emptied: its box stands in.
        let is_cheap = self.of_item(operand, 0).pairs <= WORK_MAX;
        patch.replace(item, written.filter(|_| is_cheap).unwrap_or_else(|| "IFCBOOLEANRESULT($,$,$)".to_owned()));
        true
    }

    /// How long items take to mesh, in pairs of faces or so.
    pub(crate) fn work(&mut self, items: &[u32]) -> u64 {
        let ItemWork { faces, pairs } = self.of_items(items, 0);
        faces.saturating_add(pairs)
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
    use crate::{Element, GeometryStatus};
    use std::fmt::Write as _;

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
    fn the_most_detailed_opening_is_left_out_and_told() {
        let (model, diagnostics) = read(&wall_with_openings(&[200, 60_000, 300])).unwrap();
        let Element { geometry, .. } = &model.elements[0];
        assert_eq!(geometry.status, GeometryStatus::Meshed);
        let told: Vec<_> = diagnostics.iter().filter(|d| d.code.name() == "openings_not_cut").collect();
        let [told] = told[..] else { panic!("{diagnostics:?}") };
        assert!(told.message.starts_with("1 of its 3 openings not cut: #2000"), "{}", told.message);
        // The others are: half the wall of 1 x 0.5 x 3 in units of half a metre is inside them.
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
}
