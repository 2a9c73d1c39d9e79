//! Where on earth does the building stand, as the file says?

use crate::kernel::File;
use crate::report::Report;
use crate::{Georeference, MapConversion};

/// IfcMapConversion with its IfcProjectedCRS, and true north of the model context.
pub(crate) fn read(file: &File<'_>, report: &mut Report) -> Georeference {
    let conversions = file.records("IfcMapConversion", report);
    let map_conversion = conversions.first().map(|record| {
        let number = |at: usize, default: f64| record.at(at).number().unwrap_or(default);
        let crs = record.at(1).reference().and_then(|id| file.record(id)).map(|crs| crs.text(0)).unwrap_or_default();
        MapConversion {
            crs,
            eastings_northings_height: [number(2, 0.0), number(3, 0.0), number(4, 0.0)],
            x_axis: [number(5, 1.0), number(6, 0.0)],
            scale: number(7, 1.0),
        }
    });
    let contexts = file.records("IfcGeometricRepresentationContext", report);
    let true_north = contexts
        .iter()
        .filter(|c| c.is("IFCGEOMETRICREPRESENTATIONCONTEXT"))
        .filter(|c| !c.text(1).eq_ignore_ascii_case("plan"))
        .filter_map(|c| c.at(5).reference())
        .find_map(|id| {
            let ratios = file.record_of(id, "IFCDIRECTION")?;
            let [x, y] = [0, 1].map(|i| ratios.at(0).list().get(i).and_then(|r| r.number()));
            Some([x?, y?])
        });
    Georeference { map_conversion, true_north }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{file, with_file};

    #[test]
    fn map_conversion_and_true_north_are_read() {
        let text = file(
            "#1=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,$,#2);#2=IFCDIRECTION((0.5,0.8));
             #3=IFCMAPCONVERSION(#1,#4,458870.,5438232.,110.,0.9,0.1,$);#4=IFCPROJECTEDCRS('EPSG:25832',$,$,$,$,$,$);",
        );
        let found = with_file(&text, |file| read(file, &mut Report::default()));
        assert_eq!(found.true_north, Some([0.5, 0.8]));
        let conversion = found.map_conversion.unwrap();
        assert_eq!(conversion.crs, "EPSG:25832");
        assert_eq!(conversion.eastings_northings_height, [458870.0, 5438232.0, 110.0]);
        assert_eq!((conversion.x_axis, conversion.scale), ([0.9, 0.1], 1.0));
    }
}
