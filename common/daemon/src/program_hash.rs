//! Hash of the running program: what of a cache may differ from build to build is taken by the program alone that made it.

use sha2::{Digest, Sha256};
use std::fs;
use std::sync::OnceLock;

static OWN: OnceLock<Option<u128>> = OnceLock::new();

/// The first half of the SHA-256 of the program's file; `None` if that cannot be read.
pub fn program_hash() -> Option<u128> {
    *OWN.get_or_init(|| {
        // The file that runs, also after another one has taken its name.
        let bytes = fs::read("/proc/self/exe").ok()?;
        Some(u128::from_le_bytes(Sha256::digest(bytes)[..16].try_into().ok()?))
    })
}
