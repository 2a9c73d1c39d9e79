//! Placements resolved by the kernel: IfcGridPlacement, IfcLinearPlacement.

use ifc_lite_core::EntityDecoder;
use ifc_lite_geometry::GeometryRouter;

use super::File;
use crate::affine::{affine, is_finite};
use nalgebra::{Affine3, Point3, Vector3};

/// Resolves a product's placement with the kernel.
pub(crate) struct Resolver<'a> {
    decoder: EntityDecoder<'a>,
    router: GeometryRouter,
}

impl<'a> Resolver<'a> {
    pub(crate) fn new(file: &File<'a>) -> Self {
        let mut decoder = file.index.decoder(file.bytes);
        let router = GeometryRouter::with_units(file.bytes, &mut decoder);
        Self { decoder, router }
    }

    /// The product's frame in the world, in metres.
    pub(crate) fn placement(&mut self, product: u32) -> Option<Affine3<f64>> {
        let entity = self.decoder.decode_by_id(product).ok()?;
        let m = self.router.resolve_scaled_placement_strict(&entity, &mut self.decoder).ok()?;
        let axis = |at: usize| Vector3::new(m[at], m[at + 1], m[at + 2]);
        Some(affine([axis(0), axis(4), axis(8)], Point3::from(axis(12)))).filter(is_finite)
    }
}
