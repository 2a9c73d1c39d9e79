//! Federation of several small IFC texts.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use ingest::{FilePlacement, IngestError, IngestOptions, SiteFrame, SourceFile, ingest};
use messages::{ArchiveBuffer, DiagnosticCode, Site, SiteOutline};

/// A file with one wall of 2 x 1 x 3 m whose middle is `at` (in metres) of the file's world.
struct File {
    name: &'static str,
    /// Metres per unit: 1 or 0.001.
    unit_m: f64,
    at_m: [f64; 2],
    /// Records `#2..` for the georeference.
    earth: String,
}

impl File {
    fn source(&self) -> SourceFile {
        let prefix = if self.unit_m == 1.0 { "$" } else { ".MILLI." };
        let [x, y, width, depth, height] =
            [self.at_m[0], self.at_m[1], 2.0, 1.0, 3.0].map(|metres| metres / self.unit_m);
        let (name, earth) = (self.name, &self.earth);
        let text = format!(
            "ISO-10303-21;HEADER;FILE_DESCRIPTION((''),'2;1');FILE_NAME('','',(''),(''),'','','');FILE_SCHEMA(('IFC4'));ENDSEC;DATA;
             #100=IFCPROJECT('p',$,'P',$,$,$,$,(#101),#104);#101=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,#102,$);
             #102=IFCAXIS2PLACEMENT3D(#107,$,$);#103=IFCLOCALPLACEMENT($,#108);#104=IFCUNITASSIGNMENT((#105));
             #105=IFCSIUNIT(*,.LENGTHUNIT.,{prefix},.METRE.);#106=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);
             #107=IFCCARTESIANPOINT((0.,0.,0.));#108=IFCAXIS2PLACEMENT3D(#109,$,$);#109=IFCCARTESIANPOINT(({x:?},{y:?},0.));
             #110=IFCEXTRUDEDAREASOLID(#111,#102,#112,{height:?});#111=IFCRECTANGLEPROFILEDEF(.AREA.,$,$,{width:?},{depth:?});
             #112=IFCDIRECTION((0.,0.,1.));#120=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',(#110));
             #121=IFCPRODUCTDEFINITIONSHAPE($,$,(#120));#1=IFCWALL('{name}',$,'W',$,$,#103,#121,$,$);{earth}
             ENDSEC;END-ISO-10303-21;"
        );
        SourceFile { path: self.name.into(), bytes: text.into_bytes() }
    }
}

/// A map conversion as written; MapUnit is the metre, or the unit of the project.
fn conversion(eastings: f64, northings: f64, x_axis: &str, scale: &str, in_metres: bool) -> String {
    let unit = if in_metres { "#106" } else { "$" };
    format!(
        "#2=IFCMAPCONVERSION(#101,#3,{eastings:?},{northings:?},0.,{x_axis},{scale});\
         #3=IFCPROJECTEDCRS('EPSG:25832',$,$,$,$,$,{unit});"
    )
}

fn site(files: &[&File], places: &[Option<FilePlacement>]) -> Result<ArchiveBuffer, IngestError> {
    let sources: Vec<SourceFile> = files.iter().map(|f| f.source()).collect();
    let options = IngestOptions { places, ..IngestOptions::default() };
    ingest(&sources, &options)
}

/// Middles in plan of the bodies of the site's elements by GlobalId, in metres.
fn middles_m(site: &ArchiveBuffer) -> Vec<(String, [f64; 2])> {
    let site = Site::open(site.bytes()).unwrap();
    let middle = |e: &messages::ElementRecord| [0, 1].map(|k| f64::from(e.min_tenths[k] + e.max_tenths[k]) / 2e4);
    site.elements.iter().map(|e| (site.text(e.global_id).to_owned(), middle(e))).collect()
}

fn close(a: [f64; 2], b: [f64; 2]) -> bool {
    (0..2).all(|k| (a[k] - b[k]).abs() < 2e-3)
}

#[test]
fn files_in_metres_and_millimetres_meet_through_their_map_conversions() {
    let metres = File {
        name: "metres",
        unit_m: 1.0,
        at_m: [5.0, 0.0],
        earth: conversion(500_000.0, 5_400_000.0, "$,$", "$", true),
    };
    let second = |earth: String| File { name: "second", unit_m: 0.001, at_m: [1.0, 2.0], earth };
    let millimetres = second(conversion(500_020_000.0, 5_400_010_000.0, "$,$", "1.", false));
    // The same with the unit of the map named, and Scale between the two units.
    let scaled = second(conversion(500_020.0, 5_400_010.0, "$,$", "0.001", true));
    for second in [&millimetres, &scaled] {
        let found = middles_m(&site(&[&metres, second], &[]).unwrap());
        assert!(close(found[0].1, [5.0, 0.0]) && close(found[1].1, [21.0, 12.0]), "{found:?}");
    }
}

#[test]
fn a_turned_file_is_turned_by_the_direction_of_its_x_axis_whatever_its_length() {
    let plain = File {
        name: "plain",
        unit_m: 1.0,
        at_m: [0.0, 0.0],
        earth: conversion(500_000.0, 5_400_000.0, "$,$", "$", true),
    };
    // Its x axis points north, written with a length of 3.
    let turned = File {
        name: "turned",
        unit_m: 1.0,
        at_m: [4.0, 1.0],
        earth: conversion(500_010.0, 5_400_000.0, "0.,3.", "$", true),
    };
    let found = middles_m(&site(&[&plain, &turned], &[]).unwrap());
    assert!(close(found[1].1, [9.0, 4.0]), "{found:?}");
}

#[test]
fn the_georeference_of_the_site_is_in_metres_and_of_the_first_files_world() {
    let plain = File { name: "plain", unit_m: 1.0, at_m: [0.0, 0.0], earth: String::new() };
    let millimetres = File {
        name: "millimetres",
        unit_m: 0.001,
        at_m: [1.0, 2.0],
        earth: conversion(500_020_000.0, 5_400_010_000.0, "$,$", "1.", false),
    };
    let place = FilePlacement { translation_m: [10.0, 0.0, 0.0], yaw_rad: 0.0 };
    let archive = site(&[&plain, &millimetres], &[None, Some(place)]).unwrap();
    let site = Site::open(archive.bytes()).unwrap();
    assert_eq!(site.text(site.head.earth_crs), "EPSG:25832");
    assert_eq!((site.text(site.head.earth_unit), site.head.earth_unit_m), ("MILLIMETRE", 0.001));
    // The second file's origin lies 10 m east of the first's.
    let [east, north, _] = site.head.earth_m;
    assert!((east - 500_010.0).abs() < 1e-6 && (north - 5_400_010.0).abs() < 1e-6, "{east} {north}");
    assert_eq!(site.head.earth_scale, [1.0; 3]);
}

/// All orders of three.
const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];

#[test]
fn the_verdict_about_distance_does_not_depend_on_the_order_of_files_that_are_turned() {
    let file = |name, x: f64, axis: &str| File {
        name,
        unit_m: 1.0,
        at_m: [0.0, 0.0],
        earth: conversion(500_000.0 + x, 5_400_000.0, axis, "$", true),
    };
    // A to B and B to C are near, A to C is not.
    let chain = [file("a", 0.0, "$,$"), file("b", 95.0, "1.,1."), file("c", 190.0, "0.,1.")];
    let apart = [file("a", 0.0, "$,$"), file("b", 95.0, "1.,1."), file("c", 400.0, "0.,1.")];
    for order in ORDERS {
        assert!(site(&order.map(|k| &chain[k]), &[]).is_ok(), "{order:?}");
        let error = site(&order.map(|k| &apart[k]), &[]).err().unwrap().to_string();
        // The nearest two files of the groups: b and c, in the order of the command line.
        let [first, second] = if order.iter().position(|k| *k == 1) < order.iter().position(|k| *k == 2) {
            ["b", "c"]
        } else {
            ["c", "b"]
        };
        assert!(error.contains(&format!("{first} and {second} lie 30")), "{order:?}: {error}");
        assert!(error.contains(&format!("--place {second}=")), "{error}");
    }
}

#[test]
fn files_of_different_projected_systems_share_a_world_and_a_warning() {
    let one = File { name: "one", unit_m: 1.0, at_m: [0.0, 0.0], earth: conversion(5.0, 5.0, "$,$", "$", true) };
    let other = File {
        name: "other",
        unit_m: 1.0,
        at_m: [3.0, 0.0],
        earth: conversion(900.0, 5.0, "$,$", "$", true).replace("25832", "2056"),
    };
    let archive = site(&[&one, &other], &[]).unwrap();
    assert!(close(middles_m(&archive)[1].1, [3.0, 0.0]));
    let site = Site::open(archive.bytes()).unwrap();
    assert!(site.diagnostics.iter().any(|d| d.code == DiagnosticCode::ProjectedSystemsDiffer && d.source == 1));
}

/// `n` walls, of which the first `n_broken` are swept along a curve that is not there.
fn walls(n: usize, n_broken: usize) -> SourceFile {
    let file = File { name: "walls.ifc", unit_m: 1.0, at_m: [0.0, 0.0], earth: String::new() };
    let wall = |k: usize| {
        let shape = if k < n_broken { "#132" } else { "#121" };
        format!("#{}=IFCWALL('wall{k}',$,'W',$,$,#103,{shape},$,$);", 200 + k)
    };
    let broken = "#130=IFCSURFACECURVESWEPTAREASOLID(#111,#102,#999,0.,1.,#998);\
                  #131=IFCSHAPEREPRESENTATION(#101,'Body','AdvancedSweptSolid',(#130));#132=IFCPRODUCTDEFINITIONSHAPE($,$,(#131));";
    let text = String::from_utf8(file.source().bytes).unwrap();
    let walls: String = (0..n).map(wall).collect();
    let text = text.replace("#1=IFCWALL('walls.ifc',$,'W',$,$,#103,#121,$,$);", &format!("{walls}{broken}"));
    SourceFile { bytes: text.into_bytes(), ..file.source() }
}

#[test]
fn a_file_of_whose_bodies_most_cannot_be_meshed_is_refused_unless_boxes_are_allowed() {
    let options = |allow_boxes| IngestOptions { allow_boxes, ..IngestOptions::default() };
    assert!(ingest(&[walls(4, 2)], &options(false)).is_ok(), "half is not most");
    let error = ingest(&[walls(3, 2)], &options(false)).err().unwrap().to_string();
    for word in
        ["walls.ifc", "of 3 bodies", " 2 cannot", "#200 wall0", "IfcSurfaceCurveSweptAreaSolid #130", "--allow-boxes"]
    {
        assert!(error.contains(word), "{word}: {error}");
    }
    assert!(ingest(&[walls(3, 2)], &options(true)).is_ok());
}

#[test]
fn a_frame_is_kept_for_revisions_of_its_building_alone() {
    let site_of = |frame_of: Option<&SiteOutline>| {
        let frame = SiteFrame { map_from_world: frames::UprightRigid3::new([0.0; 3], 0.3), frame_epoch: 5 };
        let options = IngestOptions { frame: Some(frame), frame_of, frame_epoch: 6, ..IngestOptions::default() };
        ingest(&[walls(4, 0)], &options).unwrap()
    };
    let epoch_of = |site: &ArchiveBuffer| Site::open(site.bytes()).unwrap().head.frame_epoch;
    let first = site_of(None);
    assert_eq!(epoch_of(&first), 5, "without a site to compare with it is kept");
    let mut outline = SiteOutline::of(&Site::open(first.bytes()).unwrap());
    assert_eq!(epoch_of(&site_of(Some(&outline))), 5);
    let renamed = outline.elements.into_iter().map(|(id, element)| (id.replace("wall", "pier"), element));
    outline.elements = renamed.collect();
    let another = site_of(Some(&outline));
    assert_eq!(epoch_of(&another), 6);
    assert_eq!(Site::open(another.bytes()).unwrap().head.map_from_world_yaw_rad, 0.0);
}
