//! Nav2 map files of a storey.

use crate::input::ExportFile;
use grid::{MapMode, MapYaml, encode_pgm, pixel_of};
use messages::Grid;

/// The three map pairs of a storey, each file made when it is asked for.
pub(crate) fn files<'a>(folder: &'a str, grid: &'a Grid<'_>) -> impl Iterator<Item = ExportFile> + 'a {
    let spec = grid.spec();
    let layers = [("planning", grid.planning), ("localization", grid.localization), ("keepout", grid.keepout)];
    layers.into_iter().flat_map(move |(name, layer)| {
        let image = format!("{name}.pgm");
        let yaml = MapYaml { image: &image, spec: &spec, mode: MapMode::Trinary }.to_string();
        let pixels: Vec<u8> = layer.iter().map(|&occupancy| pixel_of(occupancy)).collect();
        let pgm = encode_pgm(spec.width as usize, &pixels);
        [ExportFile::new(format!("{folder}/{image}"), pgm), ExportFile::new(format!("{folder}/{name}.yaml"), yaml)]
    })
}

/// The three map pairs of a storey, in no folder.
pub fn map_files(grid: &Grid<'_>) -> Vec<ExportFile> {
    let named = |file: ExportFile| ExportFile::new(file.path.trim_start_matches('/'), file.bytes);
    files("", grid).map(named).collect()
}
