//! Length, angle and time units of a file, as factors to SI; never guessed.

use crate::kernel::{File, Patch, Record};

/// Longest chain of units that are defined by other units.
const CHAIN_MAX: usize = 8;

/// The length unit of the project.
pub(crate) struct LengthUnit {
    pub(crate) metres: f64,
    record: u32,
}

/// Finds it, or says what is wrong with it.
pub(crate) fn length_unit(file: &File<'_>) -> Result<LengthUnit, String> {
    let unit = unit(file, "LENGTHUNIT")?;
    let metres = factor(file, &unit, "METRE", 0)
        .ok_or_else(|| format!("unit #{} has no usable factor to metres", file.written_id(unit.id)))?;
    Ok(LengthUnit { metres, record: unit.id })
}

/// Name of the length unit, e.g. `MILLIMETRE`.
pub(crate) fn name(file: &File<'_>, unit: &LengthUnit) -> String {
    file.record(unit.record).map(|record| name_of(&record)).unwrap_or_default()
}

/// Name of any unit of length, and metres per unit; `None` if its factor cannot be used.
pub(crate) fn metres_per(file: &File<'_>, unit: u32) -> Option<(String, f64)> {
    let record = file.record(unit)?;
    Some((name_of(&record), factor(file, &record, "METRE", 0)?))
}

fn name_of(unit: &Record<'_>) -> String {
    if unit.is("IFCSIUNIT") {
        return [2, 3].into_iter().filter_map(|at| unit.at(at).enumeration()).collect::<String>().to_ascii_uppercase();
    }
    unit.text(2)
}

/// Metres per unit of a name that a property gives instead of an IfcNamedUnit.
pub(crate) fn metres_of_name(name: &str) -> Option<f64> {
    let name = name.to_ascii_uppercase().replace(['_', '-'], " ");
    let si = |unit: &str| {
        let prefixed = name.strip_suffix(unit)?.trim();
        if prefixed.is_empty() { Some(1.0) } else { prefix(prefixed) }
    };
    match name.trim() {
        "M" => Some(1.0),
        "CM" => Some(1e-2),
        "MM" => Some(1e-3),
        "FOOT" | "FEET" | "FT" | "INTERNATIONAL FOOT" => Some(0.3048),
        "US SURVEY FOOT" | "US SURVEY FEET" | "US FOOT" | "FTUS" => Some(1200.0 / 3937.0),
        "INCH" => Some(0.0254),
        _ => si("METRE").or_else(|| si("METER")),
    }
}

/// Radians per plane angle unit, if the project defines it.
pub(crate) fn radians(file: &File<'_>) -> Option<f64> {
    factor(file, &unit(file, "PLANEANGLEUNIT").ok()?, "RADIAN", 0)
}

/// Seconds per time unit of the project: a second where it names none.
pub(crate) fn seconds_per_time_unit(file: &File<'_>) -> Result<f64, String> {
    let Ok(unit) = unit(file, "TIMEUNIT") else { return Ok(1.0) };
    factor(file, &unit, "SECOND", 0)
        .ok_or_else(|| format!("unit #{} has no usable factor to seconds", file.written_id(unit.id)))
}

/// The project's unit of this kind.
fn unit<'a>(file: &File<'a>, kind: &str) -> Result<Record<'a>, String> {
    let project = file.all("IfcProject").into_iter().find_map(|(span, _)| file.record(span.id));
    let project = project.ok_or("there is no IfcProject that could name it")?;
    let assignment = project.at(8).reference().and_then(|id| file.record_of(id, "IFCUNITASSIGNMENT"));
    let assignment =
        assignment.ok_or_else(|| format!("IfcProject #{} has no UnitsInContext", file.written_id(project.id)))?;
    let units = assignment.at(0).references();
    let is_wanted = |unit: &Record<'_>| unit.at(1).enumeration().is_some_and(|k| k.eq_ignore_ascii_case(kind));
    let unit = units.into_iter().filter_map(|id| file.record(id)).find(is_wanted);
    unit.ok_or_else(|| format!("IfcUnitAssignment #{} names no {kind}", file.written_id(assignment.id)))
}

/// SI base units per unit.
fn factor(file: &File<'_>, unit: &Record<'_>, base_unit: &str, depth: usize) -> Option<f64> {
    if depth > CHAIN_MAX {
        return None;
    }
    let factor = if unit.is("IFCSIUNIT") {
        let is_base = unit.at(3).enumeration().is_some_and(|name| name.eq_ignore_ascii_case(base_unit));
        is_base.then(|| unit.at(2).enumeration().map_or(Some(1.0), prefix))??
    } else if unit.is("IFCCONVERSIONBASEDUNIT") || unit.is("IFCCONVERSIONBASEDUNITWITHOFFSET") {
        let measure = file.record_of(unit.at(3).reference()?, "IFCMEASUREWITHUNIT")?;
        let base = file.record(measure.at(1).reference()?)?;
        measure.at(0).number()? * factor(file, &base, base_unit, depth + 1)?
    } else {
        return None;
    };
    (factor.is_finite() && factor > 0.0).then_some(factor)
}

fn prefix(name: &str) -> Option<f64> {
    let power = match name.to_ascii_uppercase().as_str() {
        "EXA" => 1e18,
        "PETA" => 1e15,
        "TERA" => 1e12,
        "GIGA" => 1e9,
        "MEGA" => 1e6,
        "KILO" => 1e3,
        "HECTO" => 1e2,
        "DECA" => 1e1,
        "DECI" => 1e-1,
        "CENTI" => 1e-2,
        "MILLI" => 1e-3,
        "MICRO" => 1e-6,
        "NANO" => 1e-9,
        "PICO" => 1e-12,
        "FEMTO" => 1e-15,
        "ATTO" => 1e-18,
        _ => return None,
    };
    Some(power)
}

/// Makes the kernel use the factor that the file gives: it prefers what a unit of that name usually means.
pub(crate) fn pin(file: &File<'_>, unit: &LengthUnit, patch: &mut Patch) {
    if (file.kernel_unit_m() / unit.metres - 1.0).abs() < 1e-12 {
        return;
    }
    let Some(record) = file.record(unit.record) else { return };
    let (dimensions, factor) = (record.at(0).reference(), record.at(3).reference());
    if let (Some(dimensions), Some(factor)) = (dimensions, factor) {
        let text = format!("IFCCONVERSIONBASEDUNIT(#{dimensions},.LENGTHUNIT.,'unit of the file',#{factor})");
        patch.replace(record.id, text);
    }
}

#[cfg(test)]
mod tests {
    use crate::testing::{file, with_file};

    fn check(units: &str) -> Result<f64, String> {
        let text = file(&format!("#1=IFCPROJECT('p',$,$,$,$,$,$,$,#2);{units}"));
        with_file(&text, |file| super::length_unit(file).map(|unit| unit.metres))
    }

    #[test]
    fn si_prefixes_and_conversions_are_applied() {
        let assignment = "#2=IFCUNITASSIGNMENT((#9,#3));#9=IFCSIUNIT(*,.AREAUNIT.,$,.SQUARE_METRE.);";
        assert_eq!(check(&format!("{assignment}#3=IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.);")), Ok(1e-3));
        let foot = "#3=IFCCONVERSIONBASEDUNIT($,.LENGTHUNIT.,'FOOT',#4);#4=IFCMEASUREWITHUNIT(IFCREAL(304.8),#5);\
                    #5=IFCSIUNIT(*,.LENGTHUNIT.,.MILLI.,.METRE.);";
        assert!((check(&format!("{assignment}{foot}")).unwrap() - 0.3048).abs() < 1e-12);
    }

    #[test]
    fn a_unit_that_is_missing_or_unusable_is_never_one() {
        let conversion = |factor: &str| {
            format!(
                "#2=IFCUNITASSIGNMENT((#3));#3=IFCCONVERSIONBASEDUNIT($,.LENGTHUNIT.,'x',#4);\
                 #4=IFCMEASUREWITHUNIT({factor},#5);#5=IFCSIUNIT(*,.LENGTHUNIT.,$,.METRE.);"
            )
        };
        for (units, word) in [
            (String::new(), "UnitsInContext"),
            ("#2=IFCUNITASSIGNMENT(());".to_owned(), "no LENGTHUNIT"),
            ("#2=IFCUNITASSIGNMENT((#3));#3=IFCSIUNIT(*,.LENGTHUNIT.,.HUGE.,.METRE.);".to_owned(), "factor"),
            ("#2=IFCUNITASSIGNMENT((#3));#3=IFCCONVERSIONBASEDUNIT($,.LENGTHUNIT.,'x',#3);".to_owned(), "factor"),
            (conversion("IFCREAL(0.)"), "factor"),
            (conversion("IFCREAL(-1.)"), "factor"),
            (conversion("IFCREAL(1.E400)"), "factor"),
        ] {
            let why = check(&units).unwrap_err();
            assert!(why.contains(word), "{units}: {why}");
        }
    }
}
