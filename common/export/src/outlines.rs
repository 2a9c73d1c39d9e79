//! Outlines of elements for `semantic.json`: as exact as their class needs, so that the file grows with elements and not with
//! triangles.
//!
//! Doors and floors are exact. Of the others corners are left out within a tolerance. What consists of many triangles is
//! not united but painted into cells that are finer than the tolerance, once for all copies that are turned alike.

use crate::input::ExportInput;
use crate::painted_outline::{Outline, Painting};
use frames::{TENTHS_PER_M, metres};
use geometry::{BodyShape, LazyFootprint, MeshView, Slab, simplified};
use grid::Class;
use messages::{ElementRecord, element_flags};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::HashMap;

/// Tolerance of structure in tenths of a millimetre: 5 mm.
const STRUCTURE_TENTHS: i32 = 50;

/// Most parts that are united exactly: of doors and floors, of structure, of furniture and equipment.
const MAX_UNITED_EXACT: usize = 20_000;
const MAX_UNITED_STRUCTURE: usize = 1_000;
const MAX_UNITED_FURNITURE: usize = 24;

/// How far outlines may deviate from the plans of the bodies, in metres. Those of doors and floors are exact.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub(crate) struct FootprintTolerance {
    /// Of walls, columns, stairs and all that is not named below; 0 if exact ones were asked for.
    structure_m: f64,
    /// Of furniture and equipment: a third of a cell; 0 if exact ones were asked for.
    furniture_and_equipment_m: f64,
}

impl FootprintTolerance {
    pub(crate) fn of(input: &ExportInput<'_>) -> Self {
        let scale = i32::from(!input.exact_footprints);
        Self {
            structure_m: metres(scale * STRUCTURE_TENTHS),
            furniture_and_equipment_m: metres(scale * third_of_a_cell(input)),
        }
    }
}

/// Precision of the outlines of a class.
struct Precision {
    /// In tenths of a millimetre.
    tolerance: i32,
    max_united: usize,
}

impl Precision {
    fn of(input: &ExportInput<'_>, record: &ElementRecord) -> Self {
        let is_floor = record.has(element_flags::FLOOR);
        match record.class() {
            _ if input.exact_footprints => Self { tolerance: 0, max_united: usize::MAX },
            Class::Door | Class::Slab => Self { tolerance: 0, max_united: MAX_UNITED_EXACT },
            _ if is_floor => Self { tolerance: 0, max_united: MAX_UNITED_EXACT },
            Class::Furniture | Class::Mep => {
                Self { tolerance: third_of_a_cell(input), max_united: MAX_UNITED_FURNITURE }
            }
            _ => Self { tolerance: STRUCTURE_TENTHS, max_united: MAX_UNITED_STRUCTURE },
        }
    }
}

fn third_of_a_cell(input: &ExportInput<'_>) -> i32 {
    (input.resolution_m * f64::from(TENTHS_PER_M) / 3.0).floor().max(1.0) as i32
}

/// Where an outline comes from.
enum Source<'f> {
    /// The exact union, less the corners within a tolerance.
    United(&'f LazyFootprint, i32),
    /// A painting, and what it is shifted by.
    Painted(usize, [i32; 3]),
}

/// The elements that meet the slab of each map storey, and their outlines there.
pub(crate) fn outlines(input: &ExportInput<'_>) -> Vec<Vec<(u32, Outline)>> {
    let mut easel = Easel::default();
    let source = |(element, footprint)| (element, easel.source(input, element, footprint));
    let cuts = input.footprints.iter().map(|cuts| cuts.iter().map(|(element, footprint)| (*element, footprint)));
    let mut source = source;
    let sources: Vec<Vec<(u32, Source<'_>)>> = cuts.map(|cuts| cuts.map(&mut source).collect()).collect();
    let painted: Vec<Outline> = easel.paintings.par_iter().map(Painting::outline).collect();
    let outline = |(element, source): &(u32, Source<'_>)| match source {
        Source::United(footprint, tolerance) => {
            let footprint = footprint.get(|| meshes(input, *element));
            let own_tolerance = None;
            (*element, Outline { area: simplified(&footprint.area, *tolerance), own_tolerance })
        }
        Source::Painted(k, origin) => (*element, painted[*k].shifted(*origin)),
    };
    sources.iter().map(|of_storey| of_storey.par_iter().map(outline).collect()).collect()
}

fn meshes<'a>(input: &ExportInput<'a>, element: u32) -> impl Iterator<Item = MeshView<'a>> {
    input.site.element_meshes(&input.site.elements[element as usize])
}

/// What is to be painted, each shape once.
#[derive(Default)]
struct Easel<'a> {
    paintings: Vec<Painting<'a>>,
    known: HashMap<(BodyShape<'a>, Slab, i32), usize>,
}

impl<'a> Easel<'a> {
    fn source<'f>(&mut self, input: &ExportInput<'a>, element: u32, footprint: &'f LazyFootprint) -> Source<'f> {
        let precision = Precision::of(input, &input.site.elements[element as usize]);
        if footprint.n_parts() <= precision.max_united {
            return Source::United(footprint, precision.tolerance);
        }
        let body = BodyShape(meshes(input, element).collect());
        let origin = body.origin();
        let Slab { lo, hi } = footprint.slab();
        let slab = Slab { lo: lo.saturating_sub(origin[2]), hi: hi.saturating_sub(origin[2]) };
        let next = self.paintings.len();
        let place = *self.known.entry((body.clone(), slab, precision.tolerance)).or_insert(next);
        if place == next {
            // What was to be exact and has too many parts says how exact it is.
            let own_tolerance = (precision.tolerance == 0).then_some(STRUCTURE_TENTHS);
            let tolerance = own_tolerance.unwrap_or(precision.tolerance);
            self.paintings.push(Painting { body, slab, tolerance, own_tolerance });
        }
        Source::Painted(place, origin)
    }
}
