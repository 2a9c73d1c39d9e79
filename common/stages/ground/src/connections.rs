//! Connections of surfaces: from contacts along their borders to how one gets from one to another.

use crate::contacts::{Contact, Contacts};
use crate::surfaces::Surfaces;
use messages::{GroundClass, GroundConnection, GroundConnectionRecord};

/// Steps along the border of two surfaces that differ by less are one connection, in tenths of a millimetre: 2 cm.
const SAME_STEP: i32 = 200;

/// Shorter borders are corners that touch.
const MIN_LENGTH_M: f32 = 0.05;

/// A contact seen from the surface with the lower number.
#[derive(Clone, Copy)]
struct Border {
    surfaces: [u32; 2],
    step: i32,
    at: [i32; 3],
    length_m: f32,
    is_flush: bool,
    /// It is on the border of the second surface.
    is_of_second: bool,
}

/// The connections, sorted by their surfaces and steps.
pub(crate) fn connections(surfaces: &Surfaces, contacts: &Contacts) -> Vec<GroundConnectionRecord> {
    let mut borders: Vec<Border> = contacts.all.iter().filter_map(|contact| border(contact, surfaces)).collect();
    borders.sort_by_key(|b| (b.surfaces, b.step, b.at, b.is_of_second));
    let mut found = Vec::new();
    let mut rest = borders.as_slice();
    while let Some(first) = rest.first() {
        let is_same = |b: &Border| b.surfaces == first.surfaces && b.step - first.step <= SAME_STEP;
        let (same, others) = rest.split_at(rest.partition_point(is_same));
        rest = others;
        // Both borders may have been looked along.
        let length = |second: bool| same.iter().filter(|b| b.is_of_second == second).map(|b| b.length_m).sum::<f32>();
        let length_m = length(false).max(length(true));
        let middle = same[same.len() / 2];
        if length_m >= MIN_LENGTH_M {
            found.push(GroundConnectionRecord {
                surfaces: middle.surfaces,
                at_tenths: middle.at,
                step_tenths: middle.step,
                length_m,
                kind: kind(middle, surfaces).into(),
            });
        }
    }
    found
}

fn border(contact: &Contact, surfaces: &Surfaces) -> Option<Border> {
    let own = surfaces.of_face[contact.face as usize]?;
    let other = surfaces.of_face[contact.other as usize]?;
    let is_of_second = other < own;
    let step = if is_of_second { -contact.step } else { contact.step };
    let (at, length_m, is_flush) = (contact.at, contact.length_m, contact.is_flush);
    let surfaces = [own.min(other), own.max(other)];
    (own != other).then_some(Border { surfaces, step, at, length_m, is_flush, is_of_second })
}

fn kind(border: Border, surfaces: &Surfaces) -> GroundConnection {
    let has = |class: GroundClass| border.surfaces.iter().any(|&surface| surfaces.class(surface) == class);
    if has(GroundClass::StairTread) {
        GroundConnection::Stair
    } else if has(GroundClass::Ramp) && border.step.abs() <= SAME_STEP {
        GroundConnection::Ramp
    } else if border.is_flush {
        GroundConnection::SharedEdge
    } else {
        GroundConnection::Step
    }
}
