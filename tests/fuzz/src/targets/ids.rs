//! IDS files: an IDS text, and a zero byte and an IFC file behind it if there are any.

use ids::{Ids, Scope};

/// A house that specifications apply to, for inputs without one.
const HOUSE: &[u8] = b"ISO-10303-21;HEADER;FILE_SCHEMA(('IFC4'));ENDSEC;DATA;\
    #1=IFCPROJECT('p',$,'P',$,$,$,$,$,#2);#2=IFCUNITASSIGNMENT((#3));#3=IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.);\
    #4=IFCWALL('w',$,'W',$,$,$,$,$,.SOLIDWALL.);#5=IFCDOOR('d',$,'D',$,$,$,$,$,2000.,900.,.DOOR.,$,$);\
    #6=IFCOPENINGELEMENT('o',$,$,$,$,$,$,$,$);#7=IFCRELVOIDSELEMENT('v',$,$,$,#4,#6);#8=IFCRELFILLSELEMENT('f',$,$,$,#6,#5);\
    #9=IFCPROPERTYSET('s',$,'Set',$,(#10,#11));#10=IFCPROPERTYSINGLEVALUE('A',$,IFCLENGTHMEASURE(12.),$);\
    #11=IFCPROPERTYBOUNDEDVALUE('B',$,IFCREAL(2.),IFCREAL(1.),$,$);#12=IFCRELDEFINESBYPROPERTIES('r',$,$,$,(#4,#5),#9);\
    #13=IFCMATERIAL('Brick',$,$);#14=IFCRELASSOCIATESMATERIAL('m',$,$,$,(#4),#13);#15=IFCCLASSIFICATION($,$,$,'Sys',$,$,$);\
    #16=IFCCLASSIFICATIONREFERENCE($,'1.2',$,#15,$,$);#17=IFCRELASSOCIATESCLASSIFICATION('c',$,$,$,(#4),#16);\
    ENDSEC;END-ISO-10303-21;";

/// Reads the file and checks the house by it; what comes out hangs together and can be written.
pub fn run(bytes: &[u8]) {
    let at = memchr::memchr(0, bytes).unwrap_or(bytes.len());
    let (text, ifc) = bytes.split_at(at);
    let Ok(ids) = Ids::read(text) else { return };
    let ifc = ifc.get(1..).filter(|ifc| !ifc.is_empty()).unwrap_or(HOUSE);
    let Ok(report) = ids::check(&ids, ifc, Scope::All) else { return };
    for specification in &report.specifications {
        let n_applicable = specification.n_applicable.expect("all are checked");
        assert!(specification.n_failed <= n_applicable);
        assert!(
            specification
                .requirements
                .iter()
                .all(|r| specification.prohibited.is_empty() && r.n_passed + r.failed.len() == n_applicable)
        );
    }
    assert!(!report.text().is_empty());
}
