//! Footprints in `semantic.json`: within the tolerance that it says, whatever the detail; exact ones on request.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{Maps, convert, demo_model};
use serde_json::Value;
use std::fmt::Write;

const RADIUS_M: f64 = 0.4;

/// Places of the balls in the demo building, in metres.
const PLACES_M: [[f64; 2]; 2] = [[3.0, 2.0], [4.3, 2.7]];

/// The demo building with furniture: balls of 2 n (n - 1) triangles.
fn demo_with_balls(n: u32) -> String {
    let text = std::fs::read_to_string(demo_model()).unwrap();
    let at = text.rfind("ENDSEC;").unwrap();
    let reference = |entity: &str| {
        let line = text.lines().find(|line| line.contains(entity)).unwrap();
        line.split('=').next().unwrap().to_owned()
    };
    let (storey, context) = (reference("=IFCBUILDINGSTOREY("), reference("=IFCGEOMETRICREPRESENTATIONCONTEXT("));
    let (mut points, mut faces) = (vec!["(0.,0.,-400.)".to_owned()], Vec::new());
    for i in 1..n {
        let polar = std::f64::consts::PI * (f64::from(i) / f64::from(n) - 0.5);
        for k in 0..n {
            let turn = std::f64::consts::TAU * f64::from(k) / f64::from(n);
            let [x, y, z] = [libm::cos(polar) * libm::cos(turn), libm::cos(polar) * libm::sin(turn), libm::sin(polar)]
                .map(|c| 400.0 * c);
            points.push(format!("({x:.4},{y:.4},{z:.4})"));
        }
    }
    points.push("(0.,0.,400.)".to_owned());
    let top = points.len();
    for k in 0..n {
        let corner = |ring: u32, k: u32| 2 + ring * n + k % n;
        faces.push(format!("(1,{},{})", corner(0, k + 1), corner(0, k)));
        for i in 0..n - 2 {
            let [a, b, c, d] = [corner(i, k), corner(i, k + 1), corner(i + 1, k + 1), corner(i + 1, k)];
            faces.push(format!("({a},{b},{c}),({a},{c},{d})"));
        }
        faces.push(format!("({},{},{top})", corner(n - 2, k), corner(n - 2, k + 1)));
    }
    let mut records = format!(
        "#9000000=IFCCARTESIANPOINTLIST3D(({}));
#9000001=IFCTRIANGULATEDFACESET(#9000000,$,.U.,({}),$);
#9000002=IFCSHAPEREPRESENTATION({context},'Body','Tessellation',(#9000001));
#9000003=IFCPRODUCTDEFINITIONSHAPE($,$,(#9000002));
#9000004=IFCRELCONTAINEDINSPATIALSTRUCTURE('ball000000000000000009',$,$,$,(#9000100,#9000200),{storey});
",
        points.join(","),
        faces.join(",")
    );
    for (k, [x, y]) in PLACES_M.into_iter().enumerate() {
        let id = 9_000_100 + 100 * k;
        writeln!(
            records,
            "#{id}=IFCFURNITURE('ball00000000000000000{k}',$,'Ball',$,$,#{},#9000003,$,$);#{}=IFCLOCALPLACEMENT($,#{});
#{}=IFCAXIS2PLACEMENT3D(#{},$,$);#{}=IFCCARTESIANPOINT(({:.1},{:.1},500.));",
            id + 1,
            id + 1,
            id + 2,
            id + 2,
            id + 3,
            id + 3,
            1000.0 * x,
            1000.0 * y
        )
        .unwrap();
    }
    format!("{}{records}{}", &text[..at], &text[at..])
}

fn corners(footprint: &Value) -> Vec<[f64; 2]> {
    let rings = footprint.as_array().unwrap().iter().flat_map(|polygon| polygon.as_array().unwrap());
    let points = rings.flat_map(|ring| ring.as_array().unwrap());
    points.map(|p| [0, 1].map(|k| p[k].as_f64().unwrap())).collect()
}

fn planning(maps: &Maps) -> Vec<Vec<u8>> {
    let storeys = maps.manifest["storeys"].as_array().unwrap();
    let file = |s: &Value| maps.path().join(s["directory"].as_str().unwrap()).join("planning.pgm");
    storeys.iter().map(|s| std::fs::read(file(s)).unwrap()).collect()
}

#[test]
fn footprints_of_fine_furniture_are_small_and_within_the_tolerance_that_the_document_says() {
    let home = tempfile::tempdir().unwrap();
    let model = home.path().join("model.ifc");
    std::fs::write(&model, demo_with_balls(100)).unwrap();
    let (maps, exact_maps) = (convert(&model, &[]), convert(&model, &["--exact-footprints"]));
    let (document, exact) = (maps.json("semantic.json"), exact_maps.json("semantic.json"));
    let tolerance_m = document["footprint_tolerance"]["furniture_and_equipment_m"].as_f64().unwrap();
    assert!((tolerance_m - 0.05 / 3.0).abs() < 1e-4, "{tolerance_m}");
    assert_eq!(document["footprint_tolerance"]["structure_m"], 0.005);
    assert_eq!(exact["footprint_tolerance"]["furniture_and_equipment_m"], 0.0);
    for k in 0..2 {
        let id = format!("ball00000000000000000{k}");
        let of = |document: &Value| corners(&document["elements"][&id]["footprints"]["0"]);
        let (outline, exact) = (of(&document), of(&exact));
        assert!(outline.len() < 60 && exact.len() > 90, "{} corners, {} exact ones", outline.len(), exact.len());
        let centre = [0, 1].map(|i| exact.iter().map(|p| p[i]).sum::<f64>() / exact.len() as f64);
        let off = |p: &[f64; 2]| ((p[0] - centre[0]).hypot(p[1] - centre[1]) - RADIUS_M).abs();
        let worst = outline.iter().map(off).fold(0.0, f64::max);
        // The ball of straight edges is a millimetre smaller than a round one.
        assert!(worst <= tolerance_m + 0.002, "{worst}");
    }
    for (id, element) in document["elements"].as_object().unwrap().iter().filter(|(_, e)| e["class"] == "door") {
        assert_eq!(element["footprints"], exact["elements"][id]["footprints"], "{id}");
    }
    assert!(planning(&maps) == planning(&exact_maps), "maps do not depend on outlines");
}
