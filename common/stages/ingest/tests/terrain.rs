//! Terrain in every form in which files have it, and terrain that is broken.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

#[path = "support/terrain_file.rs"]
mod terrain_file;

use ingest::{IngestOptions, SourceFile, ingest};
use messages::{ArchiveBuffer, GroundClass, Site};
use terrain_file::{Form, TerrainFile, field};

/// A vertex of a site lies this near to where the file has it, in metres.
const LOSS_M: f64 = 0.000_5;

fn site(file: &TerrainFile) -> ArchiveBuffer {
    let source = SourceFile { path: "terrain.ifc".into(), bytes: file.text().into_bytes() };
    let options = IngestOptions { allow_boxes: true, ..IngestOptions::default() };
    ingest(&[source], &options).unwrap()
}

/// Triangles of the ground of a site in the world, in metres, and its class.
fn ground(site: &Site<'_>) -> (Vec<[[f64; 3]; 3]>, GroundClass) {
    let shift = site.head.map_from_world_m;
    let back = |v: [i32; 3]| [0, 1, 2].map(|k| f64::from(v[k]) / 1e4 - shift[k]);
    let elements = site.elements.iter().filter(|e| e.ground.get() != GroundClass::None);
    let meshes = elements.clone().flat_map(|e| site.element_meshes(e));
    let meshes = meshes.chain(site.terrains.iter().flat_map(|t| site.terrain_meshes(t)));
    let triangles = meshes.flat_map(|mesh| mesh.corners().map(|t| t.map(back)).collect::<Vec<_>>()).collect();
    let found = elements.map(|e| e.ground.get()).chain(site.terrains.iter().map(|t| t.ground.get())).next();
    (triangles, found.unwrap_or(GroundClass::None))
}

fn diagnostics(site: &Site<'_>) -> Vec<(&'static str, String)> {
    site.diagnostics.iter().map(|d| (d.code.get().name(), site.text(d.message).to_owned())).collect()
}

/// Every triangle of the file is in the site, at its place.
fn check(file: &TerrainFile, class: GroundClass) {
    let archive = site(file);
    let site = Site::open(archive.bytes()).unwrap();
    let (triangles, found) = ground(&site);
    let what = format!("{file:?}\n{:?}", diagnostics(&site));
    assert_eq!(found, class, "{what}");
    let is_near = |a: &[f64; 3], b: &[f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() <= LOSS_M);
    for t in &file.triangles {
        let corners = t.map(|k| file.points[k as usize - 1]);
        let is_it = |other: &&[[f64; 3]; 3]| corners.iter().all(|c| other.iter().any(|o| is_near(c, o)));
        assert_eq!(triangles.iter().filter(is_it).count(), 1, "{corners:?} of {what}");
    }
    let n_more = if file.form == Form::Brep { usize::MAX } else { file.triangles.len() };
    assert!(triangles.len() <= n_more, "{what}");
}

#[test]
fn terrain_is_read_in_every_form_on_every_owner() {
    let owners = [
        ("IFCGEOGRAPHICELEMENT", "$,.TERRAIN.", GroundClass::Terrain),
        ("IFCGEOGRAPHICELEMENT", "$,$", GroundClass::Terrain),
        ("IFCSITE", "$,$,$,$,$,$,$", GroundClass::Terrain),
        ("IFCGEOTECHNICALSTRATUM", "$,.SOLID.", GroundClass::Terrain),
        ("IFCEARTHWORKSFILL", "$,.EMBANKMENT.", GroundClass::Terrain),
        ("IFCPAVEMENT", "$,.FLEXIBLE.", GroundClass::Road),
        ("IFCCOURSE", "$,.PAVEMENT.", GroundClass::Road),
        ("IFCROAD", "$,.ELEMENT.,$", GroundClass::Road),
        ("IFCROADPART", "$,.ELEMENT.,.LONGITUDINAL.,.CARRIAGEWAY.", GroundClass::Road),
    ];
    for form in Form::ALL {
        for (entity, rest, class) in owners {
            check(&TerrainFile { owner: (entity, rest), ..TerrainFile::slope(form) }, class);
        }
    }
}

#[test]
fn terrain_of_ifc2x3_is_the_shape_of_the_site() {
    for form in [Form::ShellBased, Form::FaceBased, Form::Brep] {
        let owner = ("IFCSITE", "$,.ELEMENT.,$,$,$,$,$");
        check(&TerrainFile { schema: "IFC2X3", owner, ..TerrainFile::slope(form) }, GroundClass::Terrain);
    }
}

#[test]
fn any_name_of_the_representation_is_read_but_those_of_boxes_and_axes() {
    for identifier in ["Surface", "FootPrint", "Facetation", "Terrain", "Reference"] {
        let owner = ("IFCSITE", "$,$,$,$,$,$,$");
        check(&TerrainFile { identifier, owner, ..TerrainFile::slope(Form::Network) }, GroundClass::Terrain);
        check(&TerrainFile { identifier, ..TerrainFile::slope(Form::ShellBased) }, GroundClass::Terrain);
    }
    let archive = site(&TerrainFile { identifier: "Axis", ..TerrainFile::slope(Form::Network) });
    assert!(ground(&Site::open(archive.bytes()).unwrap()).0.is_empty());
}

#[test]
fn coordinates_of_national_grids_lose_less_than_a_millimetre() {
    for unit_m in [1.0, 0.001] {
        for form in Form::ALL {
            for owner in [("IFCGEOGRAPHICELEMENT", "$,.TERRAIN."), ("IFCSITE", "$,$,$,$,$,$,$")] {
                let (points, triangles) =
                    field(4, 700.123_4, [4_467_812.345_6, 5_331_234.567_8], |x, y| 512.123_4 + x * 0.013 + y * 0.007);
                let file = TerrainFile { unit_m, owner, points, triangles, ..TerrainFile::slope(form) };
                check(&file, GroundClass::Terrain);
            }
        }
    }
}

#[test]
fn triangles_that_a_network_flags_as_voids_and_holes_are_left_out() {
    let mut file = TerrainFile::slope(Form::Network);
    let mut flags = vec![0; file.triangles.len()];
    (flags[3], flags[4], flags[5], flags[6]) = (-1, -2, 7, 2);
    file.flags = Some(flags);
    let archive = site(&file);
    let (triangles, _) = ground(&Site::open(archive.bytes()).unwrap());
    assert_eq!(triangles.len(), file.triangles.len() - 2);
    let removed = file.triangles.drain(3..5).collect::<Vec<_>>();
    let corners = removed[0].map(|k| file.points[k as usize - 1]);
    assert!(
        !triangles.iter().any(|t| t.iter().all(|c| corners.iter().any(|r| (c[0] - r[0]).hypot(c[1] - r[1]) < 0.01)))
    );
}

/// A pit of 6 x 6 m down to 76 m in the middle of the slope, which voids the terrain or nothing.
fn pit(form: Form, voids: &str) -> TerrainFile {
    let more = format!(
        "#1000=IFCEARTHWORKSCUT('cut',$,'Pit',$,$,#7,#1001,$,.EXCAVATION.);#1001=IFCPRODUCTDEFINITIONSHAPE($,$,(#1002));
         #1002=IFCSHAPEREPRESENTATION(#2,'Body','SweptSolid',(#1003));#1003=IFCEXTRUDEDAREASOLID(#1004,#1006,#1005,9.);
         #1004=IFCRECTANGLEPROFILEDEF(.AREA.,$,$,6.,6.);#1005=IFCDIRECTION((0.,0.,1.));#1006=IFCAXIS2PLACEMENT3D(#1007,$,$);
         #1007=IFCCARTESIANPOINT((110.,60.,76.));{voids}"
    );
    TerrainFile { more, ..TerrainFile::slope(form) }
}

#[test]
fn a_cut_of_earthworks_that_voids_nothing_is_told_and_leaves_the_ground_as_it_is() {
    for form in [Form::Network, Form::Brep] {
        let archive = site(&pit(form, ""));
        let site = Site::open(archive.bytes()).unwrap();
        let told = diagnostics(&site);
        assert!(told.iter().any(|d| d.0 == "earthworks_not_cut"), "{told:?}");
        let area: f64 = ground(&site).0.iter().map(|t| plan_area(t).max(0.0)).sum();
        assert!((area - 400.0).abs() < 1e-3, "{area} of {form:?}: {told:?}");
    }
}

#[test]
fn a_cut_of_earthworks_is_a_hole_in_a_surface_and_a_pit_in_a_solid() {
    for form in [Form::Network, Form::Brep] {
        let archive = site(&pit(form, "#1008=IFCRELVOIDSELEMENT('voids',$,$,$,#10,#1000);"));
        let site = Site::open(archive.bytes()).unwrap();
        let triangles = ground(&site).0;
        let is_floor = |t: &&[[f64; 3]; 3]| t.iter().all(|v| (v[2] - 76.0).abs() < 1e-3);
        let floor: f64 = triangles.iter().filter(is_floor).map(plan_area).sum();
        let above: f64 = triangles.iter().filter(|t| !is_floor(t)).map(|t| plan_area(t).max(0.0)).sum();
        let expect = if form == Form::Brep { 36.0 } else { 0.0 };
        assert!((floor - expect).abs() < 1e-2 && (above - 364.0).abs() < 1e-2, "{floor} {above} of {form:?}");
        assert!(!diagnostics(&site).iter().any(|d| d.0 == "earthworks_not_cut"));
    }
}

fn plan_area(t: &[[f64; 3]; 3]) -> f64 {
    let d = |k: usize, i: usize| t[k][i] - t[0][i];
    (d(1, 0) * d(2, 1) - d(2, 0) * d(1, 1)) / 2.0
}

#[test]
fn broken_terrain_is_told_and_never_a_panic() {
    let told = |file: &TerrainFile| {
        let archive = site(file);
        let site = Site::open(archive.bytes()).unwrap();
        (ground(&site).0.len(), diagnostics(&site))
    };
    let has = |found: &[(&str, String)], code: &str, what: &str| {
        assert!(found.iter().any(|(c, m)| *c == code && m.contains(what)), "no {code} {what}: {found:?}");
    };
    for form in [Form::Network, Form::TriangulatedFaceSet, Form::IndexedFaceSet] {
        let mut astray = TerrainFile::slope(form);
        astray.triangles.extend([[1, 2, 99], [0, 1, 2], [-5, 1, 2]]);
        let n = astray.triangles.len() - 3;
        let (found, diagnostics) = told(&astray);
        assert_eq!(found, n, "{form:?}");
        has(&diagnostics, "terrain_incomplete", "3 triangles of its item");
    }
    let mut folded = TerrainFile::slope(Form::TriangulatedFaceSet);
    folded.points.extend([[100.0, 50.0, 95.0], [105.0, 50.0, 95.0]]);
    folded.triangles.extend([[1, 2, 26], [2, 1, 7], [1, 7, 1]]);
    has(&told(&folded).1, "terrain_faces_unusable", "vertical");
    has(&told(&folded).1, "terrain_faces_unusable", "turned over or folded");
    let mut flags = TerrainFile::slope(Form::Network);
    flags.flags = Some(vec![-1; 3]);
    has(&told(&flags).1, "terrain_incomplete", "flags for another number");
    for owner in [("IFCSITE", "$,$,$,$,$,$,$"), ("IFCGEOGRAPHICELEMENT", "$,.TERRAIN.")] {
        let nothing =
            TerrainFile { triangles: Vec::new(), points: Vec::new(), owner, ..TerrainFile::slope(Form::Network) };
        let (found, diagnostics) = told(&nothing);
        assert_eq!(found, 0);
        assert!(!diagnostics.is_empty(), "{owner:?}");
        let mut holes = TerrainFile { owner, ..TerrainFile::slope(Form::Network) };
        holes.flags = Some(vec![-2; holes.triangles.len()]);
        let (found, diagnostics) = told(&holes);
        assert_eq!(found, 0, "{diagnostics:?}");
    }
}

#[test]
fn fine_terrain_is_held_with_fewer_triangles_and_the_error_is_told() {
    let z = |x: f64, y: f64| 100.0 + 0.02 * x + 0.5 * libm::sin(x / 4.0) * libm::cos(y / 5.0);
    let (points, triangles) = field(81, 0.03, [0.0, 0.0], z);
    let file = TerrainFile { points, triangles, ..TerrainFile::slope(Form::Network) };
    for owner in [("IFCSITE", "$,$,$,$,$,$,$"), ("IFCGEOGRAPHICELEMENT", "$,.TERRAIN.")] {
        let archive = site(&TerrainFile { owner, ..file.clone() });
        let site = Site::open(archive.bytes()).unwrap();
        let (found, _) = ground(&site);
        let told = diagnostics(&site);
        let message = &told.iter().find(|d| d.0 == "terrain_simplified").unwrap().1;
        assert!(message.contains(&format!("from 12800 to {} triangles", found.len())), "{message}");
        let error_m: f64 = message.split("at most ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
        assert!(found.len() < 2_000 && error_m <= 0.01, "{message}");
        // Every point of the file lies within the error of the surface.
        for [x, y, z] in &file.points {
            let height = found.iter().find_map(|t| height_in(t, [*x, *y])).unwrap();
            assert!((height - z).abs() <= error_m + 3e-4, "{} at {x} {y}", (height - z).abs());
        }
    }
}

/// Height of a triangle at a place that it covers in plan.
fn height_in(t: &[[f64; 3]; 3], [x, y]: [f64; 2]) -> Option<f64> {
    let area = |a: [f64; 2], b: [f64; 2], c: [f64; 2]| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
    let [a, b, c] = t.map(|v| [v[0], v[1]]);
    let whole = area(a, b, c);
    let w = [area([x, y], b, c), area(a, [x, y], c), area(a, b, [x, y])].map(|w| w / whole);
    w.iter().all(|w| *w >= -1e-3).then(|| (0..3).map(|k| w[k] * t[k][2]).sum())
}
