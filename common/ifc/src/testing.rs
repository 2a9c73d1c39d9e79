//! Minimal files for tests.

use crate::header;
use crate::kernel::File;
use crate::wide_ids::WrittenIds;
use diagnostics::{Diagnostic, Report};

/// A complete IFC4 file around the records.
pub(crate) fn file(records: &str) -> String {
    file_of("IFC4", records)
}

pub(crate) fn file_of(schema: &str, records: &str) -> String {
    format!(
        "ISO-10303-21;HEADER;FILE_DESCRIPTION((''),'2;1');FILE_NAME('','',(''),(''),'','','');\
         FILE_SCHEMA(('{schema}'));ENDSEC;DATA;\n{records}\nENDSEC;END-ISO-10303-21;"
    )
}

/// Metre project with a model context `#101`, a placement `#103` at the origin and a 2 x 1 x 3 m box `#110`.
pub(crate) const BASICS: &str = "
    #100=IFCPROJECT('project',$,'P',$,$,$,$,(#101),#104);#101=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,#102,$);
    #102=IFCAXIS2PLACEMENT3D(#107,$,$);#103=IFCLOCALPLACEMENT($,#102);#104=IFCUNITASSIGNMENT((#105,#106));
    #105=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);#106=IFCSIUNIT(*,.PLANEANGLEUNIT.,$,.RADIAN.);
    #107=IFCCARTESIANPOINT((0.,0.,0.));#110=IFCEXTRUDEDAREASOLID(#111,#102,#112,3.);
    #111=IFCRECTANGLEPROFILEDEF(.AREA.,$,#113,2.,1.);#112=IFCDIRECTION((0.,0.,1.));
    #113=IFCAXIS2PLACEMENT2D(#114,$);#114=IFCCARTESIANPOINT((0.,0.));
    #120=IFCSHAPEREPRESENTATION(#101,'Body','SweptSolid',(#110));#121=IFCPRODUCTDEFINITIONSHAPE($,$,(#120));
";

/// Scans the text, which must be whole.
pub(crate) fn with_file<T>(text: &str, work: impl FnOnce(&File<'_>) -> T) -> T {
    let mut report = Report::default();
    let header = header::read(text.as_bytes(), &mut report).unwrap();
    work(&File::scan(text.as_bytes(), header.schema, WrittenIds::default(), &mut report).unwrap())
}

/// Reads the text with one thread.
pub(crate) fn read(text: &str) -> Result<(crate::Model, Vec<Diagnostic>), crate::ReadError> {
    crate::read(text.as_bytes(), &crate::ReadOptions::default())
}

/// Volume that the faces of a part enclose; negative if they look inward.
pub(crate) fn volume_m3(part: &crate::MeshPart) -> f32 {
    let six_times: f32 = part
        .triangles
        .iter()
        .map(|t| {
            let [a, b, c] = t.map(|v| part.positions_m[v as usize]);
            a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
        })
        .sum();
    six_times / 6.0
}
