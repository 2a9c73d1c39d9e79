//! Nav2 map files of a storey.

use crate::input::ExportFile;
use grid::{MapMode, MapYaml, encode_pgm, pixel_of};
use messages::Grid;

/// The three map pairs of a storey.
pub(crate) fn files(folder: &str, grid: &Grid<'_>) -> Vec<ExportFile> {
    let spec = grid.spec();
    let (width, height) = (spec.width as usize, spec.height as usize);
    let layers = [("planning", grid.planning), ("localization", grid.localization), ("keepout", grid.keepout)];
    layers
        .into_iter()
        .flat_map(|(name, layer)| {
            let image = format!("{name}.pgm");
            let yaml = MapYaml { image: &image, spec: &spec, mode: MapMode::Trinary }.to_string();
            let pgm = encode_pgm(width, |index| pixel_of(layer[index]), height);
            [ExportFile::new(format!("{folder}/{image}"), pgm), ExportFile::new(format!("{folder}/{name}.yaml"), yaml)]
        })
        .collect()
}
