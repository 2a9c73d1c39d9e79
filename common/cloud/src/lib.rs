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
//! # The octree
//!
//! ```text
//! groundplan convert house.ifc -o maps --octomap --octomap-resolution 0.05 --octomap-box=-1,-1,0,12,9,3
//! ```
//!
//! | file | content |
//! |---|---|
//! | `octomap/structure.bt` | binary OctoMap: cells of a volume in `map`, its tree pruned |
//! | `octomap/structure.json` | resolution, volume, how much is occupied, free, unknown; elements and rooms, by GlobalId |
//!
//! - Occupied are cells that a surface of the elements that would have points crosses, and those within their closed bodies. The same
//!   function chooses the elements of both outputs.
//! - Free are cells that lie wholly within the closed body of a room that the schedule has open, and that nothing meets which stands or
//!   is terrain, of whatever class, finished or not. Gross areas and shafts make nothing free.
//! - All else is unknown: cells of doors, glass and furniture, of what is being built or removed, closed rooms, and everything outdoors,
//!   because no model says what is not there. An element whose body could not be made may stand anywhere; `without_body` lists it.
//! - Faces of closed bodies that lie in a face of a cell do not cross it, so that a wall on the lattice is as thick as it is; those of
//!   open surfaces are in the cells on both sides.
//! - Memory grows with the surfaces, not with the volume. A volume beyond the keys of an OctoMap, 32768 cells from the origin, and more
//!   than 2^26 cells at surfaces are refused.
//!
//! # Where
//!
//! - cells that bodies fill: `src/octree.rs`, whether a triangle meets one: `src/cube.rs`
//! - points on a triangle: `src/lattice.rs`
//! - what is hidden, and which way a normal looks: `src/visible.rs`

mod bodies;
mod cube;
mod document;
mod error;
mod lattice;
mod octomap;
mod octree;
mod options;
mod pcd;
mod ply;
mod point;
mod selection;
mod visible;

pub use document::Structure;
pub use error::CloudError;
pub use octomap::{Octomap, OctomapError, OctomapOptions, OctomapOptionsError, octomap_files};
pub use options::{CloudOptions, CloudOptionsError};
pub use selection::UnknownClass;

use export::{ExportFile, ExportInput, json_text};
use messages::Site;
use visible::Body;

/// The files of a cloud, in `cloud/`.
///
/// # Errors
/// Too many points.
pub fn files(input: &ExportInput<'_>, options: &CloudOptions) -> Result<Vec<ExportFile>, CloudError> {
    let (chosen, left_out) = options.selection.structure(input);
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

fn bodies_of<'a>(site: &Site<'a>, element: u32, place: u32) -> impl Iterator<Item = Body<'a>> + use<'a> {
    let record = &site.elements[element as usize];
    let class = record.class().id();
    site.element_meshes(record).map(move |mesh| Body { mesh, element: place, class })
}
