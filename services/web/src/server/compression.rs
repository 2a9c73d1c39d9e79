//! Compressed answers for whoever takes them: documents and models shrink to a fifth, pictures are compressed already.

use crate::source::Bytes;
use axum::http::{HeaderMap, header};
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

/// A shorter answer fits into a packet anyway.
const MIN_BYTES: usize = 1024;

/// True if a document of this kind is sent compressed to whoever takes it.
pub(super) fn is_compressible(media_type: &str, n_bytes: usize) -> bool {
    let kind = media_type.split(';').next().unwrap_or_default();
    n_bytes >= MIN_BYTES && (kind.starts_with("text/") || ["application/json", "model/gltf-binary"].contains(&kind))
}

/// True if the answer may be compressed with gzip: it is named, or everything is, and not with the weight 0.
pub(super) fn takes_gzip(asked: &HeaderMap) -> bool {
    let listed = asked.get_all(header::ACCEPT_ENCODING).iter().filter_map(|value| value.to_str().ok());
    let (mut gzip, mut any) = (None, None);
    for coding in listed.flat_map(|list| list.split(',')) {
        let mut parts = coding.split(';').map(str::trim);
        let name = parts.next().unwrap_or_default().to_ascii_lowercase();
        let weight = parts.find_map(|part| part.strip_prefix("q=").or_else(|| part.strip_prefix("Q=")));
        let is_taken = weight.is_none_or(|weight| weight.parse().is_ok_and(|weight: f64| weight > 0.0));
        match name.as_str() {
            "gzip" | "x-gzip" => gzip = Some(is_taken),
            "*" => any = Some(is_taken),
            _ => {}
        }
    }
    gzip.or(any).unwrap_or(false)
}

/// The bytes as a gzip file. Fast: a document of a date is made for each viewer.
pub(super) fn gzip(bytes: &Bytes) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::with_capacity(bytes.len() / 4), Compression::fast());
    encoder.write_all(bytes).expect("memory takes all bytes");
    encoder.finish().expect("memory takes all bytes")
}

#[cfg(test)]
mod tests {
    use super::*;
    use axum::http::HeaderValue;
    use std::io::Read;

    #[test]
    fn only_who_takes_gzip_gets_it() {
        let takes = |value: &'static str| {
            takes_gzip(&HeaderMap::from_iter([(header::ACCEPT_ENCODING, HeaderValue::from_static(value))]))
        };
        for value in ["gzip", "deflate, gzip;q=0.5, br", "GZIP", "*", "br;q=1.0, *;q=0.1"] {
            assert!(takes(value), "{value}");
        }
        for value in ["", "br", "gzip;q=0", "gzip; q=0.0, *", "*;q=0", "identity", "gzip;q=x"] {
            assert!(!takes(value), "{value}");
        }
        assert!(!takes_gzip(&HeaderMap::new()));
    }

    #[test]
    fn what_is_unpacked_is_what_was_packed() {
        let bytes: Bytes = (0..=255).cycle().take(100_000).collect::<Vec<u8>>().into();
        let packed = gzip(&bytes);
        let mut unpacked = Vec::new();
        flate2::read::GzDecoder::new(&packed[..]).read_to_end(&mut unpacked).unwrap();
        assert!(unpacked == *bytes && packed.len() < bytes.len() / 10);
    }

    #[test]
    fn pictures_and_short_answers_are_sent_as_they_are() {
        assert!(is_compressible("text/html; charset=utf-8", 2000) && is_compressible("application/json", 1024));
        assert!(!is_compressible("image/png", 100_000) && !is_compressible("application/json", 100));
    }
}
