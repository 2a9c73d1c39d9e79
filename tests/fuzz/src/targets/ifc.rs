//! IFC files: header, container, records, units, placements, representations, geometry, and the site that is made of them.

use super::site;
use messages::Site;

/// Reads the bytes as an IFC file and opens the site that comes of it.
pub fn run(bytes: &[u8]) {
    let Ok(site) = site::of_bytes(bytes) else { return };
    let site = Site::open(site.bytes()).expect("what was written can be read");
    for element in site.elements {
        let _ = site.element_meshes(element).map(|mesh| mesh.triangles.len()).sum::<usize>();
    }
}
