//! Hostile files: never a panic, never a hang; a clear error or a model with diagnostics.

use std::path::Path;
use std::time::{Duration, Instant};

use ifc::{Diagnostic, DiagnosticCode, GeometryStatus, Model, ReadError, ReadOptions};

fn read(bytes: &[u8]) -> Result<(Model, Vec<Diagnostic>), ReadError> {
    ifc::read(bytes, &ReadOptions::default())
}

/// What the seeds of the fuzzer are known for: part of the error, or codes of the diagnostics.
const SEEDS: [(&str, &str); 18] = [
    ("broken-container.ifczip", "error: container"),
    ("cyclic-aggregates.ifc", ""),
    ("cyclic-boolean.ifc", "geometry_failed"),
    ("cyclic-mapped-item.ifc", "geometry_failed"),
    ("cyclic-placement.ifc", "placement_unusable geometry_failed"),
    ("deep-parentheses.ifc", "record_malformed"),
    ("door-2x3.ifc", ""),
    ("duplicate-and-dangling-ids.ifc", "duplicate_id placement_unusable"),
    ("foreign-schema.ifc", "error: CONFIG_CONTROL_DESIGN"),
    ("huge-coordinates.ifc", "geometry_failed"),
    ("huge-placement.ifc", "geometry_failed"),
    ("no-unit.ifc", "error: length unit"),
    ("opening.ifc", "swallowed_by_openings"),
    (
        "schedule.ifc",
        "task_nesting_circle task_time_missing task_control_dangling task_link_dangling sequence_dangling calendar_unreadable",
    ),
    ("surface-curve-sweep.ifc", ""),
    ("truncated.ifc", "error: cut off"),
    ("unclosed-text.ifc", "error: never closed"),
    ("wall.ifc", ""),
];

#[test]
fn every_seed_of_the_fuzzer_ends_as_expected() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/fuzz/corpus/ifc");
    let mut names: Vec<String> =
        std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    for name in names {
        let outcome = read(&std::fs::read(folder.join(&name)).unwrap());
        let Some((_, expected)) = SEEDS.iter().find(|(seed, _)| *seed == name) else { continue };
        match (expected.strip_prefix("error: "), outcome) {
            (Some(words), Err(error)) => assert!(error.to_string().contains(words), "{name}: {error}"),
            (None, Ok((_, diagnostics))) => {
                for code in expected.split_whitespace() {
                    assert!(diagnostics.iter().any(|d| d.code.name() == code), "{name}: no {code} in {diagnostics:?}");
                }
                assert!(!expected.is_empty() || diagnostics.is_empty(), "{name}: {diagnostics:?}");
            }
            (_, Ok((_, diagnostics))) => panic!("{name} was read: {diagnostics:?}"),
            (_, Err(error)) => panic!("{name}: {error}"),
        }
    }
}

const HEAD: &str = "ISO-10303-21;HEADER;FILE_DESCRIPTION((''),'2;1');FILE_NAME('','',(''),(''),'','','');\
    FILE_SCHEMA(('IFC4'));ENDSEC;DATA;
    #100=IFCPROJECT('project',$,'P',$,$,$,$,(#101),#104);#101=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,#102,$);
    #102=IFCAXIS2PLACEMENT3D(#107,$,$);#103=IFCLOCALPLACEMENT($,#102);#104=IFCUNITASSIGNMENT((#105));
    #105=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);#107=IFCCARTESIANPOINT((0.,0.,0.));
    #111=IFCRECTANGLEPROFILEDEF(.AREA.,$,$,2.,1.);#112=IFCDIRECTION((0.,0.,1.));#110=IFCEXTRUDEDAREASOLID(#111,#102,#112,3.);";

/// A file with a wall `#1` whose body consists of `items`.
fn wall(records: &str, items: &str) -> String {
    format!(
        "{HEAD}\n{records}\n#120=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',({items}));
         #121=IFCPRODUCTDEFINITIONSHAPE($,$,(#120));#1=IFCWALL('wall',$,$,$,$,#103,#121,$,$);\nENDSEC;END-ISO-10303-21;"
    )
}

/// Reads within seconds, whatever comes of it.
fn ends(name: &str, text: &str) {
    let start = Instant::now();
    let outcome = read(text.as_bytes());
    let elapsed = start.elapsed();
    // Generous: it tells a hang, not a slow machine.
    assert!(elapsed < Duration::from_secs(60), "{name} took {elapsed:?}");
    if let Ok((model, _)) = outcome {
        for part in model.elements.iter().flat_map(|e| &e.geometry.parts) {
            assert!(part.positions_m.iter().flatten().all(|x| x.is_finite()), "{name}");
        }
    }
}

#[test]
fn nesting_counts_and_chains_without_measure_end() {
    let deep = |n: usize| format!("#1=IFCWALL({}'w'{});", "(".repeat(n), ")".repeat(n));
    ends("deep parentheses", &format!("{HEAD}{}ENDSEC;END-ISO-10303-21;", deep(100_000)));
    let item = "#130=IFCFACETEDBREP(#131);#131=IFCCLOSEDSHELL(((((((((((((#132)))))))))))));";
    ends("nested lists in geometry", &wall(item, "#130"));
    ends(
        "parentheses in geometry",
        &wall(&format!("#130=IFCFACETEDBREP({}#1{});", "(".repeat(99_999), ")".repeat(99_999)), "#130"),
    );
    let booleans: String = (0..20_000u32)
        .map(|i| format!("#{}=IFCBOOLEANRESULT(.DIFFERENCE.,#{},#110);", 1000 + i, if i == 0 { 110 } else { 999 + i }))
        .collect();
    ends("boolean of booleans", &wall(&booleans, "#20999"));
    let maps: String = (0..40u32)
        .map(|i| {
            let (rep, map, a, b) = (1000 + 10 * i, 1001 + 10 * i, 1002 + 10 * i, 1003 + 10 * i);
            let inner = if i == 0 { "#110".to_owned() } else { format!("#{},#{}", a - 10, b - 10) };
            format!(
                "#{rep}=IFCSHAPEREPRESENTATION(#101,'Body','MappedRepresentation',({inner}));\
                 #{map}=IFCREPRESENTATIONMAP(#102,#{rep});#{a}=IFCMAPPEDITEM(#{map},#140);#{b}=IFCMAPPEDITEM(#{map},#140);"
            )
        })
        .collect();
    let operator = "#140=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#107,1.,$);";
    ends("two to the fortieth mapped items", &wall(&format!("{operator}{maps}"), "#1392"));
    let placements: String =
        (0..50_000u32).map(|i| format!("#{}=IFCLOCALPLACEMENT(#{},#102);", 1000 + i, 1001 + i)).collect();
    ends("endless placements", &wall(&placements, "#110").replace("#103,#121", "#1000,#121"));
}

#[test]
fn numbers_without_measure_end() {
    for number in ["1.E308", "-1.E308", "1.E400", "NAN", "1.E-320", "0.", "-5.", "$", "'x'", "(1.)"] {
        let circle = format!(
            "#130=IFCEXTRUDEDAREASOLID(#131,#102,#112,{number});#131=IFCCIRCLEPROFILEDEF(.AREA.,$,$,{number});"
        );
        ends(number, &wall(&circle, "#130"));
        let disk = format!(
            "#130=IFCSWEPTDISKSOLID(#131,{number},$,0.,1.);#131=IFCPOLYLINE((#107,#132));#132=IFCCARTESIANPOINT(({number},0.,{number}));"
        );
        ends(number, &wall(&disk, "#130"));
        let faces = format!(
            "#130=IFCTRIANGULATEDFACESET(#131,$,.T.,((1,2,3),(1,2,99999999)),$);#131=IFCCARTESIANPOINTLIST3D(((0.,0.,0.),({number},0.,0.),(0.,1.,{number})));"
        );
        ends(number, &wall(&faces, "#130"));
        ends(
            number,
            &wall("", "#110").replace("#107=IFCCARTESIANPOINT((0.", &format!("#107=IFCCARTESIANPOINT(({number}")),
        );
        ends(number, &wall("", "#110").replace("$,2.,1.)", &format!("$,{number},1.)")));
    }
}

#[test]
fn a_file_cut_at_any_place_is_an_error() {
    let text = wall("", "#110");
    for end in (0..text.len() - 20).step_by(41) {
        assert!(read(&text.as_bytes()[..end]).is_err(), "cut at {end}");
    }
}

#[test]
fn one_failing_product_does_not_harm_the_others() {
    let text = wall("#130=IFCSURFACECURVESWEPTAREASOLID(#111,#102,#999,0.,1.,#998);", "#130").replace(
        "ENDSEC;END",
        "#2=IFCWALL('good',$,$,$,$,#103,#3,$,$);#3=IFCPRODUCTDEFINITIONSHAPE($,$,(#4));\
             #4=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',(#110));ENDSEC;END",
    );
    let (model, diagnostics) = read(text.as_bytes()).unwrap();
    let status = |id: &str| &model.elements.iter().find(|e| e.id.global_id == id).unwrap().geometry.status;
    assert!(matches!(status("wall"), GeometryStatus::Failed { .. }));
    assert_eq!(*status("good"), GeometryStatus::Meshed);
    let failed: Vec<_> = diagnostics.iter().filter(|d| d.code != DiagnosticCode::ReferenceDangling).collect();
    assert_eq!((failed.len(), diagnostics.len()), (1, 2), "{diagnostics:?}");
    assert_eq!(failed[0].entity.as_ref().unwrap().global_id, "wall");
}
