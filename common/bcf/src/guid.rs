//! Identities: UUIDs that follow from words, GlobalIds of IFC.

use sha2::{Digest, Sha256};

/// A UUID of version 8 made from words: the same words, the same UUID.
pub fn uuid(words: &[&str]) -> String {
    let digest = Sha256::digest(words.join("\n").as_bytes());
    let mut bytes: [u8; 16] = std::array::from_fn(|k| digest[k]);
    bytes[6] = bytes[6] & 0x0f | 0x80;
    bytes[8] = bytes[8] & 0x3f | 0x80;
    let hex = format!("{:032x}", u128::from_be_bytes(bytes));
    format!("{}-{}-{}-{}-{}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

/// True for what IFC allows as a GlobalId.
pub fn is_global_id(text: &str) -> bool {
    text.len() == 22 && text.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'$')
}

/// True for a UUID as topics and their folders are named.
pub(crate) fn is_uuid(text: &str) -> bool {
    let parts: Vec<&str> = text.split('-').collect();
    let lengths: Vec<usize> = parts.iter().map(|part| part.len()).collect();
    lengths == [8, 4, 4, 4, 12] && parts.iter().all(|part| part.bytes().all(|b| b.is_ascii_hexdigit()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_same_words_give_the_same_uuid() {
        assert_eq!(uuid(&["a", "b"]), uuid(&["a", "b"]));
        assert_ne!(uuid(&["a", "b"]), uuid(&["a", "c"]));
        assert!(is_uuid(&uuid(&["a"])) && !is_uuid("a") && !is_uuid("0-0-0-0-0"));
        assert!(
            is_global_id("2nJpOmW6eM0ctxYO6wzQ8k")
                && !is_global_id("2nJpOmW6eM0ctxYO6wzQ8")
                && !is_global_id("2nJpOmW6eM0ctxYO6wzQ8-")
        );
    }
}
