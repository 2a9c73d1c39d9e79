//! Maps of map servers: a YAML text, a zero byte, and the bytes of a PGM, PNG or BMP image.

use alignment::PreparedMap;
use messages::SlamMap;
use occupancy::OccupancyMap;

/// Largest area that is prepared for alignment: it takes time in proportion.
const AREA_MAX_M2: f64 = 100.0;

/// Reads the description and the image, and makes an archive of the map.
pub fn run(bytes: &[u8]) {
    let at = memchr::memchr(0, bytes).unwrap_or(bytes.len());
    let (description, image) = bytes.split_at(at);
    let Ok(description) = std::str::from_utf8(description) else { return };
    let Ok(map) = OccupancyMap::parse(description, image.get(1..).unwrap_or_default()) else { return };
    let archive = map.to_archive();
    if let Ok(opened) = SlamMap::open(archive.bytes()) {
        assert_eq!(OccupancyMap::of_archive(&opened).cells.len(), map.cells.len());
    }
    if map.cells.len() as f64 * map.resolution_m * map.resolution_m <= AREA_MAX_M2 {
        let _ = PreparedMap::of_slam(&map);
    }
}
