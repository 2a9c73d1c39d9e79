//! GlobalIds that depend on nothing but what they stand for.

use sha2::{Digest, Sha256};

const DIGITS: &[u8; 64] = b"0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$";

/// The GlobalId of what these parts stand for together: the first 128 bits of their sha256, as IFC writes such numbers.
pub(crate) fn global_id_of(parts: &[&str]) -> String {
    let mut hasher = Sha256::new();
    for part in parts {
        hasher.update((part.len() as u64).to_le_bytes());
        hasher.update(part);
    }
    let digest = hasher.finalize();
    let mut number = digest.iter().take(16).fold(0u128, |number, byte| number << 8 | u128::from(*byte));
    let mut digits = [b'0'; 22];
    for digit in digits.iter_mut().rev() {
        *digit = DIGITS[(number & 63) as usize];
        number >>= 6;
    }
    digits.iter().map(|digit| char::from(*digit)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_differ_by_their_parts_and_are_in_range() {
        let (a, b) = (global_id_of(&["ab", "c"]), global_id_of(&["a", "bc"]));
        assert_ne!(a, b);
        assert_eq!(a, global_id_of(&["ab", "c"]));
        // 22 digits hold 132 bits: the first has two.
        assert!(a.len() == 22 && b'0' <= a.as_bytes()[0] && a.as_bytes()[0] <= b'3', "{a}");
    }
}
