//! The place of the model's world on earth: IfcMapConversion and its relatives, their substitutes in property sets, true north.
//!
//! A map conversion multiplies coordinates in the project's unit by Scale, turns them, and adds eastings, northings and height in
//! the MapUnit of the IfcProjectedCRS (the project's unit where it names none). What leaves this module is in metres.

use crate::kernel::{File, Record};
use crate::products::named;
use crate::property_sets::PropertySets;
use crate::relations::Relations;
use crate::units::{self, LengthUnit};
use crate::{Georeference, MapConversion, Property, PropertyValue};
use diagnostics::{DiagnosticCode, Named, Report, Severity};

/// Metres on the map per metre of the model. Projections stay within these bounds; a unit taken for another does not.
const SCALES: std::ops::RangeInclusive<f64> = 0.4..=2.5;

/// Easting and northing of no projected system are farther from its origin.
const FARTHEST_M: f64 = 1e8;

/// Property sets that stand for IfcMapConversion and IfcProjectedCRS in IFC2X3, in any case.
pub const MAP_CONVERSION_SETS: [&str; 2] = ["ePSet_MapConversion", "ePSet_ProjectedCRS"];

/// A map conversion as written, before units are applied.
struct WrittenConversion {
    entity: Named,
    crs: String,
    /// Name of the map's unit and metres per unit.
    map_unit: (String, f64),
    /// Eastings, northings, orthogonal height in the map's unit.
    origin: [f64; 3],
    /// XAxisAbscissa and XAxisOrdinate.
    x_axis: [Option<f64>; 2],
    /// Factor from the project's unit to the map's, per axis; `None` for a rigid operation, which has none.
    scale: Option<[f64; 3]>,
}

/// Map conversion and true north.
pub(crate) fn read(
    file: &File<'_>,
    relations: &Relations,
    unit: Option<&LengthUnit>,
    report: &mut Report,
) -> Georeference {
    let map_conversion = unit.and_then(|unit| map_conversion(file, relations, unit, report));
    Georeference { map_conversion, true_north: true_north(file, report) }
}

/// The first coordinate operation that can be used, else the property sets of the site or the project that stand for one.
fn map_conversion(
    file: &File<'_>,
    relations: &Relations,
    unit: &LengthUnit,
    report: &mut Report,
) -> Option<MapConversion> {
    for record in file.records("IfcCoordinateOperation", report) {
        let written = operation(file, &record, unit).and_then(|written| in_metres(written, unit, report));
        match written {
            Ok(conversion) => return Some(conversion),
            Err(why) => {
                report.add(Severity::Warning, DiagnosticCode::MapConversionUnusable, Some(entity(file, &record)), why)
            }
        }
    }
    let mut psets = PropertySets::new(file);
    let owners = ["IfcSite", "IfcProject"].into_iter().flat_map(|entity| file.all(entity));
    for (span, _) in owners {
        let properties = psets.of(span.id, relations);
        let Some(record) = file.record(span.id) else { continue };
        let Some(written) = property_sets(&properties, named(file, &record), file, unit) else { continue };
        match written.and_then(|written| in_metres(written, unit, report)) {
            Ok(conversion) => return Some(conversion),
            Err(why) => {
                report.add(Severity::Warning, DiagnosticCode::MapConversionUnusable, Some(named(file, &record)), why)
            }
        }
    }
    None
}

/// An operation has no GlobalId: its keyword stands for a name.
fn entity(file: &File<'_>, record: &Record<'_>) -> Named {
    Named { step_id: file.written_id(record.id), name: record.keyword.to_owned(), ..Named::default() }
}

/// IfcMapConversion, IfcMapConversionScaled or IfcRigidOperation.
fn operation(file: &File<'_>, record: &Record<'_>, unit: &LengthUnit) -> Result<WrittenConversion, String> {
    let crs = record.at(1).reference().and_then(|id| file.record(id)).ok_or("it names no target system")?;
    if !crs.is("IFCPROJECTEDCRS") {
        return Err(format!("its target {} #{} is no IfcProjectedCRS", crs.keyword, file.written_id(crs.id)));
    }
    let map_unit = match crs.at(6).reference() {
        Some(id) => units::metres_per(file, id)
            .ok_or_else(|| format!("MapUnit #{} has no usable factor to metres", file.written_id(id)))?,
        None => (units::name(file, unit), unit.metres),
    };
    let number = |at: usize| record.at(at).number();
    let origin =
        [number(2).ok_or("it has no eastings")?, number(3).ok_or("it has no northings")?, number(4).unwrap_or(0.0)];
    let written = WrittenConversion {
        entity: entity(file, record),
        crs: crs.text(0),
        map_unit,
        origin,
        x_axis: [None; 2],
        scale: None,
    };
    if record.is("IFCRIGIDOPERATION") {
        return Ok(written);
    }
    let scale = number(7).unwrap_or(1.0);
    // FactorX, FactorY, FactorZ; release candidates of IFC4X3 had ScaleY and ScaleZ instead.
    let factors = if record.is("IFCMAPCONVERSIONSCALED") {
        [8, 9, 10].map(|at| scale * number(at).unwrap_or(1.0))
    } else {
        [scale, number(8).unwrap_or(scale), number(9).unwrap_or(scale)]
    };
    Ok(WrittenConversion { x_axis: [number(5), number(6)], scale: Some(factors), ..written })
}

/// `ePSet_MapConversion` and `ePSet_ProjectedCRS`, which stand for the entities in IFC2X3; `None` without the former.
fn property_sets(
    properties: &[Property],
    owner: Named,
    file: &File<'_>,
    unit: &LengthUnit,
) -> Option<Result<WrittenConversion, String>> {
    let of = |set: &'static str| properties.iter().filter(move |p| p.set.eq_ignore_ascii_case(set));
    of(MAP_CONVERSION_SETS[0]).next()?;
    let number = |name: &str| {
        let property = of(MAP_CONVERSION_SETS[0]).find(|p| p.name.eq_ignore_ascii_case(name))?;
        match &property.value {
            PropertyValue::Number(number) => Some(*number),
            PropertyValue::Text(text) => text.trim().parse().ok(),
            PropertyValue::Boolean(_) => None,
        }
    };
    let text = |set: &'static str, name: &str| match &of(set).find(|p| p.name.eq_ignore_ascii_case(name))?.value {
        PropertyValue::Text(text) => Some(text.trim().to_owned()).filter(|t| !t.is_empty()),
        _ => None,
    };
    let read = || {
        let map_unit = match text(MAP_CONVERSION_SETS[1], "MapUnit") {
            Some(name) => units::metres_of_name(&name)
                .map(|metres| (name.clone(), metres))
                .ok_or_else(|| format!("MapUnit {name:?} of ePSet_ProjectedCRS is no unit of length that is known"))?,
            None => (units::name(file, unit), unit.metres),
        };
        let crs = text(MAP_CONVERSION_SETS[1], "Name").or_else(|| text(MAP_CONVERSION_SETS[0], "TargetCRS"));
        let origin = [
            number("Eastings").ok_or("ePSet_MapConversion has no Eastings")?,
            number("Northings").ok_or("ePSet_MapConversion has no Northings")?,
            number("OrthogonalHeight").unwrap_or(0.0),
        ];
        Ok(WrittenConversion {
            entity: owner.clone(),
            crs: crs.unwrap_or_default(),
            map_unit,
            origin,
            x_axis: [number("XAxisAbscissa"), number("XAxisOrdinate")],
            scale: Some([number("Scale").unwrap_or(1.0); 3]),
        })
    };
    Some(read())
}

fn in_metres(written: WrittenConversion, unit: &LengthUnit, report: &mut Report) -> Result<MapConversion, String> {
    let (map_unit, map_unit_m) = written.map_unit;
    let x_axis = unit_vector(written.x_axis).ok_or("XAxisAbscissa and XAxisOrdinate are no direction")?;
    let factors = written.scale.unwrap_or([unit.metres / map_unit_m; 3]);
    if factors.iter().any(|factor| !(factor.is_finite() && *factor > 0.0)) {
        return Err("its scale is not a positive number".to_owned());
    }
    let literal = factors.map(|factor| factor * map_unit_m / unit.metres);
    let are_scales = |scale: &[f64; 3]| scale.iter().all(|s| SCALES.contains(s));
    // Many exporters leave Scale at 1 although the units differ.
    let scale = if are_scales(&literal) || !are_scales(&factors) { literal } else { factors };
    let mut warn = |message: String| {
        report.add(Severity::Warning, DiagnosticCode::MapConversionDoubtful, Some(written.entity.clone()), message);
    };
    if scale != literal {
        warn(format!(
            "Scale {} between a model in units of {} m and a map in {map_unit} would make a metre {:.4} m: it is taken as a \
             ratio of metres",
            factors[0], unit.metres, literal[0]
        ));
    } else if !are_scales(&scale) {
        warn(format!("a metre of the model is {:.4} m on the map: check Scale and MapUnit", scale[0]));
    }
    let origin_m = written.origin.map(|x| x * map_unit_m);
    if origin_m[..2].iter().any(|x| x.abs() > FARTHEST_M) {
        warn(format!(
            "eastings and northings of {:.0} m and {:.0} m are on no map: check whether they are really in the MapUnit {map_unit}",
            origin_m[0], origin_m[1]
        ));
    }
    Ok(MapConversion { crs: written.crs, map_unit, map_unit_m, origin_m, x_axis, scale })
}

/// (1, 0) where neither is given; `None` for what has no direction.
fn unit_vector(direction: [Option<f64>; 2]) -> Option<[f64; 2]> {
    if direction == [None; 2] {
        return Some([1.0, 0.0]);
    }
    let [x, y] = direction.map(|d| d.unwrap_or(0.0));
    let length = libm::hypot(x, y);
    (length.is_finite() && length > 1e-9).then(|| [x / length, y / length])
}

/// TrueNorth of the first model context that gives one.
fn true_north(file: &File<'_>, report: &mut Report) -> Option<[f64; 2]> {
    let contexts = file.records("IfcGeometricRepresentationContext", report);
    contexts
        .iter()
        .filter(|c| c.is("IFCGEOMETRICREPRESENTATIONCONTEXT"))
        .filter(|c| !c.text(1).eq_ignore_ascii_case("plan"))
        .filter_map(|c| c.at(5).reference())
        .find_map(|id| {
            let ratios = file.record_of(id, "IFCDIRECTION")?;
            let [x, y] = [0, 1].map(|i| ratios.at(0).list().get(i).and_then(|r| r.number()));
            Some([x?, y?])
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{file, read as read_model};

    /// Georeference, and codes of the diagnostics, of a project in `unit` with these records.
    fn check(unit: &str, records: &str) -> (Georeference, Vec<&'static str>) {
        let text = file(&format!(
            "#1=IFCPROJECT('p',$,$,$,$,$,$,(#2),#4);#2=IFCGEOMETRICREPRESENTATIONCONTEXT($,'Model',3,1.E-5,$,#3);
             #3=IFCDIRECTION((0.5,0.8));#4=IFCUNITASSIGNMENT((#5));#5={unit};#6=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);{records}"
        ));
        let (model, diagnostics) = read_model(&text).unwrap();
        (model.georeference, diagnostics.iter().map(|d| d.code.name()).collect())
    }

    fn conversion(unit: &str, records: &str) -> (MapConversion, Vec<&'static str>) {
        let (georeference, codes) = check(unit, records);
        (georeference.map_conversion.unwrap(), codes)
    }

    const METRE: &str = "IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.)";
    const MILLIMETRE: &str = "IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.)";
    /// MapUnit is the metre of `#6`, or the project's unit.
    const CRS: &str = "#8=IFCPROJECTEDCRS('EPSG:25832',$,$,$,$,$,#6);";
    const CRS_WITHOUT_UNIT: &str = "#8=IFCPROJECTEDCRS('EPSG:25832',$,$,$,$,$,$);";

    #[test]
    fn map_conversion_and_true_north_are_read() {
        let records = format!("#7=IFCMAPCONVERSION(#2,#8,458870.,5438232.,110.,3.,4.,0.9996);{CRS}");
        let (found, codes) = check(METRE, &records);
        assert_eq!((found.true_north, codes), (Some([0.5, 0.8]), vec![]));
        let conversion = found.map_conversion.unwrap();
        assert_eq!((conversion.crs.as_str(), conversion.map_unit.as_str()), ("EPSG:25832", "METRE"));
        assert_eq!(conversion.origin_m, [458870.0, 5438232.0, 110.0]);
        assert_eq!((conversion.x_axis, conversion.scale), ([0.6, 0.8], [0.9996; 3]));
    }

    #[test]
    fn without_a_map_unit_eastings_are_in_the_unit_of_the_project() {
        let records = format!("#7=IFCMAPCONVERSION(#2,#8,729013348.8,9063992684.7,1300.,$,$,1.);{CRS_WITHOUT_UNIT}");
        let (conversion, codes) = conversion(MILLIMETRE, &records);
        assert!((conversion.origin_m[0] - 729_013.348_8).abs() < 1e-6, "{conversion:?}");
        assert!((conversion.origin_m[2] - 1.3).abs() < 1e-12);
        assert_eq!((conversion.map_unit.as_str(), conversion.map_unit_m), ("MILLIMETRE", 1e-3));
        assert_eq!((conversion.scale, codes), ([1.0; 3], vec![]));
    }

    #[test]
    fn scale_takes_the_unit_of_the_project_to_that_of_the_map() {
        let scaled = |scale: &str| format!("#7=IFCMAPCONVERSION(#2,#8,458870.,5438232.,110.,$,$,{scale});{CRS}");
        let (with, codes) = conversion(MILLIMETRE, &scaled("0.0009996"));
        assert!((with.scale[0] - 0.9996).abs() < 1e-12 && codes.is_empty(), "{with:?} {codes:?}");
        // Left at 1 it cannot be meant: a metre would be a kilometre.
        for scale in ["1.", "$"] {
            let (without, codes) = conversion(MILLIMETRE, &scaled(scale));
            assert_eq!((without.scale, codes), ([1.0; 3], vec!["map_conversion_doubtful"]));
            assert_eq!(without.origin_m, [458870.0, 5438232.0, 110.0]);
        }
    }

    #[test]
    fn factors_of_a_scaled_conversion_count_per_axis_and_a_rigid_operation_has_none() {
        let scaled = format!("#7=IFCMAPCONVERSIONSCALED(#2,#8,458870.,5438232.,110.,$,$,0.001,0.9996,0.9996,1.);{CRS}");
        let (found, codes) = conversion(MILLIMETRE, &scaled);
        let near = std::iter::zip(found.scale, [0.9996, 0.9996, 1.0]).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near && codes.is_empty(), "{found:?} {codes:?}");
        let rigid =
            format!("#7=IFCRIGIDOPERATION(#2,#8,IFCLENGTHMEASURE(458870.),IFCLENGTHMEASURE(5438232.),110.);{CRS}");
        let (found, codes) = conversion(MILLIMETRE, &rigid);
        assert_eq!((found.origin_m, codes), ([458870.0, 5438232.0, 110.0], vec![]));
        assert!((found.scale[0] - 1.0).abs() < 1e-12);
    }

    #[test]
    fn property_sets_of_the_site_stand_for_the_conversion() {
        let set = |id: u32, name: &str, members: &str| {
            format!(
                "#{}=IFCRELDEFINESBYPROPERTIES('r{id}',$,$,$,(#20),#{id});#{id}=IFCPROPERTYSET('s{id}',$,'{name}',$,({members}));",
                id + 1
            )
        };
        let records = format!(
            "#20=IFCSITE('site',$,$,$,$,$,$,$,$,$,$,$,$,$);{}{}
             #50=IFCPROPERTYSINGLEVALUE('Eastings',$,IFCLENGTHMEASURE(76670.),$);
             #51=IFCPROPERTYSINGLEVALUE('Northings',$,IFCREAL(77179.),$);
             #52=IFCPROPERTYSINGLEVALUE('XAxisAbscissa',$,IFCREAL(0.),$);#53=IFCPROPERTYSINGLEVALUE('XAxisOrdinate',$,IFCREAL(2.),$);
             #54=IFCPROPERTYSINGLEVALUE('Name',$,IFCLABEL('EPSG:31370'),$);#55=IFCPROPERTYSINGLEVALUE('MapUnit',$,IFCLABEL('METRE'),$);",
            set(30, "ePSet_MapConversion", "#50,#51,#52,#53"),
            set(40, "EPset_ProjectedCRS", "#54,#55"),
        );
        let (found, _) = conversion(MILLIMETRE, &records);
        assert_eq!((found.crs.as_str(), found.origin_m), ("EPSG:31370", [76670.0, 77179.0, 0.0]));
        assert_eq!(found.x_axis, [0.0, 1.0]);
        let (found, _) = conversion(METRE, &records.replace("(#54,#55)", "(#54)"));
        assert_eq!((found.origin_m, found.map_unit_m), ([76670.0, 77179.0, 0.0], 1.0));
        let (found, codes) = check(METRE, &records.replace("'METRE'", "'ELL'"));
        assert_eq!((found.map_conversion, codes), (None, vec!["map_conversion_unusable"]));
    }

    #[test]
    fn a_conversion_that_cannot_be_used_is_reported_and_not_used() {
        for (record, crs) in [
            ("#7=IFCMAPCONVERSION(#2,#8,$,5438232.,110.,$,$,$);", CRS),
            ("#7=IFCMAPCONVERSION(#2,#8,4.,5.,1.,0.,0.,$);", CRS),
            ("#7=IFCMAPCONVERSION(#2,#8,4.,5.,1.,$,$,-1.);", CRS),
            ("#7=IFCMAPCONVERSION(#2,$,4.,5.,1.,$,$,$);", CRS),
            (
                "#7=IFCMAPCONVERSION(#2,#8,4.,5.,1.,$,$,$);",
                "#8=IFCPROJECTEDCRS('X',$,$,$,$,$,#9);#9=IFCSIUNIT(*,.LENGTHUNIT.,.HUGE.,.METRE.);",
            ),
        ] {
            let (found, codes) = check(METRE, &format!("{record}{crs}"));
            assert_eq!((found.map_conversion, codes), (None, vec!["map_conversion_unusable"]), "{record}");
        }
    }

    #[test]
    fn coordinates_on_no_map_are_doubtful() {
        let records = format!("#7=IFCMAPCONVERSION(#2,#8,149626315.9,413717684.2,0.,$,$,0.001);{CRS}");
        assert_eq!(conversion(MILLIMETRE, &records).1, ["map_conversion_doubtful"]);
    }
}
