#![no_main]

use fuzz::{step_text, targets};
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_target!(init: fuzz::prepare(), |bytes: &[u8]| targets::ifc::run(bytes));

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    step_text::mutate(data, size, max_size, seed, libfuzzer_sys::fuzzer_mutate)
});
