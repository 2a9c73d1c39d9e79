//! The file of an index: four lines of JSON. A list of keys, its signature by a root key, the index, its signature by a key of the list.

use crate::index::{Form, SiteIndex};
use crate::keys::{KeyList, PublicKey, Signature, SigningKey};
use serde::{Deserialize, Serialize};
use std::str::from_utf8;

/// A longer file is not read: ten storeys, ten robots and a hundred dates need a fifth of it.
pub const MAX_INDEX_BYTES: u64 = 32 << 20;

/// Words for what is signed.
const KEYS: &str = "keys";
const INDEX: &str = "index";

/// An index with its list of keys, whose signatures are right: by which keys, the reader has to look at.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SignedIndex {
    /// The keys that may sign.
    pub keys: KeyList,
    /// Who signed the list.
    pub root: PublicKey,
    /// The index.
    pub index: SiteIndex,
    /// Who signed the index; in the list.
    pub signer: PublicKey,
}

/// Bytes that are no index with right signatures.
#[derive(Debug, thiserror::Error)]
pub enum SignedIndexError {
    /// Not four lines of text.
    #[error("it is not four lines of text")]
    Lines,
    /// A line that is no such document.
    #[error("its {line} cannot be read")]
    Line {
        /// Which line.
        line: &'static str,
        /// Why.
        source: serde_json::Error,
    },
    /// A signature that is not of these bytes.
    #[error("the signature of its {line} is wrong")]
    Signature {
        /// Which line.
        line: &'static str,
    },
    /// A root key that the robot does not know.
    #[error("its list of keys is signed by {root}, which is no root key of this robot")]
    Root {
        /// By whom.
        root: PublicKey,
    },
    /// The signer is not in the list.
    #[error(
        "it is signed by {signer}, which is not in list {number} of the site's keys: the key may have been revoked"
    )]
    Signer {
        /// By whom.
        signer: PublicKey,
        /// Number of the list.
        number: u64,
    },
    /// List and index are of different sites, or the index has another form.
    #[error("{0}")]
    Content(String),
}

/// A signature, and by whom.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct SignedBy {
    key: PublicKey,
    signature: Signature,
}

/// The two lines of a list of keys that a root key signs: the file `keys.jsonl` of a server.
pub(crate) fn signed_keys(keys: &KeyList, root: &SigningKey) -> String {
    signed(KEYS, keys, root)
}

/// The file of an index, with the list of keys as its root key signed it.
///
/// # Errors
/// A list of keys that is not signed right, or does not have this key.
pub fn signed_index(signed_keys: &str, index: &SiteIndex, key: &SigningKey) -> Result<Vec<u8>, SignedIndexError> {
    let (keys, root) = KeyList::parse_signed(signed_keys)?;
    let text = format!("{}{}", signed_keys_again(signed_keys), signed(INDEX, index, key));
    if !keys.keys.contains(&key.public()) {
        return Err(SignedIndexError::Signer { signer: key.public(), number: keys.number });
    }
    // What is written can be read: nobody else would find out.
    SignedIndex::parse(text.as_bytes(), &[root])?;
    Ok(text.into_bytes())
}

/// The lines as they were signed, with one end of line each.
fn signed_keys_again(signed_keys: &str) -> String {
    signed_keys.lines().map(|line| format!("{line}\n")).collect()
}

fn signed(what: &str, document: &impl Serialize, key: &SigningKey) -> String {
    let text = serde_json::to_string(document).expect("these documents have no keys but texts");
    let by = SignedBy { key: key.public(), signature: key.sign(what, &text) };
    let by = serde_json::to_string(&by).expect("these documents have no keys but texts");
    format!("{text}\n{by}\n")
}

impl KeyList {
    /// The two lines of this list that a root key signs.
    pub fn signed_by(&self, root: &SigningKey) -> String {
        signed_keys(self, root)
    }

    /// The list of two lines, and who signed it: that this is a root key, the reader has to look at.
    ///
    /// # Errors
    /// Other bytes, or a wrong signature.
    pub fn parse_signed(text: &str) -> Result<(Self, PublicKey), SignedIndexError> {
        let lines: Vec<&str> = text.lines().collect();
        let [keys, by] = lines[..] else { return Err(SignedIndexError::Lines) };
        let root = checked(KEYS, keys, by)?;
        Ok((read("list of keys", keys)?, root))
    }
}

impl SignedIndex {
    /// Reads and checks: a root key signed the list of keys, and a key of the list signed the index.
    ///
    /// # Errors
    /// Anything else. No line is read before its signature was checked.
    pub fn parse(bytes: &[u8], roots: &[PublicKey]) -> Result<Self, SignedIndexError> {
        let text = from_utf8(bytes).map_err(|_| SignedIndexError::Lines)?;
        // Lines of another form would be the same index with another sha256.
        if text.contains('\r') {
            return Err(SignedIndexError::Lines);
        }
        let lines: Vec<&str> = text.lines().take(5).collect();
        let [keys_line, keys_by, index_line, index_by] = lines[..] else { return Err(SignedIndexError::Lines) };
        let root = checked(KEYS, keys_line, keys_by)?;
        if !roots.contains(&root) {
            return Err(SignedIndexError::Root { root });
        }
        let keys: KeyList = read("list of keys", keys_line)?;
        let signer = checked(INDEX, index_line, index_by)?;
        if !keys.keys.contains(&signer) {
            return Err(SignedIndexError::Signer { signer, number: keys.number });
        }
        let Form { format } = read("index", index_line)?;
        if format != SiteIndex::FORMAT {
            let why = format!(
                "its form is {format}, this version reads {}: the server of the site and its robots need the same version of groundplan",
                SiteIndex::FORMAT
            );
            return Err(SignedIndexError::Content(why));
        }
        let index: SiteIndex = read("index", index_line)?;
        if keys.site != index.site {
            let why = format!("its list of keys is of the site {}, its index of {}", keys.site, index.site);
            return Err(SignedIndexError::Content(why));
        }
        if index.sets.is_empty() || !index.sets.is_sorted_by(|a, b| a.plan_time_s < b.plan_time_s) {
            return Err(SignedIndexError::Content(
                "its sets of maps are not in the order of their plan times".to_owned(),
            ));
        }
        Ok(Self { keys, root, index, signer })
    }
}

/// Who signed a line, whose signature is right.
fn checked(what: &'static str, text: &str, by: &str) -> Result<PublicKey, SignedIndexError> {
    let by: SignedBy = read("signature", by)?;
    if !by.key.has_signed(what, text, &by.signature) {
        return Err(SignedIndexError::Signature { line: what });
    }
    Ok(by.key)
}

fn read<'a, T: Deserialize<'a>>(line: &'static str, text: &'a str) -> Result<T, SignedIndexError> {
    serde_json::from_str(text).map_err(|source| SignedIndexError::Line { line, source })
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::index::IndexClock;
    use crate::index::tests::index;

    /// Keys of a site: root, and one that signs.
    pub(crate) struct TestKeys {
        pub(crate) root: SigningKey,
        pub(crate) signing: SigningKey,
    }

    impl TestKeys {
        pub(crate) fn new() -> Self {
            let key = || SigningKey::generate().unwrap().0;
            Self { root: key(), signing: key() }
        }

        pub(crate) fn list(&self, number: u64, keys: &[PublicKey]) -> String {
            KeyList { site: "tower".parse().unwrap(), number, keys: keys.to_vec() }.signed_by(&self.root)
        }

        pub(crate) fn file(&self, number: u64, epoch: u64) -> Vec<u8> {
            let list = self.list(number, &[self.signing.public()]);
            signed_index(&list, &index(epoch, IndexClock::ByServer, &[5]), &self.signing).unwrap()
        }
    }

    #[test]
    fn a_signed_index_says_what_was_signed_and_by_whom() {
        let keys = TestKeys::new();
        let signed = SignedIndex::parse(&keys.file(2, 7), &[keys.root.public()]).unwrap();
        assert_eq!((signed.keys.number, signed.index.epoch), (2, 7));
        assert_eq!((signed.root, signed.signer), (keys.root.public(), keys.signing.public()));
    }

    #[test]
    fn an_index_that_was_changed_anywhere_is_refused() {
        let keys = TestKeys::new();
        let file = keys.file(1, 1);
        let roots = [keys.root.public()];
        assert!(SignedIndex::parse(&file, &roots).is_ok());
        // Every tenth byte, one bit each: whatever is hit, nothing that differs is accepted as another content.
        let good = SignedIndex::parse(&file, &roots).unwrap();
        for at in (0..file.len()).step_by(10) {
            let mut changed = file.clone();
            changed[at] ^= 1;
            let read = SignedIndex::parse(&changed, &roots);
            assert!(read.is_err() || read.is_ok_and(|read| read == good), "byte {at}");
        }
        for short in [0, 1, file.len() / 2] {
            assert!(SignedIndex::parse(&file[..short], &roots).is_err());
        }
    }

    #[test]
    fn an_index_of_another_form_is_told_by_its_number() {
        let keys = TestKeys::new();
        let list = keys.list(1, &[keys.signing.public()]);
        for document in [serde_json::json!({"format": 2, "site": "tower"}), serde_json::json!({"format": 77})] {
            let file = format!("{list}{}", signed(INDEX, &document, &keys.signing));
            let why = SignedIndex::parse(file.as_bytes(), &[keys.root.public()]).unwrap_err().to_string();
            assert!(why.contains(&format!("its form is {}, this version reads", document["format"])), "{why}");
        }
    }

    #[test]
    fn keys_of_others_sign_nothing() {
        let (keys, others) = (TestKeys::new(), TestKeys::new());
        let roots = [keys.root.public()];
        let refused = |file: &[u8]| SignedIndex::parse(file, &roots).unwrap_err();
        assert!(matches!(refused(&others.file(1, 1)), SignedIndexError::Root { .. }));
        // A list that is right, with an index that a key signed which is not in it.
        let list = keys.list(1, &[keys.signing.public()]);
        let index = index(1, IndexClock::ByServer, &[5]);
        let file = format!("{list}{}", signed(INDEX, &index, &others.signing));
        assert!(matches!(refused(file.as_bytes()), SignedIndexError::Signer { .. }));
        assert!(signed_index(&list, &index, &others.signing).is_err(), "nor does a server write it");
        // The signature of a list is none of an index.
        let swapped = format!("{list}{list}");
        assert!(matches!(refused(swapped.as_bytes()), SignedIndexError::Signature { line: "index" }));
    }
}
