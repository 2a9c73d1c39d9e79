//! The calls of servers and robots on a store; a simulation has a store of its own behind them.

use crate::error::StoreError;
use jiff::Timestamp;
use std::ops::Range;

/// The objects of a store.
pub trait Objects: Send {
    /// The address of the store, without anything secret.
    fn address(&self) -> &str;

    /// An object, unless it is the one of this ETag.
    ///
    /// # Errors
    /// The store cannot be reached or refuses; an object of more bytes.
    fn fetch_unless(&self, path: &str, etag: Option<&str>, max_bytes: u64) -> Result<Fetched, StoreError>;

    /// A whole object.
    ///
    /// # Errors
    /// There is none; the store cannot be reached or refuses; an object of more bytes.
    fn fetch_whole(&self, path: &str, max_bytes: u64) -> Result<Vec<u8>, StoreError>;

    /// A part of an object that has so many bytes.
    ///
    /// # Errors
    /// As [`Self::fetch_whole`]; an object that is shorter.
    fn fetch_range(&self, path: &str, range: Range<u64>, object_bytes: u64) -> Result<Vec<u8>, StoreError>;

    /// Writes an object that is not there yet; false if it is.
    ///
    /// # Errors
    /// The store cannot be reached or refuses.
    fn create(&self, path: &str, bytes: &[u8]) -> Result<bool, StoreError>;

    /// Writes an object in the place of the one that there is.
    ///
    /// # Errors
    /// As [`Self::create`].
    fn replace(&self, path: &str, bytes: &[u8]) -> Result<(), StoreError>;

    /// Length of an object; `None` if there is none.
    ///
    /// # Errors
    /// The store cannot be reached or refuses.
    fn length(&self, path: &str) -> Result<Option<u64>, StoreError>;

    /// The objects below a folder, in the order of their paths. Web servers have no lists.
    ///
    /// # Errors
    /// As [`Self::create`].
    fn list(&self, folder: &str) -> Result<Vec<Listed>, StoreError>;

    /// Removes an object; one that is not there is none.
    ///
    /// # Errors
    /// As [`Self::create`].
    fn remove(&self, path: &str) -> Result<(), StoreError>;
}

/// What became of an object that was asked for unless it is as before.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Fetched {
    /// It is as before.
    Unchanged,
    /// There is none.
    Missing,
    /// Its bytes, and what names this state of it, where the store does so.
    New {
        /// The bytes.
        bytes: Vec<u8>,
        /// Its ETag.
        etag: Option<String>,
    },
}

/// An object of a list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// Path inside the store.
    pub path: String,
    /// Length.
    pub bytes: u64,
    /// When it was written, by the clock of the store.
    pub modified: Timestamp,
}
