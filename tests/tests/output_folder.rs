//! Output folders: foreign files are never lost, and every manifest lists its files.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{contents, convert, demo_model, groundplan};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::Path;

/// Converts the demo building into a folder: exit code and standard error.
fn run(out: &Path, more: &[&str]) -> (Option<i32>, String) {
    let model = demo_model();
    let mut arguments: Vec<&dyn AsRef<std::ffi::OsStr>> =
        vec![&"convert", &model, &"-o", &out, &"--resolution", &"0.2"];
    arguments.extend(more.iter().map(|a| a as &dyn AsRef<std::ffi::OsStr>));
    let output = groundplan(&arguments);
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn sums(folder: &Path) -> BTreeMap<String, Value> {
    let sum = |bytes: &[u8]| {
        Sha256::digest(bytes).iter().fold(String::new(), |mut hex, byte| {
            write!(hex, "{byte:02x}").unwrap();
            hex
        })
    };
    let files =
        contents(folder).into_iter().map(|(path, bytes)| (path.to_str().unwrap().to_owned(), sum(&bytes).into()));
    files.filter(|(path, _)| path != "manifest.json").collect()
}

#[test]
fn a_folder_with_files_of_a_person_is_refused_and_nothing_in_it_is_touched() {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("maps");
    assert_eq!(run(&out, &[]).0, Some(0));
    assert_eq!(run(&out, &[]).0, Some(0), "output as it was written is replaced");
    std::fs::write(out.join("notes.txt"), "precious").unwrap();
    std::fs::write(out.join("storeys/00-ground-floor/slam.pgm"), "a day of mapping").unwrap();
    std::fs::write(out.join("waypoints.csv"), "mine").unwrap();
    let before = contents(&out);
    let (code, error) = run(&out, &["--date", "2024-04-15"]);
    assert_eq!(code, Some(2));
    for word in ["notes.txt (added)", "slam.pgm (added)", "waypoints.csv (altered)", "--force"] {
        assert!(error.contains(word), "{word}: {error}");
    }
    assert!(contents(&out) == before);

    let (code, output_text) = run(&out, &["--force"]);
    assert_eq!(code, Some(0), "{output_text}");
    assert!(output_text.contains("notes.txt") && output_text.contains("maps.kept-1"), "{output_text}");
    let kept: Vec<String> =
        contents(&home.path().join("maps.kept-1")).into_iter().map(|(p, _)| p.display().to_string()).collect();
    assert_eq!(kept, ["notes.txt", "storeys/00-ground-floor/slam.pgm", "waypoints.csv"]);
    assert!(!out.join("notes.txt").exists());
    assert_eq!(run(&out, &[]).0, Some(0));
}

#[test]
fn a_web_folder_is_never_replaced() {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("site");
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("index.html"), "<html>").unwrap();
    for manifest in ["{\n  // a web manifest\n  \"name\": \"app\"\n}", "\u{feff}{\"tool\": \"groundplan\"}"] {
        std::fs::write(out.join("manifest.json"), manifest).unwrap();
        for more in [&[][..], &["--force"]] {
            let (code, error) = run(&out, more);
            assert_eq!(code, Some(2));
            assert!(error.contains("no output folder of groundplan"), "{error}");
        }
        assert_eq!(std::fs::read_to_string(out.join("index.html")).unwrap(), "<html>");
    }
}

#[test]
fn every_manifest_lists_all_files_with_their_sums() {
    let one = convert(&demo_model(), &["--resolution", "0.2", "--date", "2024-04-15"]);
    assert_eq!(one.manifest["files"], serde_json::to_value(sums(&one.path())).unwrap());
    let all = convert(&demo_model(), &["--resolution", "0.2", "--date", "all"]);
    assert_eq!(all.manifest["files"], serde_json::to_value(sums(&all.path())).unwrap());
    assert!(all.manifest["files"].as_object().unwrap().keys().filter(|k| k.ends_with("manifest.json")).count() > 1);
    // What was added to one of the folders is seen from above.
    let dated = all.path().join(all.manifest["dates"][0]["directory"].as_str().unwrap());
    std::fs::write(dated.join("notes.txt"), "precious").unwrap();
    let (code, error) = run(&all.path(), &["--date", "all"]);
    assert_eq!(code, Some(2));
    assert!(error.contains("notes.txt (added)"), "{error}");
}

#[test]
fn maps_are_the_same_with_meshes_of_an_earlier_conversion_also_if_those_are_damaged() {
    let home = tempfile::tempdir().unwrap();
    let (plain, cache) = (home.path().join("plain"), home.path().join("cache"));
    assert_eq!(run(&plain, &[]).0, Some(0));
    let file = cache.join("meshes.gpmesh");
    let with_cache = |name: &str| {
        let out = home.path().join(name);
        let (code, told) = run(&out, &["--cache", cache.to_str().unwrap(), "--json"]);
        assert_eq!(code, Some(0), "{told}");
        assert!(contents(&out) == contents(&plain), "{name}");
        told
    };
    assert!(!with_cache("cold").contains("cache"));
    let kept = std::fs::read(&file).unwrap();
    assert!(!with_cache("warm").contains("cache"));
    assert!(std::fs::read(&file).unwrap() == kept);
    let mut damaged = kept.clone();
    damaged[kept.len() / 2] ^= 1;
    for (bytes, why) in [(damaged, "damaged"), (b"maps".to_vec(), "no cache of meshes")] {
        std::fs::write(&file, bytes).unwrap();
        let told = with_cache("again");
        assert!(told.contains(why) && told.contains("meshes.gpmesh"), "{told}");
        assert!(std::fs::read(&file).unwrap() == kept, "it is written anew");
    }
    assert_eq!(run(&plain, &["--cache", file.to_str().unwrap()]).0, Some(2), "a file is no folder");
}
