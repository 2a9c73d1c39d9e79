//! Objects of a site in a folder, in S3 or behind a plain web server, with one interface.
//!
//! Calls block; each has its time. What an object holds, and whether it is to be believed, is for `replica`: this crate brings bytes, up
//! to a limit that its caller names, and knows no sites. It alone names the library of stores and its network.
//!
//! # Addresses
//!
//! | address | store |
//! |---|---|
//! | a path, `file:///srv/site` | a folder; files are replaced whole, and are on disk when a call returns |
//! | `s3://bucket/prefix` | S3; `endpoint` and `region` in the credentials name one that is not Amazon's |
//! | `https://host/path`, `http://..` | a web server, to read from |
//!
//! # Guarantees
//!
//! - An object is created once, or replaced whole.
//! - A server that ignores ranges costs whole objects, and gives the same bytes.
//! - No object is read beyond the limit that was named for it, whatever a server sends.

mod credentials;
mod error;
mod location;
mod objects;

pub use credentials::{Credentials, CredentialsError};
pub use error::StoreError;
pub use objects::{Fetched, Listed, Objects};

use futures::TryStreamExt;
use jiff::Timestamp;
use object_store::path::Path as ObjectPath;
use object_store::{GetOptions, GetRange, ObjectStore, ObjectStoreExt, PutMode, PutPayload};
use std::fmt;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use tokio::runtime::Runtime;

/// A store of objects.
pub struct Store {
    objects: Arc<dyn ObjectStore>,
    /// Goes before all paths.
    prefix: ObjectPath,
    /// The address, without anything secret.
    address: String,
    runtime: Runtime,
    ignores_ranges: AtomicBool,
    /// The last object that was fetched whole because ranges are ignored: its other parts are asked for next.
    last_whole: Mutex<Option<(String, Vec<u8>)>>,
}

impl fmt::Debug for Store {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Store({})", self.address)
    }
}

impl Store {
    /// The store at an address, to write into it: a folder is made if it is missing.
    ///
    /// # Errors
    /// An address of no kind of store, or with anything secret; credentials that do not fit.
    pub fn open(address: &str, credentials: &Credentials) -> Result<Self, StoreError> {
        Self::open_for(address, credentials, true)
    }

    /// The same, to read from it: a folder has to be there.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_to_read(address: &str, credentials: &Credentials) -> Result<Self, StoreError> {
        Self::open_for(address, credentials, false)
    }

    fn open_for(address: &str, credentials: &Credentials, to_write: bool) -> Result<Self, StoreError> {
        let (objects, prefix) = location::open(address, credentials, to_write)?;
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|source| StoreError::Thread { source })?;
        Ok(Self {
            objects,
            prefix,
            address: address.to_owned(),
            runtime,
            ignores_ranges: AtomicBool::new(false),
            last_whole: Mutex::default(),
        })
    }

    fn put(&self, path: &str, bytes: &[u8], mode: PutMode) -> Result<(), StoreError> {
        let payload = PutPayload::from(bytes.to_vec());
        let put = self.runtime.block_on(async {
            self.objects
                .put_opts(&self.at(path), payload, mode.into())
                .await
                .map_err(|source| self.refused(path, source))
        });
        put.map(drop)
    }

    fn fetch(&self, path: &str, options: GetOptions, max_bytes: u64) -> Result<(Vec<u8>, Option<String>), StoreError> {
        let too_large = || StoreError::TooLarge { path: path.to_owned(), max_bytes };
        self.runtime.block_on(async {
            let found = self.objects.get_opts(&self.at(path), options).await.map_err(|why| self.refused(path, why))?;
            let etag = found.meta.e_tag.clone();
            if found.range.end - found.range.start > max_bytes {
                return Err(too_large());
            }
            let mut bytes = Vec::new();
            let mut parts = found.into_stream();
            while let Some(part) = parts.try_next().await.map_err(|source| self.refused(path, source))? {
                if bytes.len() as u64 + part.len() as u64 > max_bytes {
                    return Err(too_large());
                }
                bytes.extend_from_slice(&part);
            }
            Ok((bytes, etag))
        })
    }

    fn at(&self, path: &str) -> ObjectPath {
        self.prefix.parts().chain(path.split('/').map(Into::into)).collect()
    }

    fn refused(&self, path: &str, source: object_store::Error) -> StoreError {
        match source {
            object_store::Error::NotFound { .. } => {
                StoreError::Missing { path: path.to_owned(), address: self.address.clone() }
            }
            source => StoreError::Store { path: path.to_owned(), address: self.address.clone(), source },
        }
    }
}

impl Objects for Store {
    fn address(&self) -> &str {
        &self.address
    }

    fn fetch_unless(&self, path: &str, etag: Option<&str>, max_bytes: u64) -> Result<Fetched, StoreError> {
        let options = GetOptions { if_none_match: etag.map(str::to_owned), ..GetOptions::default() };
        match self.fetch(path, options, max_bytes) {
            Ok((bytes, new)) if etag.is_some() && new.as_deref() == etag => {
                drop(bytes);
                Ok(Fetched::Unchanged)
            }
            Ok((bytes, etag)) => Ok(Fetched::New { bytes, etag }),
            Err(StoreError::Store { source: object_store::Error::NotModified { .. }, .. }) => Ok(Fetched::Unchanged),
            Err(StoreError::Missing { .. }) => Ok(Fetched::Missing),
            Err(why) => Err(why),
        }
    }

    fn fetch_whole(&self, path: &str, max_bytes: u64) -> Result<Vec<u8>, StoreError> {
        // Who asks for something else may come back for what was wrong: it is asked for anew.
        *self.last_whole.lock().unwrap_or_else(PoisonError::into_inner) = None;
        self.fetch(path, GetOptions::default(), max_bytes).map(|(bytes, _)| bytes)
    }

    fn fetch_range(&self, path: &str, range: Range<u64>, object_bytes: u64) -> Result<Vec<u8>, StoreError> {
        let length = range.end.saturating_sub(range.start);
        if !self.ignores_ranges.load(Ordering::Relaxed) {
            let options = GetOptions { range: Some(GetRange::Bounded(range.clone())), ..GetOptions::default() };
            match self.fetch(path, options, length) {
                Ok((bytes, _)) if bytes.len() as u64 == length => return Ok(bytes),
                Ok(_) => return Err(StoreError::Short { path: path.to_owned() }),
                Err(StoreError::Store { source, .. }) if is_about_ranges(&source) => {
                    self.ignores_ranges.store(true, Ordering::Relaxed);
                }
                Err(why) => return Err(why),
            }
        }
        let mut last = self.last_whole.lock().unwrap_or_else(PoisonError::into_inner);
        let bytes = match last.take() {
            Some((of, bytes)) if of == path => bytes,
            _ => self.fetch(path, GetOptions::default(), object_bytes)?.0,
        };
        let part = usize::try_from(range.start).ok().zip(usize::try_from(range.end).ok());
        let part = part.and_then(|(start, end)| bytes.get(start..end)).map(<[u8]>::to_vec);
        *last = Some((path.to_owned(), bytes));
        part.ok_or_else(|| StoreError::Short { path: path.to_owned() })
    }

    fn create(&self, path: &str, bytes: &[u8]) -> Result<bool, StoreError> {
        match self.put(path, bytes, PutMode::Create) {
            Ok(()) => Ok(true),
            Err(StoreError::Store { source: object_store::Error::AlreadyExists { .. }, .. }) => Ok(false),
            Err(why) => Err(why),
        }
    }

    fn replace(&self, path: &str, bytes: &[u8]) -> Result<(), StoreError> {
        self.put(path, bytes, PutMode::Overwrite)
    }

    fn length(&self, path: &str) -> Result<Option<u64>, StoreError> {
        match self.runtime.block_on(self.objects.head(&self.at(path))) {
            Ok(head) => Ok(Some(head.size)),
            Err(object_store::Error::NotFound { .. }) => Ok(None),
            Err(source) => Err(self.refused(path, source)),
        }
    }

    fn list(&self, folder: &str) -> Result<Vec<Listed>, StoreError> {
        let prefix = self.at(folder);
        let listed = self.runtime.block_on(self.objects.list(Some(&prefix)).try_collect::<Vec<_>>());
        let mut listed: Vec<Listed> = listed
            .map_err(|source| self.refused(folder, source))?
            .into_iter()
            .filter_map(|meta| {
                let parts = meta.location.prefix_match(&self.prefix)?;
                let path = parts.map(|part| part.as_ref().to_owned()).collect::<Vec<_>>().join("/");
                let modified = Timestamp::from_second(meta.last_modified.timestamp()).ok()?;
                Some(Listed { path, bytes: meta.size, modified })
            })
            .collect();
        listed.sort_by(|a, b| a.path.cmp(&b.path));
        Ok(listed)
    }

    fn remove(&self, path: &str) -> Result<(), StoreError> {
        match self.runtime.block_on(self.objects.delete(&self.at(path))) {
            Ok(()) | Err(object_store::Error::NotFound { .. }) => Ok(()),
            Err(source) => Err(self.refused(path, source)),
        }
    }
}

/// True if a server answered with something else than the range that it was asked for.
fn is_about_ranges(error: &object_store::Error) -> bool {
    let mut next: Option<&(dyn std::error::Error + 'static)> = Some(error);
    while let Some(why) = next {
        let text = why.to_string();
        if text.contains("non-partial response") || text.contains("Content-Range") || text.contains("CONTENT_RANGE") {
            return true;
        }
        next = why.source();
    }
    matches!(error, object_store::Error::NotSupported { .. })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder() -> (tempfile::TempDir, Store) {
        let home = tempfile::tempdir().unwrap();
        let store = Store::open(home.path().to_str().unwrap(), &Credentials::default()).unwrap();
        (home, store)
    }

    #[test]
    fn an_object_is_created_once_and_replaced_whole() {
        let (home, store) = folder();
        assert!(store.create("tower/index/1.jsonl", b"one").unwrap());
        assert!(!store.create("tower/index/1.jsonl", b"other").unwrap());
        assert_eq!(std::fs::read(home.path().join("tower/index/1.jsonl")).unwrap(), b"one");
        store.replace("tower/index/1.jsonl", b"two").unwrap();
        assert_eq!(store.fetch_whole("tower/index/1.jsonl", 100).unwrap(), b"two");
        assert_eq!(store.length("tower/index/1.jsonl").unwrap(), Some(3));
        assert_eq!(store.length("tower/index/2.jsonl").unwrap(), None);
    }

    #[test]
    fn an_address_with_a_password_is_refused_without_repeating_it() {
        for address in ["https://robot:hunter2@maps.example/x", "s3://maps/x?key=hunter2"] {
            let why = Store::open(address, &Credentials::default()).unwrap_err();
            assert!(matches!(why, StoreError::Secret { .. }) && !format!("{why} {why:?}").contains("hunter2"), "{why}");
        }
    }

    #[test]
    fn who_reads_makes_no_folder() {
        let home = tempfile::tempdir().unwrap();
        let away = home.path().join("away");
        assert!(Store::open_to_read(away.to_str().unwrap(), &Credentials::default()).is_err());
        assert!(!away.exists());
    }

    #[test]
    fn an_object_that_is_as_before_is_not_sent_again() {
        let (_home, store) = folder();
        assert_eq!(store.fetch_unless("a", None, 10).unwrap(), Fetched::Missing);
        store.replace("a", b"one").unwrap();
        let Fetched::New { bytes, etag } = store.fetch_unless("a", None, 10).unwrap() else { panic!("it is new") };
        assert_eq!(bytes, b"one");
        assert!(etag.is_some());
        assert_eq!(store.fetch_unless("a", etag.as_deref(), 10).unwrap(), Fetched::Unchanged);
        store.replace("a", b"other").unwrap();
        assert!(matches!(store.fetch_unless("a", etag.as_deref(), 10).unwrap(), Fetched::New { .. }));
    }

    #[test]
    fn nothing_is_read_beyond_its_limit_and_ranges_are_exact() {
        let (_home, store) = folder();
        store.replace("a/b", b"0123456789").unwrap();
        assert!(matches!(store.fetch_whole("a/b", 9), Err(StoreError::TooLarge { .. })));
        assert_eq!(store.fetch_range("a/b", 2..5, 10).unwrap(), b"234");
        assert!(store.fetch_range("a/b", 8..12, 12).is_err());
        assert!(matches!(store.fetch_whole("a/c", 9), Err(StoreError::Missing { .. })));
    }

    #[test]
    fn what_is_kept_of_a_server_that_ignores_ranges_is_kept_for_one_object_at_a_time() {
        let (_home, store) = folder();
        store.ignores_ranges.store(true, Ordering::Relaxed);
        store.replace("pack", b"wrong").unwrap();
        store.replace("recipe", b"r").unwrap();
        assert_eq!(store.fetch_range("pack", 0..2, 5).unwrap(), b"wr");
        store.replace("pack", b"right").unwrap();
        assert_eq!(store.fetch_range("pack", 2..5, 5).unwrap(), b"ong", "parts of one object are of one state of it");
        store.fetch_whole("recipe", 1).unwrap();
        assert_eq!(store.fetch_range("pack", 0..5, 5).unwrap(), b"right");
    }

    #[test]
    fn a_list_has_the_paths_inside_the_store_in_their_order() {
        let (_home, store) = folder();
        for path in ["s/index/2", "s/index/1", "s/other/1"] {
            store.create(path, b"x").unwrap();
        }
        let paths = |folder| store.list(folder).unwrap().into_iter().map(|listed| listed.path).collect::<Vec<_>>();
        assert_eq!(paths("s/index"), ["s/index/1", "s/index/2"]);
        store.remove("s/index/1").unwrap();
        store.remove("s/index/1").unwrap();
        assert_eq!(paths("s/index"), ["s/index/2"]);
        assert!(paths("nothing").is_empty());
    }
}
