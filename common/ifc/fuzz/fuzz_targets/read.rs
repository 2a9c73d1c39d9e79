//! Any bytes: never a panic, never a hang, bounded memory.
//!
//! `cargo +nightly fuzz run read -- -rss_limit_mb=2048 -timeout=20`; what it finds goes into `corpus/read`, which
//! `tests/hostile.rs` replays.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = ifc::read(bytes, &ifc::ReadOptions { threads: 1, ..ifc::ReadOptions::default() });
});
