//! Compares JSON Schemas with the files in `config/schemas`; UPDATE_GOLDEN=1 rewrites them.

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use std::path::Path;

/// Checks the schema of a document against its file.
pub(crate) fn check<T: JsonSchema>(name: &str) {
    // What is written: keys that are left out when empty are not required.
    let schema = SchemaSettings::draft2020_12().for_serialize().into_generator().into_root_schema_for::<T>();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../config/schemas").join(format!("{name}.schema.json"));
    let text = serde_json::to_string_pretty(&schema).unwrap() + "\n";
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, &text).unwrap();
    }
    let golden = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(text == golden, "{} is not current: UPDATE_GOLDEN=1 rewrites it", path.display());
}
