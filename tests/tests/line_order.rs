//! The order of a model's lines and the numbers of its records change no output: STEP gives them no meaning. Only triangles of
//! elements with several openings follow the numbers, because the kernel cuts openings in their order.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{convert, corpus, demo_model};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// SplitMix64: the next number of a sequence.
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mixed = (*state ^ (*state >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    mixed ^ (mixed >> 31)
}

fn shuffled<T>(mut items: Vec<T>, state: &mut u64) -> Vec<T> {
    for k in (1..items.len()).rev() {
        items.swap(k, (next(state) % (k as u64 + 1)) as usize);
    }
    items
}

/// Stretches of a text that are quoted, and those that are not, in turn, from the first that is not.
fn stretches(text: &str) -> Vec<String> {
    text.split('\'').map(str::to_owned).collect()
}

/// The model with each id replaced by another, if there are any, and its records in another order.
fn rewritten(text: &str, new_id: &dyn Fn(u64) -> Option<u64>, state: &mut u64) -> String {
    let (head, data) = text.split_once("DATA;").unwrap();
    let (data, tail) = data.rsplit_once("ENDSEC;").unwrap();
    let renumbered = |code: &str| {
        let mut parts = code.split('#');
        let mut out = parts.next().unwrap().to_owned();
        for part in parts {
            let end = part.find(|c: char| !c.is_ascii_digit()).unwrap_or(part.len());
            let id = part[..end].parse().unwrap();
            out += &format!("#{}{}", new_id(id).unwrap_or(id), &part[end..]);
        }
        out
    };
    // A semicolon in a text ends no record.
    let mut records = vec![String::new()];
    for (k, stretch) in stretches(data).iter().enumerate() {
        if k % 2 == 1 {
            *records.last_mut().unwrap() += &format!("'{stretch}'");
            continue;
        }
        let code = renumbered(stretch);
        for piece in code.split_inclusive(';') {
            *records.last_mut().unwrap() += piece.trim_start_matches(['\r', '\n']);
            if piece.ends_with(';') {
                records.push(String::new());
            }
        }
    }
    records.retain(|record| !record.trim().is_empty());
    format!("{head}DATA;\n{}\nENDSEC;{tail}", shuffled(records, state).join("\n"))
}

/// Ids of a model, each with another one: a permutation, spread over thrice as many numbers.
fn permutation(text: &str, state: &mut u64) -> BTreeMap<u64, u64> {
    let code: String = stretches(text).into_iter().step_by(2).collect::<Vec<String>>().join("' '");
    let digits = |part: &str| part.chars().take_while(char::is_ascii_digit).collect::<String>();
    let ids: BTreeSet<u64> = code.split('#').skip(1).map(|part| digits(part).parse().unwrap()).collect();
    let new = shuffled((1..=3 * ids.len() as u64).collect(), state);
    ids.into_iter().zip(new).collect()
}

/// A text of an output without what names the file itself: hashes, and ids behind a number sign.
fn without_names(path: &Path, bytes: &[u8]) -> Vec<u8> {
    let is_text =
        path.extension().is_some_and(|e| ["json", "jsonl", "csv", "md", "txt", "geojson"].iter().any(|t| e == *t));
    if !is_text {
        return bytes.to_vec();
    }
    let text = std::str::from_utf8(bytes).unwrap();
    let mut out = String::new();
    for word in text.split_inclusive(|c: char| !c.is_ascii_alphanumeric()) {
        let (bare, end) = word.split_at(word.len() - word.chars().last().map_or(0, char::len_utf8));
        let is_hash = [16, 64].contains(&bare.len()) && bare.chars().all(|c| c.is_ascii_hexdigit());
        let is_id = out.ends_with('#') && !bare.is_empty() && bare.chars().all(|c| c.is_ascii_digit());
        out += if is_hash || is_id { "x" } else { bare };
        out += end;
    }
    out.into_bytes()
}

fn outputs(model: &Path, more: &[&str]) -> BTreeMap<PathBuf, Vec<u8>> {
    let contents = convert(model, more).contents();
    contents.into_iter().map(|(path, bytes)| (path.clone(), without_names(&path, &bytes))).collect()
}

/// What a rewriting of a model changes.
#[derive(Clone, Copy, PartialEq)]
enum Change {
    Order,
    OrderAndIds,
}

/// Files that differ between the outputs of a model and of its rewritings.
fn differences(model: &Path, more: &[&str], change: Change, seeds: std::ops::Range<u64>) -> BTreeSet<PathBuf> {
    let text = std::fs::read_to_string(model).unwrap();
    let expected = outputs(model, more);
    let home = tempfile::tempdir().unwrap();
    let other = home.path().join(model.file_name().unwrap());
    let mut differing = BTreeSet::new();
    for seed in seeds {
        let mut state = seed;
        let ids = if change == Change::Order { BTreeMap::new() } else { permutation(&text, &mut state) };
        std::fs::write(&other, rewritten(&text, &|id| ids.get(&id).copied(), &mut state)).unwrap();
        let found = outputs(&other, more);
        let paths: BTreeSet<&PathBuf> = expected.keys().chain(found.keys()).collect();
        differing.extend(paths.into_iter().filter(|path| expected.get(*path) != found.get(*path)).cloned());
    }
    differing
}

fn check(model: &Path, more: &[&str], change: Change, seeds: std::ops::Range<u64>) {
    let differing = differences(model, more, change, seeds);
    assert!(differing.is_empty(), "{}: {differing:?}", model.display());
}

#[test]
fn no_output_of_the_demo_building_depends_on_the_order_of_lines_or_on_ids() {
    check(&demo_model(), &["--with-geometry", "--world"], Change::Order, 0..2);
    check(&demo_model(), &["--date", "2024-05-13"], Change::OrderAndIds, 2..5);
}

#[test]
fn no_output_of_a_model_whose_records_share_global_ids_depends_on_the_order_of_lines_or_on_ids() {
    let text = std::fs::read_to_string(demo_model()).unwrap();
    let home = tempfile::tempdir().unwrap();
    let model = home.path().join("twins.ifc");
    // Every wall has the GlobalId of the first, every space that of the first space.
    let mut firsts: BTreeMap<&str, &str> = BTreeMap::new();
    let lines = text.lines().map(|line| {
        let Some((before, rest)) = line.split_once("('") else { return line.to_owned() };
        let Some((keyword, (id, after))) = before.split_once('=').map(|p| p.1).zip(rest.split_once('\'')) else {
            return line.to_owned();
        };
        if !["IFCWALL", "IFCSPACE"].contains(&keyword) || id.len() != 22 {
            return line.to_owned();
        }
        let first = firsts.entry(keyword).or_insert(id);
        format!("{before}('{first}'{after}")
    });
    std::fs::write(&model, lines.collect::<Vec<String>>().join("\n")).unwrap();
    check(&model, &[], Change::Order, 0..1);
    check(&model, &[], Change::OrderAndIds, 1..3);
}

#[test]
fn a_model_with_ids_above_32_bits_gives_the_same_output_and_its_own_ids() {
    let text = std::fs::read_to_string(demo_model()).unwrap();
    let home = tempfile::tempdir().unwrap();
    let wide = home.path().join("demo.ifc");
    std::fs::write(&wide, rewritten(&text, &|id| Some(id + 5_000_000_000), &mut 1)).unwrap();
    let (expected, found) = (outputs(&demo_model(), &[]), outputs(&wide, &[]));
    let differing: Vec<&PathBuf> = expected.keys().filter(|path| expected.get(*path) != found.get(*path)).collect();
    assert!(differing.is_empty() && expected.len() == found.len(), "{differing:?}");
    let report = convert(&wide, &[]).json("report.json").to_string();
    let ids: Vec<&str> = report.split("\"#").skip(1).collect();
    assert!(ids.iter().all(|id| id.starts_with("50000")) && !ids.is_empty(), "{ids:?}");
}

#[test]
#[ignore = "real buildings: scripts/test --corpus runs it"]
fn no_output_of_a_real_building_depends_on_the_order_of_lines_or_on_ids() {
    let Some(buildings) = corpus("buildings") else { return };
    for name in ["AC20-FZK-Haus.ifc", "Ifc2x3_Duplex_Architecture.ifc", "fhnw-three-storeys.ifc", "demo2.ifc"] {
        check(&buildings.join(name), &[], Change::Order, 0..1);
        check(&buildings.join(name), &[], Change::OrderAndIds, 1..2);
    }
}
