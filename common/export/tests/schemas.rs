//! `config/schemas` equals the schemas of the written documents; UPDATE_GOLDEN=1 rewrites them.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use std::path::Path;

fn check<T: JsonSchema>(name: &str) {
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

#[test]
fn schemas_are_current() {
    check::<export::Manifest>("manifest");
    check::<export::DatesManifest>("dates-manifest");
    check::<export::DeviationsDocument>("deviations");
    check::<export::Report>("report");
    check::<export::Semantic>("semantic");
    check::<export::SiteFrameFile>("site-frame");
    check::<export::SiteGraph>("site-graph");
    check::<export::Waypoints>("waypoints");
}
