//! The JSON Schema of the fleet's maps in `config/schemas` is that of what we write; UPDATE_GOLDEN=1 rewrites it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../export/tests/support/schema.rs"]
mod schema;

use schema::check;

#[test]
fn the_schema_of_the_maps_in_a_store_is_current() {
    check::<fleet::vda5050::StoreMapsDocument>("fleet-store-maps");
}

#[test]
fn the_schema_of_the_maps_is_current() {
    check::<fleet::vda5050::MapsDocument>("fleet-maps");
}
