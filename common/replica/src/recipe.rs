//! Recipes: of which blocks an archive consists, in which packs they lie, and which of them are to be fetched.

use crate::blocks::{block_lengths, cut, pack_block};
use crate::index::{ArchiveEntry, BlobEntry, Form};
use messages::{ContentHash, ContentId};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, HashMap};
use std::ops::Range;

/// Packs that an archive may be spread over, beside those that its length asks for. With one more it is packed anew: who comes late
/// fetches few objects.
const MAX_PACKS: usize = 16;

/// From this length on a pack ends and another one begins, so that each is written, and fetched where ranges are ignored, in minutes.
const PACK_BYTES: u64 = 32 << 20;

/// An archive that uses less than this share of its packs is packed anew, so that packs of long ago can go.
const MIN_SHARE_USED: u64 = 4;

/// Parts of a pack that lie closer together are fetched at once, with what is between them.
const MAX_GAP: u64 = 16 << 10;

/// Most bytes of one fetch, so that one that breaks off loses little.
const MAX_FETCH_BYTES: u64 = 8 << 20;

/// Largest archive that is followed: the largest sample of a bus, on which a robot publishes it.
const MAX_ARCHIVE_BYTES: u64 = 8 << 30;

/// Longest file of a recipe: an archive of the largest size has some 32,000 blocks, and at most four times as many.
pub const MAX_RECIPE_BYTES: u64 = 16 << 20;

/// The form of recipes that this version reads and writes.
const FORMAT: u32 = 1;

/// How an archive is put together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recipe {
    /// sha256 of the archive.
    pub id: ContentId,
    /// Length of the archive.
    pub bytes: u64,
    /// Packs.
    packs: Vec<BlobEntry>,
    /// Blocks in their order.
    blocks: Vec<Block>,
}

/// A block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Block {
    /// sha256 of what it holds.
    id: ContentId,
    /// Where it begins in the archive.
    begin: u64,
    /// How many bytes it has there.
    bytes: u64,
    place: BlockPlace,
}

/// Where a block lies, compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct BlockPlace {
    /// Place of the pack in the recipe.
    pack: u32,
    /// Where it begins there.
    offset: u64,
    /// How many bytes it has there.
    bytes: u64,
}

/// A recipe as text.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Document {
    /// Version of this form: [`FORMAT`].
    format: u32,
    id: ContentId,
    bytes: u64,
    packs: Vec<BlobEntry>,
    blocks: Vec<DocumentBlock>,
}

/// A block as text.
#[derive(Debug, Clone, Copy, Serialize, Deserialize)]
struct DocumentBlock(
    /// sha256 of what it holds.
    ContentId,
    /// How many bytes it has in the archive.
    u64,
    /// Place of the pack in the recipe.
    u32,
    /// Where it begins there.
    u64,
    /// How many bytes it has there.
    u64,
);

/// A recipe with the packs that it needs, where blocks are new.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PackedArchive {
    /// The recipe.
    pub recipe: Recipe,
    /// The new packs.
    pub packs: Vec<Vec<u8>>,
}

/// A part of a pack, and the blocks that it has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fetch {
    /// The pack.
    pub pack: BlobEntry,
    /// Which of its bytes.
    pub range: Range<u64>,
    /// Places of the blocks in the archive.
    pub blocks: Vec<usize>,
}

/// A recipe that cannot be.
#[derive(Debug, thiserror::Error)]
pub enum BadRecipe {
    /// Not a recipe.
    #[error("the recipe of an archive cannot be read")]
    Json(#[from] serde_json::Error),
    /// Written by another version.
    #[error(
        "the recipe of an archive has the form {found}, this version reads {FORMAT}: the server of the site and its robots need the \
         same version of groundplan"
    )]
    Form {
        /// Its form.
        found: u32,
    },
    /// Numbers that do not fit.
    #[error("the recipe of an archive is wrong: {0}")]
    Numbers(&'static str),
}

/// Packs an archive: blocks that the earlier recipe of its topic has are named there, all others are in new packs.
pub fn pack(archive: &[u8], earlier: Option<&Recipe>) -> PackedArchive {
    let cuts: Vec<(ContentId, Range<usize>)> =
        cut(archive).map(|range| (ContentId::of(&archive[range.clone()]), range)).collect();
    let known = earlier.map(Recipe::places).unwrap_or_default();
    let known = if is_worth_keeping(archive.len() as u64, &cuts, &known) { known } else { HashMap::new() };

    let mut packs: Vec<BlobEntry> = Vec::new();
    let mut place_of_pack: BTreeMap<ContentId, u32> = BTreeMap::new();
    let mut new_packs: Vec<Vec<u8>> = Vec::new();
    let mut new_blocks: HashMap<ContentId, BlockPlace> = HashMap::new();
    let mut places = Vec::new();
    for (id, range) in &cuts {
        if let Some((pack, known)) = known.get(id) {
            let place = *place_of_pack.entry(pack.id).or_insert_with(|| {
                packs.push(*pack);
                (packs.len() - 1) as u32
            });
            places.push(Place::Known(BlockPlace { pack: place, ..*known }));
            continue;
        }
        let place = *new_blocks.entry(*id).or_insert_with(|| {
            if new_packs.last().is_none_or(|pack| pack.len() as u64 >= PACK_BYTES) {
                new_packs.push(Vec::new());
            }
            let place = (new_packs.len() - 1) as u32;
            let packed = pack_block(&archive[range.clone()]);
            let pack = &mut new_packs[place as usize];
            let offset = pack.len() as u64;
            pack.extend_from_slice(&packed);
            BlockPlace { pack: place, offset, bytes: packed.len() as u64 }
        });
        places.push(Place::New(place));
    }
    // New packs come after the known ones; they have names once they are whole.
    let n_known = packs.len() as u32;
    packs.extend(new_packs.iter().map(|pack| BlobEntry { id: ContentId::of(pack), bytes: pack.len() as u64 }));
    let block = |((id, range), place): ((ContentId, Range<usize>), Place)| {
        let place = match place {
            Place::Known(place) => place,
            Place::New(place) => BlockPlace { pack: n_known + place.pack, ..place },
        };
        Block { id, begin: range.start as u64, bytes: range.len() as u64, place }
    };
    let blocks = cuts.into_iter().zip(places).map(block).collect();
    let recipe = Recipe { id: ContentId::of(archive), bytes: archive.len() as u64, packs, blocks };
    PackedArchive { recipe, packs: new_packs }
}

/// Where a block lies while an archive is packed.
enum Place {
    /// In a pack of before.
    Known(BlockPlace),
    /// In a new one.
    New(BlockPlace),
}

/// Most packs of an archive of this length.
fn max_packs(archive_bytes: u64) -> usize {
    MAX_PACKS + usize::try_from(archive_bytes / PACK_BYTES).unwrap_or(usize::MAX / 2)
}

/// Where each block lies, in which pack.
type KnownBlocks = HashMap<ContentId, (BlobEntry, BlockPlace)>;

/// True if the packs of the known blocks are few, and used enough.
fn is_worth_keeping(archive_bytes: u64, cuts: &[(ContentId, Range<usize>)], known: &KnownBlocks) -> bool {
    let mut used: BTreeMap<ContentId, (u64, u64)> = BTreeMap::new();
    for (pack, place) in cuts.iter().filter_map(|(id, _)| known.get(id)) {
        used.entry(pack.id).or_insert((0, pack.bytes)).0 += place.bytes;
    }
    let (bytes_used, bytes) = used.values().fold((0, 0), |(u, b), (used, bytes)| (u + used, b + bytes));
    used.len() < max_packs(archive_bytes) && bytes_used * MIN_SHARE_USED >= bytes
}

impl Recipe {
    /// Its bytes as a blob.
    pub fn to_bytes(&self) -> Vec<u8> {
        let block =
            |Block { id, bytes, place, .. }: &Block| DocumentBlock(*id, *bytes, place.pack, place.offset, place.bytes);
        let document = Document {
            format: FORMAT,
            id: self.id,
            bytes: self.bytes,
            packs: self.packs.clone(),
            blocks: self.blocks.iter().map(block).collect(),
        };
        serde_json::to_vec(&document).expect("a recipe has no keys but texts")
    }

    /// The entry of its archive in an index, with the content hash that the archive has in itself.
    pub fn entry(&self, content_hash: ContentHash) -> ArchiveEntry {
        let bytes = self.to_bytes();
        let recipe = BlobEntry { id: ContentId::of(&bytes), bytes: bytes.len() as u64 };
        ArchiveEntry { id: self.id, content_hash, bytes: self.bytes, recipe }
    }

    /// The recipe that an index names; that the bytes are those that it names was looked at before.
    ///
    /// # Errors
    /// Bytes that are no recipe of this archive.
    pub fn parse(bytes: &[u8], of: &ArchiveEntry) -> Result<Self, BadRecipe> {
        let recipe = Self::parse_any(bytes)?;
        match (recipe.id, recipe.bytes) == (of.id, of.bytes) {
            true => Ok(recipe),
            false => Err(BadRecipe::Numbers("it is of another archive")),
        }
    }

    /// The recipe of any archive.
    ///
    /// # Errors
    /// Bytes that are no recipe.
    pub fn parse_any(bytes: &[u8]) -> Result<Self, BadRecipe> {
        let Form { format: found } = serde_json::from_slice(bytes)?;
        if found != FORMAT {
            return Err(BadRecipe::Form { found });
        }
        let Document { format: _, id, bytes, packs, blocks } = serde_json::from_slice(bytes)?;
        let mut begin = 0u64;
        let block = |DocumentBlock(id, bytes, pack, offset, packed): DocumentBlock| {
            let block = Block { id, begin, bytes, place: BlockPlace { pack, offset, bytes: packed } };
            begin = begin.saturating_add(bytes);
            block
        };
        let recipe = Self { id, bytes, packs, blocks: blocks.into_iter().map(block).collect() };
        recipe.check().map_err(BadRecipe::Numbers)?;
        Ok(recipe)
    }

    fn check(&self) -> Result<(), &'static str> {
        if self.bytes > MAX_ARCHIVE_BYTES {
            return Err("its archive is larger than any can be");
        }
        let end = self.blocks.last().map_or(0, |last| last.begin.saturating_add(last.bytes));
        if end != self.bytes {
            return Err("its blocks are not as long as the archive");
        }
        // One more with new blocks, for each that they need.
        if self.packs.len() > 2 * max_packs(self.bytes) + 1 {
            return Err("it has too many packs");
        }
        let lengths = block_lengths(self.bytes);
        for (k, Block { bytes, place, .. }) in self.blocks.iter().enumerate() {
            let is_last = k + 1 == self.blocks.len();
            let is_long_enough = *bytes >= *lengths.start() || is_last && *bytes > 0;
            if !is_long_enough || bytes > lengths.end() {
                return Err("a block is shorter or longer than any can be");
            }
            let pack = self.packs.get(place.pack as usize).ok_or("a block is in no pack")?;
            // What zstd cannot make smaller gets a little larger.
            let is_inside = place.offset.checked_add(place.bytes).is_some_and(|end| end <= pack.bytes);
            if !is_inside || place.bytes > bytes + (bytes >> 7) + 512 {
                return Err("a block lies outside of its pack");
            }
        }
        Ok(())
    }

    /// Number of blocks.
    pub fn n_blocks(&self) -> usize {
        self.blocks.len()
    }

    /// sha256 of a block, and where it lies in the archive.
    ///
    /// # Panics
    /// There are fewer blocks.
    pub fn block(&self, place: usize) -> (ContentId, Range<u64>) {
        let Block { id, begin, bytes, .. } = self.blocks[place];
        (id, begin..begin + bytes)
    }

    /// What is to be fetched for the blocks that are not there, in the order of the packs.
    pub fn missing(&self, is_there: impl Fn(usize) -> bool) -> Vec<Fetch> {
        let mut places: Vec<usize> = (0..self.blocks.len()).filter(|place| !is_there(*place)).collect();
        places.sort_by_key(|place| (self.blocks[*place].place.pack, self.blocks[*place].place.offset));
        let mut fetches: Vec<Fetch> = Vec::new();
        for place in places {
            let BlockPlace { pack, offset, bytes } = self.blocks[place].place;
            let (pack, end) = (self.packs[pack as usize], offset + bytes);
            match fetches.last_mut() {
                Some(last)
                    if last.pack == pack
                        && offset <= last.range.end + MAX_GAP
                        && end.max(last.range.end) - last.range.start <= MAX_FETCH_BYTES =>
                {
                    last.range.end = last.range.end.max(end);
                    last.blocks.push(place);
                }
                _ => fetches.push(Fetch { pack, range: offset..end, blocks: vec![place] }),
            }
        }
        fetches
    }

    /// The bytes of a block among those that were fetched.
    ///
    /// # Panics
    /// The fetch is not of this recipe, or does not have the block.
    pub fn part<'a>(&self, fetch: &Fetch, fetched: &'a [u8], place: usize) -> &'a [u8] {
        let BlockPlace { offset, bytes, .. } = self.blocks[place].place;
        let begin = usize::try_from(offset - fetch.range.start).expect("a fetch is small");
        &fetched[begin..begin + usize::try_from(bytes).expect("a fetch is small")]
    }

    /// Blobs that it needs.
    pub fn packs(&self) -> &[BlobEntry] {
        &self.packs
    }

    /// Where each of its blocks lies.
    fn places(&self) -> KnownBlocks {
        let place = |block: &Block| (block.id, (self.packs[block.place.pack as usize], block.place));
        self.blocks.iter().map(place).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::blocks::tests::noise;
    use crate::blocks::unpack_block;
    use proptest::prelude::*;

    /// Longest block of a small archive, and a length of archives that have many.
    const MAX_BLOCK: u64 = 512 << 10;
    const BLOCK: usize = 256 << 10;

    /// A store of packs, and an archive put together from what is fetched of them and of what is held.
    fn fetched(
        recipe: &Recipe,
        store: &HashMap<ContentId, Vec<u8>>,
        held: &HashMap<ContentId, Vec<u8>>,
    ) -> (Vec<u8>, u64) {
        let mut archive = vec![0; recipe.bytes as usize];
        let (mut n_bytes, mut n_blocks) = (0, 0);
        for place in 0..recipe.n_blocks() {
            let (id, range) = recipe.block(place);
            if let Some(block) = held.get(&id) {
                archive[range.start as usize..range.end as usize].copy_from_slice(block);
                n_blocks += 1;
            }
        }
        for fetch in recipe.missing(|place| held.contains_key(&recipe.block(place).0)) {
            let pack = &store[&fetch.pack.id];
            let bytes = &pack[fetch.range.start as usize..fetch.range.end as usize];
            n_bytes += bytes.len() as u64;
            for place in &fetch.blocks {
                let (id, range) = recipe.block(*place);
                let block = unpack_block(recipe.part(&fetch, bytes, *place), range.end - range.start, id).unwrap();
                archive[range.start as usize..range.end as usize].copy_from_slice(&block);
                n_blocks += 1;
            }
        }
        assert_eq!(n_blocks, recipe.n_blocks());
        (archive, n_bytes)
    }

    /// The number and bytes of the blocks that who has an archive fetches of the next.
    fn new_blocks(before: &Recipe, archive: &[u8]) -> (usize, usize, Recipe) {
        let PackedArchive { recipe, packs } = pack(archive, Some(before));
        let had: BTreeMap<ContentId, ()> = before.blocks.iter().map(|block| (block.id, ())).collect();
        let n = recipe.missing(|place| had.contains_key(&recipe.block(place).0)).iter().map(|f| f.blocks.len()).sum();
        (n, packs.iter().map(Vec::len).sum(), recipe)
    }

    #[test]
    fn a_small_change_is_a_small_pack() {
        let mut archive = noise(1, 10 * BLOCK + 77);
        let first = pack(&archive, None);
        archive[3 * BLOCK + 5] ^= 1;
        let (n, bytes, second) = new_blocks(&first.recipe, &archive);
        assert!((1..=3).contains(&n) && bytes <= n * (MAX_BLOCK as usize + 8_192), "{n} blocks, {bytes} bytes");
        let third = pack(&archive, Some(&second));
        assert_eq!((third.packs, &third.recipe), (Vec::new(), &second), "the same again needs nothing");
    }

    #[test]
    fn what_is_inserted_or_left_out_changes_the_blocks_around_it_alone() {
        let archive = noise(6, 40 * BLOCK);
        let first = pack(&archive, None).recipe;
        assert!(first.n_blocks() > 30, "{}", first.n_blocks());
        for at in [0, 17, 11 * BLOCK + 3, 39 * BLOCK] {
            let inserted = [&archive[..at], b"a wall", &archive[at..]].concat();
            let (n, _, recipe) = new_blocks(&first, &inserted);
            assert!((1..=4).contains(&n), "{n} of {} blocks after an insertion at {at}", recipe.n_blocks());
            let left_out = [&archive[..at], &archive[at + 100..]].concat();
            let (n, _, recipe) = new_blocks(&first, &left_out);
            assert!((1..=4).contains(&n), "{n} of {} blocks after a removal at {at}", recipe.n_blocks());
        }
    }

    #[test]
    fn an_archive_of_many_dates_is_packed_anew_before_its_packs_are_many() {
        let mut archive = noise(2, 40 * BLOCK);
        let mut recipe = pack(&archive, None).recipe;
        let mut most = 0;
        for date in 0..60 {
            let at = (date * 7 % 40) * BLOCK;
            archive[at..at + 64].copy_from_slice(&noise(100 + date as u64, 64));
            recipe = pack(&archive, Some(&recipe)).recipe;
            recipe.check().unwrap();
            most = most.max(recipe.packs().len());
        }
        assert!((2..=MAX_PACKS).contains(&most), "{most}");
    }

    #[test]
    fn a_large_archive_has_packs_of_a_length_that_can_be_sent() {
        let archive = noise(5, 70 << 20);
        let PackedArchive { recipe, packs } = pack(&archive, None);
        assert_eq!(packs.len(), 3);
        assert!(packs.iter().all(|pack| (pack.len() as u64) < PACK_BYTES + 2 * MAX_BLOCK));
        recipe.check().unwrap();
        let store = packs.into_iter().map(|bytes| (ContentId::of(&bytes), bytes)).collect();
        assert!(fetched(&recipe, &store, &HashMap::new()).0 == archive);
    }

    #[test]
    fn a_recipe_with_wrong_numbers_is_refused() {
        let good = pack(&noise(3, 3 * BLOCK), None).recipe;
        let entry = good.entry(ContentHash::NONE);
        assert_eq!(Recipe::parse(&good.to_bytes(), &entry).unwrap(), good);
        let refused = |change: &dyn Fn(&mut Recipe)| {
            let mut wrong = good.clone();
            change(&mut wrong);
            Recipe::parse(&wrong.to_bytes(), &entry).unwrap_err().to_string()
        };
        let cases: [&dyn Fn(&mut Recipe); 13] = [
            &|r| r.bytes += 1,
            &|r| r.bytes = MAX_ARCHIVE_BYTES + 1,
            &|r| r.blocks[0].bytes = 1,
            &|r| r.blocks[0].bytes = MAX_BLOCK + 1,
            &|r| r.blocks[0].bytes = u64::MAX,
            &|r| {
                let moved = r.blocks[0].bytes - 1;
                r.blocks[0].bytes = 1;
                r.blocks[1].bytes += moved;
            },
            &|r| r.blocks.truncate(2),
            &|r| r.blocks.push(Block { bytes: 0, ..r.blocks[0] }),
            &|r| r.blocks[0].place.pack = 9,
            &|r| r.blocks[0].place.offset = u64::MAX,
            &|r| r.blocks[0].place.bytes = r.packs[0].bytes + 1,
            &|r| r.packs = vec![r.packs[0]; 60],
            &|r| r.id = ContentId::of(b"another"),
        ];
        for (k, change) in cases.iter().enumerate() {
            assert!(refused(*change).contains("is wrong"), "{k}");
        }
        let newer = String::from_utf8(good.to_bytes()).unwrap().replacen("\"format\":1", "\"format\":2", 1);
        assert!(matches!(Recipe::parse(newer.as_bytes(), &entry), Err(BadRecipe::Form { found: 2 })));
        for broken in ["[", "{}", "{\"format\":1}"] {
            assert!(matches!(Recipe::parse(broken.as_bytes(), &entry), Err(BadRecipe::Json(_))), "{broken}");
        }
    }

    #[test]
    fn an_empty_archive_has_no_pack() {
        let PackedArchive { recipe, packs } = pack(&[], None);
        assert_eq!((recipe.n_blocks(), packs.len()), (0, 0));
        assert!(recipe.missing(|_| false).is_empty());
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(24))]

        /// Dates follow each other; who has any of them, and some blocks of others, puts the newest together.
        #[test]
        fn whoever_fetches_what_is_missing_has_the_archive(
            changes in prop::collection::vec((0..5 * BLOCK, any::<u8>()), 1..6),
            lost in prop::collection::vec(any::<bool>(), 6),
        ) {
            let mut archive = noise(4, 5 * BLOCK + 9);
            let mut store = HashMap::new();
            let mut held = HashMap::new();
            let mut recipe = None;
            for (at, value) in changes {
                // In place, or what follows moves.
                match value % 3 {
                    0 => archive.insert(at, value),
                    1 => drop(archive.remove(at)),
                    _ => archive[at] = value,
                }
                let packed = pack(&archive, recipe.as_ref());
                for bytes in packed.packs {
                    store.insert(ContentId::of(&bytes), bytes);
                }
                let (whole, _) = fetched(&packed.recipe, &store, &held);
                prop_assert_eq!(&whole, &archive);
                held = (0..packed.recipe.n_blocks())
                    .filter(|place| !lost[*place % lost.len()])
                    .map(|place| {
                        let (id, range) = packed.recipe.block(place);
                        (id, archive[range.start as usize..range.end as usize].to_vec())
                    })
                    .collect();
                let (again, n_bytes) = fetched(&packed.recipe, &store, &held);
                prop_assert_eq!(&again, &archive);
                if lost.iter().all(|lost| !lost) {
                    prop_assert_eq!(n_bytes, 0);
                }
                recipe = Some(packed.recipe);
            }
        }
    }
}
