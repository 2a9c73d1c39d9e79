//! Acceptance of an index by a robot: nothing older than what it acknowledged, nothing that its keys do not say.
//!
//! An index is refused, in this order:
//!
//! 1. while it is fetched: more than [`MAX_INDEX_BYTES`](crate::MAX_INDEX_BYTES);
//! 2. before a line is read ([`SignedIndex::parse`]): not four lines of the expected form, a list of keys that no root key of the
//!    robot's configuration signed, an index that no key of that list signed;
//! 3. what is signed, but is no index: another format, unknown fields, a list of another site, no sets or sets out of order ([`Refusal::Signed`]);
//! 4. another site than the robot follows, an older list, an older epoch, other content under the epoch that was acknowledged;
//! 5. another layout of archives;
//! 6. by `site-follow`, a zone of the site's clock that its machine does not know.
//!
//! The rest is believed, but for the time of publication, which decides nothing, and for length, sha256 and content hash of archives,
//! which are checked before a set is shown. A set without this robot, or a storey that it follows, is not shown, nor are those after it:
//! what was shown stays, and the status says why. Number of the list and epoch are on disk before
//! anything of an index is shown.

use crate::keys::PublicKey;
use crate::objects::SiteName;
use crate::signed_index::{SignedIndex, SignedIndexError};
use messages::ContentId;
use serde::{Deserialize, Serialize};

/// What a robot has acknowledged last; it is on its disk before anything of it is shown.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Acknowledged {
    /// The site.
    pub site: SiteName,
    /// Number of the list of keys.
    pub keys_number: u64,
    /// Epoch of the index.
    pub epoch: u64,
    /// sha256 of the line of the index, by which another index of the same epoch is noticed.
    pub index: ContentId,
}

/// Why an index is not accepted.
#[derive(Debug, thiserror::Error)]
pub enum Refusal {
    /// It is not what it should be, or nobody signed it whom the robot knows.
    #[error("the index of the site is refused")]
    Signed(#[from] SignedIndexError),
    /// It is of another site.
    #[error("the index is of the site {found}, this robot follows {followed}")]
    OtherSite {
        /// Its site.
        found: SiteName,
        /// The robot's site.
        followed: SiteName,
    },
    /// Its list of keys is older.
    #[error(
        "the index has list {found} of the site's keys, this robot has seen {known}: a key that was revoked may be in it"
    )]
    OlderKeys {
        /// Number of its list.
        found: u64,
        /// Number of the newest.
        known: u64,
    },
    /// It is older.
    #[error("the index has epoch {found}, this robot has acknowledged {known}: an old index comes again")]
    Older {
        /// Its epoch.
        found: u64,
        /// The epoch that was acknowledged.
        known: u64,
    },
    /// It has the epoch of another one.
    #[error("there are two indices of epoch {epoch}: two servers publish this site, or its store was set back")]
    Fork {
        /// The epoch.
        epoch: u64,
    },
    /// Its archives are of another version.
    #[error("the archives of the site have layout {found}, this version reads {read}: update groundplan")]
    Layout {
        /// That of the index.
        found: u32,
        /// That of this program.
        read: u32,
    },
}

/// Checks an index that a robot got; the answer is what it says, and what has to be kept before it is shown.
///
/// # Errors
/// An index that nobody signed whom `roots` lead to, of another site, older than what was acknowledged, or another one of that epoch.
pub fn accept(
    bytes: &[u8],
    roots: &[PublicKey],
    site: &SiteName,
    known: Option<&Acknowledged>,
) -> Result<(SignedIndex, Acknowledged), Refusal> {
    let signed = SignedIndex::parse(bytes, roots)?;
    let index = &signed.index;
    if index.site != *site {
        return Err(Refusal::OtherSite { found: index.site.clone(), followed: site.clone() });
    }
    let line = bytes.split(|byte| *byte == b'\n').nth(2).unwrap_or_default();
    let now = Acknowledged {
        site: site.clone(),
        keys_number: signed.keys.number,
        epoch: index.epoch,
        index: ContentId::of(line),
    };
    // What was acknowledged of another site says nothing of this one.
    if let Some(known) = known.filter(|known| known.site == *site) {
        if now.keys_number < known.keys_number {
            return Err(Refusal::OlderKeys { found: now.keys_number, known: known.keys_number });
        }
        if now.epoch < known.epoch {
            return Err(Refusal::Older { found: now.epoch, known: known.epoch });
        }
        if now.epoch == known.epoch && now.index != known.index {
            return Err(Refusal::Fork { epoch: now.epoch });
        }
    }
    if index.layout_version != messages::LAYOUT_VERSION {
        return Err(Refusal::Layout { found: index.layout_version, read: messages::LAYOUT_VERSION });
    }
    Ok((signed, now))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::index::IndexClock;
    use crate::index::tests::index;
    use crate::keys::SigningKey;
    use crate::signed_index::signed_index;
    use crate::signed_index::tests::TestKeys;

    fn tower() -> SiteName {
        "tower".parse().unwrap()
    }

    #[test]
    fn what_was_acknowledged_never_goes_back() {
        let keys = TestKeys::new();
        let roots = [keys.root.public()];
        let taken = |file: &[u8], known: Option<&Acknowledged>| accept(file, &roots, &tower(), known);
        let second = keys.file(1, 2);
        let (_, known) = taken(&second, None).unwrap();
        assert_eq!(taken(&second, Some(&known)).unwrap().1, known, "the same again changes nothing");
        assert!(matches!(taken(&keys.file(1, 1), Some(&known)), Err(Refusal::Older { found: 1, known: 2 })));
        assert_eq!(taken(&keys.file(1, 9), Some(&known)).unwrap().1.epoch, 9);
    }

    #[test]
    fn two_indices_of_one_epoch_are_told_apart() {
        let keys = TestKeys::new();
        let roots = [keys.root.public()];
        let list = keys.list(1, &[keys.signing.public()]);
        let file = |at_s| signed_index(&list, &index(4, IndexClock::ByServer, &[at_s]), &keys.signing).unwrap();
        let (_, known) = accept(&file(5), &roots, &tower(), None).unwrap();
        assert!(matches!(accept(&file(6), &roots, &tower(), Some(&known)), Err(Refusal::Fork { epoch: 4 })));
    }

    #[test]
    fn a_key_that_was_revoked_signs_nothing_any_more() {
        let keys = TestKeys::new();
        let (next, _) = SigningKey::generate().unwrap();
        let roots = [keys.root.public()];
        let [old, both, new] = [
            keys.list(1, &[keys.signing.public()]),
            keys.list(2, &[keys.signing.public(), next.public()]),
            keys.list(3, &[next.public()]),
        ];
        let file = |list: &str, epoch, key: &SigningKey| {
            signed_index(list, &index(epoch, IndexClock::ByServer, &[5]), key).unwrap()
        };
        let taken =
            |file: &[u8], known: Option<&Acknowledged>| accept(file, &roots, &tower(), known).map(|(_, now)| now);
        let first = taken(&file(&old, 1, &keys.signing), None).unwrap();
        let rotating = taken(&file(&both, 2, &next), Some(&first)).unwrap();
        let revoked = taken(&file(&new, 3, &next), Some(&rotating)).unwrap();
        // Whoever has the old key, and the old list, makes an index that is newer than all.
        let stolen = file(&old, 100, &keys.signing);
        assert!(matches!(taken(&stolen, Some(&revoked)), Err(Refusal::OlderKeys { found: 1, known: 3 })));
        assert!(taken(&stolen, Some(&first)).is_ok(), "before the list came that revokes it, nobody can know");
        // With the new list the key is not in it.
        let forged = String::from_utf8(file(&new, 4, &next)).unwrap();
        let stolen = String::from_utf8(stolen).unwrap();
        let mixed: Vec<&str> = forged.lines().take(2).chain(stolen.lines().skip(2)).collect();
        let refused = taken(mixed.join("\n").as_bytes(), Some(&revoked)).unwrap_err();
        assert!(matches!(refused, Refusal::Signed(SignedIndexError::Signer { number: 3, .. })), "{refused:?}");
    }

    #[test]
    fn another_site_and_another_layout_are_refused() {
        let keys = TestKeys::new();
        let roots = [keys.root.public()];
        let other = accept(&keys.file(1, 1), &roots, &"bridge".parse().unwrap(), None);
        assert!(matches!(other, Err(Refusal::OtherSite { .. })));
        let mut newer = index(1, IndexClock::ByServer, &[5]);
        newer.layout_version += 1;
        let file = signed_index(&keys.list(1, &[keys.signing.public()]), &newer, &keys.signing).unwrap();
        assert!(matches!(accept(&file, &roots, &tower(), None), Err(Refusal::Layout { .. })));
    }
}
