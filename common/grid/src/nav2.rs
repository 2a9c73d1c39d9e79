//! Nav2 map files: an 8-bit PGM image and a YAML text beside it.
//!
//! Three pixel values with the thresholds written here read the same in ROS 1 and in every Nav2 release. Row 0 of an
//! image is the top, row 0 of a grid the bottom.

use crate::GridSpec;

/// Pixel of an occupied cell.
pub const OCCUPIED: u8 = 0;
/// Pixel of an unknown cell.
pub const UNKNOWN: u8 = 205;
/// Pixel of a free cell.
pub const FREE: u8 = 254;

/// The pixel of an occupancy value as in `nav_msgs`: 0 free, 100 occupied, -1 unknown.
pub fn pixel_of(occupancy: i8) -> u8 {
    match occupancy {
        0 => FREE,
        -1 => UNKNOWN,
        _ => OCCUPIED,
    }
}

/// The occupancy value that Nav2's map_server reads from one of these three pixels, with the thresholds of [`MapYaml`].
pub fn occupancy_of(pixel: u8) -> i8 {
    match pixel {
        FREE => 0,
        UNKNOWN => -1,
        _ => 100,
    }
}

/// A binary PGM of pixels that are row-major from the bottom.
pub fn encode_pgm(width: usize, pixels: &[u8]) -> Vec<u8> {
    let height = pixels.len().checked_div(width).unwrap_or(0);
    let mut out = format!("P5\n{width} {height}\n255\n").into_bytes();
    out.reserve(pixels.len());
    pixels.chunks_exact(width.max(1)).rev().for_each(|row| out.extend_from_slice(row));
    out
}

/// Width, height and pixels (row-major from the bottom) of a binary 8-bit PGM; `None` if it is not one.
pub fn decode_pgm(bytes: &[u8]) -> Option<(usize, usize, Vec<u8>)> {
    let mut at = 0;
    let mut fields = Vec::new();
    while fields.len() < 4 {
        while bytes.get(at)?.is_ascii_whitespace() {
            at += 1;
        }
        if bytes[at] == b'#' {
            at += bytes[at..].iter().position(|&b| b == b'\n')?;
            continue;
        }
        let length = bytes[at..].iter().position(u8::is_ascii_whitespace)?;
        fields.push(std::str::from_utf8(&bytes[at..at + length]).ok()?);
        at += length;
    }
    let (width, height): (usize, usize) = (fields[1].parse().ok()?, fields[2].parse().ok()?);
    let pixels = bytes.get(at + 1..)?;
    if fields[0] != "P5" || fields[3] != "255" || Some(pixels.len()) != width.checked_mul(height) || pixels.is_empty() {
        return None;
    }
    Some((width, height, pixels.chunks_exact(width).rev().flatten().copied().collect()))
}

/// How map servers read the pixels of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MapMode {
    /// As one of three values: free, occupied, unknown.
    Trinary,
    /// As values from 0, white, to 100, black; nothing is unknown.
    Scale,
    /// As values from 0 to 100; higher pixels are unknown.
    Raw,
}

/// The YAML text beside an image.
#[derive(Debug, Clone, Copy)]
pub struct MapYaml<'a> {
    /// File name of the image, beside the YAML file.
    pub image: &'a str,
    /// Specification of the grid.
    pub spec: &'a GridSpec,
    /// How its pixels are read.
    pub mode: MapMode,
}

impl std::fmt::Display for MapYaml<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y] = self.spec.origin_m();
        writeln!(f, "image: {}", self.image)?;
        let (mode, occupied, free) = match self.mode {
            MapMode::Trinary => ("trinary", "0.65", "0.196"),
            MapMode::Scale => ("scale", "1.0", "0.0"),
            // The thresholds are required, and not used.
            MapMode::Raw => ("raw", "0.65", "0.196"),
        };
        writeln!(f, "mode: {mode}")?;
        writeln!(f, "resolution: {:?}", self.spec.resolution_m())?;
        writeln!(f, "origin: [{x:?}, {y:?}, 0.0]")?;
        writeln!(f, "negate: 0")?;
        writeln!(f, "occupied_thresh: {occupied}")?;
        writeln!(f, "free_thresh: {free}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_row_of_the_image_is_the_top() {
        let pixels = [OCCUPIED, FREE, UNKNOWN, FREE, FREE, FREE];
        let pgm = encode_pgm(3, &pixels);
        assert_eq!(&pgm[pgm.len() - 6..], [FREE, FREE, FREE, OCCUPIED, FREE, UNKNOWN]);
        assert_eq!(decode_pgm(&pgm), Some((3, 2, pixels.to_vec())));
    }

    #[test]
    fn unknown_stays_unknown_at_the_threshold() {
        assert!((255.0 - f64::from(UNKNOWN)) / 255.0 > 0.196);
        assert!((255.0 - f64::from(UNKNOWN)) / 255.0 < 0.65);
    }

    #[test]
    fn what_is_no_pgm_is_refused() {
        for bytes in
            [&b""[..], b"P5", b"P5\n2 2\n255\n123", b"P6\n1 1\n255\n1", b"P5\n0 0\n255\n", b"P5\n# only a comment"]
        {
            assert_eq!(decode_pgm(bytes), None);
        }
    }

    #[test]
    fn resolution_and_origin_are_written_in_full() {
        let spec = GridSpec { cell_tenths: 125, first_cell: [-3, 7], width: 1, height: 1 };
        let text = MapYaml { image: "planning.pgm", spec: &spec, mode: MapMode::Trinary }.to_string();
        assert!(text.contains("resolution: 0.0125\n") && text.contains("origin: [-0.0375, 0.0875, 0.0]\n"), "{text}");
    }
}
