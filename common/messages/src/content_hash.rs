//! Hashes of content inside one host.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};
use std::fmt;
use xxhash_rust::xxh3::xxh3_64;

/// A hash of 64 bits (xxh3) that tells content apart inside one host: of an archive in its preamble, of what it was made from in its
/// head and in sample headers, of a robot profile, of the inputs of a computation.
///
/// It is quick to make and no protection: who wants to can make other content of the same hash, and among many contents two may have
/// the same by chance. What leaves the host, or is kept for others, is identified by a [`crate::ContentId`]. Documents may still show the hash
/// beside, as 16 hexadecimal digits, so that people find what they see on the bus.
///
/// In records and in JSON it is the plain number.
#[derive(Clone, Copy, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Zeroable, Pod, Serialize, Deserialize)]
#[repr(transparent)]
#[serde(transparent)]
pub struct ContentHash(u64);

impl ContentHash {
    /// Of nothing: an input that is not there or does not matter.
    pub const NONE: Self = Self(0);

    /// Of bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(xxh3_64(bytes))
    }

    /// With this number, for hashes that are made piece by piece.
    pub const fn from_bits(bits: u64) -> Self {
        Self(bits)
    }

    /// Its number.
    pub const fn to_bits(self) -> u64 {
        self.0
    }

    /// Its bytes as they lie in an archive, from which another hash is made.
    pub const fn to_le_bytes(self) -> [u8; 8] {
        self.0.to_le_bytes()
    }

    /// True for [`Self::NONE`].
    pub const fn is_none(self) -> bool {
        self.0 == 0
    }
}

impl fmt::Display for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

impl fmt::Debug for ContentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_shows_16_digits_and_lies_in_records_as_its_number() {
        let hash = ContentHash::from_bits(0xab);
        assert_eq!((hash.to_string(), format!("{hash:?}")), ("00000000000000ab".to_owned(), hash.to_string()));
        assert_eq!(bytemuck::bytes_of(&hash), hash.to_bits().to_le_bytes());
        assert!(ContentHash::NONE.is_none() && !hash.is_none());
        assert_eq!(ContentHash::of(b""), ContentHash::from_bits(0x2d06_8005_38d3_94c2), "xxh3 of nothing");
    }
}
