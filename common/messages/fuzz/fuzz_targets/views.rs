//! Bytes as archives of every kind, behind the hash too: refused, or read to the end without a panic.
#![no_main]

#[path = "../../tests/support/mod.rs"]
mod support;

use libfuzzer_sys::fuzz_target;
use messages::ArchiveBuffer;

fuzz_target!(|bytes: &[u8]| {
    // A whole archive of one kind, with the fuzzer's bytes laid over it; or the fuzzer's bytes alone.
    let Some((&choice, bytes)) = bytes.split_first() else { return };
    let mut buffer = match choice % 7 {
        0 => support::site(),
        1 => support::phase(),
        2 => support::grid(),
        3 => support::grids(),
        4 => support::plan(),
        5 => support::deviations(),
        _ => ArchiveBuffer::zeroed(bytes.len()),
    };
    for (at, byte) in buffer.bytes_mut().iter_mut().zip(bytes) {
        *at ^= byte;
    }
    support::walk(buffer.bytes());
    support::reseal(buffer.bytes_mut());
    support::walk(buffer.bytes());
});
