//! Files as one: a tar archive (POSIX ustar) without times and owners.

use export::ExportFile;

const BLOCK: usize = 512;

/// The archive of files with short names and less than 8 GiB each, in their order.
pub(super) fn archive(files: &[ExportFile]) -> Vec<u8> {
    let mut out = Vec::new();
    for file in files {
        out.extend_from_slice(&header(&file.path, file.bytes.len()));
        out.extend_from_slice(&file.bytes);
        out.resize(out.len().next_multiple_of(BLOCK), 0);
    }
    out.resize(out.len() + 2 * BLOCK, 0);
    out
}

fn header(name: &str, size: usize) -> [u8; BLOCK] {
    let mut header = [0; BLOCK];
    let mut put = |at: usize, text: &[u8]| header[at..at + text.len()].copy_from_slice(text);
    put(0, name.as_bytes());
    put(100, b"0000644\0");
    put(108, b"0000000\0");
    put(116, b"0000000\0");
    put(124, format!("{size:011o}\0").as_bytes());
    put(136, b"00000000000\0");
    // The sum is of a header with spaces in its place.
    put(148, b"        ");
    put(156, b"0");
    put(257, b"ustar\x0000");
    let sum: u32 = header.iter().map(|&byte| u32::from(byte)).sum();
    header[148..156].copy_from_slice(format!("{sum:06o}\0 ").as_bytes());
    header
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_a_header_and_whole_blocks() {
        let bytes = archive(&[ExportFile::new("a.yaml", "mode: raw\n"), ExportFile::new("b.pgm", vec![7; 513])]);
        assert_eq!(bytes.len(), (1 + 1 + 1 + 2 + 2) * BLOCK);
        assert_eq!((&bytes[..6], &bytes[124..135]), (&b"a.yaml"[..], &b"00000000012"[..]));
        let sum: u32 = bytes[..BLOCK]
            .iter()
            .enumerate()
            .map(|(k, &b)| if (148..156).contains(&k) { 32 } else { u32::from(b) })
            .sum();
        assert_eq!(&bytes[148..154], format!("{sum:06o}").as_bytes());
        assert_eq!(&bytes[1024..1029], b"b.pgm");
    }
}
