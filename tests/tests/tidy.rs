//! Enforces the crate layering and the folder layout.

#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "support/imports.rs"]
mod imports;
#[path = "support/limit_table.rs"]
mod limit_table;
#[path = "support/page_imports.rs"]
mod page_imports;

use imports::{circles, imports, modules, named_paths as paths_of_code, names};
use limit_table::{declared_value, limits_in_bytes, limits_of, product_source};
use page_imports::{page_imports, page_modules};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the tests are a folder of the workspace").to_owned()
}

/// Crates of the workspace that each crate may depend on.
const ALLOWED: [(&str, &[&str]); 53] = [
    ("diagnostics", &[]),
    ("input-files", &[]),
    ("frames", &[]),
    ("geometry", &["frames"]),
    ("convex", &["frames", "geometry"]),
    ("ifc", &["diagnostics", "frames", "geometry"]),
    ("ids", &["ifc"]),
    ("as-built", &["frames"]),
    ("schedule-files", &["diagnostics", "frames"]),
    ("grid", &["frames", "geometry"]),
    ("messages", &["diagnostics", "frames", "geometry", "grid"]),
    ("bcf", &[]),
    ("bus", &["messages"]),
    ("site-view", &["bus", "messages"]),
    ("daemon", &["bus", "diagnostics", "frames", "input-files", "messages", "site-view"]),
    ("replica", &["messages"]),
    ("store", &[]),
    ("fleet-link", &[]),
    ("safety", &["frames", "geometry", "grid", "messages"]),
    ("export", &["bcf", "diagnostics", "frames", "geometry", "grid", "input-files", "messages", "safety"]),
    ("world", &["convex", "diagnostics", "export", "frames", "geometry", "grid", "messages"]),
    ("cloud", &["export", "frames", "geometry", "grid", "messages"]),
    ("fleet", &["export", "frames", "geometry", "grid", "messages", "safety"]),
    ("open-rmf", &["export", "frames", "geometry", "grid", "messages"]),
    ("occupancy", &["grid", "input-files", "messages"]),
    ("ros", &["export", "frames", "geometry", "grid", "messages"]),
    ("ingest", &["frames", "geometry", "grid", "messages", "ifc"]),
    ("tasks", &["diagnostics", "frames", "messages", "schedule-files"]),
    ("schedule", &["diagnostics", "frames", "messages", "schedule-files", "tasks"]),
    ("ground", &["frames", "geometry", "messages"]),
    ("raster", &["diagnostics", "frames", "geometry", "grid", "ground", "messages"]),
    ("waypoints", &["diagnostics", "frames", "geometry", "grid", "messages", "safety"]),
    ("site-files", &["cloud", "export", "fleet", "ground", "messages", "open-rmf", "raster", "world"]),
    ("alignment", &["diagnostics", "frames", "geometry", "grid", "messages", "occupancy", "raster"]),
    ("deviations", &["frames", "geometry", "grid", "messages", "occupancy"]),
    ("answers", &["diagnostics", "export", "frames", "messages", "schedule", "waypoints"]),
    ("model-check", &["answers", "bcf", "diagnostics", "export", "frames", "geometry", "grid", "messages"]),
    ("site-schedule", &["daemon", "messages", "schedule"]),
    (
        "site-answers",
        &[
            "answers",
            "bus",
            "daemon",
            "frames",
            "geometry",
            "input-files",
            "messages",
            "raster",
            "schedule",
            "site-view",
            "waypoints",
        ],
    ),
    ("site-http", &["daemon", "input-files"]),
    (
        "ask",
        &[
            "answers",
            "bus",
            "daemon",
            "diagnostics",
            "frames",
            "messages",
            "schedule",
            "site-answers",
            "site-http",
            "site-schedule",
            "site-view",
            "waypoints",
        ],
    ),
    ("ifc-ingest", &["bus", "daemon", "export", "ingest", "messages"]),
    ("schedule-eval", &["bus", "daemon", "diagnostics", "frames", "messages", "schedule", "tasks"]),
    ("rasterize", &["bus", "daemon", "grid", "messages", "raster"]),
    ("waypoint-gen", &["bus", "daemon", "messages", "site-view", "waypoints"]),
    ("site-follow", &["bus", "daemon", "fleet-link", "frames", "messages", "replica", "store"]),
    (
        "site-server",
        &[
            "bus",
            "cloud",
            "daemon",
            "export",
            "fleet",
            "fleet-link",
            "frames",
            "messages",
            "raster",
            "replica",
            "schedule",
            "site-files",
            "site-schedule",
            "site-view",
            "store",
            "waypoints",
            "world",
        ],
    ),
    (
        "ros-bridge",
        &[
            "bus",
            "daemon",
            "diagnostics",
            "export",
            "frames",
            "grid",
            "messages",
            "ros",
            "safety",
            "site-view",
            "world",
        ],
    ),
    (
        "web",
        &[
            "answers",
            "bus",
            "daemon",
            "export",
            "frames",
            "grid",
            "input-files",
            "messages",
            "raster",
            "schedule",
            "site-answers",
            "site-http",
            "site-schedule",
            "site-view",
            "world",
        ],
    ),
    (
        "slam-align",
        &["alignment", "bus", "daemon", "deviations", "diagnostics", "frames", "messages", "occupancy", "site-view"],
    ),
    (
        "site-simulator",
        &[
            "bus",
            "daemon",
            "ifc-ingest",
            "messages",
            "rasterize",
            "schedule-eval",
            "site-follow",
            "site-server",
            "slam-align",
            "store",
            "waypoint-gen",
        ],
    ),
    ("slam-simulator", &["frames", "grid", "occupancy"]),
    (
        "groundplan",
        &[
            "alignment",
            "as-built",
            "answers",
            "bcf",
            "bus",
            "cloud",
            "daemon",
            "deviations",
            "diagnostics",
            "export",
            "fleet",
            "frames",
            "geometry",
            "grid",
            "ids",
            "ingest",
            "input-files",
            "messages",
            "model-check",
            "occupancy",
            "raster",
            "replica",
            "ros",
            "safety",
            "schedule",
            "site-answers",
            "site-files",
            "site-schedule",
            "site-view",
            "tasks",
            "waypoints",
            "world",
        ],
    ),
];

/// Foreign crates, and the crates that alone may name each.
const FENCED: [(&str, &[&str]); 31] = [
    ("ifc-lite-core", &["ifc"]),
    ("ifc-lite-geometry", &["ifc"]),
    ("ifc-lite-processing", &["ifc"]),
    ("i_overlay", &["geometry"]),
    ("i_triangle", &["convex", "geometry"]),
    ("nalgebra", &["alignment", "as-built", "deviations", "frames", "geometry", "ifc"]),
    ("parry3d-f64", &["convex", "geometry"]),
    ("image", &["alignment", "occupancy"]),
    ("rustfft", &["alignment"]),
    ("iceoryx2", &["bus"]),
    ("regex", &["ids"]),
    ("cdr-encoding", &["ros"]),
    ("mcap", &["groundplan"]),
    ("ros2-client", &["ros-bridge"]),
    ("foxglove", &["ros-bridge"]),
    ("tokio", &["ask", "ros-bridge", "site-http", "store", "web"]),
    ("rmcp", &["ask"]),
    ("object_store", &["store"]),
    ("reqwest", &["store"]),
    ("rustls", &["groundplan", "store"]),
    ("url", &["store"]),
    ("fastcdc", &["replica"]),
    ("ring", &["replica"]),
    ("ureq", &["groundplan"]),
    ("zenoh", &["fleet-link"]),
    ("zstd", &["replica"]),
    ("axum", &["ask", "site-http", "web"]),
    ("axum-server", &["site-http"]),
    ("hyper-util", &["site-http"]),
    ("tower-service", &["site-http"]),
    ("flate2", &["web"]),
];

/// Crates whose modules import each other in a circle, and why each of them may.
const CIRCLES: &[(&str, &str)] = &[];

/// Packages that a stage must not depend on: it knows neither bus nor command line, log or operating system.
const NOT_FOR_STAGES: [&str; 5] = ["bus", "daemon", "clap", "tracing", "rustix"];

/// Modules of the standard library that a stage must not name: it knows no files, processes and clocks.
const OUTSIDE: [&str; 4] = ["fs", "net", "env", "process"];

/// The folders of all crates but the tests; one folder is a Python package. The simulators lie among the tests, because no
/// product may depend on them.
fn crates() -> Vec<PathBuf> {
    let folders = ["common", "common/stages", "services"];
    let entries = folders.iter().flat_map(|folder| std::fs::read_dir(root().join(folder)).unwrap());
    let paths = entries.map(|entry| entry.unwrap().path());
    let paths = paths.filter(|path| !path.ends_with("common/stages") && !path.ends_with("common/python"));
    paths.chain(["site-simulator", "slam-simulator"].map(|name| root().join("tests").join(name))).collect()
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap().to_string_lossy().into_owned()
}

fn manifest(folder: &Path) -> toml::Table {
    std::fs::read_to_string(folder.join("Cargo.toml")).unwrap().parse().unwrap()
}

fn manifests() -> BTreeMap<String, toml::Table> {
    crates().iter().map(|path| (name_of(path), manifest(path))).collect()
}

/// Names in the tables of dependencies of a manifest, those of tests and build scripts included.
fn all_dependencies(manifest: &toml::Table) -> Vec<&String> {
    let tables = ["dependencies", "dev-dependencies", "build-dependencies"];
    tables.iter().filter_map(|name| manifest.get(*name)?.as_table()).flat_map(toml::Table::keys).collect()
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
fn no_permission_is_left_over() {
    let manifests = manifests();
    for (name, may) in ALLOWED {
        let used = dependencies(&manifests[name]);
        let left: Vec<&&str> = may.iter().filter(|other| !used.iter().any(|used| used == *other)).collect();
        assert!(left.is_empty(), "{name} does not depend on {left:?}: take them off the table");
    }
    for (foreign, owners) in FENCED {
        let names_it = |owner: &&&str| all_dependencies(&manifests[**owner]).iter().any(|used| *used == foreign);
        let left: Vec<&&str> = owners.iter().filter(|owner| !names_it(owner)).collect();
        assert!(left.is_empty(), "{left:?} do not name {foreign}: take them off the table");
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
fn no_package_but_the_simulator_of_a_site_depends_on_a_service() {
    let is_service = |name: &&String| root().join("services").join(name).exists();
    let folders = [root().join("tests"), root().join("tests/fuzz")];
    let crates = crates().into_iter().filter(|folder| !folder.ends_with("site-simulator"));
    for folder in crates.chain(folders) {
        let manifest = manifest(&folder);
        let service = all_dependencies(&manifest).into_iter().find(is_service);
        assert_eq!(service, None, "{} depends on a service", folder.display());
    }
}

#[test]
fn stages_and_answers_know_neither_bus_nor_files_nor_clocks() {
    let is_pure = |path: &PathBuf| path.parent().unwrap().ends_with("stages") || path.ends_with("answers");
    for folder in crates().into_iter().filter(is_pure) {
        let (name, manifest) = (name_of(&folder), manifest(&folder));
        for dependency in all_dependencies(&manifest) {
            assert!(!NOT_FOR_STAGES.contains(&dependency.as_str()), "{name} must not depend on {dependency}");
        }
        for (module, text) in modules(&folder.join("src")) {
            for path in paths_of_code(&text) {
                let words: Vec<&str> = path.iter().map(String::as_str).collect();
                let is_outside = matches!(words[..], ["std", module, ..] if OUTSIDE.contains(&module));
                let is_clock = words.iter().any(|word| ["Instant", "SystemTime"].contains(word));
                assert!(!is_outside && !is_clock, "{name}::{} names {}", module.join("::"), words.join("::"));
            }
        }
    }
}

#[test]
fn modules_import_one_way() {
    let justified = BTreeMap::from_iter(CIRCLES.iter().copied());
    for folder in crates().into_iter().chain([root().join("tests/fuzz")]) {
        let (name, circles) = (name_of(&folder), circles(&imports(&modules(&folder.join("src")))));
        match justified.get(name.as_str()) {
            Some(why) => assert!(!circles.is_empty(), "{name} has no circle any more, take it off the list ({why})"),
            None => assert!(circles.is_empty(), "modules of {name} import each other:\n{}", circles.join("\n")),
        }
    }
}

#[test]
fn modules_of_the_page_import_one_way() {
    let modules = page_modules(&root().join("services/web/page/src"));
    let imports = page_imports(&modules);
    // Who reads nothing finds no circle.
    let from_main = imports[&vec!["main.js".to_owned()]].keys().filter(|from| from[0] == "plan.js").count();
    assert_eq!((from_main, modules.contains_key("plan.js")), (1, true));
    let circles = circles(&imports);
    assert!(circles.is_empty(), "modules of the page import each other:\n{}", circles.join("\n"));
}

#[test]
fn a_circle_of_the_page_is_found_through_all_kinds_of_imports() {
    let circles_of = |texts: &[(&str, &str)]| {
        circles(&page_imports(&texts.iter().map(|(name, text)| (format!("{name}.js"), (*text).to_owned())).collect()))
    };
    let a = (
        "a",
        "import L from \"leaflet\";\nimport {\n  f as g,\n  h,\n} from \"./b.js\";\nexport const x = \"./a.js\";",
    );
    assert_eq!(
        circles_of(&[a, ("b", "export { x } from './c.js';"), ("c", "const later = () => import(\"./a.js\");")]),
        ["a.js names f, h of b.js", "b.js names x of c.js", "c.js names (module) of a.js",]
    );
    let comments = "// import { x } from \"./a.js\";\n/* as\n * import \"./a.js\" */\nexport const f = 1, h = 2;";
    assert_eq!(circles_of(&[a, ("b", comments)]), Vec::<String>::new());
}

/// The circles of a crate of these modules; `lib` is the crate itself.
fn circles_of(texts: &[(&str, &str)]) -> Vec<String> {
    let path = |name: &str| name.split("::").filter(|part| *part != "lib").map(str::to_owned).collect();
    circles(&imports(&texts.iter().map(|(name, text)| (path(name), (*text).to_owned())).collect()))
}

#[test]
fn a_circle_is_found_through_children_re_exports_and_imported_modules() {
    let lib = ("lib", "mod a; mod b; pub use b::Thing;");
    let b = ("b", "use crate::a;\npub struct Thing; fn f() { a::g() }");
    let found = circles_of(&[lib, ("a", "use crate::{other, Thing as T}; fn g() -> T { T }"), b]);
    assert_eq!(found, ["a names Thing of b", "b names (module), g of a"]);
    let found =
        circles_of(&[("lib", "mod a;"), ("a", "mod c; fn f() { c::g() } pub struct S;"), ("a::c", "use super::S;")]);
    assert_eq!(found, ["a names g of a::c", "a::c names S of a"]);
}

#[test]
fn tests_comments_texts_and_re_exports_of_children_are_no_imports() {
    let lib = ("lib", "mod a; mod b; pub use a::S; use b::f;");
    let tests = "#[cfg(test)]\nmod tests { use super::*; use crate::b::g; fn t() { [1; 2]; } }";
    let a = format!(
        "pub struct S; // crate::b::h\nconst T: [&str; 2] = [r#\"\" crate::b::k\"#, \"\\\" crate::b::l\"]; {tests}"
    );
    let b = "use crate::a::S; fn f(c: char) -> bool { c == '\"' || c == '\\'' } fn g<'a>(s: &'a S) -> impl Sized + use<'a> {}";
    assert_eq!(circles_of(&[lib, ("a", &a), ("b", b)]), Vec::<String>::new());
}

/// Words that no name has: the last paragraph of the glossary, without what it says in brackets.
fn unused_words() -> Vec<String> {
    let glossary = std::fs::read_to_string(root().join("GLOSSARY.md")).unwrap();
    let list = glossary.trim().rsplit("\n\n").next().unwrap();
    let without_brackets: String =
        list.split('(').map(|part| part.split_once(')').map_or(part, |(_, rest)| rest)).collect();
    let words: Vec<String> = without_brackets.split(',').map(|word| word.trim().to_owned()).collect();
    assert!(words.len() > 5 && words.iter().all(|word| word.chars().all(char::is_alphabetic)), "{words:?}");
    words
}

#[test]
fn names_use_the_words_of_the_glossary() {
    let unused = unused_words();
    for folder in crates().into_iter().chain([root().join("tests/fuzz")]) {
        for (module, text) in modules(&folder.join("src")) {
            for words in names(&text) {
                let place = || format!("{} in {}::{}", words.join("_"), name_of(&folder), module.join("::"));
                let is_construction_phase =
                    |at: usize| words[at].starts_with("phase") && at > 0 && words[at - 1] == "construction";
                let found = (0..words.len()).find(|at| unused.contains(&words[*at]) && !is_construction_phase(*at));
                assert_eq!(found.map(|at| &words[at]), None, "{}", place());
            }
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
    let folders = ["services", "common", "tests", "config", "scripts", "docs", "target"];
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

/// Lines of `ARCHITECTURE.md`: a person reads it as a whole. What concerns one crate is in the head of that crate.
const ARCHITECTURE_LINES_MAX: usize = 350;

#[test]
fn the_architecture_can_be_read_as_a_whole() {
    let n_lines = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap().lines().count();
    assert!(n_lines <= ARCHITECTURE_LINES_MAX, "ARCHITECTURE.md has {n_lines} lines, at most {ARCHITECTURE_LINES_MAX}");
}

#[test]
fn an_answer_to_where_something_is_decided_names_at_most_two_files() {
    let text = std::fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let table = text.split("## Where each thing is decided").nth(1).unwrap().split("\n## ").next().unwrap();
    let rows: Vec<&str> = table.lines().filter(|line| line.starts_with("| ")).skip(1).collect();
    assert!(rows.len() > 50, "{} rows", rows.len());
    for row in rows {
        let n_files = named_paths(row).len();
        assert!((1..=2).contains(&n_files), "{n_files} files: {row}");
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

/// Headings of a document, as links name them.
fn headings(document: &Path) -> Vec<String> {
    let text = std::fs::read_to_string(document).unwrap();
    let titles = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#').trim());
    let slug = |title: &str| {
        let letters =
            title.to_lowercase().chars().filter(|c| c.is_alphanumeric() || [' ', '-'].contains(c)).collect::<String>();
        letters.replace(' ', "-")
    };
    titles.map(slug).collect()
}

#[test]
fn documents_name_files_that_exist() {
    let of_top = ["README.md", "ARCHITECTURE.md", "BENCHMARKS.md", "CHANGELOG.md", "CONTRIBUTING.md", "GLOSSARY.md"];
    let pages = std::fs::read_dir(root().join("docs")).unwrap().map(|entry| entry.unwrap().path());
    for document in of_top.map(|name| root().join(name)).into_iter().chain(pages) {
        let text = std::fs::read_to_string(&document).unwrap();
        for named in named_paths(&text) {
            let (path, heading) = named.split_once('#').unwrap_or((named, ""));
            let found = [document.parent().unwrap(), &root()].map(|folder| folder.join(path));
            let found = found.iter().find(|path| path.exists());
            let has = |path: &PathBuf| heading.is_empty() || headings(path).iter().any(|own| own == heading);
            assert!(found.is_some_and(has), "{} names {named}", document.display());
        }
    }
}

#[test]
fn files_of_the_state_folder_are_named_in_one_place() {
    let openers = ["StateFile::at(", "StateFile::of(", "KeptFile::at(", "Epochs::at(", "state.join("];
    let products = crates().into_iter().filter(|folder| !folder.starts_with(root().join("tests")));
    let modules = products.flat_map(|folder| modules(&folder.join("src")));
    let mut n_openers = 0;
    for (module, text) in modules.filter(|(module, _)| !module.iter().any(|name| name == "tests")) {
        let product = text.split("#[cfg(test)]").next().unwrap();
        for line in product.lines() {
            let Some(opened) = openers.iter().find_map(|opener| line.split(opener).nth(1)) else { continue };
            n_openers += 1;
            let module = module.join("::");
            let is_named = opened.starts_with('"') || opened.contains(", \"");
            assert!(!is_named, "{module}: {}: the name belongs in daemon::state_files", line.trim());
        }
    }
    assert!(n_openers > 20, "{n_openers}");
}

#[test]
fn limits_have_the_values_that_the_page_shows() {
    let limits = limits_of(&std::fs::read_to_string(root().join("docs/limits.md")).unwrap());
    assert!(limits.len() > 70, "{} limits", limits.len());
    for limit in &limits {
        let declared = declared_value(&product_source(&root().join(&limit.file)), &limit.constant);
        assert_eq!(declared, Some(limit.value), "{} of {}", limit.constant, limit.file);
    }
    let is_on_page = |file: &str, name: &str| limits.iter().any(|limit| limit.file == file && limit.constant == name);
    for folder in crates().iter().filter(|folder| !folder.starts_with(root().join("tests"))) {
        for path in files_below(&folder.join("src")) {
            let file = path.strip_prefix(root()).unwrap().display().to_string();
            for name in limits_in_bytes(&product_source(&path)) {
                assert!(is_on_page(&file, name), "docs/limits.md does not have {name} of {file}");
            }
        }
    }
}

#[test]
fn a_limit_that_changed_is_noticed() {
    let source = "pub const MAX_A_BYTES: u64 = 4 << 30;\nconst MAX_B: usize = 8_000 - 24;\nconst MAX_C: usize = f();\nconst D_BYTES_MAX: u8 = 1;";
    let check = |constant, expected| assert_eq!(declared_value(source, constant), expected, "{constant}");
    check("MAX_A_BYTES", Some(4 << 30));
    check("MAX_B", Some(7_976));
    check("MAX_C", None);
    check("MAX_D", None);
    assert_eq!(limits_in_bytes(source).collect::<Vec<_>>(), ["MAX_A_BYTES", "D_BYTES_MAX"]);
    let row = |value: &str| limits_of(&format!("| a file | {value} | [`MAX_A_BYTES`](../a.rs) |")).remove(0).value;
    assert_eq!([row("4 GiB"), row("7,976"), row("2 KiB"), row("94 bytes")], [4 << 30, 7_976, 2_048, 94]);
}

/// Rust files of a folder and its folders.
fn files_below(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let (folders, files): (Vec<_>, Vec<_>) = entries.partition(|path| path.is_dir());
    let own = files.into_iter().filter(|path| path.extension().is_some_and(|end| end == "rs"));
    own.chain(folders.iter().flat_map(|folder| files_below(folder))).collect()
}
