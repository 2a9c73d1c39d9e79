//! Parts of the faces of a site that other bodies cover: found once for a site, whatever stands at a date.

use crate::box_tree::{BoxTree, Corners, corners_of};
use crate::overlap::overlap;
use crate::plane::Triangle;
use geometry::Ring;

/// Faces that lie less than this above another cover it, in tenths of a millimetre: 2 cm.
pub(crate) const COVER: i32 = 200;

/// Faces nearer than this are at one height: rounded vertices leave a plane by less.
const ONE_HEIGHT: f64 = 2.0;

/// A part of a face that a body covers where it is there.
#[derive(Debug)]
pub(crate) struct Cover {
    pub(crate) face: u32,
    pub(crate) body: u32,
    pub(crate) ring: Ring,
}

/// The covers of all faces, by face. Faces are in the order of their bodies; undersides are those of closed bodies.
pub(crate) fn covers(faces: &[(Triangle, u32)], undersides: &[(Triangle, u32)]) -> Vec<Cover> {
    let mut found = Vec::new();
    let tops = BoxTree::of(faces.iter().map(|(t, _)| t));
    let bottoms = BoxTree::of(undersides.iter().map(|(t, _)| t));
    let mut near = Vec::new();
    for (k, (face, body)) in faces.iter().enumerate() {
        let reach = reach_of(face);
        near.clear();
        tops.each(&reach, |other| near.push(other));
        near.sort_unstable();
        for &other in near.iter().filter(|&&other| other != k) {
            let (upper, of) = &faces[other];
            // Of two at one height the later one stays.
            let least = if other > k { -ONE_HEIGHT } else { ONE_HEIGHT };
            let ring = overlap(face, upper, least, f64::from(COVER));
            found.extend(ring.map(|ring| Cover { face: k as u32, body: *of, ring }));
        }
        near.clear();
        bottoms.each(&reach, |other| near.push(other));
        near.sort_unstable();
        for &other in near.iter().filter(|&&other| undersides[other].1 != *body) {
            let (upper, of) = &undersides[other];
            let ring = overlap(face, upper, -ONE_HEIGHT, f64::from(COVER));
            found.extend(ring.map(|ring| Cover { face: k as u32, body: *of, ring }));
        }
    }
    found
}

fn reach_of(face: &Triangle) -> Corners {
    let [mut min, mut max] = corners_of(face);
    min[2] -= COVER;
    max[2] += COVER;
    [min, max]
}
