//! Exported maps as Nav2's map server publishes them.

use serde_json::Value;
use sha2::{Digest, Sha256};
use std::path::Path;

/// sha256 of a layer of a map storey as Nav2's map server publishes the file that `export` writes.
pub fn published_by_map_server(folder: &Path, storey: usize, layer: &str) -> String {
    let manifest: Value = serde_json::from_slice(&std::fs::read(folder.join("manifest.json")).unwrap()).unwrap();
    let directory = folder.join(manifest["storeys"][storey]["directory"].as_str().unwrap());
    let (width, _, pixels) = grid::decode_pgm(&std::fs::read(directory.join(layer)).unwrap()).unwrap();
    let cell = |pixel: u8| match f64::from(255 - pixel) / 255.0 {
        p if p > 0.65 => 100_u8,
        p if p < 0.196 => 0,
        _ => 255,
    };
    // `decode_pgm` gives the lowest row first, as the message has it.
    let cells: Vec<u8> = pixels.chunks(width).flatten().map(|&pixel| cell(pixel)).collect();
    Sha256::digest(cells).iter().map(|byte| format!("{byte:02x}")).collect()
}
