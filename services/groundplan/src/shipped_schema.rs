//! Compares a shipped schema with that of the document it describes, for tests.

use schemars::Schema;
use std::path::Path;

/// Compares `config/schemas/<name>.schema.json` with a schema; UPDATE_GOLDEN=1 writes it.
pub(crate) fn assert_shipped_schema(name: &str, schema: &Schema) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../../config/schemas/{name}.schema.json"));
    let schema = serde_json::to_string_pretty(schema).expect("a schema is JSON") + "\n";
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(&path, &schema).expect("the schema is written");
    }
    let shipped = std::fs::read_to_string(path).expect("the schema is shipped");
    assert!(shipped == schema, "{name}: UPDATE_GOLDEN=1 writes it");
}
