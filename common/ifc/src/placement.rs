//! Product placements: chains of IfcLocalPlacement in f64; other kinds through the kernel.

use rustc_hash::FxHashMap;

use crate::affine::{affine, is_finite, normalised};
use crate::kernel::{File, Record, Resolver};
use nalgebra::{Affine3, Point3, Vector3};

/// Longest chain of placements; the kernel has the same bound.
const CHAIN_MAX: usize = 100;

/// Placements of the file, each resolved once. Metres.
pub(crate) struct Placements<'f, 'a> {
    file: &'f File<'a>,
    unit_m: f64,
    known: FxHashMap<u32, Result<Affine3<f64>, &'static str>>,
    kernel: Option<Resolver<'a>>,
}

impl<'f, 'a> Placements<'f, 'a> {
    pub(crate) fn new(file: &'f File<'a>, unit_m: f64) -> Self {
        Self { file, unit_m, known: FxHashMap::default(), kernel: None }
    }

    /// The frame of a product in the world: `Ok(None)` if it has no placement, else why it cannot be resolved.
    pub(crate) fn of_product(&mut self, product: &Record<'_>) -> Result<Option<Affine3<f64>>, &'static str> {
        let Some(placement) = product.at(5).reference() else { return Ok(None) };
        match self.resolve(placement) {
            Err(NOT_LOCAL) => {
                let kernel = self.kernel.get_or_insert_with(|| Resolver::new(self.file));
                kernel.placement(product.id).map(Some).ok_or("its grid or linear placement cannot be resolved")
            }
            other => other.map(Some),
        }
    }

    fn resolve(&mut self, placement: u32) -> Result<Affine3<f64>, &'static str> {
        let mut chain: Vec<(u32, Affine3<f64>)> = Vec::new();
        let mut next = Some(placement);
        let mut world = Ok(Affine3::identity());
        while let Some(id) = next {
            if let Some(&known) = self.known.get(&id) {
                world = known;
                break;
            }
            if chain.len() >= CHAIN_MAX || chain.iter().any(|&(seen, _)| seen == id) {
                world = Err("its placement is relative to itself or nested too deeply");
                break;
            }
            match local(self.file, id, self.unit_m) {
                Ok((local, parent)) => {
                    chain.push((id, local));
                    next = parent;
                }
                Err(why) => {
                    world = Err(why);
                    break;
                }
            }
        }
        for (id, local) in chain.into_iter().rev() {
            world = world.map(|parent| parent * local);
            self.known.insert(id, world);
        }
        world.and_then(|w| if is_finite(&w) { Ok(w) } else { Err("its placement is not finite") })
    }
}

const NOT_LOCAL: &str = "its placement is of another kind";

/// The placement relative to its parent, and the parent.
fn local(file: &File<'_>, id: u32, unit_m: f64) -> Result<(Affine3<f64>, Option<u32>), &'static str> {
    let record = file.record(id).ok_or("its placement is missing")?;
    if !record.is("IFCLOCALPLACEMENT") {
        return Err(NOT_LOCAL);
    }
    let relative = record.at(1).reference().and_then(|id| file.record(id)).ok_or("its placement is missing")?;
    Ok((axis2_placement(file, &relative, unit_m).ok_or("its placement is malformed")?, record.at(0).reference()))
}

/// IfcAxis2Placement2D or 3D.
pub(crate) fn axis2_placement(file: &File<'_>, record: &Record<'_>, unit_m: f64) -> Option<Affine3<f64>> {
    let origin = point(file, record.at(0).reference()?)? * unit_m;
    let direction = |at: usize| record.at(at).reference().and_then(|id| direction(file, id));
    if record.is("IFCAXIS2PLACEMENT2D") {
        let x = direction(1).and_then(|d| normalised(Vector3::new(d.x, d.y, 0.0))).unwrap_or_else(Vector3::x);
        return Some(affine([x, Vector3::new(-x.y, x.x, 0.0), Vector3::z()], origin));
    }
    let z = direction(1).and_then(normalised).unwrap_or_else(Vector3::z);
    let x = direction(2).and_then(|d| across(d, z)).or_else(|| across(fallback(z), z))?;
    Some(affine([x, z.cross(&x), z], origin))
}

/// IfcCartesianTransformationOperator2D or 3D, with or without a scale per axis.
pub(crate) fn operator(file: &File<'_>, record: &Record<'_>, unit_m: f64) -> Option<Affine3<f64>> {
    let direction = |at: usize| record.at(at).reference().and_then(|id| direction(file, id)).and_then(normalised);
    let origin = record.at(2).reference().and_then(|id| point(file, id))? * unit_m;
    let scale = record.at(3).number().unwrap_or(1.0);
    let (z, scales) = if record.keyword.to_ascii_uppercase().starts_with("IFCCARTESIANTRANSFORMATIONOPERATOR3D") {
        let scales = [Some(scale), record.at(5).number(), record.at(6).number()].map(|s| s.unwrap_or(scale));
        (direction(4), scales)
    } else {
        (None, [scale, record.at(4).number().unwrap_or(scale), scale])
    };
    let z = z.unwrap_or_else(Vector3::z);
    let x = direction(0).and_then(|d| across(d, z)).or_else(|| across(fallback(z), z))?;
    let y = z.cross(&x);
    // Axis2 may point the other way: that is how a mirror is written.
    let y = if direction(1).is_some_and(|d| d.dot(&y) < 0.0) { -y } else { y };
    Some(affine([x * scales[0], y * scales[1], z * scales[2]], origin))
}

/// The direction nearest to `d` at right angles to the unit vector `n`; `None` if `d` is along `n`.
fn across(d: Vector3<f64>, n: Vector3<f64>) -> Option<Vector3<f64>> {
    normalised(d - n * d.dot(&n))
}

/// An axis that is far from along `z`.
fn fallback(z: Vector3<f64>) -> Vector3<f64> {
    if z.x.abs() < 0.9 { Vector3::x() } else { Vector3::y() }
}

/// IfcCartesianPoint in the file's units; a 2D point has z = 0.
pub(crate) fn point(file: &File<'_>, id: u32) -> Option<Point3<f64>> {
    let record = file.record_of(id, "IFCCARTESIANPOINT")?;
    let coordinates = record.at(0).list();
    let at = |i: usize| coordinates.get(i).map_or(Some(0.0), |c| c.number());
    (!coordinates.is_empty()).then_some(())?;
    Some(Point3::new(at(0)?, at(1)?, at(2)?))
}

/// IfcDirection, of any length; a 2D direction has z = 0.
pub(crate) fn direction(file: &File<'_>, id: u32) -> Option<Vector3<f64>> {
    let record = file.record_of(id, "IFCDIRECTION")?;
    let ratios = record.at(0).list();
    let at = |i: usize| ratios.get(i).map_or(Some(0.0), |c| c.number());
    Some(Vector3::new(at(0)?, at(1)?, at(2)?))
}
