//! `config/schemas/as-built.schema.json` is the schema of the list of changes; UPDATE_GOLDEN=1 rewrites it.

#[test]
fn the_schema_is_current() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../config/schemas/as-built.schema.json");
    let schema = serde_json::to_string_pretty(&schemars::schema_for!(as_built::ChangeList)).unwrap() + "\n";
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(path, &schema).unwrap();
    }
    assert_eq!(std::fs::read_to_string(path).unwrap(), schema, "UPDATE_GOLDEN=1 writes it");
}
