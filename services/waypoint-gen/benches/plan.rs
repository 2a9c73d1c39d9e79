//! CPU time of planning waypoints for models, on one thread: with the options by default, and with one waypoint for each room.
//!
//! usage: cargo bench -p waypoint-gen --bench plan -- [--repeat N] [MODEL.ifc ..]
//!
//! Without a model it is an office floor of 57 rooms, 3,470 m2. The least of the runs counts.
#![expect(clippy::print_stdout, reason = "figures are what it is for")]
#![expect(clippy::unwrap_used, reason = "a benchmark stops where it fails")]

use ingest::{IngestOptions, SourceFile};
use messages::{Grid, Grids, MissionPlan, RobotProfile, SafetyRules, ScheduleState, ScheduleStateBuilder, Site};
use raster::Rasterizer;
use rustix::time::{ClockId, clock_gettime};
use std::path::{Path, PathBuf};
use std::process::Command;
use waypoints::{MissionPlanInput, MissionPlanOptions, MissionPlanner};

fn cpu_ms() -> f64 {
    let time = clock_gettime(ClockId::ProcessCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 / 1e6
}

fn main() {
    let (mut repeat, mut models) = (5, Vec::new());
    let mut words = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(word) = words.next() {
        match word.as_str() {
            "--repeat" => repeat = words.next().unwrap().parse().unwrap(),
            _ => models.push(PathBuf::from(word)),
        }
    }
    let home = tempfile::tempdir().unwrap();
    if models.is_empty() {
        models.push(office(home.path()));
    }
    println!("| model | reached | defaults | for 1,000 m2 | a waypoint for each room |\n|---|---|---|---|---|");
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(|| {
        models.iter().for_each(|model| measure(model, repeat));
    });
}

fn office(home: &Path) -> PathBuf {
    let script = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../scripts/office_model.py"));
    let model = home.join("office.ifc");
    assert!(Command::new("python3").arg(script).arg(&model).args(["--rooms", "57"]).status().unwrap().success());
    model
}

fn measure(model: &Path, repeat: usize) {
    let files = [SourceFile { path: model.to_owned(), bytes: std::fs::read(model).unwrap() }];
    let options = IngestOptions { prefer_last: true, allow_boxes: true, ..IngestOptions::default() };
    let site = ingest::ingest(&files, &options).unwrap();
    let site = Site::open(site.bytes()).unwrap();
    let built =
        ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), site.spaces.len()).finish();
    let schedule_state = ScheduleState::open(built.bytes()).unwrap();
    let mut rasterizer = Rasterizer::new(&site, &RobotProfile::DEFAULT, 0.05).unwrap();
    rasterizer.draw(&site, &schedule_state);
    let index = rasterizer.index(&site, &schedule_state, "default", &[], &SafetyRules::default()).finish();
    let index = Grids::open(index.bytes()).unwrap();
    let grids: Vec<Grid<'_>> = rasterizer.drawn().map(|grid| Grid::open(grid.archive).unwrap()).collect();
    let plan = |options: &MissionPlanOptions| {
        let (site, schedule_state, index) = (&site, &schedule_state, &index);
        let input = MissionPlanInput { site, schedule_state, index, grids: &grids, options };
        let run = || {
            let begun = cpu_ms();
            let plan = MissionPlanner::default().plan(&input);
            (cpu_ms() - begun, plan)
        };
        (0..repeat).map(|_| run()).min_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
    };
    let (with_scans_ms, plan_bytes) = plan(&MissionPlanOptions::default());
    let (centres_ms, _) = plan(&MissionPlanOptions::parse("waypoints = [\"centre\"]").unwrap());
    let plan = MissionPlan::open(plan_bytes.bytes()).unwrap();
    let reached_m2: f64 = plan.storeys.iter().map(|storey| storey.reached_m2).sum();
    println!(
        "| {} | {reached_m2:.0} m2 | {with_scans_ms:.0} ms | {:.0} ms | {centres_ms:.0} ms |",
        files[0].name(),
        with_scans_ms / reached_m2 * 1e3
    );
}
