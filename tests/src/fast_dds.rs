//! A participant of the ROS 2 graph on Fast DDS.

use super::peer::Peer;
use super::{announce, root};
use std::ffi::OsStr;
use std::process::Command;
use std::sync::OnceLock;

/// What the script ends with where Fast DDS is not installed.
const NO_FAST_DDS: i32 = 3;

/// True, unless Fast DDS cannot be had: then it says so. All tests of a process look once.
pub fn has_peer() -> bool {
    static HAS_PEER: OnceLock<bool> = OnceLock::new();
    *HAS_PEER.get_or_init(build)
}

fn build() -> bool {
    let made = Command::new(root().join("scripts/fast-dds")).output().unwrap();
    let why = String::from_utf8_lossy(&made.stderr);
    if made.status.code() == Some(NO_FAST_DDS) {
        announce(&format!("SKIPPED: no peer with Fast DDS: {why}"));
        return false;
    }
    assert!(made.status.success(), "{why}");
    true
}

/// A participant that prints what comes.
pub fn join(domain: u16, more: &[&dyn AsRef<OsStr>]) -> Peer {
    let mut command = Command::new(root().join("target/fast-dds/peer"));
    Peer::start(command.args(["--domain", &domain.to_string()]).args(more))
}
