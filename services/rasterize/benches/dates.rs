//! CPU time of drawing dates, against that of copying the grids that change: what `live` measures, on one thread, without daemons and bus.
//!
//! usage: cargo bench -p rasterize --bench dates -- [--worst N] [--dates FIRST..END] [MODEL.ifc]
//!
//! Without a model the site is the demo building 60 times, as in `live`. Each date is drawn on grids of the one before, as rasterize
//! does; all of them, or some by their numbers, are walked through twice.
#![expect(clippy::print_stdout, reason = "figures are what it is for")]
#![expect(clippy::unwrap_used, reason = "a benchmark stops where it fails")]

use ingest::{IngestOptions, SourceFile};
use messages::{ArchiveBuffer, ContentHash, RobotProfile, ScheduleState, Site};
use raster::Rasterizer;
use rustix::time::{ClockId, clock_gettime};
use schedule::{Overrides, Rules};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::Command;

fn cpu_ms() -> f64 {
    let time = clock_gettime(ClockId::ThreadCPUTime);
    time.tv_sec as f64 * 1e3 + time.tv_nsec as f64 / 1e6
}

/// A date that was drawn.
struct Step {
    at_s: i64,
    toggled: f64,
    grids: usize,
    draw_ms: f64,
    copy_ms: f64,
    memcpy_ms: f64,
}

impl Step {
    fn ratio(&self) -> f64 {
        (self.draw_ms + self.copy_ms) / self.memcpy_ms
    }
}

fn main() {
    let (mut worst, mut model, mut dates) = (5, None, 0..usize::MAX);
    let mut words = std::env::args().skip(1).filter(|a| a != "--bench");
    while let Some(word) = words.next() {
        match word.as_str() {
            "--worst" => worst = words.next().unwrap().parse().unwrap(),
            "--dates" => {
                let text = words.next().unwrap();
                let (first, end) = text.split_once("..").unwrap();
                dates = first.parse().unwrap()..end.parse().unwrap();
            }
            _ => model = Some(PathBuf::from(word)),
        }
    }
    let home = tempfile::tempdir().unwrap();
    let model = model.unwrap_or_else(|| tiled(home.path()));
    rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap().install(|| measure(&model, worst, &dates));
}

fn tiled(home: &Path) -> PathBuf {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let model = home.join("tiled.ifc");
    let tile = Command::new("python3")
        .args([root.join("scripts/tile_model.py"), root.join("config/demo/demo.ifc"), model.clone()])
        .status();
    assert!(tile.unwrap().success());
    model
}

fn measure(model: &Path, worst: usize, wanted: &Range<usize>) {
    let files = [SourceFile { path: model.to_owned(), bytes: std::fs::read(model).unwrap() }];
    let options = IngestOptions { prefer_last: true, allow_boxes: true, ..IngestOptions::default() };
    let site = ingest::ingest(&files, &options).unwrap();
    let site = Site::open(site.bytes()).unwrap();
    let timeline = schedule::evaluate(&site, &Rules::default(), &Overrides::default()).unwrap();
    let mut rasterizer = Rasterizer::new(&site, &RobotProfile::DEFAULT, 0.05).unwrap();
    let mut walk = Walk { copies: Vec::new(), memory: Vec::new(), hashes: Vec::new(), states: Vec::new() };
    let dates = timeline.instants_s();
    let dates = &dates[wanted.start..wanted.end.min(dates.len())];
    let mut pass = || -> Vec<Step> {
        let draw = |&at_s: &i64| {
            let state = timeline.schedule_state_at(Some(at_s)).finish();
            walk.step(&mut rasterizer, &site, &ScheduleState::open(state.bytes()).unwrap(), at_s)
        };
        // What is before the first date is no change by one date.
        dates.iter().map(draw).skip(1).collect()
    };
    let (first, again) = (pass(), pass());
    println!("{} elements, {} storeys, {} cells", site.elements.len(), site.map_storeys.len(), rasterizer.n_cells());
    report("for the first time", &first, worst);
    report("again", &again, worst);
}

/// Dates with at most 1 % of the elements toggled.
fn report(when: &str, steps: &[Step], worst: usize) {
    let small = steps.iter().filter(|step| step.grids > 0 && step.toggled <= 0.01);
    let mut small: Vec<&Step> = small.collect();
    small.sort_by(|a, b| a.ratio().total_cmp(&b.ratio()));
    let at = |p: f64| small[((small.len() - 1) as f64 * p).round() as usize].ratio();
    println!(
        "\n{} dates drawn {when}: (draw + copy) / memcpy p50 {:.1}, p90 {:.1}, p99 {:.1}",
        small.len(),
        at(0.5),
        at(0.9),
        at(0.99)
    );
    println!("| plan time, s | toggled | grids | draw | copy | memcpy | ratio |\n|---|---|---|---|---|---|---|");
    for step in small.iter().rev().take(worst) {
        println!(
            "| {} | {:.2} % | {} | {:.1} ms | {:.1} ms | {:.1} ms | {:.1} |",
            step.at_s,
            step.toggled * 100.0,
            step.grids,
            step.draw_ms,
            step.copy_ms,
            step.memcpy_ms,
            step.ratio()
        );
    }
}

/// What the bus would hold.
struct Walk {
    /// Memory of the last two samples of each grid, used in turn.
    memory: Vec<[ArchiveBuffer; 2]>,
    copies: Vec<Vec<u8>>,
    hashes: Vec<ContentHash>,
    states: Vec<u8>,
}

impl Walk {
    fn step(&mut self, rasterizer: &mut Rasterizer, site: &Site<'_>, state: &ScheduleState<'_>, at_s: i64) -> Step {
        let begun = cpu_ms();
        rasterizer.draw(site, state);
        let drawn = cpu_ms();
        let mut changed = Vec::new();
        for (k, grid) in rasterizer.drawn().enumerate() {
            if self.hashes.len() <= k {
                self.hashes.push(ContentHash::NONE);
                self.copies.push(vec![0; grid.archive.len()]);
                self.memory.push([0, 1].map(|_| ArchiveBuffer::copy_of(grid.archive)));
            }
            if std::mem::replace(&mut self.hashes[k], grid.content_hash) != grid.content_hash {
                let [next, last] = &mut self.memory[k];
                grid.copy_into(next.bytes_mut());
                std::mem::swap(next, last);
                changed.push(k);
            }
        }
        let copied = cpu_ms();
        for &k in &changed {
            self.copies[k].copy_from_slice(self.memory[k][1].bytes());
        }
        let memcpy_ms = cpu_ms() - copied;
        let states: Vec<u8> = (0..state.n_elements()).map(|k| state.effective(k) as u8).collect();
        let toggled = states.iter().zip(&self.states).filter(|(a, b)| a != b).count() as f64 / states.len() as f64;
        self.states = states;
        Step { at_s, toggled, grids: changed.len(), draw_ms: drawn - begun, copy_ms: copied - drawn, memcpy_ms }
    }
}
