//! Bodies of which nothing bounds what the kernel needs, and those that are costly to cut, are meshed in a process of their own.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{client, demo_model};
use rustix::process::{Pid, Signal, kill_process};
use serde_json::Value;
use std::fmt::Write;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Generous: it tells a hang, not a slow machine.
const DEADLINE: Duration = Duration::from_secs(240);

/// The demo building with an element whose profile of so many corners is turned about an axis by 6 degrees.
fn demo_with_a_turned_profile(n_corners: u32) -> String {
    let [storey, context] = ids_of_demo();
    let first = 9_000_000;
    let point = |k: u32| first + 100 + k;
    let corners: Vec<String> = (0..=n_corners).map(|k| format!("#{}", point(k % n_corners))).collect();
    let mut records = format!(
        "#9000000=IFCBUILDINGELEMENTPROXY('turned0000000000000000',$,'Turned',$,$,#9000001,#9000002,$,$);
#9000001=IFCLOCALPLACEMENT($,#9000003);
#9000002=IFCPRODUCTDEFINITIONSHAPE($,$,(#9000004));
#9000003=IFCAXIS2PLACEMENT3D(#9000010,$,$);
#9000004=IFCSHAPEREPRESENTATION({context},'Body','SweptSolid',(#9000005));
#9000005=IFCREVOLVEDAREASOLID(#9000006,#9000003,#9000008,6.);
#9000006=IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#9000007);
#9000007=IFCPOLYLINE(({}));
#9000008=IFCAXIS1PLACEMENT(#9000009,#9000011);
#9000009=IFCCARTESIANPOINT((2000.,0.,0.));
#9000010=IFCCARTESIANPOINT((4000.,4000.,0.));
#9000011=IFCDIRECTION((0.,1.,0.));
#9000012=IFCRELCONTAINEDINSPATIALSTRUCTURE('turned0000000000000001',$,$,$,(#9000000),{storey});
",
        corners.join(",")
    );
    for k in 0..n_corners {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(n_corners);
        let radius_mm = 500.0 + f64::from(k * 7 % 13) * 10.0;
        let (sin, cos) = libm::sincos(angle);
        let [x, y] = [radius_mm * cos, radius_mm * sin];
        writeln!(records, "#{}=IFCCARTESIANPOINT(({x:.6},{y:.6}));", point(k)).unwrap();
    }
    demo_with(&records)
}

/// The first storey of the demo building, and its context.
fn ids_of_demo() -> [String; 2] {
    let text = std::fs::read_to_string(demo_model()).unwrap();
    ["=IFCBUILDINGSTOREY(", "=IFCGEOMETRICREPRESENTATIONCONTEXT("].map(|entity| {
        let record = text.lines().find(|line| line.contains(entity)).unwrap();
        record.split('=').next().unwrap().to_owned()
    })
}

/// The demo building with more records.
fn demo_with(records: &str) -> String {
    let text = std::fs::read_to_string(demo_model()).unwrap();
    let at = text.rfind("ENDSEC;").unwrap();
    format!("{}{records}{}", &text[..at], &text[at..])
}

/// The demo building with a wall of 4 x 0.3 x 3 m beside it, without a top, so that the kernel cuts it, of which an opening leaves nothing in the middle: a star of so many
/// corners, which becomes wider from one side to the other.
fn demo_with_a_star_in_a_wall(n_corners: u32) -> String {
    let [storey, context] = ids_of_demo();
    let mut records = format!(
        "#9000000=IFCWALL('starred000000000000000',$,'Starred',$,$,#9000001,#9000002,$,$);
#9000001=IFCLOCALPLACEMENT($,#9000003);
#9000002=IFCPRODUCTDEFINITIONSHAPE($,$,(#9000004));
#9000003=IFCAXIS2PLACEMENT3D(#9000005,$,$);
#9000004=IFCSHAPEREPRESENTATION({context},'Body','SurfaceModel',(#9000006));
#9000005=IFCCARTESIANPOINT((-8000.,0.,0.));
#9000006=IFCSHELLBASEDSURFACEMODEL((#9000007));
#9000007=IFCOPENSHELL((#9000040,#9000043,#9000046,#9000049,#9000052));
#9000011=IFCOPENINGELEMENT('star000000000000000000',$,'Star',$,$,#9000001,#9000012,$,$);
#9000012=IFCPRODUCTDEFINITIONSHAPE($,$,(#9000013));
#9000013=IFCSHAPEREPRESENTATION({context},'Body','Brep',(#9000014));
#9000014=IFCFACETEDBREP(#9000015);
#9000016=IFCRELVOIDSELEMENT('star000000000000000001',$,$,$,#9000000,#9000011);
#9000017=IFCRELCONTAINEDINSPATIALSTRUCTURE('starred000000000000001',$,$,$,(#9000000),{storey});
"
    );
    for k in 0..8 {
        let [x, y, z] = [4000 * (k & 1), 300 * (k >> 1 & 1), 3000 * (k >> 2)];
        writeln!(records, "#{}=IFCCARTESIANPOINT(({x}.,{y}.,{z}.));", 9_000_020 + k).unwrap();
    }
    for (k, face) in (0..).zip([[0, 2, 3, 1], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]) {
        let ([a, b, c, d], id) = (face.map(|k: u32| 9_000_020 + k), 9_000_040 + 3 * k);
        writeln!(records, "#{id}=IFCFACE((#{}));#{}=IFCFACEOUTERBOUND(#{},.T.);", id + 1, id + 1, id + 2).unwrap();
        writeln!(records, "#{}=IFCPOLYLOOP((#{a},#{b},#{c},#{d}));", id + 2).unwrap();
    }
    let point = |side: u32, k: u32| 9_100_000 + side * n_corners + k % n_corners;
    let mut outlines: Vec<Vec<u32>> =
        vec![(0..n_corners).map(|k| point(0, k)).collect(), (0..n_corners).rev().map(|k| point(1, k)).collect()];
    for k in 0..n_corners {
        let angle = std::f64::consts::TAU * f64::from(k) / f64::from(n_corners);
        let (sin, cos) = libm::sincos(angle);
        for (side, y, scale) in [(0, -200.0, 1.0), (1, 500.0, 1.1)] {
            let radius_mm = scale * if k % 2 == 0 { 600.0 } else { 1600.0 };
            let [x, z] = [2000.0 + radius_mm * cos, 900.0 + 1.8 * radius_mm * sin];
            writeln!(records, "#{}=IFCCARTESIANPOINT(({x:.6},{y:.1},{z:.6}));", point(side, k)).unwrap();
        }
        outlines.push(vec![point(0, k + 1), point(0, k), point(1, k), point(1, k + 1)]);
    }
    let mut faces = Vec::new();
    for (face, outline) in (9_200_000..).step_by(3).zip(outlines) {
        let corners: Vec<String> = outline.iter().map(|corner| format!("#{corner}")).collect();
        let (outer, outline) = (face + 1, face + 2);
        writeln!(
            records,
            "#{outline}=IFCPOLYLOOP(({}));#{outer}=IFCFACEOUTERBOUND(#{outline},.T.);",
            corners.join(",")
        )
        .unwrap();
        writeln!(records, "#{face}=IFCFACE((#{outer}));").unwrap();
        faces.push(format!("#{face}"));
    }
    writeln!(records, "#9000015=IFCCLOSEDSHELL(({}));", faces.join(",")).unwrap();
    demo_with(&records)
}

/// The process that a conversion has started, as soon as it is there; `None` if the conversion ends without.
fn mesh_process_of(converting: &mut Child) -> Option<Pid> {
    let begun = Instant::now();
    let parent = format!("PPid:\t{}\n", converting.id());
    loop {
        for process in std::fs::read_dir("/proc").unwrap().flatten() {
            let read = |name: &str| std::fs::read(process.path().join(name)).unwrap_or_default();
            let is_child = String::from_utf8_lossy(&read("status")).contains(&parent);
            if is_child && String::from_utf8_lossy(&read("cmdline")).contains("mesh-process") {
                return Pid::from_raw(process.file_name().to_str().unwrap().parse().unwrap());
            }
        }
        if converting.try_wait().unwrap().is_some() {
            return None;
        }
        assert!(begun.elapsed() < DEADLINE);
    }
}

#[test]
fn a_kernel_that_dies_takes_its_element_with_it_and_nothing_else() {
    let home = tempfile::tempdir().unwrap();
    let (model, out) = (home.path().join("model.ifc"), home.path().join("out"));
    std::fs::write(&model, demo_with_a_turned_profile(40_000)).unwrap();
    let mut command = Command::new(client());
    command.arg("convert").arg(&model).arg("-o").arg(&out).stdout(Stdio::null()).stderr(Stdio::null());
    let mut converting = command.spawn().unwrap();
    let mut n_killed = 0;
    while let Some(process) = mesh_process_of(&mut converting) {
        kill_process(process, Signal::KILL).unwrap();
        n_killed += 1;
        while std::fs::read_to_string(format!("/proc/{}/stat", process.as_raw_nonzero()))
            .is_ok_and(|s| !s.contains(" Z "))
        {}
    }
    assert!(n_killed > 0 && converting.wait().unwrap().success());
    let report: Value = serde_json::from_slice(&std::fs::read(out.join("report.json")).unwrap()).unwrap();
    let found: Vec<&Value> =
        report["diagnostics"].as_array().unwrap().iter().filter(|found| found["code"] == "geometry_failed").collect();
    let [found] = found[..] else { panic!("{found:?}") };
    let message = found["message"].as_str().unwrap();
    assert!(message.contains("the system ended the kernel's process") && message.contains("bounding box"), "{message}");
    let semantic: Value = serde_json::from_slice(&std::fs::read(out.join("semantic.json")).unwrap()).unwrap();
    assert!(semantic["elements"].as_object().unwrap().len() > 100, "the others are there");
}

#[test]
fn a_body_without_bounds_is_meshed_like_any_other() {
    let home = tempfile::tempdir().unwrap();
    let model = home.path().join("model.ifc");
    std::fs::write(&model, demo_with_a_turned_profile(40)).unwrap();
    let maps = end_to_end::convert(&model, &[]);
    let semantic = maps.json("semantic.json");
    let turned = &semantic["elements"]["turned0000000000000000"];
    // Half a metre and some to both sides; the angle is small.
    let width_m = turned["aabb_m"]["max"][0].as_f64().unwrap() - turned["aabb_m"]["min"][0].as_f64().unwrap();
    assert!((1.0..1.3).contains(&width_m), "{turned:#}");
    assert!(!maps.json("report.json")["diagnostics"].to_string().contains("turned0000000000000000"));
}

/// What `report.json` says of openings that are not cut: the GlobalIds of elements, and why.
fn not_cut(maps: &end_to_end::Maps) -> Vec<(String, String)> {
    let report = maps.json("report.json");
    let found = report["diagnostics"].as_array().unwrap().iter().filter(|found| found["code"] == "openings_not_cut");
    let text = |value: &Value| value.as_str().unwrap().to_owned();
    found.map(|found| (text(&found["global_id"]), text(&found["message"]))).collect()
}

#[test]
fn a_cut_that_takes_too_long_ends_and_its_element_is_whole_and_named() {
    let home = tempfile::tempdir().unwrap();
    let model = home.path().join("model.ifc");
    // More than twice the time that it may take.
    std::fs::write(&model, demo_with_a_star_in_a_wall(1400)).unwrap();
    let maps = end_to_end::convert(&model, &[]);
    let [(element, why)] = &not_cut(&maps)[..] else { panic!("{:?}", not_cut(&maps)) };
    assert_eq!(element, "starred000000000000000");
    assert!(why.contains("more than 10 s of CPU time"), "{why}");
    // In the middle the opening would leave nothing of the wall.
    assert_eq!(maps.storey(0).planning(-6.0, 0.15), end_to_end::OCCUPIED);
    // All others are as without it.
    let elements = |maps: &end_to_end::Maps| {
        let mut elements = maps.json("semantic.json")["elements"].as_object().unwrap().clone();
        elements.remove("starred000000000000000");
        elements
    };
    let demo = end_to_end::convert(&demo_model(), &[]);
    assert_eq!(elements(&maps), elements(&demo));
}

#[test]
fn a_costly_cut_that_ends_is_made() {
    let home = tempfile::tempdir().unwrap();
    let model = home.path().join("model.ifc");
    // More than 1,200 triangles are cut apart.
    std::fs::write(&model, demo_with_a_star_in_a_wall(320)).unwrap();
    let maps = end_to_end::convert(&model, &[]);
    assert_eq!(not_cut(&maps), []);
    assert_ne!(maps.storey(0).planning(-6.0, 0.15), end_to_end::OCCUPIED);
    assert_eq!(maps.storey(0).planning(-7.9, 0.15), end_to_end::OCCUPIED);
}
