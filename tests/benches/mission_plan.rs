//! Quality and time of waypoint planning against one scan per space centroid: a JSON document per storey on standard
//! output; with `--instances DIR` the set-cover instances, for an exact solver.
//!
//! usage: cargo bench -p end-to-end --bench mission_plan -- [--instances DIR] [--quality N] [--tour-kicks N]
//! MODEL.ifc...

#![expect(clippy::print_stdout, reason = "figures are what it is for")]

use ingest::{IngestOptions, SourceFile};
use messages::{Grid, Grids, MissionPlan, RobotProfile, ScheduleState, ScheduleStateBuilder, Site};
use raster::Rasterizer;
use rustix::time::{ClockId, clock_gettime};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::time::Instant;
use waypoints::{MissionPlanInput, MissionPlanOptions, MissionPlanner, SetCoverInstance};

struct Arguments {
    models: Vec<PathBuf>,
    instances: Option<PathBuf>,
    quality: u32,
    tour_kicks: Option<u32>,
}

fn main() {
    let mut arguments = Arguments { models: Vec::new(), instances: None, quality: 1, tour_kicks: None };
    let mut words = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(word) = words.next() {
        let mut value = || words.next().expect("an option has a value");
        match word.as_str() {
            "--instances" => arguments.instances = Some(PathBuf::from(value())),
            "--quality" => arguments.quality = value().parse().expect("a number"),
            "--tour-kicks" => arguments.tour_kicks = Some(value().parse().expect("a number")),
            _ => arguments.models.push(PathBuf::from(word)),
        }
    }
    for model in &arguments.models {
        measure(&arguments, model);
    }
}

fn measure(arguments: &Arguments, model: &Path) {
    let files = [SourceFile { path: model.to_owned(), bytes: std::fs::read(model).expect("the model can be read") }];
    let name = files[0].name();
    let ingest = IngestOptions { prefer_last: true, allow_boxes: true, ..IngestOptions::default() };
    let Ok(site) = ingest::ingest(&files, &ingest) else { return };
    let site = Site::open(site.bytes()).expect("a site");
    let schedule_state =
        ScheduleStateBuilder::everything_built(site.content_hash(), site.elements.len(), site.spaces.len()).finish();
    let schedule_state = ScheduleState::open(schedule_state.bytes()).expect("a schedule state");
    let mut rasterizer = Rasterizer::new(&site, &RobotProfile::DEFAULT, 0.05).expect("a resolution that fits");
    rasterizer.draw(&site, &schedule_state);
    let index = rasterizer.index(&site, &schedule_state, "default", &[], &messages::SafetyRules::default()).finish();
    let index = Grids::open(index.bytes()).expect("an index");
    let grids: Vec<Grid<'_>> = rasterizer.drawn().map(|g| Grid::open(g.archive).expect("a grid")).collect();
    let mut options = MissionPlanOptions::parse(&format!("[scan]\nquality = {}", arguments.quality)).expect("options");
    if let Some(kicks) = arguments.tour_kicks {
        options.tour_kicks = kicks;
    }
    let input = MissionPlanInput {
        site: &site,
        schedule_state: &schedule_state,
        index: &index,
        grids: &grids,
        options: &options,
    };

    // Storeys are measured one by one: planned alone, beside a planner that knows the others.
    let mut planner = MissionPlanner::default();
    let mission_plan_bytes = planner.plan(&input);
    let mission_plan = MissionPlan::open(mission_plan_bytes.bytes()).expect("a mission plan");
    let (wall, cpu) = (Instant::now(), cpu_s());
    let again = MissionPlanner::default().plan(&input);
    let (wall_s, cpu_s) = (wall.elapsed().as_secs_f64(), cpu_s() - cpu);
    assert_eq!(again.bytes(), mission_plan_bytes.bytes(), "a mission plan is a function of its input");
    let reached_m2: f64 = mission_plan.storeys.iter().map(|s| s.reached_m2).sum();
    eprintln!("{name}: {wall_s:.3} s, {cpu_s:.3} s CPU for {reached_m2:.0} m2");
    for (storey, (record, of)) in mission_plan.storeys.iter().zip(planner.instances(&input)).enumerate() {
        if record.n_faces == 0 {
            continue;
        }
        let instance = of.instance;
        let chosen = waypoints::cover(&instance, options.search_steps);
        if let Some(folder) = &arguments.instances {
            std::fs::create_dir_all(folder).expect("a folder");
            let document = json!({
                "sets": instance.sets, "groups": instance.groups, "goal": instance.goal,
                "group_goals": instance.group_goals, "chosen": chosen,
            });
            let path = folder.join(format!("{name}-{storey}.json"));
            std::fs::write(path, document.to_string()).expect("the instance can be written");
        }
        let centroid_seen = seen_by(&instance, &of.centroids);
        let share = |n: usize| n as f64 / f64::from(record.n_faces);
        let line = json!({
            "model": name, "storey": storey, "reached_m2": record.reached_m2, "storeys_in_run": mission_plan.storeys.len(),
            "faces": record.n_faces, "places": record.n_places, "scans": chosen.len(),
            "connecting": record.n_connecting, "coverage": share(seen_by(&instance, &chosen)),
            "centroids": of.centroids.len(), "centroid_coverage": share(centroid_seen),
            "tour_m": record.tour_m, "tour_bound_m": record.tour_bound_m,
            "building_wall_s": wall_s, "building_cpu_s": cpu_s, "building_m2": reached_m2,
        });
        println!("{line}");
    }
}

fn seen_by(instance: &SetCoverInstance, sets: &[u32]) -> usize {
    let mut seen = vec![false; instance.groups.len()];
    sets.iter().flat_map(|&set| &instance.sets[set as usize]).for_each(|&f| seen[f as usize] = true);
    seen.iter().filter(|s| **s).count()
}

/// CPU seconds of this process so far.
fn cpu_s() -> f64 {
    let now = clock_gettime(ClockId::ProcessCPUTime);
    now.tv_sec as f64 + now.tv_nsec as f64 / 1e9
}
