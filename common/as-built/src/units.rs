//! Metres per length unit of a file.

use crate::step_file::{Instance, StepFile};

/// Prefixes of units.
const PREFIXES: [(&str, f64); 8] = [
    ("$", 1.0),
    (".MILLI.", 1e-3),
    (".CENTI.", 1e-2),
    (".DECI.", 1e-1),
    (".MICRO.", 1e-6),
    (".NANO.", 1e-9),
    (".DECA.", 10.0),
    (".KILO.", 1e3),
];

/// Metres per length unit of the project; `None` if the file does not define it.
pub(crate) fn length_unit_m(file: &StepFile<'_>) -> Option<f64> {
    let project = file.all("IFCPROJECT").into_iter().next()?;
    let assignment = file.referred(&project, 8)?;
    let units = file.references(&assignment, 0).into_iter().filter_map(|id| file.instance(id));
    let length = |unit: &Instance<'_>| file.argument(unit, 1).eq_ignore_ascii_case(b".LENGTHUNIT.");
    units.filter(length).find_map(|unit| unit_m(file, &unit, 0))
}

fn unit_m(file: &StepFile<'_>, unit: &Instance<'_>, depth: usize) -> Option<f64> {
    if unit.is("IFCSIUNIT") {
        let prefix = std::str::from_utf8(file.argument(unit, 2)).ok()?;
        let is_metre = file.argument(unit, 3).eq_ignore_ascii_case(b".METRE.");
        let known = PREFIXES.iter().find(|(name, _)| name.eq_ignore_ascii_case(prefix)).filter(|_| is_metre)?;
        return Some(known.1);
    }
    let is_converted = ["IFCCONVERSIONBASEDUNIT", "IFCCONVERSIONBASEDUNITWITHOFFSET"].iter().any(|name| unit.is(name));
    if !is_converted || depth > 4 {
        return None;
    }
    let measure = file.referred(unit, 3)?;
    let count = file.number(&measure, 0).filter(|count| *count > 0.0)?;
    Some(count * unit_m(file, &file.referred(&measure, 1)?, depth + 1)?)
}
