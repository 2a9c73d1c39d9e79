//! `config/schemas` equals the schema of the check; UPDATE_GOLDEN=1 rewrites it.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "../../export/tests/support/schema.rs"]
mod schema;

#[test]
fn the_schema_is_current() {
    schema::check::<model_check::ModelCheck>("model-check");
}
