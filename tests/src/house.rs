//! Small models written by hand: elements with one body each on one storey at 0.

use std::fmt::Write;
use std::path::{Path, PathBuf};

/// A model in metres; bodies are given in the world.
pub struct House {
    schema: &'static str,
    records: String,
    on_storey: Vec<usize>,
    /// Storeys and their spaces.
    spaces: Vec<(usize, usize)>,
    storeys: Vec<usize>,
    n_records: usize,
}

/// Records up to here are those of every model.
const FIRST: usize = 20;

/// Attributes behind the representation that are not given.
pub const PLAIN: &str = "$,$";

impl House {
    pub fn new(schema: &'static str) -> Self {
        let (on_storey, spaces, storeys) = (Vec::new(), Vec::new(), vec![8]);
        Self { schema, records: String::new(), on_storey, spaces, storeys, n_records: FIRST }
    }

    fn record(&mut self, text: &str) -> usize {
        self.n_records += 1;
        writeln!(self.records, "#{}={text};", self.n_records).unwrap();
        self.n_records
    }

    /// An upright prism: its outline in x and z, and from where to where it goes along y. Returns its product definition.
    fn prism(&mut self, outline: &[[f64; 2]], [y0, y1]: [f64; 2]) -> usize {
        let corners: Vec<String> = outline
            .iter()
            .chain(&outline[..1])
            .map(|[x, z]| format!("#{}", self.record(&format!("IFCCARTESIANPOINT(({x:?},{z:?}))"))))
            .collect();
        let line = self.record(&format!("IFCPOLYLINE(({}))", corners.join(",")));
        let profile = self.record(&format!("IFCARBITRARYCLOSEDPROFILEDEF(.AREA.,$,#{line})"));
        let at = self.record(&format!("IFCCARTESIANPOINT((0.,{y1:?},0.))"));
        let place = self.record(&format!("IFCAXIS2PLACEMENT3D(#{at},#12,#13)"));
        let depth = y1 - y0;
        let solid = self.record(&format!("IFCEXTRUDEDAREASOLID(#{profile},#{place},#14,{depth:?})"));
        let shape = self.record(&format!("IFCSHAPEREPRESENTATION(#2,'Body','SweptSolid',(#{solid}))"));
        self.record(&format!("IFCPRODUCTDEFINITIONSHAPE($,$,(#{shape}))"))
    }

    /// An element of the storey; `rest` are its attributes behind the representation. Returns its record.
    pub fn add_prism(&mut self, entity: &str, name: &str, rest: &str, outline: &[[f64; 2]], y: [f64; 2]) -> usize {
        let body = self.prism(outline, y);
        let element = self.record(&format!("{entity}('{:0>22}',$,'{name}',$,$,#7,#{body},{rest})", self.n_records));
        self.on_storey.push(element);
        element
    }

    /// An element of the storey that is a box, from corner to corner.
    pub fn add(&mut self, entity: &str, name: &str, rest: &str, [min, max]: [[f64; 3]; 2]) -> usize {
        let outline = [[min[0], min[2]], [max[0], min[2]], [max[0], max[2]], [min[0], max[2]]];
        self.add_prism(entity, name, rest, &outline, [min[1], max[1]])
    }

    /// An element of the storey without a body. Returns its record.
    pub fn add_bodiless(&mut self, entity: &str, name: &str, rest: &str) -> usize {
        let element = self.record(&format!("{entity}('{:0>22}',$,'{name}',$,$,#7,$,{rest})", self.n_records));
        self.on_storey.push(element);
        element
    }

    /// An opening of an element that is a box. Returns its record.
    pub fn add_opening(&mut self, host: usize, corners: [[f64; 3]; 2]) -> usize {
        let opening = self.add("IFCOPENINGELEMENT", "Opening", PLAIN, corners);
        self.on_storey.pop();
        self.record(&format!("IFCRELVOIDSELEMENT('v{opening}',$,$,$,#{host},#{opening})"));
        opening
    }

    /// Lets an element fill an opening.
    pub fn fill(&mut self, opening: usize, element: usize) {
        self.record(&format!("IFCRELFILLSELEMENT('f{element}',$,$,$,#{opening},#{element})"));
    }

    /// Makes elements parts of another one.
    pub fn aggregate(&mut self, whole: usize, parts: &[usize]) {
        let parts: Vec<String> = parts.iter().map(|part| format!("#{part}")).collect();
        self.record(&format!("IFCRELAGGREGATES('a{whole}',$,$,$,#{whole},({}))", parts.join(",")));
    }

    /// Panels of a door: operation, position, and share of the width.
    pub fn add_panels(&mut self, door: usize, panels: &[(&str, &str, f64)]) {
        for (k, (operation, position, share)) in panels.iter().enumerate() {
            let panel = self.record(&format!(
                "IFCDOORPANELPROPERTIES('p{door}_{k}',$,$,$,0.05,.{operation}.,{share:?},.{position}.,$)"
            ));
            self.record(&format!("IFCRELDEFINESBYPROPERTIES('d{door}_{k}',$,$,$,(#{door}),#{panel})"));
        }
    }

    /// A room that is a box.
    pub fn add_room(&mut self, name: &str, corners: [[f64; 3]; 2]) {
        self.add_space(name, "INTERNAL", corners);
    }

    /// A space of this PredefinedType that is a box.
    pub fn add_space(&mut self, name: &str, predefined_type: &str, corners: [[f64; 3]; 2]) {
        let room = self.add("IFCSPACE", name, &format!("$,.ELEMENT.,.{predefined_type}.,$"), corners);
        self.on_storey.pop();
        self.spaces.push((self.storeys[self.storeys.len() - 1], room));
    }

    /// One more storey, of the spaces from here on; what stands on it is told by heights.
    pub fn add_storey(&mut self, name: &str, z: f64) {
        let at = self.record(&format!("IFCCARTESIANPOINT((0.,0.,{z:?}))"));
        let axes = self.record(&format!("IFCAXIS2PLACEMENT3D(#{at},$,$)"));
        let place = self.record(&format!("IFCLOCALPLACEMENT($,#{axes})"));
        let id = format!("{:0>22}", self.n_records + 1);
        let storey = self.record(&format!("IFCBUILDINGSTOREY('{id}',$,'{name}',$,$,#{place},$,$,.ELEMENT.,{z:?})"));
        self.storeys.push(storey);
    }

    /// Elements from here on are contained nowhere, and so are those before.
    pub fn contain_nothing(&mut self) {
        self.on_storey.clear();
    }

    /// A record that nothing uses: what follows has other GlobalIds.
    pub fn add_unused(&mut self) {
        self.record("IFCCARTESIANPOINT((0.,0.,0.))");
    }

    /// A text property of an element.
    pub fn add_text_property(&mut self, element: usize, set: &str, property: &str, text: &str) {
        let value = self.record(&format!("IFCPROPERTYSINGLEVALUE('{property}',$,IFCTEXT('{text}'),$)"));
        let set = self.record(&format!("IFCPROPERTYSET('p{element}',$,'{set}',$,(#{value}))"));
        self.record(&format!("IFCRELDEFINESBYPROPERTIES('d{element}',$,$,$,(#{element}),#{set})"));
    }

    /// Walls of 0.2 m around a rectangle in plan, from `z` up, with nothing in them.
    pub fn add_walls(&mut self, [x0, y0, x1, y1]: [f64; 4], z: [f64; 2]) {
        let walls = [
            [[x0 - 0.2, y0 - 0.2], [x1 + 0.2, y0]],
            [[x0 - 0.2, y1], [x1 + 0.2, y1 + 0.2]],
            [[x0 - 0.2, y0], [x0, y1]],
            [[x1, y0], [x1 + 0.2, y1]],
        ];
        for [[x0, y0], [x1, y1]] in walls {
            self.add("IFCWALL", "Wall", PLAIN, [[x0, y0, z[0]], [x1, y1, z[1]]]);
        }
    }

    /// Writes the model into a folder.
    pub fn write(&self, folder: &Path) -> PathBuf {
        let list = |ids: &[usize]| ids.iter().map(|id| format!("#{id}")).collect::<Vec<_>>().join(",");
        let mut relations = String::new();
        if !self.on_storey.is_empty() {
            let on_storey = list(&self.on_storey);
            relations += &format!("#10=IFCRELCONTAINEDINSPATIALSTRUCTURE('c',$,$,$,({on_storey}),#8);\n");
        }
        for (k, storey) in self.storeys.iter().enumerate() {
            let own: Vec<usize> = self.spaces.iter().filter(|(of, _)| of == storey).map(|(_, space)| *space).collect();
            if !own.is_empty() {
                let (id, spaces) = (self.n_records + 1 + k, list(&own));
                relations += &format!("#{id}=IFCRELAGGREGATES('s{k}',$,$,$,#{storey},({spaces}));\n");
            }
        }
        let text = format!(
            "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n\
             FILE_SCHEMA(('{}'));\nENDSEC;\nDATA;\n\
             #1=IFCPROJECT('0000000000000000000001',$,'P',$,$,$,$,(#2),#3);\n\
             #2=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,#4,$);\n\
             #3=IFCUNITASSIGNMENT((#5));\n#4=IFCAXIS2PLACEMENT3D(#6,$,$);\n\
             #5=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);\n#6=IFCCARTESIANPOINT((0.,0.,0.));\n\
             #7=IFCLOCALPLACEMENT($,#4);\n\
             #8=IFCBUILDINGSTOREY('0000000000000000000008',$,'Ground',$,$,#7,$,$,.ELEMENT.,0.);\n\
             #9=IFCRELAGGREGATES('0000000000000000000009',$,$,$,#1,({}));\n\
             #12=IFCDIRECTION((0.,-1.,0.));\n#13=IFCDIRECTION((1.,0.,0.));\n#14=IFCDIRECTION((0.,0.,1.));\n\
             {}{relations}ENDSEC;\nEND-ISO-10303-21;\n",
            self.schema,
            list(&self.storeys),
            self.records
        );
        let path = folder.join("house.ifc");
        std::fs::write(&path, text).unwrap();
        path
    }
}
