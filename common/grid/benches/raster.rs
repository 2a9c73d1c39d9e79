//! Cost of rasterising polygons: linear in boundary cells, independent of area.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use geometry::{Bounds, FillRule, MultiPolygon, union};
use grid::{GridSpec, Growth, covered_cells, overlapped_cells, sparse_distances, squared_distances};
use std::hint::black_box;

/// A regular polygon of `n` corners, 10 m in radius.
fn polygon(n: u32) -> MultiPolygon {
    let corner = |k: u32| {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(n);
        [(100_000.0 * libm::cos(angle)).round() as i32, (100_000.0 * libm::sin(angle)).round() as i32]
    };
    union(&[(0..n).map(corner).collect()], FillRule::NonZero)
}

fn raster(c: &mut Criterion) {
    let bounds = Bounds { min: [-100_000; 2], max: [100_000; 2] };
    let mut group = c.benchmark_group("cells of a 20 m polygon");
    for resolution_m in [0.1, 0.05, 0.025] {
        let Ok(spec) = GridSpec::around(bounds, 10_000, resolution_m) else { continue };
        for n in [4, 400] {
            let area = polygon(n);
            let id = |what: &str| BenchmarkId::new(what, format!("{n} corners at {resolution_m} m"));
            group.bench_function(id("overlapped"), |b| b.iter(|| overlapped_cells(black_box(&area), &[], &spec)));
            group.bench_function(id("covered"), |b| b.iter(|| covered_cells(black_box(&area), &spec)));
        }
    }
    group.finish();
}

fn distances(c: &mut Criterion) {
    let mut group = c.benchmark_group("squared distances");
    for side in [256usize, 512, 1024] {
        let marked: Vec<bool> = (0..side * side).map(|i| i % 97 == 0).collect();
        group.throughput(criterion::Throughput::Elements((side * side) as u64));
        group.bench_function(BenchmarkId::from_parameter(side), |b| {
            b.iter(|| squared_distances(black_box(&marked), side))
        });
        // Three quarters are outside of the building, and marked.
        let half = side / 2;
        let mostly: Vec<bool> = (0..side * side).map(|i| half <= i % side || half <= i / side || marked[i]).collect();
        group.bench_function(BenchmarkId::new("dense, mostly outside", side), |b| {
            b.iter(|| squared_distances(black_box(&mostly), side))
        });
        group.bench_function(BenchmarkId::new("sparse, mostly outside", side), |b| {
            b.iter(|| sparse_distances(black_box(&mostly), side))
        });
    }
    group.finish();
}

/// True of some cells, by column and row.
type At = fn(usize, usize) -> bool;

/// Margins in a window of 574 x 574 cells: rooms of 80 cells behind walls of 4, with a door of 20 each.
fn margins(c: &mut Criterion) {
    const SIDE: usize = 574;
    const WORK: u8 = 1;
    const FREE: u8 = 2;
    let is_wall = |x: usize, y: usize| (x % 84 < 4 && !(30..50).contains(&(y % 84))) || y % 84 < 4 && x % 84 >= 4;
    let regions = |work: At| -> Vec<u8> {
        let cell = |i: usize| match (i % SIDE, i / SIDE) {
            (x, y) if work(x, y) => WORK,
            (x, y) if is_wall(x, y) => 0,
            _ => FREE,
        };
        (0..SIDE * SIDE).map(cell).collect()
    };
    let mut growth = Growth::default();
    let mut group = c.benchmark_group("margins in a window");
    group.throughput(criterion::Throughput::Elements((SIDE * SIDE) as u64));
    let cases: [(&str, f64, At); 4] = [
        ("no work", 30.0, |_, _| false),
        ("work at one wall", 30.0, |x, y| (84..88).contains(&x) && y < 84),
        ("work at every third wall", 30.0, |x, _| x % 252 < 4),
        ("work at every third wall, a small margin", 6.0, |x, _| x % 252 < 4),
    ];
    for (name, reach_cells, work) in cases {
        let cells = regions(work);
        group.bench_function(name, |b| {
            b.iter(|| {
                growth.load(SIDE, black_box(&cells).chunks_exact(SIDE), |cell| cell);
                growth.grow(WORK, FREE, reach_cells);
                growth.rows().flatten().filter(|cell| **cell & grid::REACHED != 0).count()
            })
        });
    }
    group.finish();
}

criterion_group!(benches, raster, distances, margins);
criterion_main!(benches);
