//! Models of a small site, and a state folder in which the first of them is in force.

use bus::Daemon;
use end_to_end::house::{House, PLAIN};
use site_simulator::{DAEMONS, Daemons, End, SimulatedClock};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicI64;
use std::sync::{Arc, OnceLock};

/// Metres per cell: what is judged is what belongs together, not how it is drawn.
pub(crate) const RESOLUTION_M: f64 = 0.25;
/// The machine's clock at the start, milliseconds since 1970: 1 March 2024.
pub(crate) const START_MS: i64 = 1_709_251_200_000;

/// The models of the site, and a state folder in which the first is in force.
pub(crate) struct Models {
    pub(crate) folder: tempfile::TempDir,
    pub(crate) paths: [PathBuf; 3],
    /// Elements whose progress can be reported: both sound models have them.
    pub(crate) walls: Vec<String>,
}

pub(crate) const RULES: &str =
    "[[property_dates]]\napplies_to = \"IfcBuiltElement\"\nset = \"Plan\"\nproperty = \"Built\"\n";

pub(crate) fn toml(state: &Path, models: &Models) -> String {
    let [first, ..] = &models.paths;
    format!(
        "models = [{:?}]\nstate = {:?}\n[schedule]\nrules = {:?}\nplan_time = \"2024-03-01\"\n[robot]\nresolution_m = {RESOLUTION_M}\n",
        first.display().to_string(),
        state.display().to_string(),
        models.folder.path().join("rules.toml").display().to_string(),
    )
}

/// A room of 4 m by 3 m whose walls are built one after the other; in the second model there is a wall more.
fn house(folder: &Path, name: &str, has_more: bool) -> (PathBuf, Vec<String>) {
    let mut house = House::new("IFC4");
    house.add("IFCSLAB", "Floor", "$,.FLOOR.", [[-0.2, -0.2, -0.2], [4.2, 3.2, 0.0]]);
    let mut walls = Vec::new();
    let corners = [
        [[-0.2, -0.2, 0.0], [4.2, 0.0, 2.5]],
        [[-0.2, 3.0, 0.0], [4.2, 3.2, 2.5]],
        [[-0.2, 0.0, 0.0], [0.0, 3.0, 2.5]],
        [[4.0, 0.0, 0.0], [4.2, 3.0, 2.5]],
    ];
    for (k, corners) in corners.into_iter().enumerate() {
        let wall = house.add("IFCWALL", "Wall", PLAIN, corners);
        house.add_text_property(wall, "Plan", "Built", &format!("2024-03-{:02}", 5 + 4 * k));
        walls.push(format!("{:0>22}", wall - 1));
    }
    house.add_room("Room", [[0.0, 0.0, 0.0], [4.0, 3.0, 2.5]]);
    if has_more {
        house.add("IFCWALL", "Partition", PLAIN, [[1.9, 0.0, 0.0], [2.1, 1.5, 2.5]]);
    }
    let path = folder.join(name);
    std::fs::rename(house.write(folder), &path).unwrap();
    (path, walls)
}

/// The models, made once; the site that the first one makes is in the state folder `template`.
pub(crate) fn models() -> &'static Models {
    static MODELS: OnceLock<Models> = OnceLock::new();
    MODELS.get_or_init(|| {
        let folder = tempfile::Builder::new().prefix("sim").tempdir_in("/dev/shm").unwrap();
        let (first, walls) = house(folder.path(), "first.ifc", false);
        let (second, _) = house(folder.path(), "second.ifc", true);
        let broken = folder.path().join("broken.ifc");
        std::fs::write(&broken, "ISO-10303-21;\nHEADER;\n").unwrap();
        std::fs::write(folder.path().join("rules.toml"), RULES).unwrap();
        let models = Models { paths: [first, second, broken], walls, folder };
        let state = models.folder.path().join("template");
        let clock = SimulatedClock(Arc::new(AtomicI64::new(START_MS)));
        let mut daemons = Daemons::of(&toml(&state, &models), models.folder.path(), clock);
        for daemon in DAEMONS {
            let started = daemons.start(daemon);
            assert!(matches!(started, End::Done(())), "{daemon}: {started:?}");
        }
        for input in 0..2 {
            daemons.deliver(Daemon::ScheduleEval, input);
        }
        daemons.tick(Daemon::IfcIngest);
        assert!(daemons.ingest.facts().unwrap().site.epoch > 0, "the first model is in force");
        models
    })
}

/// Copies a folder with all that is in it.
pub(crate) fn copy_folder(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let path = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy_folder(&entry.path(), &path);
        } else {
            std::fs::copy(entry.path(), path).unwrap();
        }
    }
}
