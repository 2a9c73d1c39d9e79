//! Stair flight attributes: risers, treads, riser height, tread length.

use crate::Stair;
use crate::kernel::{File, Record};

/// Figures of an IfcStairFlight, or of an IfcStair that carries them; `None` where there are none.
pub(crate) fn read(file: &File<'_>, record: &Record<'_>, unit_m: f64) -> Option<Stair> {
    let number = |name: &str| file.attribute(record, name).number();
    let count = |name: &str| number(name).filter(|n| (0.0..=10_000.0).contains(n)).map(|n| n as u32);
    let length = |name: &str| number(name).map(|x| x * unit_m);
    let stair = Stair {
        n_risers: count("NumberOfRisers").or_else(|| count("NumberOfRiser")),
        n_treads: count("NumberOfTreads"),
        riser_height_m: length("RiserHeight"),
        tread_length_m: length("TreadLength"),
    };
    (stair != Stair::default()).then_some(stair)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{file_of, with_file};

    #[test]
    fn heights_are_converted_and_counts_found_in_every_schema() {
        for (schema, tail) in [("IFC2X3", ""), ("IFC4", ",.STRAIGHT.")] {
            let text = file_of(schema, &format!("#1=IFCSTAIRFLIGHT('s',$,$,$,$,$,$,$,17,16,175.,280.{tail});"));
            let stair = with_file(&text, |file| read(file, &file.record(1).unwrap(), 0.001)).unwrap();
            assert_eq!((stair.n_risers, stair.n_treads), (Some(17), Some(16)));
            assert!((stair.riser_height_m.unwrap() - 0.175).abs() < 1e-12);
        }
    }
}
