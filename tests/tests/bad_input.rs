//! Broken, hostile and useless files: a clear error, no panic, no hang, earlier output untouched.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::{contents, convert, demo_model, groundplan};
use std::path::Path;

/// A metre project, a storey and a wall of 4 x 0.2 x 3 m; `{}` takes more records.
fn house(more: &str) -> String {
    let records = "
#1=IFCPROJECT('0000000000000000000001',$,'P',$,$,$,$,(#2),#3);
#2=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,#4,$);
#3=IFCUNITASSIGNMENT((#5));
#4=IFCAXIS2PLACEMENT3D(#6,$,$);
#5=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);
#6=IFCCARTESIANPOINT((0.,0.,0.));
#7=IFCLOCALPLACEMENT($,#4);
#8=IFCBUILDINGSTOREY('0000000000000000000008',$,'Ground',$,$,#7,$,$,.ELEMENT.,0.);
#9=IFCRELAGGREGATES('0000000000000000000009',$,$,$,#1,(#8));
#10=IFCRELCONTAINEDINSPATIALSTRUCTURE('000000000000000000000A',$,$,$,(#11),#8);
#11=IFCWALL('000000000000000000000B',$,'W',$,$,#7,#12,$,$);
#12=IFCPRODUCTDEFINITIONSHAPE($,$,(#13));
#13=IFCSHAPEREPRESENTATION(#2,'Body','SweptSolid',(#14));
#14=IFCEXTRUDEDAREASOLID(#15,#4,#16,3.);
#15=IFCRECTANGLEPROFILEDEF(.AREA.,$,#17,4.,0.2);
#16=IFCDIRECTION((0.,0.,1.));
#17=IFCAXIS2PLACEMENT2D(#18,$);
#18=IFCCARTESIANPOINT((0.,0.));
";
    step("IFC4", &format!("{records}{more}"))
}

fn step(schema: &str, records: &str) -> String {
    format!(
        "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n\
         FILE_SCHEMA(('{schema}'));\nENDSEC;\nDATA;\n{records}ENDSEC;\nEND-ISO-10303-21;\n"
    )
}

/// The manifest of an earlier output.
const EARLIER: &str = r#"{"tool": "groundplan", "files": {}}"#;

/// Converts the bytes over earlier output: (exit code, standard error); a failure must leave the earlier output.
fn outcome(bytes: &[u8]) -> (i32, String) {
    let home = tempfile::tempdir().unwrap();
    let (model, out) = (home.path().join("model.ifc"), home.path().join("out"));
    std::fs::create_dir(&out).unwrap();
    std::fs::write(out.join("manifest.json"), EARLIER).unwrap();
    std::fs::write(&model, bytes).unwrap();
    let output = groundplan(&[&"convert", &model, &"-o", &out]);
    let output_text = String::from_utf8_lossy(&output.stderr).into_owned();
    let code = output.status.code().unwrap_or_else(|| panic!("killed by a signal: {output_text}"));
    assert!(code <= 2 && !output_text.contains("panicked"), "{output_text}");
    let manifest = std::fs::read_to_string(out.join("manifest.json")).unwrap();
    assert_eq!(manifest == EARLIER, code != 0, "{output_text}");
    (code, output_text)
}

/// The file is refused, and the message has the word.
fn refused(bytes: impl AsRef<[u8]>, word: &str) {
    let (code, output_text) = outcome(bytes.as_ref());
    assert!(code == 1 && output_text.contains(word), "exit {code}, expected {word:?} in: {output_text}");
}

#[test]
fn the_house_without_faults_is_converted() {
    assert_eq!(outcome(house("").as_bytes()).0, 0);
}

#[test]
fn what_is_no_ifc_file_is_named_for_what_it_is() {
    refused("", "empty");
    refused("solid cube\n", "no IFC file");
    refused([0u8, 159, 146, 150, 255, 254], "no IFC file");
    refused(step("CONFIG_CONTROL_DESIGN", ""), "CONFIG_CONTROL_DESIGN");
    refused(b"PK\x03\x04 not a zip", "zip");
    refused(b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", "export it with File > Export > IFC");
    refused("AC1032 drawing", "a drawing of AutoCAD (.dwg)");
    refused("<?xml version=\"1.0\"?><ifc:ifcXML/>", "ifcXML, which is not read; export the model as IFC");
}

#[test]
fn a_file_that_is_cut_off_is_refused_wherever_it_is_cut() {
    let demo = std::fs::read(demo_model()).unwrap();
    for part in [10, 200, 5_000, demo.len() / 2, demo.len() - 40] {
        let (code, output_text) = outcome(&demo[..part]);
        assert_eq!(code, 1, "cut at {part}: {output_text}");
    }
}

#[test]
fn an_unknown_length_unit_is_an_error() {
    refused(house("").replace("#1=IFCPROJECT('0000000000000000000001',$,'P',$,$,$,$,(#2),#3);", ""), "length unit");
    refused(
        house("").replace("IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.)", "IFCSIUNIT(*,.AREAUNIT.,$,.SQUARE_METRE.)"),
        "length unit",
    );
}

#[test]
fn a_model_whose_map_would_be_blank_is_an_error() {
    let nothing = house("").replace("#11=IFCWALL('000000000000000000000B',$,'W',$,$,#7,#12,$,$);", "");
    refused(nothing, "blank");
    refused(step("IFC4", ""), "blank");
}

#[test]
fn a_blank_map_says_what_the_model_and_each_of_its_storeys_lacks() {
    let upper = "#28=IFCBUILDINGSTOREY('0000000000000000000028',$,'Upper',$,$,#7,$,$,.ELEMENT.,3.);\n";
    let nothing = house(upper).replace("#11=IFCWALL('000000000000000000000B',$,'W',$,$,#7,#12,$,$);", "");
    let (code, output_text) = outcome(nothing.as_bytes());
    assert_eq!(code, 1);
    for reason in ["the model has no elements", "storey \"Ground\": ", "storey \"Upper\": "] {
        assert!(output_text.contains(reason), "{reason}: {output_text}");
    }
    let bodiless = house("").replace(",#7,#12,$,$)", ",#7,$,$,$)");
    let (_, output_text) = outcome(bodiless.as_bytes());
    assert!(output_text.contains("of 1 element none has a body"), "{output_text}");
}

/// The maps of all storeys.
fn maps_of(model: &str) -> Vec<(std::path::PathBuf, Vec<u8>)> {
    let home = tempfile::tempdir().unwrap();
    let path = home.path().join("model.ifc");
    std::fs::write(&path, model).unwrap();
    contents(&convert(&path, &[]).path().join("storeys"))
}

#[test]
fn what_old_exporters_write_gives_the_same_maps() {
    let ordinary = house("").replace("'IFC4'", "'IFC2X3'");
    let expected = maps_of(&ordinary);
    assert!(!expected.is_empty());
    for (written, by_others) in [
        ("IFCPRODUCTDEFINITIONSHAPE", "IFCPRODUCTREPRESENTATION"),
        ("IFCSHAPEREPRESENTATION", "IFCREPRESENTATION"),
        ("'IFC2X3'", "'IFC2X2_FINAL'"),
        ("'IFC2X3'", "'IFC2X_FINAL'"),
    ] {
        assert_eq!(maps_of(&ordinary.replace(written, by_others)), expected, "{by_others}");
    }
}

#[test]
fn a_model_without_storeys_is_mapped_at_its_lowest_level() {
    let (code, output_text) = outcome(
        house("")
            .replace("#8=IFCBUILDINGSTOREY('0000000000000000000008',$,'Ground',$,$,#7,$,$,.ELEMENT.,0.);", "")
            .as_bytes(),
    );
    assert_eq!(code, 0, "{output_text}");
}

#[test]
fn hostile_files_neither_hang_nor_panic() {
    let deep = format!("#90=IFCWALL({}{});\n", "(".repeat(200_000), ")".repeat(200_000));
    let relative_to_itself = house("").replace("#7=IFCLOCALPLACEMENT($,#4);", "#7=IFCLOCALPLACEMENT(#7,#4);");
    let whole_of_itself = house("#91=IFCRELAGGREGATES('000000000000000000000C',$,$,$,#11,(#11));\n");
    let mapped_in_itself = house("#92=IFCMAPPEDITEM(#93,#94);\n#93=IFCREPRESENTATIONMAP(#4,#13);\n")
        .replace("'SweptSolid',(#14)", "'MappedRepresentation',(#92)");
    let huge = house("").replace("4.,0.2)", "1e308,1e308)");
    let far = house("").replace("IFCCARTESIANPOINT((0.,0.,0.))", "IFCCARTESIANPOINT((1e300,-1e300,1e300))");
    let dangling = house("").replace("(#14)", "(#999999)");
    let wide_id = house("#99999999999999=IFCWALL('x',$,$,$,$,$,$,$,$);\n");
    let twice = house("#14=IFCEXTRUDEDAREASOLID(#15,#4,#16,2.);\n");
    let operand_of_itself = house("#95=IFCBOOLEANRESULT(.DIFFERENCE.,#95,#14);\n").replace("(#14))", "(#95))");
    let many = house(&"#96=IFCWALL('000000000000000000000B',$,'W',$,$,#7,#12,$,$);\n".repeat(20_000));
    for text in [
        house(&deep),
        relative_to_itself,
        whole_of_itself,
        mapped_in_itself,
        huge,
        far,
        dangling,
        wide_id,
        twice,
        operand_of_itself,
        many,
    ] {
        outcome(text.as_bytes());
    }
}

#[test]
fn a_grid_that_would_be_huge_is_refused_with_the_elements_at_its_ends() {
    let far = house(
        "#20=IFCWALL('000000000000000000000D',$,'far',$,$,#21,#12,$,$);\n#21=IFCLOCALPLACEMENT($,#22);\n\
         #22=IFCAXIS2PLACEMENT3D(#23,$,$);\n#23=IFCCARTESIANPOINT((5000.,5000.,0.));\n",
    );
    refused(far, "000000000000000000000D");
}

#[test]
fn arguments_that_make_no_sense_are_usage_errors() {
    let home = tempfile::tempdir().unwrap();
    let (model, out) = (demo_model(), home.path().join("out"));
    let robot = home.path().join("robot.toml");
    std::fs::write(&robot, "name = \"x\"\nheigth_m = 1.0\n").unwrap();
    let foreign = home.path().join("robot.toml");
    for (arguments, word) in [
        (vec!["--resolution", "0.03333"], "resolution"),
        (vec!["--robot", robot.to_str().unwrap()], "heigth_m"),
        (vec!["--place", "demo.ifc=1,2"], "FILE=X,Y,Z,YAW"),
        (vec!["--frame", "/nowhere/frame.json"], "frame"),
        (vec!["-o", foreign.to_str().unwrap()], "output folder"),
    ] {
        let mut all: Vec<&dyn AsRef<std::ffi::OsStr>> = vec![&"convert", &model];
        if !arguments.contains(&"-o") {
            all.extend([&"-o" as &dyn AsRef<std::ffi::OsStr>, &out]);
        }
        all.extend(arguments.iter().map(|a| a as &dyn AsRef<std::ffi::OsStr>));
        let output = groundplan(&all);
        let output_text = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {output_text}");
        assert!(output_text.contains(word), "{arguments:?}: {output_text}");
    }
    assert!(!Path::new(&out).exists());
}
