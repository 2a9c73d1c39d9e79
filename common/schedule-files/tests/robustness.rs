//! Whatever the bytes are, reading ends with a plan that hangs together or with an error.

mod support;
mod workbook;

use proptest::prelude::*;
use schedule_files::{ReadOptions, read};
use support::check;

/// A file of each format with something of everything: the first inputs of the fuzzer.
const SAMPLES: [(&str, &[u8]); 5] = [
    ("plan.xer", include_bytes!("../../../tests/fuzz/corpus/schedule_files/plan.xer")),
    ("pmxml.xml", include_bytes!("../../../tests/fuzz/corpus/schedule_files/pmxml.xml")),
    ("mspdi.xml", include_bytes!("../../../tests/fuzz/corpus/schedule_files/mspdi.xml")),
    ("plan.csv", include_bytes!("../../../tests/fuzz/corpus/schedule_files/plan.csv")),
    ("plan.xlsx", include_bytes!("../../../tests/fuzz/corpus/schedule_files/plan.xlsx")),
];

/// What replaces a part of a file: bytes, or another part of it.
#[derive(Debug, Clone)]
enum Part {
    Bytes(Vec<u8>),
    Copy(usize, usize),
}

fn part() -> impl Strategy<Value = Part> {
    prop_oneof![
        prop::collection::vec(any::<u8>(), 0..4).prop_map(Part::Bytes),
        "[0-9<>/\"%|() \t\n,;:-]{0,6}".prop_map(|text| Part::Bytes(text.into_bytes())),
        (any::<usize>(), 0..200_usize).prop_map(|(from, len)| Part::Copy(from, len)),
    ]
}

#[test]
fn the_samples_are_read_without_a_finding() {
    for (name, bytes) in SAMPLES {
        let plan = read(name, bytes, &ReadOptions::default()).unwrap();
        assert!(plan.tasks.len() >= 4 && !plan.dependencies.is_empty() && !plan.calendars.is_empty(), "{name}");
        assert_eq!(plan.findings, [], "{name}");
        let fields = plan.tasks.iter().flat_map(|task| &task.fields);
        assert!(fields.clone().any(|(name, value)| name == "4D_Number" && value == "W-17"), "{name}");
        check(&plan);
    }
}

proptest! {
    #[test]
    fn changed_files_are_read_or_refused(
        sample in 0..SAMPLES.len(),
        changes in prop::collection::vec((any::<usize>(), 0..40_usize, part()), 1..6),
    ) {
        let (name, bytes) = SAMPLES[sample];
        let mut bytes = bytes.to_vec();
        let span = |bytes: &[u8], at: usize, len: usize| {
            let at = at % (bytes.len() + 1);
            at..(at + len).min(bytes.len())
        };
        for (at, len, part) in changes {
            let new = match part {
                Part::Bytes(new) => new,
                Part::Copy(from, len) => bytes[span(&bytes, from, len)].to_vec(),
            };
            bytes.splice(span(&bytes, at, len), new);
        }
        if let Ok(plan) = read(name, &bytes, &ReadOptions::default()) {
            check(&plan);
        }
    }

    // Changes of a container nearly always end at its checksums.
    #[test]
    fn changed_sheets_of_workbooks_are_read_or_refused(
        changes in prop::collection::vec((any::<usize>(), 0..40_usize, part()), 1..6),
    ) {
        let mut bytes = workbook::SHEET.as_bytes().to_vec();
        for (at, len, part) in changes {
            let span = |bytes: &[u8], at: usize, len: usize| {
                let at = at % (bytes.len() + 1);
                at..(at + len).min(bytes.len())
            };
            let new = match part {
                Part::Bytes(new) => new,
                Part::Copy(from, len) => bytes[span(&bytes, from, len)].to_vec(),
            };
            bytes.splice(span(&bytes, at, len), new);
        }
        let content = String::from_utf8_lossy(&bytes);
        if let Ok(plan) = read("plan.xlsx", &workbook::workbook(&[("Plan", &content)], false), &ReadOptions::default()) {
            check(&plan);
        }
    }

    #[test]
    fn any_bytes_are_read_or_refused(
        start in "(ERMHDR\t8\n%T\tTASK\n|<Project>|<APIBusinessObjects>|id;name\n)?",
        bytes in prop::collection::vec(any::<u8>(), 0..200),
    ) {
        let bytes = [start.as_bytes(), &bytes].concat();
        if let Ok(plan) = read("plan", &bytes, &ReadOptions::default()) {
            check(&plan);
        }
    }
}
