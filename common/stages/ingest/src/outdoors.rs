//! The map storey of the ground outdoors, where the site has terrain or roads.

use crate::diagnostics::add_diagnostic;
use crate::split_levels::MAX_MAP_STOREYS;
use frames::TENTHS_PER_M;
use geometry::{Bounds, MeshView, unit_normal, upward_triangles};
use ifc::{Diagnostic, DiagnosticCode, Severity};
use messages::{FloorKind, GroundClass, MapStoreyRecord, NONE, SiteBuilder};

/// Its name.
const NAME: &str = "Site";

/// Ground farther from everything else that the model has is left out.
const AROUND: i32 = 30 * TENTHS_PER_M;

/// Ground of less area in plan is none to drive on.
const MIN_AREA_M2: f64 = 10.0;

/// Roads level with the floor of a storey, within so much, are on the map of that storey.
const LEVEL: i32 = TENTHS_PER_M / 20;

/// Adds a map storey of terrain and roads after all others, none of which it changes. Its height is the median of the ground's, and
/// its GlobalId that of the building or site.
pub(crate) fn add_outdoors(builder: &mut SiteBuilder, global_id: &str) {
    let Some(bounds) = bounds_of_map(builder) else { return };
    let Some(floor_z_tenths) = height_of(builder, &bounds) else { return };
    if builder.map_storeys.len() == MAX_MAP_STOREYS {
        let message = "the ground outdoors has no map, because a site has at most 64 maps".to_owned();
        let code = DiagnosticCode::LevelsLeftOut;
        let diagnostic = Diagnostic { severity: Severity::Warning, code, entity: None, source: None, message };
        add_diagnostic(builder, NONE, &diagnostic);
        return;
    }
    let Bounds { min, max } = bounds;
    let record = MapStoreyRecord {
        global_id: builder.texts.add(global_id),
        name: builder.texts.add(NAME),
        floor_z_tenths,
        floor: FloorKind::Ground.into(),
        bounds_tenths: [min[0], min[1], max[0], max[1]],
    };
    builder.map_storeys.push(record);
}

/// Meshes of terrain and roads.
fn ground(builder: &SiteBuilder) -> impl Iterator<Item = (GroundClass, MeshView<'_>)> {
    let elements = builder.elements.iter().map(|e| (e.ground.get(), e.first_part, e.n_parts));
    let terrains = builder.terrains.iter().map(|t| (t.ground.get(), t.first_part, t.n_parts));
    let bodies = elements.chain(terrains).filter(|(class, ..)| class.is_outdoors());
    bodies.flat_map(|(class, first, n)| builder.meshes(first, n).map(move |mesh| (class, mesh)))
}

/// The part of the ground that can matter: around whatever is no terrain, or all of it where there is nothing else.
fn bounds_of_map(builder: &SiteBuilder) -> Option<Bounds> {
    let all = ground(builder).filter_map(|(_, mesh)| mesh.plan_bounds()).reduce(Bounds::joined)?;
    let stands = builder.elements.iter().filter(|e| e.n_parts > 0 && e.ground != GroundClass::Terrain);
    let elements = stands.map(|e| [e.min_tenths, e.max_tenths].map(|c| [c[0], c[1]]));
    let roads = builder.terrains.iter().filter(|t| t.ground == GroundClass::Road);
    let roads = roads.map(|t| [t.min_tenths, t.max_tenths].map(|c| [c[0], c[1]]));
    let matters = elements.chain(roads).map(|[min, max]| Bounds { min, max }).reduce(Bounds::joined);
    matters.map_or(Some(all), |matters| around(all, matters))
}

/// The part of the bounds of terrain that lies around something else; `None` if it lies elsewhere.
pub(crate) fn around(terrain: Bounds, Bounds { min, max }: Bounds) -> Option<Bounds> {
    let min = [0, 1].map(|k| terrain.min[k].max(min[k].saturating_sub(AROUND)));
    let max = [0, 1].map(|k| terrain.max[k].min(max[k].saturating_add(AROUND)));
    (min[0] < max[0] && min[1] < max[1]).then_some(Bounds { min, max })
}

/// The faces of a mesh on which one could stand: of a solid those that look up, of a sheet those of either side.
fn tops(mesh: MeshView<'_>) -> Vec<[[i32; 3]; 3]> {
    let is_gentle = |t: &[[i32; 3]; 3]| unit_normal(t).is_some_and(|n| n[2].abs() >= std::f64::consts::FRAC_1_SQRT_2);
    if mesh.closed {
        return upward_triangles(mesh, std::f64::consts::FRAC_PI_4).collect();
    }
    mesh.corners().filter(is_gentle).collect()
}

/// The median height of the ground by its area in plan; `None` if there is too little, or all of it is on the maps of other storeys.
fn height_of(builder: &SiteBuilder, bounds: &Bounds) -> Option<i32> {
    let floors: Vec<i32> = builder.map_storeys.iter().map(|s| s.floor_z_tenths).collect();
    let mut heights: Vec<(i32, f64)> = Vec::new();
    let mut other_m2 = 0.0;
    for (class, [a, b, c]) in ground(builder).flat_map(|(class, mesh)| tops(mesh).into_iter().map(move |t| (class, t)))
    {
        let side = |p: [i32; 3], k: usize| (f64::from(p[k]) - f64::from(a[k])) / f64::from(TENTHS_PER_M);
        let area_m2 = ((side(b, 0) * side(c, 1) - side(c, 0) * side(b, 1)) / 2.0).abs();
        let corners = Bounds::of([a, b, c].map(|p| [p[0], p[1]]));
        if area_m2 == 0.0 || !corners.is_some_and(|corners| corners.meets(bounds)) {
            continue;
        }
        let z = [a, b, c].map(|p| p[2]);
        heights.push(((z.iter().map(|&z| i64::from(z)).sum::<i64>() / 3) as i32, area_m2));
        let is_level = floors.iter().any(|floor| z.iter().all(|z| (z - floor).abs() <= LEVEL));
        other_m2 += if class == GroundClass::Terrain || !is_level { area_m2 } else { 0.0 };
    }
    if other_m2 < MIN_AREA_M2 {
        return None;
    }
    heights.sort_by_key(|(z, _)| *z);
    let half_m2 = heights.iter().map(|(_, area_m2)| area_m2).sum::<f64>() / 2.0;
    let mut below_m2 = 0.0;
    heights
        .iter()
        .find(|(_, area_m2)| {
            below_m2 += area_m2;
            below_m2 >= half_m2
        })
        .map(|(z, _)| *z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::{PartRecord, TerrainRecord};

    /// Adds a sheet over a rectangle in metres, at one height in the west and another one in the east, looking down.
    fn sheet([x0, y0, x1, y1]: [i32; 4], [west, east]: [i32; 2], builder: &mut SiteBuilder) -> u32 {
        let corner = |x: i32, y: i32, z: i32| [x * TENTHS_PER_M, y * TENTHS_PER_M, z];
        let first_vertex = builder.vertices.len() as u32;
        builder.vertices.extend([
            corner(x0, y0, west),
            corner(x1, y0, east),
            corner(x1, y1, east),
            corner(x0, y1, west),
        ]);
        builder.parts.push(PartRecord {
            first_vertex,
            n_vertices: 4,
            first_triangle: builder.triangles.len() as u32,
            n_triangles: 2,
            closed: 0,
            colour: 0,
        });
        builder.triangles.extend([[0, 2, 1], [0, 3, 2]]);
        builder.parts.len() as u32 - 1
    }

    fn terrain(class: GroundClass, bounds: [i32; 4], heights: [i32; 2], builder: &mut SiteBuilder) {
        let first_part = sheet(bounds, heights, builder);
        let [x0, y0, x1, y1] = bounds.map(|c| c * TENTHS_PER_M);
        let (min_tenths, max_tenths) = ([x0, y0, heights[0]], [x1, y1, heights[1]]);
        let ground = class.into();
        let record =
            TerrainRecord { first_part, n_parts: 1, ground, min_tenths, max_tenths, ..bytemuck::Zeroable::zeroed() };
        builder.terrains.push(record);
    }

    fn outdoors(builder: &mut SiteBuilder) -> Option<MapStoreyRecord> {
        let n = builder.map_storeys.len();
        add_outdoors(builder, "");
        builder.map_storeys.get(n).copied()
    }

    #[test]
    fn terrain_alone_is_mapped_whole_at_its_median_height() {
        let mut builder = SiteBuilder::default();
        terrain(GroundClass::Terrain, [0, 0, 100, 50], [0, 100_000], &mut builder);
        let storey = outdoors(&mut builder).unwrap();
        assert_eq!(storey.bounds_tenths, [0, 0, 1_000_000, 500_000]);
        assert!(storey.floor == FloorKind::Ground && (30_000..=70_000).contains(&storey.floor_z_tenths));
    }

    #[test]
    fn it_does_not_matter_which_way_a_sheet_is_turned() {
        let mut builder = SiteBuilder::default();
        terrain(GroundClass::Terrain, [0, 0, 100, 50], [0, -100_000], &mut builder);
        builder.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        assert!(outdoors(&mut builder).is_some());
    }

    #[test]
    fn of_large_terrain_what_lies_around_everything_else_is_mapped() {
        let mut builder = SiteBuilder::default();
        terrain(GroundClass::Terrain, [-500, -500, 500, 500], [0, 0], &mut builder);
        terrain(GroundClass::Road, [0, 0, 40, 6], [0, 0], &mut builder);
        assert_eq!(outdoors(&mut builder).unwrap().bounds_tenths, [-300_000, -300_000, 700_000, 360_000]);
    }

    #[test]
    fn roads_level_with_a_storey_and_slivers_have_no_map() {
        let mut builder = SiteBuilder::default();
        builder.map_storeys.push(MapStoreyRecord { floor_z_tenths: 100, ..bytemuck::Zeroable::zeroed() });
        terrain(GroundClass::Road, [0, 0, 40, 6], [0, 0], &mut builder);
        assert!(outdoors(&mut builder).is_none());
        terrain(GroundClass::Terrain, [0, 0, 3, 3], [0, 0], &mut builder);
        assert!(outdoors(&mut builder).is_none());
        terrain(GroundClass::Terrain, [3, 0, 6, 3], [0, 0], &mut builder);
        assert!(outdoors(&mut builder).is_some());
    }
}
