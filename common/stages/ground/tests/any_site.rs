//! Sites of any vertices and triangles that an archive may hold: a ground is made of each, and it opens.

#[path = "support/small_site.rs"]
mod small_site;

use messages::*;
use proptest::prelude::*;
use small_site::{Body, ground_of, site};

/// Near each other, so that they touch and fold, or as far apart as an archive allows.
fn coordinate() -> impl Strategy<Value = i32> {
    prop_oneof![6 => -40i32..40, 2 => -30_000i32..30_000, 1 => prop::sample::select(vec![-1_000_000_000, 1_000_000_000])]
}

fn body() -> impl Strategy<Value = (GroundClass, Body)> {
    let class = prop::sample::select(GroundClass::ALL.to_vec());
    let vertices = prop::collection::vec(prop::array::uniform3(coordinate()), 3..9);
    (class, vertices).prop_flat_map(|(class, vertices)| {
        let n = vertices.len() as u32;
        let triangles = prop::collection::vec(prop::array::uniform3(0..n), 0..14);
        triangles.prop_map(move |triangles| (class, (vertices.clone(), triangles)))
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]
    #[test]
    fn every_site_has_a_ground_that_opens(bodies in prop::collection::vec(body(), 0..5), is_site in any::<bool>()) {
        let archive = site(&bodies, is_site);
        let ground = ground_of(&archive, |_| true);
        let ground = Ground::open(ground.bytes()).unwrap();
        prop_assert!(ground.check_site(&Site::open(archive.bytes()).unwrap()).is_ok());
    }
}
