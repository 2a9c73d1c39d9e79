//! Terrain with fewer triangles: vertices are taken out as long as the surface stays within a vertical distance of what it was.
//!
//! A vertex inside the surface is merged into a neighbour, which leaves the region around it to triangles of that neighbour. What the
//! surface moves by is largest at the vertex or where an old edge crosses a new one, so that it is computed, not sampled. Every triangle
//! carries a bound of how far the surface has moved in it, and no vertex is taken out that would bring a bound above the tolerance.
//! Vertices of borders, of folds and of vertical faces stay.
//!
//! # Source
//! Schroeder, Zarge, Lorensen, "Decimation of Triangle Meshes", SIGGRAPH 1992, with the error kept per triangle.

use std::collections::HashMap;

/// Vertices with more neighbours stay: the work for one grows with their square.
const MAX_NEIGHBOURS: usize = 24;

/// Passes over all vertices, of which each takes out a part of what can be taken out.
const MAX_PASSES: u32 = 40;

/// A pass that takes out a smaller share of the vertices is the last one.
const LEAST_SHARE: f64 = 0.005;

/// A surface with fewer triangles.
#[derive(Debug, Clone, PartialEq)]
pub struct Decimated {
    /// Vertex positions in tenths of a millimetre: some of those of the mesh.
    pub vertices: Vec<[i32; 3]>,
    /// Triangles, turned as in the mesh.
    pub triangles: Vec<[u32; 3]>,
    /// Bound of the vertical distance between both surfaces, in tenths of a millimetre.
    pub max_error: f64,
}

/// The surface with as few triangles as are found at a vertical distance of at most `tolerance` tenths of a millimetre.
///
/// Its border in plan is unchanged. The same mesh gives the same surface. Linear in triangles for each of at most 40 passes.
pub fn decimated(vertices: &[[i32; 3]], triangles: &[[u32; 3]], tolerance: i32) -> Decimated {
    let mut surface = Surface::welded(vertices, triangles);
    for pass in 0..MAX_PASSES {
        // Flat parts first: what is taken out early costs least of the tolerance.
        let allowed = f64::from(tolerance) * f64::from(pass + 1).min(8.0) / 8.0;
        let n_removed = surface.pass(allowed);
        if pass >= 8 && (n_removed as f64) < LEAST_SHARE * surface.vertices.len() as f64 {
            break;
        }
    }
    surface.finish()
}

struct Surface {
    vertices: Vec<[i32; 3]>,
    triangles: Vec<[u32; 3]>,
    /// Bound of the vertical distance from the first surface, by triangle.
    error: Vec<f32>,
    /// Vertices that stay: corners of triangles that are vertical or turned otherwise than most.
    stays: Vec<bool>,
    /// Sign of most triangles' area in plan.
    sign: i64,
}

/// The neighbours of a vertex, in their order around it, and the triangles between them.
#[derive(Default)]
struct Star {
    ring: Vec<u32>,
    triangles: Vec<u32>,
}

impl Surface {
    fn welded(vertices: &[[i32; 3]], triangles: &[[u32; 3]]) -> Self {
        let mut index_of: HashMap<[i32; 3], u32> = HashMap::with_capacity(vertices.len());
        let mut kept: Vec<[i32; 3]> = Vec::with_capacity(vertices.len());
        let index: Vec<u32> = vertices
            .iter()
            .map(|v| {
                *index_of.entry(*v).or_insert_with(|| {
                    kept.push(*v);
                    kept.len() as u32 - 1
                })
            })
            .collect();
        drop(index_of);
        let is_triangle = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
        let triangles: Vec<[u32; 3]> =
            triangles.iter().map(|t| t.map(|i| index[i as usize])).filter(is_triangle).collect();
        let signs = triangles.iter().map(|t| cross(t.map(|i| kept[i as usize])).signum());
        let sign = if signs.clone().sum::<i64>() < 0 { -1 } else { 1 };
        let mut stays = vec![false; kept.len()];
        for (t, own) in triangles.iter().zip(signs) {
            if own != sign {
                t.iter().for_each(|&v| stays[v as usize] = true);
            }
        }
        let error = vec![0.0; triangles.len()];
        Self { vertices: kept, triangles, error, stays, sign }
    }

    /// Takes out vertices of which no two are neighbours of one; returns how many.
    fn pass(&mut self, allowed: f64) -> usize {
        let (first, around) = self.incidence();
        let mut is_touched = vec![false; self.vertices.len()];
        let mut is_gone = vec![false; self.triangles.len()];
        let (mut star, mut n_removed) = (Star::default(), 0);
        for v in 0..self.vertices.len() {
            let own = &around[first[v] as usize..first[v + 1] as usize];
            if self.stays[v] || is_touched[v] || own.len() < 3 || own.len() > MAX_NEIGHBOURS {
                continue;
            }
            if !self.star(v as u32, own, &mut star) || star.ring.iter().any(|&w| is_touched[w as usize]) {
                continue;
            }
            let Some((into, error)) = self.best_neighbour(v as u32, &star, allowed) else { continue };
            for &t in &star.triangles {
                let triangle = &mut self.triangles[t as usize];
                if triangle.contains(&into) {
                    is_gone[t as usize] = true;
                } else {
                    triangle.iter_mut().filter(|c| **c == v as u32).for_each(|c| *c = into);
                    self.error[t as usize] = error as f32;
                }
            }
            is_touched[v] = true;
            star.ring.iter().for_each(|&w| is_touched[w as usize] = true);
            n_removed += 1;
        }
        let mut gone = is_gone.iter();
        self.error.retain(|_| gone.next() == Some(&false));
        let mut gone = is_gone.iter();
        self.triangles.retain(|_| gone.next() == Some(&false));
        n_removed
    }

    /// The triangles at each vertex: where its list begins, and all lists.
    fn incidence(&self) -> (Vec<u32>, Vec<u32>) {
        let mut first = vec![0u32; self.vertices.len() + 1];
        self.triangles.iter().flatten().for_each(|&v| first[v as usize + 1] += 1);
        for v in 0..self.vertices.len() {
            first[v + 1] += first[v];
        }
        let mut next = first.clone();
        let mut around = vec![0u32; self.triangles.len() * 3];
        for (t, triangle) in (0u32..).zip(&self.triangles) {
            for &v in triangle {
                around[next[v as usize] as usize] = t;
                next[v as usize] += 1;
            }
        }
        (first, around)
    }

    /// Fills the star of a vertex; false if its triangles do not lie around it once.
    fn star(&self, v: u32, own: &[u32], star: &mut Star) -> bool {
        star.ring.clear();
        star.triangles.clear();
        let side = |t: u32| {
            let c = self.triangles[t as usize];
            let at = c.iter().position(|&i| i == v).unwrap_or(0);
            [c[(at + 1) % 3], c[(at + 2) % 3]]
        };
        let [start, mut at] = side(own[0]);
        star.ring.push(start);
        star.triangles.push(own[0]);
        while at != start {
            let mut next = own.iter().filter(|&&t| side(t)[0] == at);
            let (Some(&t), None) = (next.next(), next.next()) else { return false };
            star.ring.push(at);
            star.triangles.push(t);
            at = side(t)[1];
            if star.ring.len() > own.len() {
                return false;
            }
        }
        star.ring.len() == own.len()
    }

    /// The neighbour into which a vertex can be merged with the smallest error, and the bound of the error then.
    fn best_neighbour(&self, v: u32, star: &Star, allowed: f64) -> Option<(u32, f64)> {
        let before = star.triangles.iter().map(|&t| f64::from(self.error[t as usize])).fold(0.0, f64::max);
        let left = allowed - before;
        let mut best: Option<(u32, f64)> = None;
        for k in 0..star.ring.len() {
            let most = best.map_or(left, |b| b.1);
            let moved = self.moved(v, star, k).filter(|moved| *moved <= most);
            if let Some(moved) = moved.filter(|moved| best.is_none_or(|b| *moved < b.1)) {
                best = Some((star.ring[k], moved));
            }
        }
        best.map(|(into, moved)| (into, before + moved))
    }

    /// Largest vertical distance between the star and the fan of its `k`-th neighbour; `None` if that is folded.
    fn moved(&self, v: u32, star: &Star, k: usize) -> Option<f64> {
        let n = star.ring.len();
        let at = |i: usize| self.vertices[star.ring[(k + i) % n] as usize];
        let (apex, centre) = (at(0), self.vertices[v as usize]);
        let mut most = None;
        for i in 1..n - 1 {
            let triangle = [apex, at(i), at(i + 1)];
            if cross(triangle).signum() != self.sign {
                return None;
            }
            if most.is_none() {
                most = height_in(&triangle, centre).map(|z| (z - f64::from(centre[2])).abs());
            }
        }
        let mut most = most?;
        // New edges are those from the apex to the neighbours that are not beside it.
        for i in 2..n - 1 {
            for j in (1..n).filter(|&j| j != i) {
                most = most.max(gap_at_crossing([apex, at(i)], [centre, at(j)]).unwrap_or(0.0));
            }
        }
        Some(most)
    }

    fn finish(self) -> Decimated {
        const UNUSED: u32 = u32::MAX;
        let mut index = vec![UNUSED; self.vertices.len()];
        let mut vertices = Vec::new();
        let triangles = self
            .triangles
            .iter()
            .map(|t| {
                t.map(|v| {
                    if index[v as usize] == UNUSED {
                        index[v as usize] = vertices.len() as u32;
                        vertices.push(self.vertices[v as usize]);
                    }
                    index[v as usize]
                })
            })
            .collect();
        let max_error = self.error.iter().copied().fold(0.0, f32::max);
        // Errors are held in fewer digits than they are computed in.
        Decimated { vertices, triangles, max_error: f64::from(max_error) * (1.0 + 1e-6) }
    }
}

/// Twice the signed area in plan.
fn cross([a, b, c]: [[i32; 3]; 3]) -> i64 {
    let d = |p: [i32; 3], k: usize| i64::from(p[k]) - i64::from(a[k]);
    d(b, 0) * d(c, 1) - d(b, 1) * d(c, 0)
}

/// Height of a triangle at a place that it covers in plan.
fn height_in(triangle: &[[i32; 3]; 3], at: [i32; 3]) -> Option<f64> {
    let whole = cross(*triangle);
    let [a, b, c] = *triangle;
    let weights = [cross([at, b, c]), cross([a, at, c]), cross([a, b, at])];
    let is_inside = whole != 0 && weights.iter().all(|w| w.signum() * whole.signum() >= 0);
    let height = |(w, v): (&i64, &[i32; 3])| *w as f64 / whole as f64 * f64::from(v[2]);
    is_inside.then(|| weights.iter().zip(triangle).map(height).sum())
}

/// Vertical distance of two edges where they cross in plan; `None` where they do not.
fn gap_at_crossing([p, q]: [[i32; 3]; 2], [r, s]: [[i32; 3]; 2]) -> Option<f64> {
    let [of_r, of_s] = [cross([p, q, r]), cross([p, q, s])];
    let [of_p, of_q] = [cross([r, s, p]), cross([r, s, q])];
    let crosses = of_r.signum() * of_s.signum() < 0 && of_p.signum() * of_q.signum() < 0;
    let share = |a: i64, b: i64| a as f64 / (a as f64 - b as f64);
    let height = |a: [i32; 3], b: [i32; 3], t: f64| f64::from(a[2]) + (f64::from(b[2]) - f64::from(a[2])) * t;
    crosses.then(|| (height(p, q, share(of_p, of_q)) - height(r, s, share(of_r, of_s))).abs())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A field of n by n vertices with these heights, a metre apart, its squares cut one way or the other.
    fn field(
        n: usize,
        height: impl Fn(usize, usize) -> i32,
        cut: impl Fn(usize) -> bool,
    ) -> (Vec<[i32; 3]>, Vec<[u32; 3]>) {
        let vertices =
            (0..n * n).map(|k| [(k % n) as i32 * 10_000, (k / n) as i32 * 10_000, height(k % n, k / n)]).collect();
        let squares = (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| (y * n + x) as u32));
        let triangles = squares.flat_map(|k| {
            let [a, b, c, d] = [k, k + 1, k + 1 + n as u32, k + n as u32];
            if cut(k as usize) { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        });
        (vertices, triangles.collect())
    }

    fn height_at(vertices: &[[i32; 3]], triangles: &[[u32; 3]], at: [i32; 3]) -> Option<f64> {
        triangles.iter().find_map(|t| height_in(&t.map(|i| vertices[i as usize]), at))
    }

    fn area(vertices: &[[i32; 3]], triangles: &[[u32; 3]]) -> i64 {
        triangles.iter().map(|t| cross(t.map(|i| vertices[i as usize]))).sum()
    }

    #[test]
    fn a_plane_keeps_little_more_than_its_border_and_a_ridge_stays() {
        let (v, t) = field(21, |x, _| 100 * x as i32, |_| true);
        let plane = decimated(&v, &t, 50);
        // Some vertices beside the border stay, because triangles between corners on one line have no area.
        assert!(plane.max_error < 1e-6 && (80..110).contains(&plane.vertices.len()), "{plane:?}");
        assert!(plane.triangles.len() < t.len() / 5);
        let (v, t) = field(21, |x, _| if x == 10 { 5_000 } else { 0 }, |_| true);
        let ridge = decimated(&v, &t, 50);
        assert!(ridge.max_error <= 50.0 && ridge.triangles.len() < t.len() / 2, "{}", ridge.triangles.len());
        assert!((height_at(&ridge.vertices, &ridge.triangles, [100_000, 95_000, 0]).unwrap() - 5_000.0).abs() <= 50.0);
    }

    #[test]
    fn folds_vertical_faces_and_loose_triangles_are_left_as_they_are() {
        let vertices = [[0, 0, 0], [10_000, 0, 0], [0, 10_000, 0], [10_000, 0, 9_000], [3_000, 3_000, 500]];
        let triangles = [[0, 1, 2], [0, 1, 3], [0, 2, 4], [1, 1, 2]];
        let found = decimated(&vertices, &triangles, 1_000);
        assert_eq!((found.triangles.len(), found.max_error), (3, 0.0));
        assert_eq!(decimated(&[], &[], 100).triangles.len(), 0);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(64))]
        #[test]
        fn any_triangles_are_simplified_without_a_panic(
            vertices in prop::collection::vec(prop::array::uniform3(prop_oneof![
                6 => -9i32..9, 1 => prop::sample::select(vec![-1_000_000_000, 1_000_000_000])
            ]), 3..12),
            picks in prop::collection::vec(prop::array::uniform3(any::<prop::sample::Index>()), 0..30),
        ) {
            let triangles: Vec<[u32; 3]> =
                picks.iter().map(|t| t.map(|i| i.index(vertices.len()) as u32)).collect();
            let found = decimated(&vertices, &triangles, 5);
            prop_assert!(found.max_error <= 5.0001 && found.triangles.len() <= triangles.len());
        }

        #[test]
        fn the_surface_stays_within_the_error_that_is_told_and_covers_the_same_plan(
            heights in prop::collection::vec(-600i32..600, 14 * 14),
            smooth in 1i32..40,
            tolerance in 1i32..400,
            cuts in any::<u64>(),
            places in prop::collection::vec((0i32..130_000, 0i32..130_000), 40),
        ) {
            let (v, t) = field(14, |x, y| heights[y * 14 + x] / smooth + (x * x) as i32 * 7, |k| cuts >> (k % 64) & 1 == 1);
            let found = decimated(&v, &t, tolerance);
            prop_assert!(found.max_error <= f64::from(tolerance) * 1.000_01);
            prop_assert_eq!(area(&v, &t), area(&found.vertices, &found.triangles));
            prop_assert!(found.triangles.iter().all(|t| cross(t.map(|i| found.vertices[i as usize])) > 0));
            prop_assert!(found.vertices.iter().all(|p| v.contains(p)));
            let places = places.into_iter().map(|(x, y)| [x, y, 0]).chain(v.iter().copied());
            for at in places {
                let (before, after) = (height_at(&v, &t, at), height_at(&found.vertices, &found.triangles, at));
                let gap = (before.unwrap() - after.unwrap()).abs();
                prop_assert!(gap <= found.max_error + 1e-3, "{gap} at {at:?}, told {}", found.max_error);
            }
        }
    }
}
