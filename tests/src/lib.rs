//! Runs the client and reads what it wrote, runs sites, and the programs outside that look at them: for the end-to-end tests in `tests/`.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]
#![expect(missing_docs, reason = "for the tests of this package alone")]

pub mod fast_dds;
pub mod foxglove_peer;
pub mod house;
pub mod live;
pub mod map_server;
pub mod mapping_robot;
pub mod pages;
pub mod peer;
pub mod ros_facts;
pub mod ros_node;
pub mod ros_peer;
pub mod tower;

use serde_json::Value;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

pub const OCCUPIED: u8 = grid::OCCUPIED;
pub const FREE: u8 = grid::FREE;
pub const UNKNOWN: u8 = grid::UNKNOWN;

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_owned()
}

pub fn demo_model() -> PathBuf {
    root().join("config/demo/demo.ifc")
}

/// Writes a site on terrain, 60 x 60 m unless `more` says another size, and gives its path and what the script prints.
pub fn terrain_site(folder: &Path, more: &[&str]) -> (PathBuf, Vec<u8>) {
    let model = folder.join("site.ifc");
    let mut script = Command::new(root().join("scripts/build_terrain_site"));
    let output = script.args(["--size", "60", "60"]).args(more).arg(&model).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (model, output.stdout)
}

/// Prints a line that the test harness does not capture: a test that was skipped passes, and must still be seen.
pub fn announce(line: &str) {
    std::io::stderr().write_all(format!("\n** {line}\n").as_bytes()).unwrap();
}

/// Real files by purpose; `None`, and a loud word, where they are not at hand.
pub fn corpus(folder: &str) -> Option<PathBuf> {
    let home = std::env::var_os("GROUNDPLAN_CORPUS").map_or_else(|| root().join("../shared/corpus"), PathBuf::from);
    let path = home.join(folder);
    if !path.is_dir() {
        announce(&format!("SKIPPED: no corpus at {} (set GROUNDPLAN_CORPUS)", path.display()));
        return None;
    }
    Some(path)
}

/// Files of a folder, by name.
pub fn files_in(folder: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
    files.sort();
    files
}

/// Every file of an output folder with its content.
pub fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let (mut todo, mut found) = (vec![folder.to_owned()], Vec::new());
    while let Some(at) = todo.pop() {
        for path in files_in(&at) {
            if path.is_dir() {
                todo.push(path);
            } else {
                found.push((path.strip_prefix(folder).unwrap().to_owned(), std::fs::read(path).unwrap()));
            }
        }
    }
    found.sort();
    found
}

/// The client; its daemons lie beside it.
pub fn client() -> PathBuf {
    let own = std::env::current_exe().unwrap();
    let client = own.parent().unwrap().parent().unwrap().join("groundplan");
    assert!(client.exists(), "{} is not built: run cargo test --workspace", client.display());
    client
}

/// Writes a program by another process. What this one has open for writing, processes that other tests start at this moment have open
/// too until they become their programs, and the system starts no program that somebody has open for writing.
pub fn write_program(path: &Path, text: &str) {
    let mut shell = Command::new("sh");
    shell.args(["-c", "cat > \"$0\" && chmod 755 \"$0\""]).arg(path).stdin(Stdio::piped());
    let mut shell = shell.spawn().unwrap();
    shell.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    assert!(shell.wait().unwrap().success());
}

/// Runs the client, which lies beside the folder of the test's own executable.
pub fn groundplan(arguments: &[&dyn AsRef<std::ffi::OsStr>]) -> Output {
    Command::new(client()).args(arguments.iter().map(AsRef::as_ref)).output().unwrap()
}

/// An output folder with its temporary home.
pub struct Maps {
    home: tempfile::TempDir,
    pub manifest: Value,
    /// Standard output of the program.
    pub stdout: String,
}

/// Converts, and expects success.
pub fn convert(model: &Path, more: &[&str]) -> Maps {
    let home = tempfile::tempdir().unwrap();
    let out = home.path().join("out");
    let mut arguments: Vec<&dyn AsRef<std::ffi::OsStr>> = vec![&"convert", &model, &"-o", &out];
    arguments.extend(more.iter().map(|a| a as &dyn AsRef<std::ffi::OsStr>));
    let output = groundplan(&arguments);
    assert!(output.status.success(), "{}: {}", model.display(), String::from_utf8_lossy(&output.stderr));
    let manifest = serde_json::from_slice(&std::fs::read(out.join("manifest.json")).unwrap()).unwrap();
    Maps { home, manifest, stdout: String::from_utf8(output.stdout).unwrap() }
}

impl Maps {
    pub fn path(&self) -> PathBuf {
        self.home.path().join("out")
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_slice(&std::fs::read(self.path().join(name)).unwrap()).unwrap()
    }

    pub fn storey(&self, index: usize) -> Storey {
        let record = &self.manifest["storeys"][index];
        let folder = self.path().join(record["directory"].as_str().unwrap());
        let pixels = |name: &str| {
            let bytes = std::fs::read(folder.join(format!("{name}.pgm"))).unwrap();
            grid::decode_pgm(&bytes).unwrap()
        };
        let (width, _, planning) = pixels("planning");
        let origin = [0, 1].map(|k| record["origin_m"][k].as_f64().unwrap());
        Storey {
            width,
            origin,
            resolution: self.manifest["resolution_m"].as_f64().unwrap(),
            planning,
            keepout: pixels("keepout").2,
            localization: pixels("localization").2,
        }
    }

    /// Every file of the folder with its content.
    pub fn contents(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut todo = vec![self.path()];
        let mut contents = BTreeMap::new();
        while let Some(folder) = todo.pop() {
            for path in files_in(&folder) {
                if path.is_dir() {
                    todo.push(path);
                } else {
                    let name = path.strip_prefix(self.path()).unwrap().to_owned();
                    contents.insert(name, std::fs::read(path).unwrap());
                }
            }
        }
        contents
    }
}

/// The maps of a storey, looked up in metres.
pub struct Storey {
    width: usize,
    origin: [f64; 2],
    resolution: f64,
    planning: Vec<u8>,
    keepout: Vec<u8>,
    localization: Vec<u8>,
}

impl Storey {
    fn index(&self, x: f64, y: f64) -> usize {
        let cell = |k: usize, v: f64| ((v - self.origin[k]) / self.resolution).floor() as usize;
        cell(1, y) * self.width + cell(0, x)
    }

    pub fn planning(&self, x: f64, y: f64) -> u8 {
        self.planning[self.index(x, y)]
    }

    pub fn keepout(&self, x: f64, y: f64) -> u8 {
        self.keepout[self.index(x, y)]
    }

    pub fn localization(&self, x: f64, y: f64) -> u8 {
        self.localization[self.index(x, y)]
    }

    /// True if every pixel of the planning map is this.
    pub fn all_planning(&self, pixel: u8) -> bool {
        self.planning.iter().all(|&p| p == pixel)
    }

    /// True if every pixel of the keep-out mask is this.
    pub fn all_keepout(&self, pixel: u8) -> bool {
        self.keepout.iter().all(|&p| p == pixel)
    }

    /// Asserts that Nav2's KeepoutFilter makes no unknown cell of the planning map free.
    pub fn assert_filter_frees_nothing(&self) {
        assert_filter_frees_nothing(&self.planning, &self.keepout);
    }

    /// Asserts that all cells in the rectangle are unknown and must not be entered.
    pub fn assert_drop_off(&self, rectangle: [f64; 4]) {
        for [x, y] in self.points(rectangle) {
            let seen = (self.planning(x, y), self.keepout(x, y));
            assert_eq!(seen, (UNKNOWN, OCCUPIED), "at {x:.2}, {y:.2}");
        }
    }

    /// Asserts that no cell in the rectangle is free, and none may be entered.
    pub fn assert_forbidden(&self, rectangle: [f64; 4]) {
        for [x, y] in self.points(rectangle) {
            assert!(self.planning(x, y) != FREE && self.keepout(x, y) == OCCUPIED, "at {x:.2}, {y:.2}");
        }
    }

    /// A point per cell of a rectangle.
    fn points(&self, [x0, y0, x1, y1]: [f64; 4]) -> Vec<[f64; 2]> {
        let steps = |a: f64, b: f64| {
            let n = ((b - a) / self.resolution).floor() as usize;
            (0..n).map(move |k| a + (k as f64 + 0.5) * (b - a) / n as f64)
        };
        steps(y0, y1).flat_map(|y| steps(x0, x1).map(move |x| [x, y])).collect()
    }
}

/// Runs the rule of Nav2's KeepoutFilter over the pixels of a planning map and its mask, and asserts that no unknown cell
/// becomes free: a mask value that is unknown is skipped, any other is written where it is higher, or nothing is known.
pub fn assert_filter_frees_nothing(planning: &[u8], mask: &[u8]) {
    const NO_INFORMATION: u8 = 255;
    let cost = |pixel: u8| match pixel {
        OCCUPIED => 254,
        FREE => 0,
        _ => NO_INFORMATION,
    };
    let mut n_unknown = 0;
    assert_eq!(planning.len(), mask.len());
    for (&pixel, &mask) in planning.iter().zip(mask) {
        let (old_data, data) = (cost(pixel), cost(mask));
        let applies = data != NO_INFORMATION && (data > old_data || old_data == NO_INFORMATION);
        let cost = if applies { data } else { old_data };
        assert!([OCCUPIED, UNKNOWN].contains(&mask), "a mask has the pixel {mask}");
        assert!(pixel != UNKNOWN || cost >= 254, "an unknown cell has the cost {cost}");
        n_unknown += u32::from(pixel == UNKNOWN);
    }
    assert!(n_unknown > 0, "nothing is unknown");
}

/// The planning map of a storey as a robot might have mapped it: in a frame of its own, a quarter turn around.
pub fn turned_map(maps: &Maps, storey: usize, folder: &Path) -> PathBuf {
    let directory = maps.manifest["storeys"][storey]["directory"].as_str().unwrap();
    let source = maps.path().join(directory).join("planning.pgm");
    let (width, height, pixels) = grid::decode_pgm(&std::fs::read(source).unwrap()).unwrap();
    // What was at (column, row) comes to (height - 1 - row, column).
    let turned: Vec<u8> =
        (0..pixels.len()).map(|at| pixels[(height - 1 - at % height) * width + at / height]).collect();
    std::fs::write(folder.join("robot.pgm"), grid::encode_pgm(height, &turned)).unwrap();
    let yaml = folder.join("robot.yaml");
    std::fs::write(&yaml, "image: robot.pgm\nresolution: 0.05\norigin: [7.5, -3.0, 0.0]\nnegate: 0\n").unwrap();
    yaml
}
