//! The tree is the architecture: dependencies point one way, folders are where a newcomer looks for them.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the tests are a folder of the workspace").to_owned()
}

/// Crates of the workspace that each crate may depend on.
const ALLOWED: [(&str, &[&str]); 23] = [
    ("frames", &[]),
    ("geometry", &["frames"]),
    ("convex", &["frames", "geometry"]),
    ("ifc", &["frames", "geometry"]),
    ("grid", &["frames", "geometry"]),
    ("messages", &["frames", "geometry", "grid"]),
    ("bus", &["messages"]),
    ("daemon", &["messages", "bus"]),
    ("export", &["frames", "geometry", "grid", "messages"]),
    ("world", &["convex", "export", "frames", "geometry", "grid", "messages"]),
    ("occupancy", &["grid", "messages"]),
    ("ingest", &["frames", "geometry", "grid", "messages", "ifc"]),
    ("schedule", &["frames", "messages"]),
    ("raster", &["frames", "geometry", "grid", "messages"]),
    ("waypoints", &["frames", "geometry", "grid", "messages"]),
    ("alignment", &["frames", "grid", "messages", "occupancy", "raster"]),
    ("deviations", &["frames", "geometry", "grid", "messages", "occupancy"]),
    ("ifc-ingest", &["bus", "daemon", "ingest", "messages"]),
    ("schedule-eval", &["bus", "daemon", "frames", "messages", "schedule"]),
    ("rasterize", &["bus", "daemon", "grid", "messages", "raster"]),
    ("waypoint-gen", &["bus", "daemon", "messages", "waypoints"]),
    ("slam-align", &["alignment", "bus", "daemon", "deviations", "messages", "occupancy"]),
    (
        "groundplan",
        &[
            "alignment",
            "bus",
            "daemon",
            "deviations",
            "export",
            "frames",
            "geometry",
            "grid",
            "ingest",
            "messages",
            "occupancy",
            "raster",
            "schedule",
            "waypoints",
            "world",
        ],
    ),
];

/// Foreign crates, and the crates that alone may name each.
const FENCED: [(&str, &[&str]); 9] = [
    ("ifc-lite-core", &["ifc"]),
    ("ifc-lite-geometry", &["ifc"]),
    ("ifc-lite-processing", &["ifc"]),
    ("i_overlay", &["geometry"]),
    ("i_triangle", &["convex"]),
    ("parry3d-f64", &["convex", "geometry"]),
    ("image", &["alignment", "occupancy"]),
    ("rustfft", &["alignment"]),
    ("iceoryx2", &["bus"]),
];

fn manifests() -> BTreeMap<String, toml::Table> {
    let mut found = BTreeMap::new();
    for folder in ["common", "common/stages", "services"] {
        let entries = std::fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
        for path in entries.filter(|path| !path.ends_with("common/stages")) {
            let text = std::fs::read_to_string(path.join("Cargo.toml")).unwrap();
            found.insert(path.file_name().unwrap().to_string_lossy().into_owned(), text.parse().unwrap());
        }
    }
    found
}

fn dependencies(manifest: &toml::Table) -> Vec<&String> {
    manifest.get("dependencies").and_then(|d| d.as_table()).map(|d| d.keys().collect()).unwrap_or_default()
}

#[test]
fn dependencies_point_one_way() {
    let manifests = manifests();
    let allowed = BTreeMap::from(ALLOWED);
    for (name, manifest) in &manifests {
        let Some(may) = allowed.get(name.as_str()) else { panic!("{name} is not in the table of this test") };
        for dependency in dependencies(manifest).into_iter().filter(|d| manifests.contains_key(*d)) {
            assert!(may.contains(&dependency.as_str()), "{name} must not depend on {dependency}");
        }
    }
}

#[test]
fn foreign_kernels_are_fenced() {
    for (name, manifest) in &manifests() {
        for (foreign, owners) in FENCED {
            let names_it = dependencies(manifest).iter().any(|d| *d == foreign);
            let may = owners.contains(&name.as_str());
            assert!(!names_it || may, "{name} must not name {foreign}: that is for {}", owners.join(" and "));
        }
    }
}

#[test]
fn packages_are_named_as_their_folders_and_services_fit_into_a_process_name() {
    for (folder, manifest) in &manifests() {
        let package = manifest["package"].as_table().unwrap();
        assert_eq!(package["name"].as_str(), Some(folder.as_str()));
        assert_eq!(manifest["lints"]["workspace"].as_bool(), Some(true), "{folder} takes the workspace's lints");
    }
    for entry in std::fs::read_dir(root().join("services")).unwrap() {
        assert!(entry.unwrap().file_name().len() <= 15, "ps shows 15 bytes of a process name");
    }
}

#[test]
fn the_top_level_holds_what_the_architecture_names() {
    let folders = ["services", "common", "tests", "config", "scripts", "target"];
    let files = [
        "Cargo.toml",
        "Cargo.lock",
        "README.md",
        "ARCHITECTURE.md",
        "BENCHMARKS.md",
        "CHANGELOG.md",
        "CONTRIBUTING.md",
        "GLOSSARY.md",
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "deny.toml",
        "clippy.toml",
        "rustfmt.toml",
    ];
    for entry in std::fs::read_dir(root()).unwrap() {
        let name = entry.unwrap().file_name().to_string_lossy().into_owned();
        assert!(name.starts_with('.') || folders.contains(&name.as_str()) || files.contains(&name.as_str()), "{name}");
    }
}

/// Paths that a document names: links, and words in backticks that begin with a folder of the top level.
fn named_paths(text: &str) -> Vec<&str> {
    let links = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let links = links.filter(|link| !link.contains(':') && !link.starts_with('#'));
    let words =
        text.lines().flat_map(|line| line.split('`').skip(1).step_by(2)).filter_map(|word| word.split(' ').next());
    let is_path = |word: &&str| {
        let begins = ["common/", "services/", "scripts/", "config/", "tests/tests/", "tests/benches/", "tests/fuzz/"];
        begins.iter().any(|folder| word.starts_with(folder)) && !word.contains(['*', '<']) && !word.contains("NAME")
    };
    links.chain(words.filter(is_path)).collect()
}

#[test]
fn documents_name_files_that_exist() {
    for document in ["README.md", "ARCHITECTURE.md", "BENCHMARKS.md", "CHANGELOG.md", "CONTRIBUTING.md", "GLOSSARY.md"]
    {
        let text = std::fs::read_to_string(root().join(document)).unwrap();
        for path in named_paths(&text) {
            assert!(root().join(path).exists(), "{document} names {path}");
        }
    }
}
