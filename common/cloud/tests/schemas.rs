//! The JSON Schema of the cloud's index in `config/schemas` is that of what we write; UPDATE_GOLDEN=1 rewrites it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../export/tests/support/schema.rs"]
mod schema;

use schema::check;

#[test]
fn the_schema_of_the_structure_is_current() {
    check::<cloud::Structure>("cloud-structure");
}

#[test]
fn the_schema_of_the_octomap_is_current() {
    check::<cloud::Octomap>("octomap-structure");
}
