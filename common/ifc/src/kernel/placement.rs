//! Placements resolved by the kernel: IfcGridPlacement, IfcLinearPlacement.

use std::sync::Arc;

use ifc_lite_core::EntityDecoder;
use ifc_lite_geometry::GeometryRouter;

use super::File;
use crate::affine::Affine;

/// Resolves a product's placement with the kernel.
pub(crate) struct Resolver<'a> {
    decoder: EntityDecoder<'a>,
    router: GeometryRouter,
}

impl<'a> Resolver<'a> {
    pub(crate) fn new(file: &File<'a>) -> Self {
        let mut decoder = EntityDecoder::with_arc_index(file.bytes, Arc::clone(&file.index));
        let router = GeometryRouter::with_units(file.bytes, &mut decoder);
        Self { decoder, router }
    }

    /// The product's frame in the world, in metres.
    pub(crate) fn placement(&mut self, product: u32) -> Option<Affine> {
        let entity = self.decoder.decode_by_id(product).ok()?;
        let m = self.router.resolve_scaled_placement_strict(&entity, &mut self.decoder).ok()?;
        let column = |at: usize| [m[at], m[at + 1], m[at + 2]];
        Some(Affine { axes: [column(0), column(4), column(8)], origin: column(12) }).filter(Affine::is_finite)
    }
}
