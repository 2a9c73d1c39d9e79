//! The `ground` archive: the surface of a site that can be walked or driven on at a plan time, for no robot in particular.

use crate::archive::ArchiveError;
use crate::declaration::declare_archive;
use crate::ground_records::*;
use crate::site::MAX_COORDINATE_TENTHS;
use crate::spans::{fits, span};
use crate::tag::check_tags;

declare_archive! {
    /// The walkable surface of a site at a plan time, read in place.
    view Ground;
    /// Records of a `ground` archive to be.
    owned GroundWriter;
    sections {
        /// What it was made from.
        pub head: one(1, GroundHead),
        /// Elements and terrains that carry it, in the order of the site: elements, then terrains.
        pub bodies: many(2, GroundBodyRecord),
        /// Vertices in `map`, tenths of a millimetre; none twice.
        pub vertices: many(3, [i32; 3]),
        /// Triangles, counter-clockwise from above, by surface.
        pub faces: many(4, GroundFaceRecord),
        /// Connected surfaces, from the largest to the smallest.
        pub surfaces: many(5, GroundSurfaceRecord),
        /// Where one gets from a surface to another, sorted by the two.
        pub connections: many(6, GroundConnectionRecord),
    }
}

impl<'a> Ground<'a> {
    fn check(&self) -> Result<(), ArchiveError> {
        check_tags(self.bodies.iter().map(|b| b.class), "ground class")?;
        check_tags(self.faces.iter().map(|f| f.class), "ground class")?;
        check_tags(self.surfaces.iter().map(|s| s.class), "ground class")?;
        check_tags(self.connections.iter().map(|c| c.kind), "kind of a connection")?;
        let check = |whole: bool, what| if whole { Ok(()) } else { Err(ArchiveError::Index { what }) };
        let is_near = |c: &i32| c.unsigned_abs() <= MAX_COORDINATE_TENTHS;
        let is_angle = |a: f32| (0.0..=2.0).contains(&a);
        check(self.vertices.as_flattened().iter().all(is_near), "a coordinate")?;
        check(
            self.faces.iter().all(|f| {
                f.vertices.iter().all(|&v| (v as usize) < self.vertices.len())
                    && (f.body as usize) < self.bodies.len()
                    && (f.surface as usize) < self.surfaces.len()
                    && is_angle(f.slope_rad)
            }),
            "a face",
        )?;
        // Surfaces follow each other and leave no face out, so that walking all of them is linear.
        let mut next = 0u64;
        let whole = self.surfaces.iter().zip(0u32..).all(|(s, k)| {
            let is_next = u64::from(s.first_face) == next && fits(s.first_face, s.n_faces, self.faces.len());
            next += u64::from(s.n_faces);
            is_next
                && self.faces[span(s.first_face, s.n_faces)].iter().all(|f| f.surface == k)
                && s.area_m2.is_finite()
                && s.min_tenths.iter().chain(&s.max_tenths).all(is_near)
        });
        check(whole && next == self.faces.len() as u64, "a surface")?;
        let n_surfaces = self.surfaces.len();
        check(
            self.connections.iter().all(|c| {
                c.surfaces[0] < c.surfaces[1]
                    && (c.surfaces[1] as usize) < n_surfaces
                    && c.length_m.is_finite()
                    && c.at_tenths.iter().chain([&c.step_tenths]).all(is_near)
            }),
            "a connection",
        )
    }

    /// The faces of a surface.
    pub fn faces_of(&self, surface: &GroundSurfaceRecord) -> &'a [GroundFaceRecord] {
        &self.faces[span(surface.first_face, surface.n_faces)]
    }

    /// The corners of a face in `map`, in tenths of a millimetre.
    pub fn corners(&self, face: &GroundFaceRecord) -> [[i32; 3]; 3] {
        face.vertices.map(|v| self.vertices[v as usize])
    }
}
