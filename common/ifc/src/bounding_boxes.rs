//! Bounding boxes of representation items that cannot be meshed.

use crate::MeshPart;
use std::f64::consts::TAU;

use crate::affine::{normalised, origin};
use crate::boolean_chain::{BooleanChain, has_operator};
use crate::kernel::{File, Record};
use crate::placement::{axis2_placement, operator, point};
use crate::units;
use nalgebra::{Affine3, Point3, Vector3};

/// Limit of records visited in one file.
const VISITS_MAX: usize = 1_000_000;
/// Deepest nesting of items.
const DEPTH_MAX: usize = 48;

/// Axis-parallel box in the coordinates of the product, in metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Extent {
    pub(crate) low: Point3<f64>,
    pub(crate) high: Point3<f64>,
}

/// Finds boxes.
pub(crate) struct Extents<'f, 'a> {
    file: &'f File<'a>,
    unit_m: f64,
    /// Radians per unit of angles; without it a turn is a whole one.
    radians: Option<f64>,
    visits: usize,
    /// Items that are being looked into, to find those inside themselves.
    chain: Vec<u32>,
}

impl Extent {
    const EMPTY: Self = Self {
        low: Point3::new(f64::INFINITY, f64::INFINITY, f64::INFINITY),
        high: Point3::new(f64::NEG_INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY),
    };

    /// The box around points; `None` without any.
    pub(crate) fn around(points: impl Iterator<Item = Point3<f64>>) -> Option<Self> {
        let mut extent = Self::EMPTY;
        points.for_each(|p| extent.add(p, 0.0));
        extent.usable()
    }

    fn add(&mut self, p: Point3<f64>, radius: f64) {
        for i in 0..3 {
            self.low[i] = self.low[i].min(p[i] - radius);
            self.high[i] = self.high[i].max(p[i] + radius);
        }
    }

    pub(crate) fn contains(&self, p: Point3<f64>, margin: f64) -> bool {
        (0..3).all(|i| self.low[i] - margin <= p[i] && p[i] <= self.high[i] + margin)
    }

    pub(crate) fn meets(&self, other: &Self) -> bool {
        (0..3).all(|i| self.low[i] <= other.high[i] && other.low[i] <= self.high[i])
    }

    /// The box around this box in another frame.
    pub(crate) fn moved(&self, frame: &Affine3<f64>) -> Self {
        let mut moved = Self::EMPTY;
        self.corners().into_iter().for_each(|corner| moved.add(frame * corner, 0.0));
        moved
    }

    pub(crate) fn corners(&self) -> [Point3<f64>; 8] {
        std::array::from_fn(|i| [0, 1, 2].map(|k| if i >> k & 1 == 0 { self.low[k] } else { self.high[k] }).into())
    }

    fn usable(self) -> Option<Self> {
        let sizes = self.high - self.low;
        sizes.iter().all(|s| s.is_finite() && *s >= 0.0).then_some(self)
    }
}

impl<'f, 'a> Extents<'f, 'a> {
    pub(crate) fn new(file: &'f File<'a>, unit_m: f64) -> Self {
        Self { file, unit_m, radians: units::radians(file), visits: 0, chain: Vec::new() }
    }

    /// Of IfcBoundingBox items: (Corner, XDim, YDim, ZDim).
    pub(crate) fn of_boxes(&mut self, items: &[u32]) -> Option<Extent> {
        let mut extent = Extent::EMPTY;
        for record in items.iter().filter_map(|&id| self.file.record_of(id, "IFCBOUNDINGBOX")) {
            let corner = point(self.file, record.at(0).reference()?)?;
            let sizes = Vector3::new(record.at(1).number()?, record.at(2).number()?, record.at(3).number()?);
            extent.add(corner * self.unit_m, 0.0);
            extent.add((corner + sizes) * self.unit_m, 0.0);
        }
        extent.usable()
    }

    /// Of any items; generous where the shape is unknown.
    pub(crate) fn of_items(&mut self, items: &[u32]) -> Option<Extent> {
        let mut extent = Extent::EMPTY;
        for &item in items {
            self.visit_item(item, &Affine3::identity(), 0, &mut extent);
        }
        extent.usable()
    }

    fn visit_item(&mut self, id: u32, frame: &Affine3<f64>, depth: usize, extent: &mut Extent) {
        self.visits += 1;
        if self.visits > VISITS_MAX || depth > DEPTH_MAX || self.chain.contains(&id) {
            return;
        }
        let Some(record) = self.file.record(id) else { return };
        self.chain.push(id);
        self.visit(&record, frame, depth, extent);
        self.chain.pop();
    }

    fn visit(&mut self, record: &Record<'_>, frame: &Affine3<f64>, depth: usize, extent: &mut Extent) {
        let id = record.id;
        let keyword = record.keyword.to_ascii_uppercase();
        match keyword.as_str() {
            "IFCCARTESIANPOINT" => {
                if let Some(p) = point(self.file, id) {
                    extent.add(frame * (p * self.unit_m), 0.0);
                }
            }
            "IFCCARTESIANPOINTLIST2D" | "IFCCARTESIANPOINTLIST3D" => self.points(record, frame, extent),
            "IFCMAPPEDITEM" => {
                let Some(map) = mapping(self.file, record, self.unit_m) else { return };
                for item in mapped_items(self.file, id).collect::<Vec<u32>>() {
                    self.visit_item(item, &(frame * map), depth + 1, extent);
                }
            }
            "IFCBOOLEANRESULT" | "IFCBOOLEANCLIPPINGRESULT" => {
                let chain = BooleanChain::of(self.file, id, |_| true);
                let united = chain.booleans.iter().filter(|boolean| has_operator(boolean, "UNION"));
                let operands = united.filter_map(|boolean| boolean.at(2).reference()).chain(chain.base);
                operands.for_each(|id| self.visit_item(id, frame, depth + 1, extent));
            }
            "IFCEXTRUDEDAREASOLID" | "IFCEXTRUDEDAREASOLIDTAPERED" => self.extrusion(record, frame, depth, extent),
            "IFCREVOLVEDAREASOLID" | "IFCREVOLVEDAREASOLIDTAPERED" => self.revolution(record, frame, depth, extent),
            "IFCSWEPTDISKSOLID" | "IFCSWEPTDISKSOLIDPOLYGONAL" => {
                let radius = record.at(1).number().unwrap_or(0.0) * self.unit_m;
                self.along(record, 0, radius, frame, depth, extent);
            }
            "IFCSURFACECURVESWEPTAREASOLID"
            | "IFCFIXEDREFERENCESWEPTAREASOLID"
            | "IFCDIRECTRIXDERIVEDREFERENCESWEPTAREASOLID" => {
                let frame = frame * self.position(record, 1);
                let profile = self.inner(record.at(0).reference(), &Affine3::identity(), depth);
                let radius = profile.map_or(0.0, |p| p.corners().iter().map(|c| c.coords.norm()).fold(0.0, f64::max));
                self.along(record, 2, radius, &frame, depth, extent);
            }
            "IFCCIRCLE" | "IFCELLIPSE" => {
                let frame = frame * self.position(record, 0);
                let radius = [1, 2].map(|at| record.at(at).number().unwrap_or(0.0)).into_iter().fold(0.0, f64::max);
                extent.add(origin(&frame), radius * self.unit_m);
            }
            name if name.ends_with("PROFILEDEF") && record.at(2).number().is_none() && self.is_sized(record) => {
                self.sized_profile(record, frame, extent);
            }
            "IFCBLOCK"
            | "IFCRECTANGULARPYRAMID"
            | "IFCSPHERE"
            | "IFCRIGHTCIRCULARCONE"
            | "IFCRIGHTCIRCULARCYLINDER" => {
                let frame = frame * self.position(record, 0);
                let size = self.largest(record, 1);
                extent.add(origin(&frame), size);
            }
            "IFCAXIS2PLACEMENT3D" | "IFCAXIS2PLACEMENT2D" | "IFCDIRECTION" | "IFCSTYLEDITEM" => {}
            name if name.contains("HALFSPACE") => {}
            _ => {
                for value in record.arguments() {
                    for id in value.references() {
                        self.visit_item(id, frame, depth + 1, extent);
                    }
                }
            }
        }
    }

    fn points(&mut self, record: &Record<'_>, frame: &Affine3<f64>, extent: &mut Extent) {
        for coordinates in record.at(0).list() {
            let at = |i: usize| coordinates.list().get(i).and_then(|c| c.number()).unwrap_or(0.0) * self.unit_m;
            extent.add(frame * Point3::new(at(0), at(1), at(2)), 0.0);
        }
    }

    /// The placement in this attribute, or none.
    fn position(&self, record: &Record<'_>, at: usize) -> Affine3<f64> {
        let position = record.at(at).reference().and_then(|id| self.file.record(id));
        position.and_then(|p| axis2_placement(self.file, &p, self.unit_m)).unwrap_or_else(Affine3::identity)
    }

    fn inner(&mut self, id: Option<u32>, frame: &Affine3<f64>, depth: usize) -> Option<Extent> {
        let mut extent = Extent::EMPTY;
        self.visit_item(id?, frame, depth + 1, &mut extent);
        extent.usable()
    }

    fn extrusion(&mut self, record: &Record<'_>, frame: &Affine3<f64>, depth: usize, extent: &mut Extent) {
        let frame = frame * self.position(record, 1);
        let Some(profile) = self.inner(record.at(0).reference(), &Affine3::identity(), depth) else { return };
        let direction = self.direction(record.at(2).reference());
        let depth_m = record.at(3).number().unwrap_or(0.0) * self.unit_m;
        let along = normalised(direction).unwrap_or_else(Vector3::z) * depth_m;
        for corner in profile.corners() {
            extent.add(frame * corner, 0.0);
            extent.add(frame * (corner + along), 0.0);
        }
    }

    /// An IfcDirection; upwards without one.
    fn direction(&self, id: Option<u32>) -> Vector3<f64> {
        id.and_then(|id| self.file.record(id)).map_or_else(Vector3::z, |d| {
            let ratio = |i: usize| d.at(0).list().get(i).and_then(|x| x.number()).unwrap_or(0.0);
            Vector3::new(ratio(0), ratio(1), ratio(2))
        })
    }

    /// (SweptArea, Position, Axis, Angle, EndSweptArea): the corners of the profile on their way round.
    fn revolution(&mut self, record: &Record<'_>, frame: &Affine3<f64>, depth: usize, extent: &mut Extent) {
        const STEPS: i32 = 32;
        let frame = frame * self.position(record, 1);
        let Some(axis) = record.at(2).reference().and_then(|id| self.file.record(id)) else { return };
        let Some(centre) = axis.at(0).reference().and_then(|id| point(self.file, id)) else { return };
        let centre = centre * self.unit_m;
        let Some(n) = normalised(self.direction(axis.at(1).reference())) else { return };
        let angle = record.at(3).number().zip(self.radians).map(|(angle, radians)| angle * radians);
        let step = angle.filter(|a| a.abs() < TAU).unwrap_or(TAU) / f64::from(STEPS);
        for profile in [0, 4].into_iter().filter_map(|at| record.at(at).reference()) {
            let Some(profile) = self.inner(Some(profile), &Affine3::identity(), depth) else { continue };
            for corner in profile.corners() {
                let v = corner - centre;
                // Between two steps the arc leaves the chord by less than this.
                let sag = v.norm() * (1.0 - libm::cos(step / 2.0));
                for i in 0..=STEPS {
                    let (sin, cos) = libm::sincos(step * f64::from(i));
                    let (w, k) = (n.cross(&v), n.dot(&v) * (1.0 - cos));
                    extent.add(frame * (centre + v * cos + w * sin + n * k), sag);
                }
            }
        }
    }

    /// A curve with something of this radius around it.
    fn along(
        &mut self,
        record: &Record<'_>,
        at: usize,
        radius: f64,
        frame: &Affine3<f64>,
        depth: usize,
        extent: &mut Extent,
    ) {
        if let Some(curve) = self.inner(record.at(at).reference(), frame, depth) {
            extent.add(curve.low, radius);
            extent.add(curve.high, radius);
        }
    }

    /// A profile that is given by sizes: (ProfileType, ProfileName, Position, sizes ..).
    fn is_sized(&self, record: &Record<'_>) -> bool {
        record.at(3).number().is_some()
    }

    fn sized_profile(&mut self, record: &Record<'_>, frame: &Affine3<f64>, extent: &mut Extent) {
        let frame = frame * self.position(record, 2);
        let size = |at: usize| record.at(at).number().unwrap_or(0.0) * self.unit_m;
        let (x, y) = match record.keyword.to_ascii_uppercase().as_str() {
            "IFCCIRCLEPROFILEDEF" | "IFCCIRCLEHOLLOWPROFILEDEF" => (size(3), size(3)),
            "IFCELLIPSEPROFILEDEF" => (size(3), size(4)),
            name if name.starts_with("IFCRECTANGLE") || name.starts_with("IFCROUNDED") => {
                (size(3) / 2.0, size(4) / 2.0)
            }
            _ => (self.largest(record, 3), self.largest(record, 3)),
        };
        for (x, y) in [(x, y), (-x, y), (x, -y), (-x, -y)] {
            extent.add(frame * Point3::new(x, y, 0.0), 0.0);
        }
    }

    fn largest(&self, record: &Record<'_>, from: usize) -> f64 {
        let sizes = record.arguments().iter().skip(from).filter_map(|v| v.number());
        sizes.fold(0.0, |a: f64, b| a.max(b.abs())) * self.unit_m
    }
}

/// Of meshes, in the world.
pub(crate) fn of_parts(parts: &[MeshPart]) -> Option<Extent> {
    Extent::around(parts.iter().flat_map(MeshPart::points_m).map(Point3::from))
}

/// Items of the representation that an IfcMappedItem maps.
pub(crate) fn mapped_items<'a>(file: &File<'a>, item: u32) -> impl Iterator<Item = u32> + use<'a> {
    let items = || {
        let map = file.record(file.record(item)?.at(0).reference()?)?;
        Some(file.record(map.at(1).reference()?)?.at(3).references())
    };
    items().unwrap_or_default().into_iter()
}

/// From the coordinates of the mapped representation to those of the IfcMappedItem's user.
pub(crate) fn mapping(file: &File<'_>, item: &Record<'_>, unit_m: f64) -> Option<Affine3<f64>> {
    let map = file.record(item.at(0).reference()?)?;
    let origin = axis2_placement(file, &file.record(map.at(0).reference()?)?, unit_m)?;
    let target = operator(file, &file.record(item.at(1).reference()?)?, unit_m)?;
    Some(target * origin)
}

/// The box as a mesh in the world; `None` if it is not finite.
pub(crate) fn mesh(extent: Extent, frame: &Affine3<f64>) -> Option<MeshPart> {
    const FACES: [[u32; 4]; 6] = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let centre = (extent.low + extent.high.coords) / 2.0;
    let origin_m: [f64; 3] = (frame * centre).into();
    let corner = |c: Point3<f64>| <[f64; 3]>::from(frame * (c - centre)).map(|x| x as f32);
    let positions_m: Vec<[f32; 3]> = extent.corners().into_iter().map(corner).collect();
    let finite = origin_m.iter().all(|x| x.abs() < 1e9) && positions_m.iter().flatten().all(|x| x.abs() < 1e9);
    let triangles = FACES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    finite.then_some(MeshPart { origin_m, positions_m, triangles, colour: None })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{BASICS, file, volume_m3, with_file};

    #[test]
    fn an_extrusion_reaches_as_far_as_its_profile_and_depth() {
        let extent = with_file(&file(BASICS), |file| Extents::new(file, 0.5).of_items(&[110])).unwrap();
        assert_eq!((extent.low, extent.high), (Point3::new(-0.5, -0.25, 0.0), Point3::new(0.5, 0.25, 1.5)));
    }

    #[test]
    fn an_item_that_maps_itself_ends() {
        let text = file(&format!(
            "{BASICS}#1=IFCMAPPEDITEM(#2,#3);#2=IFCREPRESENTATIONMAP(#102,#4);
             #3=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#107,$,$);#4=IFCSHAPEREPRESENTATION(#101,'Body','X',(#1,#1,#110));"
        ));
        assert!(with_file(&text, |file| Extents::new(file, 1.0).of_items(&[1])).is_some());
    }

    #[test]
    fn a_box_is_closed_and_looks_outward() {
        let extent = Extent { low: Point3::origin(), high: Point3::new(1.0, 2.0, 3.0) };
        let part = mesh(extent, &Affine3::identity()).unwrap();
        let volume = volume_m3(&part);
        assert!((volume - 6.0).abs() < 1e-5, "{volume}");
    }
}
