//! Contacts of faces: groups of faces that continue each other, and faces beside the borders of others.
//!
//! Faces of one class that share an edge are one group. Along every other edge places are looked at, a little outside of the face: what
//! is there at the height of the edge continues it, what is there a step higher or lower is where one can go to.

use crate::box_tree::BoxTree;
use crate::plane::covers;
use crate::selected_face::SelectedFace;
use frames::TENTHS_PER_M;
use geometry::{DisjointSets, Plane};
use messages::GroundClass;
use std::collections::HashMap;

/// Highest step between two surfaces that are connected, in metres: a little more than any riser of a stair.
pub const MAX_STEP_M: f64 = 0.30;

/// How far outside of an edge is looked, in tenths of a millimetre: at it, and over a joint, a nosing, a gap of 5 cm.
const PROBES: [f64; 3] = [5.0, 150.0, 500.0];

/// Surfaces whose heights differ by less continue each other: a millimetre.
pub(crate) const FLUSH: f64 = 10.0;

/// Distance of the places along an edge, in tenths of a millimetre; more where they would be too many.
const SPACING: f64 = 1_000.0;

/// Most places of all edges, and of one: of edges longer than 400 m they lie farther apart.
const MAX_PLACES: f64 = 2e6;
const MAX_PLACES_OF_ONE: f64 = 4_096.0;

/// A place on the border of a face beside which another face lies.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Contact {
    pub(crate) face: u32,
    pub(crate) other: u32,
    pub(crate) at: [i32; 3],
    /// How much higher the other face lies.
    pub(crate) step: i32,
    pub(crate) length_m: f32,
    /// The other face begins at the edge, at its height.
    pub(crate) is_flush: bool,
}

/// Groups of faces, and the contacts of their borders.
#[derive(Debug)]
pub(crate) struct Contacts {
    /// The first face of the group of each face.
    pub(crate) group: Vec<u32>,
    pub(crate) all: Vec<Contact>,
}

impl Contacts {
    pub(crate) fn of(faces: &[SelectedFace]) -> Self {
        let mut groups = DisjointSets::new(faces.len());
        let borders = borders(faces, &mut groups);
        let tree = BoxTree::of(faces.iter().map(|f| &f.triangle));
        let length: f64 = borders.iter().map(|border| border.length).sum();
        let spacing = SPACING.max(length / MAX_PLACES);
        let planes: Vec<Plane> = faces.iter().map(|f| Plane::of(&f.triangle)).collect();
        let mut all = Vec::new();
        for border in &borders {
            let n_places = (border.length / spacing).ceil().clamp(1.0, MAX_PLACES_OF_ONE);
            for k in 0..n_places as usize {
                let at = border.at((k as f64 + 0.5) / n_places);
                let Some((other, step, is_flush)) = beside(border, at, faces, &planes, &tree) else { continue };
                if is_flush && faces[other].class == faces[border.face as usize].class {
                    groups.join(border.face, other as u32);
                    continue;
                }
                all.push(Contact {
                    face: border.face,
                    other: other as u32,
                    at: at.map(|c| c.round() as i32),
                    step: step.round() as i32,
                    length_m: (border.length / n_places / f64::from(TENTHS_PER_M)) as f32,
                    is_flush,
                });
            }
        }
        let group = (0..faces.len() as u32).map(|k| groups.first(k)).collect();
        Self { group, all }
    }
}

/// An edge of a face with no other face of its class behind it.
struct Border {
    face: u32,
    ends: [[f64; 3]; 2],
    /// In plan.
    length: f64,
}

impl Border {
    fn at(&self, share: f64) -> [f64; 3] {
        [0, 1, 2].map(|k| self.ends[0][k] + (self.ends[1][k] - self.ends[0][k]) * share)
    }

    /// A place so far outside of a place on the edge.
    fn outside(&self, at: [f64; 3], by: f64) -> [f64; 2] {
        let [dx, dy] = [0, 1].map(|k| (self.ends[1][k] - self.ends[0][k]) / self.length);
        [at[0] + dy * by, at[1] - dx * by]
    }
}

/// An edge by its ends, the smaller one first, and the class of its face.
type EdgeKey = ([i32; 3], [i32; 3], GroundClass);

/// Joins the faces that share an edge, and gives the edges that no other face of the class has.
fn borders(faces: &[SelectedFace], groups: &mut DisjointSets) -> Vec<Border> {
    let edges = |face: &SelectedFace| {
        let (t, class) = (face.triangle, face.class);
        [[t[0], t[1]], [t[1], t[2]], [t[2], t[0]]].map(|[a, b]| ([a, b], (a.min(b), a.max(b), class)))
    };
    // The first face of each edge, and whether there is another one.
    let mut faces_of: HashMap<EdgeKey, (u32, bool)> = HashMap::new();
    for (face, k) in faces.iter().zip(0..) {
        for (_, key) in edges(face) {
            let (first, is_shared) = faces_of.entry(key).or_insert((k, false));
            if *first != k {
                groups.join(*first, k);
                *is_shared = true;
            }
        }
    }
    let mut found = Vec::new();
    for (face, k) in faces.iter().zip(0..) {
        for (ends, _) in edges(face).into_iter().filter(|(_, key)| !faces_of[key].1) {
            let ends = ends.map(|end| end.map(f64::from));
            let length = libm::hypot(ends[1][0] - ends[0][0], ends[1][1] - ends[0][1]);
            if length > 0.0 {
                found.push(Border { face: k, ends, length });
            }
        }
    }
    found
}

/// The face beside a place of a border, how much higher it lies, and whether it continues the border's own.
fn beside(
    border: &Border,
    at: [f64; 3],
    faces: &[SelectedFace],
    planes: &[Plane],
    tree: &BoxTree,
) -> Option<(usize, f64, bool)> {
    let max_step = MAX_STEP_M * f64::from(TENTHS_PER_M);
    let reach = max_step + PROBES[PROBES.len() - 1];
    let mut best: Option<((bool, usize, f64), usize, f64)> = None;
    for (probe, by) in PROBES.into_iter().enumerate() {
        let place = border.outside(at, by);
        let [x, y] = place.map(|c| [c.floor() as i32, c.ceil() as i32]);
        let z = [(at[2] - reach).floor() as i32, (at[2] + reach).ceil() as i32];
        tree.each(&[[x[0], y[0], z[0]], [x[1], y[1], z[1]]], |other| {
            if other == border.face as usize || !covers(&faces[other].triangle, place) {
                return;
            }
            let step = planes[other].z([at[0], at[1]]) - at[2];
            let rank = (step.abs() > FLUSH, probe, step.abs());
            let is_better = |(old, k, _): ((bool, usize, f64), usize, f64)| (rank, other) < (old, k);
            if step.abs() <= max_step && best.is_none_or(is_better) {
                best = Some((rank, other, step));
            }
        });
    }
    best.map(|((is_step, probe, _), other, step)| (other, step, !is_step && probe == 0))
}
