//! Items that the kernel meshes wrongly or not at all, written as ones that it does mesh.
//!
//! The substitute keeps the id of the item, so that representations, booleans and maps that use it need no change, and
//! is cut by openings like any other body. Coordinates are in the file's units.

use std::f64::consts::TAU;

use crate::affine::{axes, normalised};
use crate::kernel::{File, Patch, Record};
use crate::placement::{axis2_placement, operator, point};
use crate::representations::references;
use nalgebra::{Affine3, Point2, Point3, Vector3};

/// Longest directrix and largest profile that are swept here.
const POINTS_MAX: usize = 10_000;
/// Corners of round primitives; what the kernel takes for round profiles.
const SEGMENTS: usize = 36;

/// Supertypes that IFC2X3 and its predecessors let a file use, and the subtype that the kernel insists on. Their attributes are
/// the same. Some exporters write no other (AutoCAD Architecture 2010: IfcProductRepresentation).
const SUPERTYPES: [(&str, &str); 3] = [
    ("IfcProductRepresentation", "IFCPRODUCTDEFINITIONSHAPE"),
    ("IfcRepresentation", "IFCSHAPEREPRESENTATION"),
    ("IfcManifoldSolidBrep", "IFCFACETEDBREP"),
];

/// Faces as loops of points.
type Faces = Vec<Vec<Point3<f64>>>;

/// Replaces what can be replaced. An IfcSurfaceCurveSweptAreaSolid that cannot is emptied: the kernel would mesh a part of
/// it, metres off, and the box that stands in for a failed item is better.
pub(crate) fn apply(file: &File<'_>, patch: &mut Patch) {
    for (supertype, subtype) in SUPERTYPES {
        for (span, _) in file.all(supertype).into_iter().filter(|(_, class)| class.lineage.first() == Some(&supertype))
        {
            if let Some(arguments) = file.arguments_as_written(span.id) {
                patch.replace(span.id, format!("{subtype}{arguments}"));
            }
        }
    }
    for entity in ["IfcEllipseProfileDef", "IfcTrapeziumProfileDef"] {
        for (span, _) in file.all(entity) {
            let outline = file.record(span.id).and_then(|record| outline(file, &record));
            if let Some(profile) = outline.and_then(|outline| closed_profile(&outline, patch)) {
                patch.replace(span.id, profile);
            }
        }
    }
    for (span, _) in file.all("IfcSurfaceCurveSweptAreaSolid") {
        let faces = file.record(span.id).and_then(|record| swept(file, &record));
        let shell = faces.and_then(|faces| shell(&faces, patch));
        let record = shell.unwrap_or_else(|| "IFCSURFACECURVESWEPTAREASOLID($,$,$,$,$,$)".to_owned());
        patch.replace(span.id, record);
    }
    for (span, _) in file.all("IfcCsgPrimitive3D") {
        let faces = file.record(span.id).and_then(|record| primitive(file, &record));
        if let Some(shell) = faces.and_then(|faces| shell(&faces, patch)) {
            patch.replace(span.id, shell);
        }
    }
    // The kernel wants a primitive of its own in an IfcCsgSolid.
    for (span, _) in file.all("IfcCsgSolid") {
        let root = file.record(span.id).and_then(|record| file.record(record.at(0).reference()?));
        let faces = root.and_then(|record| primitive(file, &record));
        if let Some(shell) = faces.and_then(|faces| shell(&faces, patch)) {
            patch.replace(span.id, shell);
        }
    }
}

/// The corners of a profile that the kernel does not know, in the plane that it is defined in.
fn outline(file: &File<'_>, record: &Record<'_>) -> Option<Vec<Point3<f64>>> {
    let corners = if record.is("IFCTRAPEZIUMPROFILEDEF") {
        // (ProfileType, ProfileName, Position, BottomXDim, TopXDim, YDim, TopXOffset)
        let (bottom, top, depth) = (size(record, 3)?, size(record, 4)?, size(record, 5)?);
        let (left, y) = (-bottom / 2.0, depth / 2.0);
        let start = left + record.at(6).number().unwrap_or(0.0);
        [(left, -y), (-left, -y), (start + top, y), (start, y)].map(|(x, y)| Point3::new(x, y, 0.0)).to_vec()
    } else {
        // (ProfileType, ProfileName, Position, SemiAxis1, SemiAxis2)
        let (a, b) = (size(record, 3)?, size(record, 4)?);
        circle(1.0, 0.0).into_iter().map(|p| Point3::new(a * p.x, b * p.y, p.z)).collect()
    };
    let position = record.at(2).reference();
    let frame = position.map_or(Some(Affine3::identity()), |id| axis2_placement(file, &file.record(id)?, 1.0))?;
    Some(corners.into_iter().map(|corner| frame * corner).collect())
}

/// The record of an IfcArbitraryClosedProfileDef.
fn closed_profile(outline: &[Point3<f64>], patch: &mut Patch) -> Option<String> {
    let mut points = Vec::with_capacity(outline.len() + 1);
    for p in outline {
        points.push(patch.add(format!("IFCCARTESIANPOINT(({:.12},{:.12}))", p.x, p.y))?);
    }
    points.push(*points.first()?);
    let curve = patch.add(format!("IFCPOLYLINE(({}))", references(&points)))?;
    Some(format!("IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#{curve})"))
}

/// The faces of a primitive that the kernel does not know.
fn primitive(file: &File<'_>, record: &Record<'_>) -> Option<Faces> {
    let mut faces = match record.keyword.to_ascii_uppercase().as_str() {
        "IFCRIGHTCIRCULARCYLINDER" => cylinder(record),
        "IFCRIGHTCIRCULARCONE" => cone(record),
        "IFCRECTANGULARPYRAMID" => pyramid(record),
        _ => None,
    }?;
    let frame = axis2_placement(file, &file.record(record.at(0).reference()?)?, 1.0)?;
    faces.iter_mut().flatten().for_each(|p| *p = frame * *p);
    Some(faces)
}

/// The record of an IfcFacetedBrep, which all schemas have.
fn shell(faces: &Faces, patch: &mut Patch) -> Option<String> {
    let mut ids = Vec::with_capacity(faces.len());
    for face in faces {
        let mut points = Vec::with_capacity(face.len());
        for p in face {
            points.push(patch.add(format!("IFCCARTESIANPOINT(({:.12},{:.12},{:.12}))", p.x, p.y, p.z))?);
        }
        let polyloop = patch.add(format!("IFCPOLYLOOP(({}))", references(&points)))?;
        let bound = patch.add(format!("IFCFACEOUTERBOUND(#{polyloop},.T.)"))?;
        ids.push(patch.add(format!("IFCFACE((#{bound}))"))?);
    }
    let shell = patch.add(format!("IFCCLOSEDSHELL(({}))", references(&ids)))?;
    Some(format!("IFCFACETEDBREP(#{shell})"))
}

/// A prism or, with one point on top, a pyramid over the bottom loop (counter-clockwise from above).
fn tower(bottom: &[Point3<f64>], top: &[Point3<f64>]) -> Faces {
    let n = bottom.len();
    let mut faces: Faces = vec![bottom.iter().rev().copied().collect()];
    for i in 0..n {
        let k = (i + 1) % n;
        faces.push(match top {
            [apex] => vec![bottom[i], bottom[k], *apex],
            _ => vec![bottom[i], bottom[k], top[k], top[i]],
        });
    }
    if top.len() > 1 {
        faces.push(top.to_vec());
    }
    faces
}

fn circle(radius: f64, z: f64) -> Vec<Point3<f64>> {
    let corner = |i: usize| {
        let angle = TAU * i as f64 / SEGMENTS as f64;
        Point3::new(radius * libm::cos(angle), radius * libm::sin(angle), z)
    };
    (0..SEGMENTS).map(corner).collect()
}

/// (Position, Height, Radius)
fn cylinder(record: &Record<'_>) -> Option<Faces> {
    let (height, radius) = (size(record, 1)?, size(record, 2)?);
    Some(tower(&circle(radius, 0.0), &circle(radius, height)))
}

/// (Position, Height, BottomRadius)
fn cone(record: &Record<'_>) -> Option<Faces> {
    let (height, radius) = (size(record, 1)?, size(record, 2)?);
    Some(tower(&circle(radius, 0.0), &[Point3::new(0.0, 0.0, height)]))
}

/// (Position, XLength, YLength, Height)
fn pyramid(record: &Record<'_>) -> Option<Faces> {
    let (x, y, height) = (size(record, 1)?, size(record, 2)?, size(record, 3)?);
    let bottom = [(0.0, 0.0), (x, 0.0), (x, y), (0.0, y)].map(|(x, y)| Point3::new(x, y, 0.0));
    Some(tower(&bottom, &[Point3::new(x / 2.0, y / 2.0, height)]))
}

fn size(record: &Record<'_>, at: usize) -> Option<f64> {
    record.at(at).number().filter(|&x| x > 0.0 && x < 1e9)
}

/// A polygon swept along lines in a plane, with mitred corners: x of the profile along the plane's normal, its own
/// normal along the directrix. The parameters are ignored, as IfcOpenShell does: exporters write 0 and 1 for all of it.
fn swept(file: &File<'_>, record: &Record<'_>) -> Option<Faces> {
    let frame = record
        .at(1)
        .reference()
        .map_or(Some(Affine3::identity()), |id| axis2_placement(file, &file.record(id)?, 1.0))?;
    let plane = file.record_of(record.at(5).reference()?, "IFCPLANE")?;
    let [_, _, normal] = axes(&axis2_placement(file, &file.record(plane.at(0).reference()?)?, 1.0)?);
    let mut profile = polygon(file, record.at(0).reference()?, 0)?;
    let mut path = lines(file, record.at(2).reference()?)?;
    path.dedup();
    let closed = path.len() > 3 && path.first() == path.last();
    if closed {
        path.pop();
    }
    if area(&profile) < 0.0 {
        profile.reverse();
    }
    let sides = sides(&path, normal, closed)?;
    let ring = |(p, side): (&Point3<f64>, &Vector3<f64>)| -> Vec<Point3<f64>> {
        profile.iter().map(|q| frame * (p + normal * q.x + side * q.y)).collect()
    };
    let rings: Vec<Vec<Point3<f64>>> = std::iter::zip(&path, &sides).map(ring).collect();
    let mut faces = Faces::new();
    let n_spans = if closed { rings.len() } else { rings.len() - 1 };
    for s in 0..n_spans {
        let (from, to) = (&rings[s], &rings[(s + 1) % rings.len()]);
        for i in 0..profile.len() {
            let k = (i + 1) % profile.len();
            faces.push(vec![from[i], from[k], to[k], to[i]]);
        }
    }
    if !closed {
        faces.push(rings.first()?.iter().rev().copied().collect());
        faces.push(rings.last()?.clone());
    }
    Some(faces)
}

/// Direction of the profile's y axis at each corner of the path, lengthened by the mitre.
fn sides(path: &[Point3<f64>], normal: Vector3<f64>, closed: bool) -> Option<Vec<Vector3<f64>>> {
    let n = path.len();
    let direction = |i: usize| normalised(path[(i + 1) % n] - path[i % n]);
    let in_plane = |t: &Vector3<f64>| t.dot(&normal).abs() < 1e-6;
    let n_spans = if closed { n } else { n.checked_sub(1)? };
    let spans: Vec<Vector3<f64>> = (0..n_spans).map(|i| direction(i).filter(in_plane)).collect::<Option<_>>()?;
    let across: Vec<Vector3<f64>> = spans.iter().map(|t| t.cross(&normal)).collect();
    let corner = |i: usize| {
        let before = if i > 0 || closed { across[(i + n_spans - 1) % n_spans] } else { across[0] };
        let after = if i < n_spans { across[i] } else { across[n_spans - 1] };
        let mitre = 1.0 + before.dot(&after);
        // Sharper than about 25 degrees the mitre runs away.
        (mitre > 0.1).then(|| (before + after) / mitre)
    };
    (n_spans > 0).then(|| (0..n).map(corner).collect::<Option<_>>())?
}

/// Outline of a profile of straight lines.
fn polygon(file: &File<'_>, id: u32, depth: usize) -> Option<Vec<Point2<f64>>> {
    let record = file.record(id).filter(|_| depth < 4)?;
    match record.keyword.to_ascii_uppercase().as_str() {
        "IFCARBITRARYCLOSEDPROFILEDEF" => {
            let mut points: Vec<Point2<f64>> = lines(file, record.at(2).reference()?)?.iter().map(Point3::xy).collect();
            points.dedup();
            if points.first() == points.last() {
                points.pop();
            }
            (points.len() >= 3).then_some(points)
        }
        "IFCRECTANGLEPROFILEDEF" => {
            let position = record.at(2).reference();
            let frame =
                position.map_or(Some(Affine3::identity()), |id| axis2_placement(file, &file.record(id)?, 1.0))?;
            let (x, y) = (size(&record, 3)? / 2.0, size(&record, 4)? / 2.0);
            let corner = |(x, y): (f64, f64)| (frame * Point3::new(x, y, 0.0)).xy();
            Some([(-x, -y), (x, -y), (x, y), (-x, y)].map(corner).to_vec())
        }
        "IFCDERIVEDPROFILEDEF" => {
            let map = operator(file, &file.record(record.at(3).reference()?)?, 1.0)?;
            let parent = polygon(file, record.at(2).reference()?, depth + 1)?;
            Some(parent.iter().map(|p| (map * Point3::new(p.x, p.y, 0.0)).xy()).collect())
        }
        _ => None,
    }
}

/// Points of an IfcPolyline, or of an IfcIndexedPolyCurve without arcs.
fn lines(file: &File<'_>, id: u32) -> Option<Vec<Point3<f64>>> {
    let record = file.record(id)?;
    let points: Vec<Point3<f64>> = if record.is("IFCPOLYLINE") {
        record.at(0).references().into_iter().map(|id| point(file, id)).collect::<Option<_>>()?
    } else if record.is("IFCINDEXEDPOLYCURVE") && record.at(1).list().is_empty() {
        let list = file.record(record.at(0).reference()?)?;
        let at = |p: &crate::kernel::Value<'_>, i: usize| p.list().get(i).map_or(Some(0.0), |x| x.number());
        list.at(0).list().iter().map(|p| Some(Point3::new(at(p, 0)?, at(p, 1)?, at(p, 2)?))).collect::<Option<_>>()?
    } else {
        return None;
    };
    (2..=POINTS_MAX).contains(&points.len()).then_some(points)
}

/// Twice the area; negative of a polygon that runs clockwise.
fn area(polygon: &[Point2<f64>]) -> f64 {
    let next = polygon.iter().cycle().skip(1);
    std::iter::zip(polygon, next).map(|(a, b)| a.coords.perp(&b.coords)).sum()
}

#[cfg(test)]
mod tests {
    use crate::GeometryStatus;
    use crate::testing::{BASICS, file, file_of, read};
    use diagnostics::Severity;
    use nalgebra::Vector3;

    /// Enclosed volume and upper corner of the body that consists of item `#4`.
    fn check(records: &str, volume: f64, high: [f64; 3]) {
        let (model, diagnostics) = read(&file(&format!(
            "{BASICS}#1=IFCWALL('wall',$,'W',$,$,#103,#2,$,$);#2=IFCPRODUCTDEFINITIONSHAPE($,$,(#3));
             #3=IFCSHAPEREPRESENTATION(#101,'Body','SolidModel',(#4));{records}"
        )))
        .unwrap();
        let geometry = &model.elements[0].geometry;
        assert_eq!(geometry.status, GeometryStatus::Meshed, "{diagnostics:?}");
        let part = &geometry.parts[0];
        let corners: Vec<Vector3<f64>> =
            part.positions_m.iter().map(|p| Vector3::from(part.origin_m) + Vector3::from(p.map(f64::from))).collect();
        let six: f64 = part
            .triangles
            .iter()
            .map(|t| {
                let [a, b, c] = t.map(|v| corners[v as usize]);
                a.dot(&b.cross(&c))
            })
            .sum();
        assert!((six / 6.0 - volume).abs() < 1e-3 * volume, "{} instead of {volume}", six / 6.0);
        let found = [0, 1, 2].map(|i| corners.iter().map(|p| p[i]).fold(f64::MIN, f64::max));
        assert!(std::iter::zip(found, high).all(|(a, b)| (a - b).abs() < 1e-4), "{found:?}");
    }

    #[test]
    fn a_profile_is_swept_round_mitred_corners() {
        // 0.2 m upwards (x of the profile), 0.4 m across, along an L of 3 m and 2 m in the middle of the wall.
        let sweep = "#4=IFCSURFACECURVESWEPTAREASOLID(#5,#102,#6,0.,1.,#7);#5=IFCRECTANGLEPROFILEDEF(.AREA.,$,#113,0.2,0.4);
            #6=IFCPOLYLINE((#107,#8,#9));#7=IFCPLANE(#102);#8=IFCCARTESIANPOINT((3.,0.));#9=IFCCARTESIANPOINT((3.,2.));";
        check(sweep, 0.2 * 0.4 * 5.0, [3.2, 2.0, 0.1]);
        let round = sweep.replace("(#107,#8,#9)", "(#107,#8,#9,#10,#107)");
        check(&format!("{round}#10=IFCCARTESIANPOINT((0.,2.));"), 0.2 * 0.4 * 10.0, [3.2, 2.2, 0.1]);
    }

    #[test]
    fn round_primitives_are_meshed_alone_and_in_a_tree() {
        let area = 18.0 * libm::sin(std::f64::consts::TAU / 36.0);
        let cylinder = "IFCRIGHTCIRCULARCYLINDER(#102,2.,1.);";
        check(&format!("#4={cylinder}"), 2.0 * area, [1.0, 1.0, 2.0]);
        check(&format!("#4=IFCCSGSOLID(#5);#5={cylinder}"), 2.0 * area, [1.0, 1.0, 2.0]);
        check("#4=IFCRIGHTCIRCULARCONE(#102,3.,1.);", area, [1.0, 1.0, 3.0]);
        check("#4=IFCCSGSOLID(#5);#5=IFCRECTANGULARPYRAMID(#102,2.,1.,3.);", 2.0, [2.0, 1.0, 3.0]);
    }

    #[test]
    fn profiles_that_the_kernel_does_not_know_are_drawn_by_their_corners() {
        let solid = |profile: &str| format!("#4=IFCEXTRUDEDAREASOLID(#5,#102,#112,2.);#5={profile};");
        let moved = "#6=IFCAXIS2PLACEMENT2D(#7,$);#7=IFCCARTESIANPOINT((10.,0.));";
        let trapezium = solid("IFCTRAPEZIUMPROFILEDEF(.AREA.,$,#6,4.,2.,1.,0.5)");
        check(&format!("{trapezium}{moved}"), 2.0 * 3.0, [12.0, 0.5, 2.0]);
        let area = 2.0 * 18.0 * libm::sin(std::f64::consts::TAU / 36.0);
        check(&solid("IFCELLIPSEPROFILEDEF(.AREA.,$,$,2.,1.)"), 2.0 * area, [2.0, 1.0, 2.0]);
    }

    #[test]
    fn a_brep_by_its_supertype_is_drawn() {
        let corners = [(0, "0.,0.,0."), (1, "1.,0.,0."), (2, "0.,1.,0."), (3, "0.,0.,1.")];
        let points: String = corners.map(|(k, p)| format!("#{}=IFCCARTESIANPOINT(({p}));", 10 + k)).concat();
        let faces: String = [(0, "#10,#12,#11"), (1, "#10,#11,#13"), (2, "#11,#12,#13"), (3, "#12,#10,#13")]
            .map(|(k, corners)| {
                let (outline, bound, face) = (20 + k, 30 + k, 40 + k);
                format!("#{outline}=IFCPOLYLOOP(({corners}));#{bound}=IFCFACEOUTERBOUND(#{outline},.T.);#{face}=IFCFACE((#{bound}));")
            })
            .concat();
        let shell = "#5=IFCCLOSEDSHELL((#40,#41,#42,#43));#4=IFCMANIFOLDSOLIDBREP(#5);";
        check(&format!("{points}{faces}{shell}"), 1.0 / 6.0, [1.0, 1.0, 1.0]);
    }

    /// A wall with an opening, a mapped body and a plain one, as IFC2X3.
    fn building(schema: &str) -> String {
        file_of(
            schema,
            &format!(
                "{BASICS}#1=IFCWALL('1wallwallwallwallwall0',$,'W',$,$,#103,#121,$);
                 #2=IFCOPENINGELEMENT('1hole00000000000000000',$,$,$,$,#103,#3,$);#3=IFCPRODUCTDEFINITIONSHAPE($,$,(#4));
                 #4=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',(#5));#5=IFCEXTRUDEDAREASOLID(#6,#102,#112,1.);
                 #6=IFCRECTANGLEPROFILEDEF(.AREA.,$,#113,1.,1.);#7=IFCRELVOIDSELEMENT('1void00000000000000000',$,$,$,#1,#2);
                 #10=IFCCOLUMN('1column000000000000000',$,$,$,$,#103,#11,$);#11=IFCPRODUCTDEFINITIONSHAPE($,$,(#12));
                 #12=IFCSHAPEREPRESENTATION(#101,'Body','MappedRepresentation',(#13));#13=IFCMAPPEDITEM(#14,#15);
                 #14=IFCREPRESENTATIONMAP(#102,#120);#15=IFCCARTESIANTRANSFORMATIONOPERATOR3D($,$,#107,$,$);"
            ),
        )
    }

    fn bodies(text: &str) -> String {
        let (model, _) = read(text).unwrap();
        assert!(model.elements.iter().all(|e| e.geometry.status == GeometryStatus::Meshed), "{:?}", model.elements);
        format!("{:?} {:?}", model.elements, model.openings)
    }

    #[test]
    fn supertypes_of_shapes_are_drawn_like_the_subtypes() {
        let ordinary = building("IFC2X3");
        let expected = bodies(&ordinary);
        for (subtype, supertype) in [
            ("IFCPRODUCTDEFINITIONSHAPE(", "IFCPRODUCTREPRESENTATION("),
            ("IFCPRODUCTDEFINITIONSHAPE(", "IfcProductRepresentation ("),
            ("IFCSHAPEREPRESENTATION(", "IFCREPRESENTATION("),
        ] {
            let general = ordinary.replace(subtype, supertype);
            assert_ne!(general, ordinary);
            assert_eq!(bodies(&general), expected, "{supertype}");
        }
    }

    #[test]
    fn schemas_before_ifc2x3_are_read_as_it() {
        let expected = bodies(&building("IFC2X3"));
        for schema in ["IFC2X_FINAL", "IFC2X2_FINAL", "IFC2X2_ADD1"] {
            let text = building(schema);
            assert_eq!(bodies(&text), expected, "{schema}");
            let (model, diagnostics) = read(&text).unwrap();
            assert_eq!((model.source.schema.as_str(), diagnostics[0].code.name()), (schema, "schema_older"));
        }
    }

    #[test]
    fn entities_that_no_schema_has_are_reported() {
        let unknown = "#50=IFCDISCRETEWALL('1unknown00000000000000',$,$,$,$,#103,#121,$);#51=IFCDETAIL(1.);";
        let text = building("IFC2X3").replace("\nENDSEC;END", &format!("{unknown}#52=IFCDETAIL(2.);\nENDSEC;END"));
        let (_, diagnostics) = read(&text).unwrap();
        let found: Vec<(Severity, &str)> = diagnostics.iter().map(|d| (d.severity, d.message.as_str())).collect();
        let expected = [
            (Severity::Info, "IFCDETAIL #51 and 1 more: no IFC schema has this entity; it is skipped"),
            (Severity::Warning, "IFCDISCRETEWALL #50: no IFC schema has this entity; it is skipped"),
        ];
        assert_eq!(found, expected);
    }
}
