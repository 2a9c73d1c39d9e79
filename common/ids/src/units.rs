//! Values of measures in units of SI.

use ifc::{Record, StepFile, Value};
use rustc_hash::FxHashMap;

/// Longest chain of units that are defined by other units.
const CHAIN_MAX: usize = 8;

/// Kinds of units without which a measure means nothing; a file that does not define another kind means SI.
const NAMED: [&str; 5] = ["LENGTHUNIT", "AREAUNIT", "VOLUMEUNIT", "PLANEANGLEUNIT", "MASSUNIT"];

/// SI value = `factor` · (value − `offset`).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Conversion {
    pub(crate) factor: f64,
    pub(crate) offset: f64,
}

const SI: Conversion = Conversion { factor: 1.0, offset: 0.0 };

impl Conversion {
    pub(crate) fn apply(self, value: f64) -> f64 {
        self.factor * (value - self.offset)
    }
}

/// The units of a project, by kind in capitals.
#[derive(Debug, Default)]
pub(crate) struct Units {
    of_kind: FxHashMap<String, Option<Conversion>>,
}

impl Units {
    pub(crate) fn of(file: &StepFile<'_>) -> Self {
        let mut of_kind = FxHashMap::default();
        for id in file.ids_of("IFCPROJECT").iter().chain(file.ids_of("IFCPROJECTLIBRARY")) {
            let assignment = file.record(*id).and_then(|project| file.record(project.at(8).reference()?));
            let Some(assignment) = assignment.filter(|record| record.is("IfcUnitAssignment")) else { continue };
            for unit in assignment.at(0).references() {
                if let Some(kind) = file.record(unit).and_then(|record| kind_of(&record)) {
                    of_kind.entry(kind).or_insert_with(|| conversion(file, unit, 0));
                }
            }
        }
        Self { of_kind }
    }

    /// The conversion of a measure whose value has this unit, or none of its own; `None` if the file does not say, or its unit
    /// cannot be used. What is no measure is not converted.
    pub(crate) fn conversion(&self, file: &StepFile<'_>, measure: &str, unit: Option<u32>) -> Option<Conversion> {
        let Some(kind) = kind_of_measure(measure) else { return Some(SI) };
        if let Some(unit) = unit {
            return conversion(file, unit, 0);
        }
        match self.of_kind.get(&kind) {
            Some(conversion) => *conversion,
            None => (!NAMED.contains(&kind.as_str())).then_some(SI),
        }
    }
}

/// The kind of unit that values of a type have; `None` for a type without units.
fn kind_of_measure(measure: &str) -> Option<String> {
    let name = measure.to_ascii_uppercase();
    let quantity = name.strip_prefix("IFC")?.strip_suffix("MEASURE")?;
    let quantity = match quantity {
        "POSITIVELENGTH" | "NONNEGATIVELENGTH" => "LENGTH",
        "POSITIVEPLANEANGLE" => "PLANEANGLE",
        "THERMALCONDUCTIVITY" => "THERMALCONDUCTANCE",
        "RATIO" | "POSITIVERATIO" | "NORMALISEDRATIO" | "COUNT" | "CONTEXTDEPENDENT" | "DESCRIPTIVE" | "MONETARY"
        | "NUMERIC" | "COMPOUNDPLANEANGLE" | "COMPLEXNUMBER" => return None,
        quantity => quantity,
    };
    Some(format!("{quantity}UNIT"))
}

fn kind_of(unit: &Record<'_>) -> Option<String> {
    let is_unit = ["IfcSIUnit", "IfcConversionBasedUnit", "IfcConversionBasedUnitWithOffset", "IfcDerivedUnit"];
    let kind = unit.at(1).enumeration().filter(|_| is_unit.iter().any(|entity| unit.is(entity)))?;
    Some(kind.to_ascii_uppercase())
}

fn conversion(file: &StepFile<'_>, unit: u32, depth: usize) -> Option<Conversion> {
    let record = file.record(unit).filter(|_| depth <= CHAIN_MAX)?;
    let conversion = match record.keyword.to_ascii_uppercase().as_str() {
        "IFCSIUNIT" => si(record.at(2).enumeration(), record.at(3).enumeration()?)?,
        "IFCCONVERSIONBASEDUNIT" => based(file, &record, 0.0, depth)?,
        "IFCCONVERSIONBASEDUNITWITHOFFSET" => based(file, &record, record.at(4).number()?, depth)?,
        "IFCDERIVEDUNIT" => {
            let factors = record.at(0).references().into_iter().map(|id| {
                let element = file.record(id).filter(|element| element.is("IfcDerivedUnitElement"))?;
                let factor = self::conversion(file, element.at(0).reference()?, depth + 1)?.factor;
                power(factor, element.at(1).number()?)
            });
            Conversion { factor: factors.product::<Option<f64>>()?, offset: 0.0 }
        }
        _ => return None,
    };
    (conversion.factor.is_finite() && conversion.factor > 0.0).then_some(conversion)
}

fn based(file: &StepFile<'_>, unit: &Record<'_>, offset: f64, depth: usize) -> Option<Conversion> {
    let measure = file.record(unit.at(3).reference()?).filter(|record| record.is("IfcMeasureWithUnit"))?;
    let base = conversion(file, measure.at(1).reference()?, depth + 1)?;
    let factor = match measure.at(0) {
        Value::Null => return None,
        value => value.number()?,
    };
    Some(Conversion { factor: factor * base.factor, offset })
}

fn si(prefix: Option<&str>, name: &str) -> Option<Conversion> {
    let power_of_ten = match prefix.map(str::to_ascii_uppercase).as_deref() {
        None => 1.0,
        Some("EXA") => 1e18,
        Some("PETA") => 1e15,
        Some("TERA") => 1e12,
        Some("GIGA") => 1e9,
        Some("MEGA") => 1e6,
        Some("KILO") => 1e3,
        Some("HECTO") => 1e2,
        Some("DECA") => 1e1,
        Some("DECI") => 1e-1,
        Some("CENTI") => 1e-2,
        Some("MILLI") => 1e-3,
        Some("MICRO") => 1e-6,
        Some("NANO") => 1e-9,
        Some("PICO") => 1e-12,
        Some("FEMTO") => 1e-15,
        Some("ATTO") => 1e-18,
        Some(_) => return None,
    };
    // A square millimetre is the square of a millimetre; the unit of mass in SI is the kilogram.
    match name.to_ascii_uppercase().as_str() {
        "SQUARE_METRE" => Some(Conversion { factor: power(power_of_ten, 2.0)?, offset: 0.0 }),
        "CUBIC_METRE" => Some(Conversion { factor: power(power_of_ten, 3.0)?, offset: 0.0 }),
        "GRAM" => Some(Conversion { factor: power_of_ten * 1e-3, offset: 0.0 }),
        "DEGREE_CELSIUS" => Some(Conversion { factor: power_of_ten, offset: -273.15 }),
        _ => Some(Conversion { factor: power_of_ten, offset: 0.0 }),
    }
}

/// A whole power, of an exponent that units have.
fn power(base: f64, exponent: f64) -> Option<f64> {
    let n = (0_u32..=12).find(|n| f64::from(*n) == exponent.abs())?;
    let product: f64 = (0..n).map(|_| base).product();
    Some(if exponent < 0.0 { 1.0 / product } else { product })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_are_converted_to_si() {
        let data = "#1=IFCPROJECT('p',$,$,$,$,$,$,$,#2);#2=IFCUNITASSIGNMENT((#3,#4,#5,#8,#10,#20));\
            #3=IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.);#4=IFCSIUNIT(*,.AREAUNIT.,.CENTI.,.SQUARE_METRE.);\
            #5=IFCCONVERSIONBASEDUNIT(#6,.PLANEANGLEUNIT.,'degree',#7);#6=IFCDIMENSIONALEXPONENTS(0,0,0,0,0,0,0);\
            #7=IFCMEASUREWITHUNIT(IFCPLANEANGLEMEASURE(0.0174532925199433),#9);#9=IFCSIUNIT(*,.PLANEANGLEUNIT.,$,.RADIAN.);\
            #8=IFCSIUNIT(*,.MASSUNIT.,$,.GRAM.);#10=IFCDERIVEDUNIT((#11,#12),.LINEARVELOCITYUNIT.,$);\
            #11=IFCDERIVEDUNITELEMENT(#3,1);#12=IFCDERIVEDUNITELEMENT(#13,-1);#13=IFCSIUNIT(*,.TIMEUNIT.,$,.SECOND.);\
            #20=IFCSIUNIT(*,.THERMODYNAMICTEMPERATUREUNIT.,$,.DEGREE_CELSIUS.);#30=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);";
        let text = format!("ISO-10303-21;HEADER;FILE_SCHEMA(('IFC4'));ENDSEC;DATA;{data}ENDSEC;END-ISO-10303-21;");
        let (file, _) = StepFile::read(text.as_bytes()).unwrap();
        let units = Units::of(&file);
        let check = |measure: &str, value: f64, unit, expected: f64| {
            let si = units.conversion(&file, measure, unit).unwrap().apply(value);
            assert!((si - expected).abs() < 1e-12 * expected.abs(), "{measure}: {si}");
        };
        check("IfcPositiveLengthMeasure", 1500.0, None, 1.5);
        check("IFCLENGTHMEASURE", 1.5, Some(30), 1.5);
        check("IFCAREAMEASURE", 1.0, None, 1e-4);
        check("IFCPLANEANGLEMEASURE", 180.0, None, std::f64::consts::PI);
        check("IFCMASSMEASURE", 2.0, None, 2e-3);
        check("IFCLINEARVELOCITYMEASURE", 1.0, None, 1e-3);
        check("IFCTHERMODYNAMICTEMPERATUREMEASURE", 20.0, None, 293.15);
        check("IFCTIMEMEASURE", 2.0, None, 2.0);
        check("IFCREAL", 2.0, None, 2.0);
        assert_eq!(units.conversion(&file, "IFCVOLUMEMEASURE", None), None);
        assert_eq!(units.conversion(&file, "IFCLENGTHMEASURE", Some(6)), None);
    }
}
