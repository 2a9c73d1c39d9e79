//! Malicious archives with valid hashes: rejected with an error or read without a panic.

mod support;

use messages::{ArchiveBuffer, ArchiveError, MapStoreyRecord, PartRecord, Site, SiteBuilder};
use proptest::prelude::*;
use support::{alignment, deviations, grid, grids, phase, plan, reseal, site, slam_map, walk};

/// Miri takes a thousand times as long.
const CASES: u32 = if cfg!(miri) { 6 } else { 20_000 };

fn archive() -> impl Strategy<Value = ArchiveBuffer> {
    prop::sample::select(vec![site(), phase(), grid(), grids(), plan(), slam_map(), alignment(), deviations()])
}

/// What tends to hurt.
fn word() -> impl Strategy<Value = u32> {
    prop_oneof![
        any::<u32>(),
        0u32..40,
        prop::sample::select(vec![u32::MAX, u32::MAX - 1, i32::MAX as u32, i32::MIN as u32, 1 << 24, 0x7ff0_0000])
    ]
}

#[test]
fn whole_archives_are_read_to_the_end() {
    for archive in [site(), phase(), grid(), grids(), plan(), slam_map(), alignment(), deviations()] {
        assert!(walk(archive.bytes()) > 4);
        let mut again = archive.clone();
        reseal(again.bytes_mut());
        assert_eq!(again.bytes(), archive.bytes());
    }
}

#[test]
fn a_task_that_is_nested_in_itself_is_refused() {
    let whole = site();
    let parents = {
        let view = Site::open(whole.bytes()).unwrap();
        let start = whole.bytes().as_ptr() as usize;
        view.tasks.iter().map(|t| &raw const t.parent as usize - start).collect::<Vec<_>>()
    };
    for (task, parent) in [(0, 2u32), (1, 1), (0, 0)] {
        let mut buffer = whole.clone();
        buffer.bytes_mut()[parents[task]..][..4].copy_from_slice(&parent.to_le_bytes());
        reseal(buffer.bytes_mut());
        assert_eq!(Site::open(buffer.bytes()).unwrap_err(), ArchiveError::Index { what: "the schedule" });
    }
}

#[test]
fn a_map_storey_whose_bounds_are_turned_over_is_refused_because_grids_are_laid_around_them() {
    let opened = |bounds_tenths: [i32; 4]| {
        let mut builder = SiteBuilder::default();
        let (global_id, name) = (builder.texts.add("storey"), builder.texts.add("Storey"));
        builder.map_storeys.push(MapStoreyRecord { global_id, name, floor_z_tenths: 0, floor: 1, bounds_tenths });
        Site::open(builder.finish().bytes()).map(|_| ())
    };
    assert_eq!(opened([0, 0, 10, 10]), Ok(()));
    for turned in [[11, 0, 10, 10], [0, 11, 10, 10]] {
        assert_eq!(opened(turned), Err(ArchiveError::Index { what: "a coordinate" }));
    }
}

#[test]
fn parts_that_share_triangles_are_refused_because_walking_them_would_be_quadratic() {
    let part = PartRecord { first_vertex: 0, n_vertices: 3, first_triangle: 0, n_triangles: 1, closed: 0, colour: 0 };
    let opened = |n_parts: usize| {
        let mut builder = SiteBuilder::default();
        builder.vertices.extend([[0; 3]; 6]);
        builder.triangles.push([0, 1, 2]);
        builder.parts.extend(vec![part; n_parts]);
        Site::open(builder.finish().bytes()).map(|_| ())
    };
    assert_eq!(opened(1), Ok(()));
    assert_eq!(opened(2), Err(ArchiveError::Index { what: "a triangle" }));
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(CASES) })]

    #[test]
    fn changed_words_are_refused_or_harmless(
        archive in archive(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), word()), 1..6),
    ) {
        let mut buffer = archive;
        let n_words = buffer.bytes().len() / 4;
        for (at, word) in changes {
            let at = at.index(n_words) * 4;
            buffer.bytes_mut()[at..at + 4].copy_from_slice(&word.to_le_bytes());
        }
        walk(buffer.bytes());
        reseal(buffer.bytes_mut());
        walk(buffer.bytes());
    }

    #[test]
    fn cut_off_archives_are_refused_or_harmless(archive in archive(), length in any::<prop::sample::Index>()) {
        let cut = &archive.bytes()[..length.index(archive.bytes().len())];
        let mut buffer = ArchiveBuffer::zeroed(cut.len());
        buffer.bytes_mut().copy_from_slice(cut);
        walk(buffer.bytes());
        reseal(buffer.bytes_mut());
        walk(buffer.bytes());
    }

    #[test]
    fn any_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        let mut buffer = ArchiveBuffer::zeroed(bytes.len());
        buffer.bytes_mut().copy_from_slice(&bytes);
        prop_assert_eq!(walk(buffer.bytes()), 0);
    }
}
