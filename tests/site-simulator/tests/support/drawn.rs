//! Maps of a small site with two storeys at each of its dates, in two revisions: by the daemons and the stages themselves.

use bus::{Bus, Daemon};
use daemon::SiteConfig;
use end_to_end::house::{House, PLAIN};
use replica::{IndexClock, KeyList, PublicKey, SigningKey};
use site_server::later_sets::LaterSets;
use site_server::pieces::{SetPieces, SitePieces};
use site_server::service::{piece, robot_pieces};
use site_simulator::{DAEMONS, Daemons, End, SimulatedClock};
use site_view::SiteSetReader;
use std::collections::BTreeMap;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicI64;
use std::sync::{Arc, OnceLock};

/// Metres per cell: so that the map of a storey has several blocks.
const RESOLUTION_M: f64 = 0.03;
/// The machine's clock at the start, milliseconds since 1970: 1 March 2024.
pub(crate) const START_MS: i64 = 1_709_251_200_000;
/// The name of the robot in the index.
pub(crate) const ROBOT: &str = daemon::UNNAMED_ROBOT;
/// Storeys of the site.
pub(crate) const N_STOREYS: usize = 2;

/// A revision of the site, drawn at all of its dates.
pub(crate) struct Revision {
    pub(crate) site: SitePieces,
    /// In the order of their plan times; the first is that of the start.
    pub(crate) sets: Vec<SetPieces>,
}

/// Keys of the site, and of somebody else.
pub(crate) struct Keys {
    pub(crate) root: PublicKey,
    pub(crate) foreign_root: PublicKey,
    pub(crate) signing: [SigningKey; 2],
    pub(crate) foreign: SigningKey,
    /// Lists of the site's keys: of the first one, and of the second one alone.
    pub(crate) lists: [String; 2],
    pub(crate) foreign_list: String,
    /// Files of a server: its key, and the list.
    pub(crate) files: [[PathBuf; 2]; 2],
}

/// The site.
pub(crate) struct Drawn {
    pub(crate) revisions: Vec<Revision>,
    pub(crate) keys: Keys,
    _folder: tempfile::TempDir,
}

const RULES: &str = "[[property_dates]]\napplies_to = \"IfcWall\"\nset = \"Plan\"\nproperty = \"Built\"\n";

/// Two rooms of 6 m by 4 m, one above the other, whose walls are built one after the other; in the second revision there is a wall more.
fn house(folder: &Path, has_more: bool) -> PathBuf {
    let mut house = House::new("IFC4");
    let mut day = 3;
    for (storey, z) in [0.0, 3.0].into_iter().enumerate() {
        if storey > 0 {
            house.add_storey("Upper", z);
        }
        house.add("IFCSLAB", "Floor", "$,.FLOOR.", [[-0.2, -0.2, z - 0.2], [6.2, 4.2, z]]);
        let corners = [
            [[-0.2, -0.2, z], [6.2, 0.0, z + 2.5]],
            [[-0.2, 4.0, z], [6.2, 4.2, z + 2.5]],
            [[-0.2, 0.0, z], [0.0, 4.0, z + 2.5]],
        ];
        for corners in corners {
            let wall = house.add("IFCWALL", "Wall", PLAIN, corners);
            house.add_text_property(wall, "Plan", "Built", &format!("2024-03-{day:02}"));
            day += 3;
        }
        house.add_room("Room", [[0.0, 0.0, z], [6.0, 4.0, z + 2.5]]);
    }
    if has_more {
        house.add("IFCWALL", "Partition", PLAIN, [[2.9, 0.0, 0.0], [3.1, 2.5, 2.5]]);
    }
    house.write(folder)
}

fn revision(folder: &Path, has_more: bool) -> Revision {
    std::fs::create_dir(folder).unwrap();
    let (model, rules) = (house(folder, has_more), folder.join("rules.toml"));
    std::fs::write(&rules, RULES).unwrap();
    let toml = format!(
        "models = [{model:?}]\nstate = \"state\"\n[schedule]\nrules = {rules:?}\nplan_time = \"2024-03-01\"\n[robot]\nresolution_m = {RESOLUTION_M}\n"
    );
    let mut daemons = Daemons::of(&toml, folder, SimulatedClock(Arc::new(AtomicI64::new(START_MS))));
    for daemon in DAEMONS {
        let started = daemons.start(daemon);
        assert!(matches!(started, End::Done(())), "{daemon}: {started:?}");
    }
    for _ in 0..2 {
        for daemon in DAEMONS {
            (0..4).for_each(|input| drop(daemons.deliver(daemon, input)));
        }
        // The model is in force once schedule-eval has judged it.
        daemons.tick(Daemon::IfcIngest);
    }
    let mut reader = SiteSetReader::of(&Bus::in_process(&daemons.shared.bus, Daemon::Groundplan)).unwrap();
    reader.take().unwrap();
    let set = reader.set().expect("the site is drawn");
    let site = SitePieces {
        site: piece("site", set.site),
        tasks: set.tasks.map(|tasks| piece("tasks", tasks)),
        frame_epoch: set.site.bytes().header().frame_epoch,
        clock: IndexClock::ByServer,
    };
    let head = set.state.view().head;
    let first = SetPieces {
        plan_time_s: head.plan_time().map(|at| at.civil_seconds()),
        valid_until_s: messages::plan_time(head.valid_until_s).map(|at| at.civil_seconds()),
        state: piece("schedule-state", set.state),
        robots: BTreeMap::from([(ROBOT.to_owned(), robot_pieces(ROBOT, &set))]),
    };
    let later = LaterSets::default().draw(&daemons.shared.config, &site, &first, usize::MAX).unwrap();
    let sets: Vec<SetPieces> = std::iter::once(first).chain(later).collect();
    assert!(sets.len() >= 6, "{} dates", sets.len());
    for set in &sets {
        let maps = &set.robots[ROBOT];
        assert!(maps.storeys.len() == N_STOREYS && maps.mission_plan.is_some());
    }
    Revision { site, sets }
}

fn keys(folder: &Path) -> Keys {
    let key = || SigningKey::generate().unwrap();
    let ((root, _), (foreign_root, _), (foreign, _)) = (key(), key(), key());
    let pairs = [key(), key()];
    let list = |root: &SigningKey, number: u64, key: &SigningKey| {
        KeyList { site: "tower".parse().unwrap(), number, keys: vec![key.public()] }.signed_by(root)
    };
    let lists = [1, 2].map(|number| list(&root, number, &pairs[number as usize - 1].0));
    let files = [0, 1].map(|k| {
        let [key, list] = [folder.join(format!("{k}.pem")), folder.join(format!("{k}.jsonl"))];
        std::fs::write(&key, &pairs[k].1).unwrap();
        std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o600)).unwrap();
        std::fs::write(&list, &lists[k]).unwrap();
        [key, list]
    });
    let foreign_list = list(&foreign_root, 9, &foreign);
    let signing = pairs.map(|(key, _)| key);
    Keys { root: root.public(), foreign_root: foreign_root.public(), signing, foreign, lists, foreign_list, files }
}

/// The site, drawn once.
pub(crate) fn drawn() -> &'static Drawn {
    static DRAWN: OnceLock<Drawn> = OnceLock::new();
    DRAWN.get_or_init(|| {
        let folder = tempfile::Builder::new().prefix("sim").tempdir_in("/dev/shm").unwrap();
        let revisions = [("first", false), ("second", true)];
        let revisions = revisions.map(|(name, has_more)| revision(&folder.path().join(name), has_more)).into();
        Drawn { revisions, keys: keys(folder.path()), _folder: folder }
    })
}

/// A configuration of this text.
pub(crate) fn config(toml: &str, home: &Path) -> SiteConfig {
    SiteConfig::parse(toml, home).unwrap()
}
