//! Names of sites, and of the objects of a store.

use messages::ContentId;
use serde::{Deserialize, Deserializer, Serialize};
use std::fmt;
use std::str::FromStr;

/// Longest name of a site.
const MAX_BYTES: usize = 64;

/// The name of a site in a store: 1 to 64 bytes of `a` to `z`, `0` to `9`, `-` and `_`, so that it is a part of paths as it is.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct SiteName(String);

/// A text that is no name of a site.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{text:?} is no name of a site: 1 to {MAX_BYTES} characters of a-z, 0-9, - and _")]
pub struct SiteNameError {
    /// As given, or its beginning.
    text: String,
}

impl SiteName {
    /// The name as text.
    pub fn as_str(&self) -> &str {
        &self.0
    }
}

impl FromStr for SiteName {
    type Err = SiteNameError;

    fn from_str(text: &str) -> Result<Self, SiteNameError> {
        let is_plain = |byte: u8| matches!(byte, b'a'..=b'z' | b'0'..=b'9' | b'-' | b'_');
        if text.is_empty() || text.len() > MAX_BYTES || !text.bytes().all(is_plain) {
            return Err(SiteNameError { text: text.chars().take(2 * MAX_BYTES).collect() });
        }
        Ok(Self(text.to_owned()))
    }
}

impl<'de> Deserialize<'de> for SiteName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer)?.parse().map_err(serde::de::Error::custom)
    }
}

impl fmt::Display for SiteName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// Where the blobs of a site lie. Sites share none: each removes what it does not need any more.
pub fn blob_folder(site: &SiteName) -> String {
    format!("{site}/blobs")
}

/// Where a blob lies.
pub fn blob_path(site: &SiteName, id: ContentId) -> String {
    let digits = id.to_string();
    format!("{}/{}/{digits}", blob_folder(site), &digits[..2])
}

/// Where the newest index of a site lies.
pub fn current_path(site: &SiteName) -> String {
    format!("{site}/current.jsonl")
}

/// Where the indices of a site lie.
pub fn index_folder(site: &SiteName) -> String {
    format!("{site}/index")
}

/// Where the list of the blobs that the index of an epoch needs lies: for the server, which removes what no list has.
pub fn blob_list_path(site: &SiteName, epoch: u64) -> String {
    format!("{site}/needed/{epoch:020}.json")
}

/// Where the index of an epoch lies. Names are ordered as epochs are.
pub fn index_path(site: &SiteName, epoch: u64) -> String {
    format!("{}/{epoch:020}.jsonl", index_folder(site))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_leads_nowhere_else() {
        for bad in ["", "..", "a/b", "a b", "Ä", &"x".repeat(65)] {
            assert!(bad.parse::<SiteName>().is_err(), "{bad:?}");
        }
        let site: SiteName = "tower-2_east".parse().unwrap();
        assert_eq!(index_path(&site, 7), "tower-2_east/index/00000000000000000007.jsonl");
        assert!(index_path(&site, 9) < index_path(&site, 10));
        let blob = blob_path(&site, ContentId::of(b""));
        assert!(blob.starts_with("tower-2_east/blobs/e3/e3b0c442"), "{blob}");
    }
}
