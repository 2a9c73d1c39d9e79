//! Map files as map servers read them, written.

use grid::{encode_pgm, pixel_of};
use occupancy::OccupancyMap;
use std::path::Path;

/// Writes `FOLDER/NAME.pgm` and `FOLDER/NAME.yaml`.
///
/// # Errors
/// A file that cannot be written.
pub fn write_map(folder: &Path, name: &str, map: &OccupancyMap) -> std::io::Result<()> {
    let pixels: Vec<u8> = map.cells.iter().map(|cell| pixel_of(cell.occupancy())).collect();
    let pgm = encode_pgm(map.width, &pixels);
    std::fs::write(folder.join(format!("{name}.pgm")), pgm)?;
    std::fs::write(folder.join(format!("{name}.yaml")), description(&format!("{name}.pgm"), map))
}

/// As `grid::MapYaml` has it, with an origin that is no whole number of cells.
fn description(image: &str, map: &OccupancyMap) -> String {
    let [x, y, yaw] = map.origin;
    format!(
        "image: {image}\nmode: trinary\nresolution: {:?}\norigin: [{x:?}, {y:?}, {yaw:?}]\nnegate: 0\n\
         occupied_thresh: 0.65\nfree_thresh: 0.196\n",
        map.resolution_m
    )
}
