//! Pairs of model maps and simulated SLAM maps, through the public interface and the program.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use occupancy::{CELL_M, Cell, OccupancyMap};
use slam_simulator::{RandomGenerator, Reference, Simulation, Strengths, fits, floor_plans, is_unique, simulated};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

/// A building of one storey whose floor is these boxes (x from, y from, x to, y to, in metres) with walls of 0.2 m around it.
fn building(name: &str, boxes: &[[f64; 4]]) -> Reference {
    let (width, height) = (300, 240);
    let is_in = |x: f64, y: f64, grown: f64| {
        boxes.iter().any(|b| b[0] - grown < x && x < b[2] + grown && b[1] - grown < y && y < b[3] + grown)
    };
    let cell = |k: usize| {
        let [x, y] = [k % width, k / width].map(|c| (c as f64 + 0.5) * CELL_M - 1.0);
        match (is_in(x, y, 0.0), is_in(x, y, 0.2)) {
            (true, _) => Cell::Free,
            (false, true) => Cell::Occupied,
            _ => Cell::Unknown,
        }
    };
    let cells = (0..width * height).map(cell).collect();
    let map = OccupancyMap { width, cells, resolution_m: CELL_M, origin: [-1.0, -1.0, 0.0] };
    Reference::new(name.to_owned(), name.to_owned(), map, None).unwrap()
}

fn room() -> Reference {
    building("room", &[[0.0, 0.0, 9.0, 6.0]])
}

fn l_shape() -> Reference {
    building("l-shape", &[[0.0, 0.0, 11.0, 5.0], [0.0, 0.0, 4.0, 9.0]])
}

fn drive(reference: &Reference, strengths: &Strengths, seed: u64) -> Simulation {
    simulated(reference, strengths, &RandomGenerator::of(&[seed])).unwrap()
}

#[test]
fn the_true_pose_takes_a_map_of_an_empty_building_onto_the_walls_of_its_model() {
    for (k, (name, map)) in floor_plans::drawn(9, 3).into_iter().enumerate() {
        let reference = Reference::new(name.clone(), name.clone(), map, None).unwrap();
        let resolution_m = [0.02, 0.05, 0.1][k % 3];
        let simulation = drive(&reference, &Strengths { resolution_m, ..Strengths::none() }, k as u64);
        let occupied = places(&simulation.slam, Cell::Occupied);
        let near = occupied.iter().filter(|&&p| is_near_wall(&reference.map, simulation.map_from_slam.apply(p)));
        let share = near.count() as f64 / occupied.len() as f64;
        assert!(share > 0.95 && occupied.len() > 100, "{name}: {share} of {}", occupied.len());
        assert!(simulation.measures.clutter_share < 0.01, "{name}: {}", simulation.measures.clutter_share);
    }
}

/// True if the middle of an occupied cell is within 0.1 m.
fn is_near_wall(map: &OccupancyMap, p: [f64; 2]) -> bool {
    let [x, y] = [0, 1].map(|k| (p[k] - map.origin[k]) / map.resolution_m);
    let around = (-3..=3).flat_map(|dy| (-3..=3).map(move |dx| (x.floor() + f64::from(dx), y.floor() + f64::from(dy))));
    around.into_iter().any(|(column, row)| {
        let is_inside = column >= 0.0 && row >= 0.0 && column < map.width as f64;
        let cell = is_inside.then(|| map.cells.get(row as usize * map.width + column as usize)).flatten();
        let far_m = libm::hypot(column + 0.5 - x, row + 0.5 - y) * map.resolution_m;
        cell == Some(&Cell::Occupied) && far_m < 0.1
    })
}

fn places(map: &OccupancyMap, cell: Cell) -> Vec<[f64; 2]> {
    let at = |k: usize, axis: usize| {
        let count = if axis == 0 { k % map.width } else { k / map.width };
        map.origin[axis] + (count as f64 + 0.5) * map.resolution_m
    };
    (0..map.cells.len()).filter(|&k| map.cells[k] == cell).map(|k| [at(k, 0), at(k, 1)]).collect()
}

#[test]
fn an_l_shape_is_unique_and_a_rectangle_is_its_own_twin() {
    let (room, l_shape) = (room(), l_shape());
    let seen = |reference: &Reference| drive(reference, &Strengths::none(), 1).visible_walls;
    let (walls_of_room, walls_of_l) = (seen(&room), seen(&l_shape));
    assert!(!is_unique(&room, &walls_of_room));
    assert!(is_unique(&l_shape, &walls_of_l));
    assert!(fits(&l_shape, &walls_of_l) && !fits(&room, &walls_of_l) && !fits(&l_shape, &walls_of_room));
}

#[test]
fn more_furniture_makes_more_of_the_map_clutter() {
    let (_, map) = floor_plans::drawn(1, 8).remove(0);
    let reference = Reference::new("office".to_owned(), "office".to_owned(), map, None).unwrap();
    let mean = |clutter: f64| {
        let share =
            |seed: u64| drive(&reference, &Strengths::none().with_clutter(clutter), seed).measures.clutter_share;
        (0..4).map(share).sum::<f64>() / 4.0
    };
    let shares = [0.0, 0.2, 0.5, 1.0].map(mean);
    assert!(shares.windows(2).all(|s| s[0] + 0.05 < s[1]), "{shares:?}");
    assert!(shares[0] < 0.01 && shares[3] > 0.45, "{shares:?}");
}

#[test]
fn a_drifting_map_bends_as_much_as_was_asked_for() {
    let (_, map) = floor_plans::drawn(1, 8).remove(0);
    let reference = Reference::new("office".to_owned(), "office".to_owned(), map, None).unwrap();
    for bend_m in [0.0, 0.05, 0.1] {
        let strengths = Strengths { bend_m, loop_correction: 0.5, ..Strengths::none() };
        let residual = drive(&reference, &strengths, 3).measures.residual;
        assert!(residual.residual_max_m <= bend_m + 0.01 && residual.residual_max_deg < 2.1, "{bend_m}: {residual:?}");
        assert!(residual.residual_max_m > 0.3 * bend_m - 1e-9, "{bend_m}: {residual:?}");
    }
}

fn slam_pairs(arguments: &[&str], folder: &Path) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_slam-pairs")).args(arguments).current_dir(folder).output().unwrap()
}

fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(files(&path));
        } else {
            found.insert(path.strip_prefix(folder).unwrap().display().to_string(), std::fs::read(&path).unwrap());
        }
    }
    found
}

#[test]
fn the_same_seed_gives_the_same_bytes_with_any_number_of_threads() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    assert!(slam_pairs(&["plans", "plans", "--count", "3"], at).status.success());
    for (out, seed, threads) in [("one", "4", "1"), ("two", "4", "2"), ("other", "5", "2")] {
        let arguments = [out, "plans", "--count", "4", "--wrong", "2", "--seed", seed, "--threads", threads];
        let done = slam_pairs(&arguments, at);
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    }
    let [one, two, other] = ["one", "two", "other"].map(|name| files(&at.join(name)));
    assert_eq!(one, two);
    assert_ne!(one["truth.jsonl"], other["truth.jsonl"]);
    let pairs = String::from_utf8(one["pairs.jsonl"].clone()).unwrap();
    for line in pairs.lines().map(|line| serde_json::from_str::<serde_json::Value>(line).unwrap()) {
        for map in ["reference", "slam"] {
            OccupancyMap::read(&at.join("one").join(line[map].as_str().unwrap())).unwrap();
        }
    }
}

#[test]
fn wrong_pairs_tell_what_is_mixed_up() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // A building of two storeys that differ, and one of which another copy is the same.
    for (building, storey, reference) in [
        ("house", "00-ground", l_shape()),
        ("house", "01-upper", room()),
        ("house", "02-attic", room()),
        ("shed", "00-ground", building("shed", &[[0.0, 0.0, 8.0, 5.0]])),
    ] {
        let storey = at.join(building).join("storeys").join(storey);
        std::fs::create_dir_all(&storey).unwrap();
        slam_simulator::write_map(&storey, "localization", &reference.map).unwrap();
    }
    let done = slam_pairs(&["out", "house", "shed", "--count", "2", "--wrong", "8", "--clutter", "low"], at);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let truth = std::fs::read_to_string(at.join("out/truth.jsonl")).unwrap();
    let truths: Vec<serde_json::Value> = truth.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(truths.len(), 10);
    let mut kinds = BTreeMap::new();
    for truth in &truths {
        assert_eq!(truth["same_building"].as_bool().unwrap(), truth["wrong"].is_null());
        assert_eq!(truth["is_unique"].is_boolean(), truth["wrong"].is_null());
        let name = truth["pair"].as_str().unwrap();
        *kinds.entry(truth["wrong"].as_str().unwrap_or("none")).or_insert(0) += 1;
        let same_twice = ["upper_in_house-02", "attic_in_house-01"].iter().any(|same| name.contains(same));
        assert!(!same_twice, "{name}: two storeys that are the same");
        assert_eq!(truth["wrong"] == "building", name.contains("shed") && name.contains("_in_"), "{name}");
    }
    assert!(kinds["building"] >= 4 && kinds["storey"] >= 2 && kinds["none"] == 2, "{kinds:?}");
}

#[test]
fn a_growing_map_keeps_what_it_knew_in_one_frame() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    assert!(slam_pairs(&["plans", "plans", "--count", "3", "--seed", "2"], at).status.success());
    let arguments = ["out", "plans", "--count", "6", "--wrong", "3", "--looks", "5", "--seed", "9", "--clutter", "low"];
    let done = slam_pairs(&arguments, at);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let lines = |name: &str| -> Vec<serde_json::Value> {
        let text = std::fs::read_to_string(at.join("out").join(name)).unwrap();
        text.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
    };
    let mut drives: BTreeMap<String, Vec<(serde_json::Value, OccupancyMap)>> = BTreeMap::new();
    for (pair, truth) in lines("pairs.jsonl").iter().zip(lines("truth.jsonl")) {
        assert_eq!((&pair["pair"], &pair["drive"], &pair["look"]), (&truth["pair"], &truth["drive"], &truth["look"]));
        let map = OccupancyMap::read(&at.join("out").join(pair["slam"].as_str().unwrap())).unwrap();
        drives.entry(pair["drive"].as_str().unwrap().to_owned()).or_default().push((truth, map));
    }
    assert_eq!(drives.len(), 9);
    let mut bends = [0, 0];
    for (drive, looks) in &drives {
        assert_eq!(looks.last().unwrap().0["look"], 5, "{drive}: the whole way is always there");
        let bends_back = looks[0].0["bends_back"].as_bool().unwrap();
        bends[usize::from(bends_back)] += 1;
        for pair in looks.windows(2) {
            let ([before, after], [earlier, later]) = ([&pair[0].0, &pair[1].0], [&pair[0].1, &pair[1].1]);
            assert!(before["look"].as_u64() < after["look"].as_u64());
            assert!(before["way_m"].as_f64() < after["way_m"].as_f64(), "{drive}");
            let known = |map: &OccupancyMap| [Cell::Free, Cell::Occupied].map(|cell| places(map, cell)).concat();
            let known_later: std::collections::BTreeSet<[i64; 2]> =
                known(later).iter().map(|p| p.map(|c| (c / later.resolution_m).floor() as i64)).collect();
            let earlier_known = known(earlier);
            let n_kept = earlier_known
                .iter()
                .filter(|p| known_later.contains(&p.map(|c| (c / later.resolution_m).floor() as i64)))
                .count();
            let share = n_kept as f64 / earlier_known.len() as f64;
            assert!(share > if bends_back { 0.9 } else { 0.9999 }, "{drive}: {share} of what was known");
            let far = |key: &str| (before[key].as_f64().unwrap() - after[key].as_f64().unwrap()).abs();
            assert!(far("x") < 1.5 && far("y") < 1.5, "{drive}: one frame");
        }
    }
    assert!(bends.iter().all(|n| *n > 0), "{bends:?}");
}

#[test]
fn what_cannot_be_simulated_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let empty = OccupancyMap { width: 50, cells: vec![Cell::Free; 2500], resolution_m: 0.05, origin: [0.0; 3] };
    slam_simulator::write_map(at, "empty", &empty).unwrap();
    let done = slam_pairs(&["out", "empty.yaml"], at);
    let text = String::from_utf8_lossy(&done.stderr).into_owned();
    assert!(!done.status.success() && text.contains("empty cannot be simulated"), "{text}");
    assert!(text.contains("no reference can be simulated"), "{text}");
    assert_eq!(slam_pairs(&["out"], at).status.code(), Some(2));
}
