//! Cost of a footprint: wall, wall with openings, round column, heap of boxes, finely meshed sphere.

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use geometry::{MeshView, Slab, footprint, is_closed};
use std::hint::black_box;

type Mesh = (Vec<[i32; 3]>, Vec<[u32; 3]>);

const SLAB: Slab = Slab { lo: 500, hi: 12_500 };

fn append_box(mesh: &mut Mesh, min: [i32; 3], max: [i32; 3]) {
    let base = mesh.0.len() as u32;
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    mesh.0.extend((0..8).map(|i| [0, 1, 2].map(|k| if i >> k & 1 == 1 { max[k] } else { min[k] })));
    mesh.1.extend(
        quads.iter().flat_map(|q: &[u32; 4]| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]].map(|t| t.map(|i| i + base))),
    );
}

/// `n` boxes in a row that overlap.
fn boxes(n: i32) -> Mesh {
    let mut mesh = Mesh::default();
    for k in 0..n {
        append_box(
            &mut mesh,
            [k * 700, k % 3 * 500, k % 5 * 1_000],
            [k * 700 + 900, k % 3 * 500 + 900, k % 5 * 1_000 + 4_000],
        );
    }
    mesh
}

/// A ball of 1 m around the middle of the slab, `n` by `2 n` quads.
fn ball(n: usize) -> Mesh {
    let at = |i: usize, j: usize| {
        let (polar, around) = (std::f64::consts::PI * i as f64 / n as f64, std::f64::consts::PI * j as f64 / n as f64);
        let (r, z) = (5_000.0 * libm::sin(polar), 5_000.0 * libm::cos(polar));
        [(r * libm::cos(around)).round() as i32, (r * libm::sin(around)).round() as i32, z.round() as i32 + 6_000]
    };
    let vertices = (0..=n).flat_map(|i| (0..2 * n).map(move |j| at(i, j))).collect();
    let index = |i: usize, j: usize| (i * 2 * n + j % (2 * n)) as u32;
    let quad = |i: usize, j: usize| {
        let (a, b, c, d) = (index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1));
        [[a, b, c], [a, c, d]]
    };
    (vertices, (0..n).flat_map(|i| (0..2 * n).flat_map(move |j| quad(i, j))).collect())
}

fn footprints(c: &mut Criterion) {
    let mut group = c.benchmark_group("footprint");
    let shapes = [("box", boxes(1)), ("20 boxes", boxes(20)), ("ball of 1k", ball(16)), ("ball of 16k", ball(64))];
    for (name, (vertices, triangles)) in &shapes {
        group.throughput(Throughput::Elements(triangles.len() as u64));
        let mesh = MeshView { vertices, triangles, closed: is_closed(vertices, triangles) };
        group.bench_function(BenchmarkId::from_parameter(name), |b| b.iter(|| footprint([black_box(mesh)], SLAB)));
    }
    group.finish();
}

criterion_group!(benches, footprints);
criterion_main!(benches);
