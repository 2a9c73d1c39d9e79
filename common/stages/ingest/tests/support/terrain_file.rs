//! Writes a small terrain in each form in which files have it.
#![allow(dead_code, reason = "every test file uses a part of this")]

use std::fmt::Write;

/// What the faces are written as.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Form {
    Network,
    TriangulatedFaceSet,
    /// With a list of indices of points between triangles and points.
    IndexedFaceSet,
    PolygonalFaceSet,
    ShellBased,
    FaceBased,
    /// A solid down to 5 m below the lowest point.
    Brep,
}

impl Form {
    pub(crate) const ALL: [Self; 7] = [
        Self::Network,
        Self::TriangulatedFaceSet,
        Self::IndexedFaceSet,
        Self::PolygonalFaceSet,
        Self::ShellBased,
        Self::FaceBased,
        Self::Brep,
    ];
}

/// A terrain and how it is written.
#[derive(Debug, Clone)]
pub(crate) struct TerrainFile {
    pub(crate) schema: &'static str,
    /// Entity, and its attributes behind the representation.
    pub(crate) owner: (&'static str, &'static str),
    pub(crate) form: Form,
    /// Identifier of the representation.
    pub(crate) identifier: &'static str,
    /// Metres per unit: 1 or 0.001.
    pub(crate) unit_m: f64,
    /// In metres, in the world.
    pub(crate) points: Vec<[f64; 3]>,
    pub(crate) triangles: Vec<[i64; 3]>,
    /// Of a network.
    pub(crate) flags: Option<Vec<i64>>,
    /// Records behind all others, from #1000 on.
    pub(crate) more: String,
}

/// A field of n by n points, so many metres apart, from a corner.
pub(crate) fn field(
    n: usize,
    apart_m: f64,
    corner: [f64; 2],
    z: impl Fn(f64, f64) -> f64,
) -> (Vec<[f64; 3]>, Vec<[i64; 3]>) {
    let points = (0..n * n).map(|k| {
        let [x, y] = [(k % n) as f64 * apart_m, (k / n) as f64 * apart_m];
        [corner[0] + x, corner[1] + y, z(x, y)]
    });
    let squares = (0..n - 1).flat_map(|y| (0..n - 1).map(move |x| (y * n + x) as i64 + 1));
    let triangles = squares.flat_map(|k| [[k, k + 1, k + 1 + n as i64], [k, k + 1 + n as i64, k + n as i64]]);
    (points.collect(), triangles.collect())
}

impl TerrainFile {
    /// A slope of 20 x 20 m on a geographic element.
    pub(crate) fn slope(form: Form) -> Self {
        let (points, triangles) = field(5, 5.0, [100.0, 50.0], |x, y| 80.0 + x * 0.05 + y * 0.02);
        Self {
            schema: "IFC4X3_ADD2",
            owner: ("IFCGEOGRAPHICELEMENT", "$,.TERRAIN."),
            form,
            identifier: "Body",
            unit_m: 1.0,
            points,
            triangles,
            flags: None,
            more: String::new(),
        }
    }

    pub(crate) fn text(&self) -> String {
        let prefix = if self.unit_m == 1.0 { "$" } else { ".MILLI." };
        let mut text = format!(
            "ISO-10303-21;HEADER;FILE_DESCRIPTION((''),'2;1');FILE_NAME('','',(''),(''),'','','');FILE_SCHEMA(('{}'));ENDSEC;DATA;
             #1=IFCPROJECT('project',$,'P',$,$,$,$,(#2),#4);#2=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,#3,$);
             #3=IFCAXIS2PLACEMENT3D(#6,$,$);#4=IFCUNITASSIGNMENT((#5));#5=IFCSIUNIT(*,.LENGTHUNIT.,{prefix},.METRE.);
             #6=IFCCARTESIANPOINT((0.,0.,0.));#7=IFCLOCALPLACEMENT($,#3);\n",
            self.schema
        );
        let mut next = 10_000;
        let mut add = |text: &mut String, record: String| {
            next += 1;
            let _ = writeln!(text, "#{next}={record};");
            next
        };
        let item = self.item(&mut text, &mut add);
        let (entity, rest) = self.owner;
        let _ = write!(
            text,
            "#8=IFCSHAPEREPRESENTATION(#2,'{}','SurfaceModel',(#{item}));#9=IFCPRODUCTDEFINITIONSHAPE($,$,(#8));\n\
             #10={entity}('terrain',$,'Terrain',$,$,#7,#9,{rest});\n{}\nENDSEC;END-ISO-10303-21;",
            self.identifier, self.more
        );
        text
    }

    fn item(&self, text: &mut String, add: &mut dyn FnMut(&mut String, String) -> u64) -> u64 {
        let point = |p: &[f64; 3]| {
            let [x, y, z] = p.map(|c| c / self.unit_m);
            format!("({x:?},{y:?},{z:?})")
        };
        let tuples =
            |list: &[[i64; 3]]| list.iter().map(|[a, b, c]| format!("({a},{b},{c})")).collect::<Vec<_>>().join(",");
        let mut list = |text: &mut String, points: &[[f64; 3]]| {
            let all: Vec<String> = points.iter().map(point).collect();
            add(text, format!("IFCCARTESIANPOINTLIST3D(({}))", all.join(",")))
        };
        let triangles = tuples(&self.triangles);
        match self.form {
            Form::Network => {
                let points = list(text, &self.points);
                let flags = self.flags.clone().unwrap_or_else(|| vec![0; self.triangles.len()]);
                let flags: Vec<String> = flags.iter().map(i64::to_string).collect();
                let flags = flags.join(",");
                add(text, format!("IFCTRIANGULATEDIRREGULARNETWORK(#{points},$,.F.,({triangles}),$,({flags}))"))
            }
            Form::TriangulatedFaceSet => {
                let points = list(text, &self.points);
                add(text, format!("IFCTRIANGULATEDFACESET(#{points},$,.F.,({triangles}),$)"))
            }
            Form::IndexedFaceSet => {
                let turned: Vec<[f64; 3]> = self.points.iter().rev().copied().collect();
                let points = list(text, &turned);
                let indices: Vec<String> = (1..=self.points.len()).rev().map(|k| k.to_string()).collect();
                let indices = indices.join(",");
                add(text, format!("IFCTRIANGULATEDFACESET(#{points},$,.F.,({triangles}),({indices}))"))
            }
            Form::PolygonalFaceSet => {
                let points = list(text, &self.points);
                let faces: Vec<String> = self
                    .triangles
                    .iter()
                    .map(|[a, b, c]| format!("#{}", add(text, format!("IFCINDEXEDPOLYGONALFACE(({a},{b},{c}))"))))
                    .collect();
                add(text, format!("IFCPOLYGONALFACESET(#{points},.F.,({}),$)", faces.join(",")))
            }
            Form::ShellBased => {
                let faces = self.faces(text, add);
                let shell = add(text, format!("IFCOPENSHELL(({faces}))"));
                add(text, format!("IFCSHELLBASEDSURFACEMODEL((#{shell}))"))
            }
            Form::FaceBased => {
                let faces = self.faces(text, add);
                let set = add(text, format!("IFCCONNECTEDFACESET(({faces}))"));
                add(text, format!("IFCFACEBASEDSURFACEMODEL((#{set}))"))
            }
            Form::Brep => {
                let faces = self.solid().faces(text, add);
                let shell = add(text, format!("IFCCLOSEDSHELL(({faces}))"));
                add(text, format!("IFCFACETEDBREP(#{shell})"))
            }
        }
    }

    fn faces(&self, text: &mut String, add: &mut dyn FnMut(&mut String, String) -> u64) -> String {
        let point = |p: &[f64; 3]| {
            let [x, y, z] = p.map(|c| c / self.unit_m);
            format!("IFCCARTESIANPOINT(({x:?},{y:?},{z:?}))")
        };
        let points: Vec<u64> = self.points.iter().map(|p| add(text, point(p))).collect();
        let mut face = |t: &[i64; 3]| {
            let corners = t.map(|k| format!("#{}", points[k as usize - 1])).join(",");
            let polyloop = add(text, format!("IFCPOLYLOOP(({corners}))"));
            let bound = add(text, format!("IFCFACEOUTERBOUND(#{polyloop},.T.)"));
            format!("#{}", add(text, format!("IFCFACE((#{bound}))")))
        };
        self.triangles.iter().map(&mut face).collect::<Vec<_>>().join(",")
    }

    /// The faces with an underside and sides.
    fn solid(&self) -> Self {
        let mut solid = self.clone();
        let n = self.points.len() as i64;
        let lowest = self.points.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min) - 5.0;
        solid.points.extend(self.points.iter().map(|[x, y, _]| [*x, *y, lowest]));
        solid.triangles.extend(self.triangles.iter().map(|[a, b, c]| [a + n, c + n, b + n]));
        let edges = || self.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
        for [a, b] in edges().filter(|[a, b]| !edges().any(|other| other == [*b, *a])) {
            solid.triangles.extend([[b, a, a + n], [b, a + n, b + n]]);
        }
        solid
    }
}
