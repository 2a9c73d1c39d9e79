//! A site for many machines: what its server signs, what a robot accepts, and which bytes it has to fetch.
//!
//! There is no store, no network, no file and no clock inside: hashes go in, what to fetch comes out.
//!
//! # What a store holds
//!
//! | object | content |
//! |---|---|
//! | `SITE/current.jsonl` | the newest index with its signatures ([`SignedIndex`]); it alone is ever replaced |
//! | `SITE/index/EPOCH.jsonl` | the same for each epoch, created once: two servers cannot both publish an epoch |
//! | `SITE/needed/EPOCH.json` | which blobs that index needs, for the server |
//! | `SITE/blobs/XX/SHA256` | recipes, packs, exported files and lists of them, by the sha256 of their bytes; `XX` begins it |
//!
//! An archive is a recipe ([`Recipe`]): its blocks in their order, each with its sha256, its length, and where it lies in which pack. A
//! pack has those blocks, compressed, that were new when the archive was published, so that a date of which little changes is a small
//! pack; a robot fetches the blocks that it does not have, by ranges. Archives are cut where their content says so, so that what is
//! inserted into a model moves what follows without changing its blocks.
//!
//! An exported file is a blob as it is, so that whoever can fetch by HTTP can have it. A list of them ([`FileList`]) is a blob too, which
//! the index names for each robot and plan time: files are many, and robots that need none do not fetch their names with each index.
//!
//! # Guarantees
//!
//! - An index is accepted only if a signing key made its signature that is in a list of keys, and a root key of the robot made that of
//!   the list. Nothing of an index is looked at before.
//! - What was acknowledged never goes back: neither the number of the list of keys nor the epoch. An epoch that comes again with another
//!   content is refused, not taken.
//! - Bytes count only with their sha256: each block, and each archive as a whole. Sizes are bounded before anything is unpacked.
//! - Signatures are Ed25519 over the bytes of a line behind a word that says what is signed, so that a signature of one kind is none of
//!   another.

mod acceptance;
mod blocks;
mod file_list;
mod index;
mod keys;
mod objects;
mod recipe;
mod retention;
mod signed_index;

pub use acceptance::{Acknowledged, Refusal, accept};
pub use blocks::{BadBlock, unpack_block};
pub use file_list::{BadFileList, FileEntry, FileList, MAX_FILE_BYTES, MAX_FILE_LIST_BYTES};
pub use index::{ArchiveEntry, BlobEntry, IndexClock, PlanSet, RobotFiles, RobotMaps, SetChoice, SiteIndex, StoreyMap};
pub use keys::{KeyError, KeyList, PublicKey, SigningKey};
pub use objects::{
    SiteName, SiteNameError, blob_folder, blob_list_path, blob_path, current_path, index_folder, index_path,
};
pub use recipe::{BadRecipe, Fetch, MAX_RECIPE_BYTES, PackedArchive, Recipe, pack};
pub use retention::{KeptIndex, Retention, expired};
pub use signed_index::{MAX_INDEX_BYTES, SignedIndex, SignedIndexError, signed_index};
