//! Meshes of an earlier reading, by content: what did not change is not meshed and cut again.
//!
//! An entry is what the kernel made of a product, or the difference of a body and its openings, under a hash of all that it was
//! made of. What is made with a cache is equal, byte for byte, to what is made without one. A cache is of one program: its bytes
//! begin with a hash of the program, of themselves and of their length, and others are not taken. It keeps what the last reading
//! needed, up to a number of bytes.

use rustc_hash::FxHashMap;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};
use thiserror::Error;
use xxhash_rust::xxh3::xxh3_128;

const MAGIC: [u8; 8] = *b"GPMESH01";
/// Magic, hash of the program, hash of what follows the head, its length.
const HEAD: usize = 48;
/// Key and length of an entry.
const ENTRY_HEAD: usize = 20;

/// Why bytes are no cache that this program can use.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum MeshCacheError {
    /// They begin otherwise.
    #[error("it is no cache of meshes")]
    Foreign,
    /// Meshes may differ from program to program.
    #[error("it was written by another build of the program")]
    OtherProgram,
    /// They are not what was written.
    #[error("it is damaged")]
    Damaged,
}

/// What a cache was good for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct MeshCacheCounts {
    /// Products and differences that were taken from the cache.
    pub found: usize,
    /// Products and differences that were made anew.
    pub made: usize,
    /// Bytes that are kept for the next reading.
    pub bytes: usize,
}

/// Most bytes of a cache that is kept as a file: the meshes of a model of 700 MB or so. While files are read they take as much memory,
/// and as much again for those that are made anew and for the file that is written.
const MAX_MESH_CACHE_BYTES: usize = 512 << 20;

/// Meshes of the last reading, and those of this one.
#[derive(Debug)]
pub struct MeshCache {
    program: u128,
    max_bytes: usize,
    last: Vec<u8>,
    /// Where the entry of a key lies in them.
    index: FxHashMap<u128, Range<usize>>,
    next: Mutex<Next>,
}

#[derive(Debug, Default)]
struct Next {
    /// Entries that this reading needed: those made anew, and places of the others.
    entries: BTreeMap<u128, Kept>,
    counts: MeshCacheCounts,
}

#[derive(Debug)]
enum Kept {
    Last(Range<usize>),
    New(Vec<u8>),
}

impl MeshCache {
    /// An empty cache of a program, by a hash of it, that keeps at most so many bytes.
    pub fn new(program: u128, max_bytes: usize) -> Self {
        Self { program, max_bytes, last: Vec::new(), index: FxHashMap::default(), next: Mutex::default() }
    }

    /// The cache that [`MeshCache::finish`] gave.
    ///
    /// # Errors
    /// Bytes that are something else, of another program, or damaged.
    pub fn read(bytes: Vec<u8>, program: u128, max_bytes: usize) -> Result<Self, MeshCacheError> {
        let number =
            |at: usize| -> Option<u128> { Some(u128::from_le_bytes(bytes.get(at..at + 16)?.try_into().ok()?)) };
        if !bytes.starts_with(&MAGIC) {
            return Err(MeshCacheError::Foreign);
        }
        let length = bytes.get(40..HEAD).and_then(|length| Some(u64::from_le_bytes(length.try_into().ok()?)));
        let (Some(of), Some(hash), Some(length)) = (number(8), number(24), length) else {
            return Err(MeshCacheError::Damaged);
        };
        if of != program {
            return Err(MeshCacheError::OtherProgram);
        }
        if length != (bytes.len() - HEAD) as u64 || hash != xxh3_128(&bytes[HEAD..]) {
            return Err(MeshCacheError::Damaged);
        }
        let (mut index, mut at) = (FxHashMap::default(), HEAD);
        while at < bytes.len() {
            let length = bytes.get(at + 16..at + ENTRY_HEAD).and_then(|length| length.try_into().ok());
            let (Some(key), Some(length)) = (number(at), length) else { return Err(MeshCacheError::Damaged) };
            let entry = at + ENTRY_HEAD..at + ENTRY_HEAD + u32::from_le_bytes(length) as usize;
            if entry.end > bytes.len() {
                return Err(MeshCacheError::Damaged);
            }
            at = entry.end;
            index.insert(key, entry);
        }
        Ok(Self { program, max_bytes, last: bytes, index, next: Mutex::default() })
    }

    /// The cache in a file, as it was read: an empty one if there is none, or with the reason if it cannot be used.
    pub fn of_file(read: io::Result<Vec<u8>>, program: u128) -> (Self, Option<String>) {
        let cache = match read {
            Ok(bytes) => Self::read(bytes, program, MAX_MESH_CACHE_BYTES).map_err(|why| why.to_string()),
            Err(why) if why.kind() == io::ErrorKind::NotFound => Ok(Self::new(program, MAX_MESH_CACHE_BYTES)),
            Err(why) => Err(why.to_string()),
        };
        match cache {
            Ok(cache) => (cache, None),
            Err(why) => (Self::new(program, MAX_MESH_CACHE_BYTES), Some(why)),
        }
    }

    /// The bytes to read the next time from: what this reading needed.
    pub fn finish(&self) -> Vec<u8> {
        let next = self.next();
        let mut bytes = vec![0; HEAD];
        bytes.reserve(next.counts.bytes);
        for (key, kept) in &next.entries {
            let entry = match kept {
                Kept::Last(place) => &self.last[place.clone()],
                Kept::New(entry) => entry,
            };
            bytes.extend_from_slice(&key.to_le_bytes());
            bytes.extend_from_slice(&(entry.len() as u32).to_le_bytes());
            bytes.extend_from_slice(entry);
        }
        let (hash, length) = (xxh3_128(&bytes[HEAD..]), (bytes.len() - HEAD) as u64);
        bytes[..8].copy_from_slice(&MAGIC);
        bytes[8..24].copy_from_slice(&self.program.to_le_bytes());
        bytes[24..40].copy_from_slice(&hash.to_le_bytes());
        bytes[40..HEAD].copy_from_slice(&length.to_le_bytes());
        bytes
    }

    /// What was taken from the cache, and what was not.
    pub fn counts(&self) -> MeshCacheCounts {
        self.next().counts
    }

    /// True if this reading made something, or did not need all that the earlier one kept.
    pub fn has_changed(&self) -> bool {
        let next = self.next();
        next.counts.made > 0 || next.entries.len() != self.index.len()
    }

    /// True if there is an entry of this key.
    pub(crate) fn has(&self, key: u128) -> bool {
        self.index.contains_key(&key)
    }

    /// The entry of a key, if there is one that `fits`; it is kept.
    pub(crate) fn take<T: DeserializeOwned>(&self, key: u128, fits: impl FnOnce(&T) -> bool) -> Option<T> {
        let place = self.index.get(&key)?;
        let entry = postcard::from_bytes(&self.last[place.clone()]).ok().filter(fits)?;
        let mut next = self.next();
        next.counts.found += 1;
        self.keep(&mut next, key, place.len(), || Kept::Last(place.clone()));
        Some(entry)
    }

    /// Counts what was made anew, and keeps it under its key; without a key it is not kept.
    pub(crate) fn put<T: Serialize>(&self, key: Option<u128>, entry: &T) {
        let entry = key.and_then(|key| Some((key, postcard::to_stdvec(entry).ok()?)));
        let mut next = self.next();
        next.counts.made += 1;
        if let Some((key, entry)) = entry.filter(|(_, entry)| u32::try_from(entry.len()).is_ok()) {
            self.keep(&mut next, key, entry.len(), || Kept::New(entry));
        }
    }

    fn keep(&self, next: &mut Next, key: u128, length: usize, kept: impl FnOnce() -> Kept) {
        let bytes = next.counts.bytes + ENTRY_HEAD + length;
        if bytes <= self.max_bytes && !next.entries.contains_key(&key) {
            next.counts.bytes = bytes;
            next.entries.insert(key, kept());
        }
    }

    fn next(&self) -> MutexGuard<'_, Next> {
        // Nothing panics while it is held.
        self.next.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cache(max_bytes: usize) -> MeshCache {
        let cache = MeshCache::new(7, max_bytes);
        cache.put(Some(1), &vec![1u32; 30]);
        cache.put(Some(2), &vec![2u32; 30]);
        cache.put(None, &vec![3u32; 30]);
        cache
    }

    fn taken(cache: &MeshCache, key: u128) -> Option<Vec<u32>> {
        cache.take(key, |_| true)
    }

    #[test]
    fn what_was_needed_is_kept_and_what_was_not_is_forgotten() {
        let first = cache(1 << 20);
        assert_eq!(taken(&first, 1), None, "it is of this reading");
        let second = MeshCache::read(first.finish(), 7, 1 << 20).unwrap();
        assert_eq!(taken(&second, 2), Some(vec![2; 30]));
        assert_eq!(second.take(1, |_: &Vec<u32>| false), None);
        let MeshCacheCounts { found, made, .. } = second.counts();
        assert_eq!((found, made), (1, 0));
        let third = MeshCache::read(second.finish(), 7, 1 << 20).unwrap();
        assert_eq!([1, 2].map(|key| taken(&third, key)), [None, Some(vec![2; 30])]);
    }

    #[test]
    fn no_more_bytes_are_kept_than_are_allowed() {
        let (one, both) = (cache(70), cache(140));
        assert!(one.finish().len() <= HEAD + 70 && both.finish().len() <= HEAD + 140);
        let [one, both] = [one, both].map(|cache| MeshCache::read(cache.finish(), 7, 140).unwrap());
        assert_eq!([one.has(1), one.has(2), both.has(1), both.has(2)], [true, false, true, true]);
    }

    #[test]
    fn bytes_that_are_damaged_or_of_others_are_not_taken() {
        let bytes = cache(1 << 20).finish();
        let read = |bytes: &[u8], program| MeshCache::read(bytes.to_vec(), program, 1 << 20).map(drop);
        assert_eq!(read(&bytes, 7), Ok(()));
        assert_eq!(read(&bytes, 8), Err(MeshCacheError::OtherProgram));
        assert_eq!(read(b"ISO-10303-21;", 7), Err(MeshCacheError::Foreign));
        assert_eq!(read(&[], 7), Err(MeshCacheError::Foreign));
        for length in 8..bytes.len() {
            assert!(read(&bytes[..length], 7).is_err(), "{length}");
        }
        for at in 0..bytes.len() {
            let mut damaged = bytes.clone();
            damaged[at] ^= 0x40;
            assert!(read(&damaged, 7).is_err(), "{at}");
        }
    }
}
