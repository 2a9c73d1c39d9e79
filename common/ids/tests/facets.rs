//! Facets on small files: what the test cases of buildingSMART, which are not part of the repository, do not have.

#![expect(clippy::unwrap_used, reason = "helpers of tests may")]

use ids::{Ids, IdsError, IdsReport, Scope, SpecificationOutcome};

fn file(schema: &str, data: &str) -> String {
    format!("ISO-10303-21;HEADER;FILE_SCHEMA(('{schema}'));ENDSEC;DATA;{data}ENDSEC;END-ISO-10303-21;")
}

fn document(applicability: &str, requirements: &str) -> String {
    format!(
        "<ids xmlns='http://standards.buildingsmart.org/IDS' xmlns:xs='http://www.w3.org/2001/XMLSchema'>
        <info><title>t</title></info><specifications><specification name='s' ifcVersion='IFC2X3 IFC4'>
        <applicability minOccurs='0' maxOccurs='unbounded'>{applicability}</applicability>
        <requirements>{requirements}</requirements></specification></specifications></ids>"
    )
}

fn simple(name: &str, value: &str) -> String {
    format!("<{name}><simpleValue>{value}</simpleValue></{name}>")
}

fn entity(class: &str) -> String {
    format!("<entity>{}</entity>", simple("name", class))
}

fn report(document: &str, ifc: &str) -> IdsReport {
    ids::check(&Ids::read(document.as_bytes()).unwrap(), ifc.as_bytes(), Scope::OfRelease).unwrap()
}

/// Reasons of the elements that fail the first requirement.
fn reasons(document: &str, ifc: &str) -> Vec<String> {
    let report = report(document, ifc);
    report.specifications[0].requirements[0].failed.iter().map(|element| element.reason.clone()).collect()
}

const UNITS: &str =
    "#1=IFCPROJECT('p',$,$,$,$,$,$,$,#2);#2=IFCUNITASSIGNMENT((#3));#3=IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.);";

#[test]
fn a_bounded_property_matches_as_the_table_of_the_manual_says() {
    let range = "<value><xs:restriction base='xs:double'><xs:minExclusive value='2'/><xs:maxInclusive value='5'/></xs:restriction></value>";
    let of = |value: &str| {
        let parts = simple("propertySet", "S") + &simple("baseName", "P") + value;
        document(&entity("IFCWALL"), &format!("<property dataType='IFCREAL'>{parts}</property>"))
    };
    let bounds = |lower: &str, upper: &str| {
        let real = |x: &str| if x == "$" { x.to_owned() } else { format!("IFCREAL({x}.)") };
        let property = format!("IFCPROPERTYBOUNDEDVALUE('P',$,{},{},$,$)", real(upper), real(lower));
        file(
            "IFC4",
            &format!(
                "#4=IFCWALL('w',$,$,$,$,$,$,$,$);#5=IFCPROPERTYSET('s',$,'S',$,(#6));#6={property};#7=IFCRELDEFINESBYPROPERTIES('r',$,$,$,(#4),#5);"
            ),
        )
    };
    let rows = [
        (range.to_owned(), "3", "4", true),
        (range.to_owned(), "$", "4", false),
        (range.to_owned(), "3", "$", false),
        (range.to_owned(), "2", "3", false),
        (range.to_owned(), "3", "5", true),
        (simple("value", "3"), "2", "4", true),
        (simple("value", "2"), "2", "4", true),
        (simple("value", "2"), "2", "$", true),
        (simple("value", "2"), "$", "2", true),
        (simple("value", "5"), "2", "4", false),
        (simple("value", "5"), "$", "4", false),
        (range.to_owned(), "$", "$", false),
        (simple("value", "3"), "$", "$", false),
        (String::new(), "2", "$", true),
    ];
    for (value, lower, upper, passes) in rows {
        assert_eq!(reasons(&of(&value), &bounds(lower, upper)).is_empty(), passes, "{value} {lower} {upper}");
    }
}

#[test]
fn occurrences_of_ifc2x3_are_of_the_class_that_their_type_tells_and_walls_are_not() {
    let data = "#4=IFCFLOWTERMINAL('a',$,$,$,$,$,$,$);#5=IFCAIRTERMINALTYPE('t',$,$,$,$,$,$,$,$,.GRILLE.);#6=IFCRELDEFINESBYTYPE('r',$,$,$,(#4),#5);\
        #7=IFCWALLSTANDARDCASE('w',$,$,$,$,$,$,$);#8=IFCWALLTYPE('u',$,$,$,$,$,$,$,$,.STANDARD.);#9=IFCRELDEFINESBYTYPE('q',$,$,$,(#7),#8);";
    let n = |class: &str| {
        let report = report(&document(&entity(class), &entity(class)), &file("IFC2X3", data));
        report.specifications[0].n_applicable
    };
    assert_eq!(
        [n("IFCAIRTERMINAL"), n("IFCFLOWTERMINAL"), n("IFCWALL"), n("IFCWALLSTANDARDCASE")],
        [Some(1), Some(1), Some(0), Some(1)]
    );
}

#[test]
fn attributes_of_measures_are_compared_in_metres() {
    let value = "<value><xs:restriction base='xs:double'><xs:minInclusive value='0.8'/></xs:restriction></value>";
    let document =
        document(&entity("IFCDOOR"), &format!("<attribute>{}{value}</attribute>", simple("name", "OverallWidth")));
    let door = |width: &str| format!("#4=IFCDOOR('d',$,$,$,$,$,$,$,2000.,{width},$,$,$);");
    assert!(reasons(&document, &file("IFC4", &(UNITS.to_owned() + &door("900.")))).is_empty());
    assert_eq!(
        reasons(&document, &file("IFC4", &(UNITS.to_owned() + &door("700.")))),
        ["OverallWidth is 0.7, not >= 0.8"]
    );
    assert!(reasons(&document, &file("IFC4", &door("900.")))[0].contains("unit"), "a file without units");
}

#[test]
fn absence_is_judged_by_cardinality() {
    let wall = |set: &str| file("IFC4", &format!("#4=IFCWALL('w',$,$,$,$,$,$,$,$);{set}"));
    let set = |value: &str| {
        wall(&format!(
            "#5=IFCPROPERTYSET('s',$,'S',$,(#6));#6=IFCPROPERTYSINGLEVALUE('P',$,{value},$);#7=IFCRELDEFINESBYPROPERTIES('r',$,$,$,(#4),#5);"
        ))
    };
    let passes = |cardinality: &str, ifc: &str| {
        let property = format!(
            "<property cardinality='{cardinality}'>{}{}</property>",
            simple("propertySet", "S"),
            simple("baseName", "P")
        );
        reasons(&document(&entity("IFCWALL"), &property), ifc).is_empty()
    };
    let files = [wall(""), set("$"), set("IFCLABEL('')"), set("IFCLABEL('x')")];
    let of = |cardinality: &str| files.each_ref().map(|ifc| passes(cardinality, ifc));
    assert_eq!(of("required"), [false, false, false, true]);
    assert_eq!(of("optional"), [true, true, false, true]);
    assert_eq!(of("prohibited"), [true, false, false, false]);
}

#[test]
fn wholes_are_followed_through_all_relations_or_the_one_that_is_named() {
    let data = "#4=IFCDOOR('d',$,$,$,$,$,$,$,$,$,$,$,$);#5=IFCWALL('w',$,$,$,$,$,$,$,$);#6=IFCOPENINGELEMENT('o',$,$,$,$,$,$,$,$);\
        #7=IFCRELVOIDSELEMENT('v',$,$,$,#5,#6);#8=IFCRELFILLSELEMENT('f',$,$,$,#6,#4);#9=IFCBUILDINGSTOREY('s',$,$,$,$,$,$,$,$,$);\
        #10=IFCRELCONTAINEDINSPATIALSTRUCTURE('c',$,$,$,(#5),#9);#11=IFCRELAGGREGATES('a',$,$,$,#9,(#9));";
    let why = |class: &str, relation: &str| {
        let part = format!("<partOf{relation}>{}</partOf>", entity(class));
        reasons(&document(&entity("IFCDOOR"), &part), &file("IFC4", data)).join("")
    };
    assert_eq!(why("IFCBUILDINGSTOREY", ""), "");
    assert_eq!(why("IFCWALL", " relation='IFCRELVOIDSELEMENT IFCRELFILLSELEMENT'"), "");
    assert_eq!(
        why("IFCBUILDING", ""),
        "it is part of IfcOpeningElement, IfcWall, IfcBuildingStorey, and of no IFCBUILDING"
    );
    let contained = why("IFCBUILDINGSTOREY", " relation='IFCRELCONTAINEDINSPATIALSTRUCTURE'");
    assert_eq!(contained, "it is part of nothing by IFCRELCONTAINEDINSPATIALSTRUCTURE");
}

#[test]
fn specifications_of_other_releases_are_not_checked_and_the_report_says_so() {
    let report = report(&document(&entity("IFCWALL"), ""), &file("IFC4X3_ADD2", "#1=IFCWALL('w',$,$,$,$,$,$,$,$);"));
    assert_eq!(report.specifications[0].outcome, SpecificationOutcome::NotChecked);
    assert!(
        report.passed && report.text().contains("it is for IFC2X3, IFC4, and the file is IFC4X3_ADD2"),
        "{}",
        report.text()
    );
}

#[test]
fn files_that_ids_does_not_allow_are_refused_with_their_line() {
    let good = document(&entity("IFCWALL"), &format!("<attribute>{}</attribute>", simple("name", "Name")));
    assert!(Ids::read(good.as_bytes()).is_ok());
    let cases = [
        ("<info>", "<info>\n<author>x</author>", "line 3"),
        ("<title>t</title>", "", "title"),
        ("name='s' ", "", "lacks the attribute name"),
        ("IFC2X3 IFC4", "IFC2X4", "IFC2X4"),
        ("minOccurs='0' ", "minOccurs='2' ", "minOccurs 2"),
        ("<attribute>", "<attribute cardinality='maybe'>", "maybe"),
        ("<attribute>", "<attribute color='red'>", "color"),
        (
            "<simpleValue>Name</simpleValue>",
            "<xs:restriction base='xs:string'><xs:pattern value='a+?'/></xs:restriction>",
            "a+?",
        ),
        (
            "<simpleValue>Name</simpleValue>",
            "<xs:restriction base='xs:string'><xs:totalDigits value='3'/></xs:restriction>",
            "totalDigits",
        ),
        ("IFCWALL", "IfcWall", "capitals"),
        ("IFCWALL", "IFCELEMENT", "no class"),
        ("Name<", "Naem<", "Naem"),
    ];
    for (part, instead, expected) in cases {
        assert!(good.contains(part), "{part}");
        let error = Ids::read(good.replacen(part, instead, 1).as_bytes()).unwrap_err();
        assert!(matches!(error, IdsError::Structure { .. } | IdsError::Unsatisfiable { .. }), "{error}");
        assert!(error.to_string().contains(expected), "{error}");
    }
}
