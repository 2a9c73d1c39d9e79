//! Connected surfaces of one class, from the largest to the smallest.

use crate::box_tree::{Corners, corners_of, joined};
use crate::contacts::Contacts;
use crate::plane::double_area;
use crate::selected_face::SelectedFace;
use frames::TENTHS_PER_M;
use messages::{GroundClass, GroundFaceRecord, GroundSurfaceRecord, GroundWriter};
use std::collections::HashMap;

/// Smaller surfaces are slivers of what lies beside them.
const MIN_SURFACE_M2: f64 = 0.000_5;

/// Smaller level faces of stairs and scaffolds are rims of stringers and ends of tubes.
const MIN_TREAD_M2: f64 = 0.02;

/// The surfaces, and the surface of each face.
#[derive(Debug)]
pub(crate) struct Surfaces {
    /// `None` for a face of a surface that is too small.
    pub(crate) of_face: Vec<Option<u32>>,
    found: Vec<Found>,
}

#[derive(Debug)]
struct Found {
    class: GroundClass,
    area_m2: f64,
    corners: Corners,
    faces: Vec<u32>,
}

impl Surfaces {
    pub(crate) fn of(faces: &[SelectedFace], contacts: &Contacts) -> Self {
        let mut place: HashMap<u32, usize> = HashMap::new();
        let mut found: Vec<Found> = Vec::new();
        for (k, face) in faces.iter().enumerate() {
            let at = *place.entry(contacts.group[k]).or_insert_with(|| {
                let (class, corners) = (face.class, corners_of(&face.triangle));
                found.push(Found { class, area_m2: 0.0, corners, faces: Vec::new() });
                found.len() - 1
            });
            let unit = f64::from(TENTHS_PER_M);
            found[at].area_m2 += double_area(&face.triangle) as f64 / 2.0 / (unit * unit);
            found[at].corners = joined(found[at].corners, corners_of(&face.triangle));
            found[at].faces.push(k as u32);
        }
        found.retain(|surface| {
            let is_tread = matches!(surface.class, GroundClass::StairTread | GroundClass::ScaffoldDeck);
            surface.area_m2 >= if is_tread { MIN_TREAD_M2 } else { MIN_SURFACE_M2 }
        });
        found.sort_by(|a, b| b.area_m2.total_cmp(&a.area_m2).then_with(|| a.faces.cmp(&b.faces)));
        let mut of_face = vec![None; faces.len()];
        for (surface, k) in found.iter().zip(0..) {
            surface.faces.iter().for_each(|&face| of_face[face as usize] = Some(k));
        }
        Self { of_face, found }
    }

    /// The class of a surface.
    pub(crate) fn class(&self, surface: u32) -> GroundClass {
        self.found[surface as usize].class
    }

    /// The vertices, faces and surfaces of an archive to be.
    pub(crate) fn written(&self, faces: &[SelectedFace]) -> GroundWriter {
        let mut out = GroundWriter::default();
        let mut index: HashMap<[i32; 3], u32> = HashMap::new();
        for (surface, number) in self.found.iter().zip(0..) {
            let [min_tenths, max_tenths] = surface.corners;
            out.surfaces.push(GroundSurfaceRecord {
                area_m2: surface.area_m2,
                min_tenths,
                max_tenths,
                first_face: out.faces.len() as u32,
                n_faces: surface.faces.len() as u32,
                class: surface.class.into(),
                reserved: [0; 7],
            });
            for &k in &surface.faces {
                let face = &faces[k as usize];
                let vertices = face.triangle.map(|v| {
                    *index.entry(v).or_insert_with(|| {
                        out.vertices.push(v);
                        out.vertices.len() as u32 - 1
                    })
                });
                out.faces.push(GroundFaceRecord {
                    vertices,
                    body: face.body,
                    surface: number,
                    slope_rad: face.slope_rad,
                    class: face.class.into(),
                    reserved: [0; 3],
                });
            }
        }
        out
    }
}
