//! The surfaces of what stands at the plan time as points with normals: the reference of lidars that look in three dimensions.
//!
//! ```text
//! groundplan convert house.ifc -o maps --cloud
//! groundplan convert house.ifc -o maps --cloud --date 2024-04-15 --cloud-spacing 0.1 --cloud-classes wall,column,slab
//! pcl_viewer maps/cloud/structure.pcd
//! ```
//!
//! | file | content |
//! |---|---|
//! | `cloud/structure.pcd` | PCD 0.7, binary: `x y z normal_x normal_y normal_z label element`, for PCL, Autoware, small_gicp |
//! | `cloud/structure.ply` | PLY, binary: the same points as vertices, `x y z nx ny nz class element`, for Open3D, CloudCompare, rmcl |
//! | `cloud/structure.json` | what the numbers mean: classes, GlobalIds by `element`, what is left out and why |
//!
//! Coordinates are metres in `map`, rounded to what a 32-bit number holds: a tenth of a millimetre within 1 km of the origin, a
//! millimetre at 10 km. `label` and `class` are the ids of classes that `classes.png` has.
//!
//! # Guarantees
//!
//! - Only finished elements (`built` in the effective state) of the chosen classes have points; where none are chosen, of classes that
//!   stay where they are, and coverings and footings. Glass has none, nor has a box
//!   that stands in for a body: what a lidar would look for in vain makes a match worse than a gap. `structure.json` lists them.
//! - Points lie on the faces, in the middle of the cells of a lattice with the spacing, seen along the axis of `map` to which the
//!   face is steepest: their distance on the face is at most 1.74 times the spacing, and a face is not sampled twice.
//! - A point is left out where the body of another element of the cloud lies 5 mm in front of it: what is buried or touched by
//!   another body cannot be seen. Coincident faces that look the same way count once.
//! - Normals look out of bodies, also of those whose faces are wound inwards. Of a surface that does not close they look out where a
//!   line of the lattice meets it an even number of times, as if it did, and else as its faces are wound.
//! - The same input gives the same bytes, on any number of threads.
//!
//! # Where
//!
//! - points on a triangle: `src/lattice.rs`
//! - what is hidden, and which way a normal looks: `src/visible.rs`

mod document;
mod error;
mod lattice;
mod options;
mod pcd;
mod ply;
mod point;
mod visible;

pub use document::Structure;
pub use error::CloudError;
pub use options::{CloudOptions, CloudOptionsError};

use document::LeftOut;
use export::{ExportFile, ExportInput, json_text};
use messages::{ElementState, Site, element_flags};
use visible::Body;

/// The files of a cloud, in `cloud/`.
///
/// # Errors
/// Too many points.
pub fn files(input: &ExportInput<'_>, options: &CloudOptions) -> Result<Vec<ExportFile>, CloudError> {
    let (chosen, left_out) = chosen(input, options);
    let site = input.site;
    let bodies: Vec<Body<'_>> =
        chosen.iter().enumerate().flat_map(|(place, &element)| bodies_of(site, element, place as u32)).collect();
    let points = visible::points(&bodies, options)?;
    let structure = Structure::of(input, options, &chosen, &points, left_out);
    Ok(vec![
        ExportFile::new("cloud/structure.pcd", pcd::bytes(&points)),
        ExportFile::new("cloud/structure.ply", ply::bytes(&points)),
        ExportFile::new("cloud/structure.json", json_text(&structure)),
    ])
}

/// Elements that have points, and those of the chosen classes that have none, with the reason.
fn chosen(input: &ExportInput<'_>, options: &CloudOptions) -> (Vec<u32>, Vec<(u32, LeftOut)>) {
    let (mut chosen, mut left_out) = (Vec::new(), Vec::new());
    for (k, element) in input.site.elements.iter().enumerate() {
        let is_entity = |entity: &&str| input.site.is_a(element, entity);
        if !(options.classes.contains(&element.class()) || options.entities.iter().any(is_entity)) {
            continue;
        }
        let state = input.schedule_state.effective(k);
        let why = match state {
            ElementState::NotStarted | ElementState::Removed => continue,
            _ if element.has(element_flags::FAILED) => LeftOut::NoBody,
            // An assembly of parts that are elements of their own.
            _ if element.n_parts == 0 => continue,
            _ if element.has(element_flags::BOUNDING_BOX) => LeftOut::BoundingBox,
            _ if element.has(element_flags::GLASS) => LeftOut::Glass,
            ElementState::InProgress => LeftOut::InProgress,
            ElementState::BeingRemoved => LeftOut::BeingRemoved,
            ElementState::Built => {
                chosen.push(k as u32);
                continue;
            }
        };
        left_out.push((k as u32, why));
    }
    (chosen, left_out)
}

fn bodies_of<'a>(site: &Site<'a>, element: u32, place: u32) -> impl Iterator<Item = Body<'a>> + use<'a> {
    let record = &site.elements[element as usize];
    let class = record.class().id();
    site.element_meshes(record).map(move |mesh| Body { mesh, element: place, class })
}
