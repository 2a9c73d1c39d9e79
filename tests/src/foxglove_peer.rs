//! A client of the server for Foxglove, and where that is served.

use super::live::{DEADLINE, Live, POLL_INTERVAL};
use super::peer::Peer;
use super::root;
use bus::Daemon;
use daemon::facts::RosBridgeFacts;
use daemon::{Report, StatusBoard};
use std::net::SocketAddr;
use std::process::Command;
use std::time::Instant;

/// What the client needs.
pub const PACKAGES: [&str; 4] =
    ["websockets==15.0.1", "mcap-ros2-support==0.6.0", "mcap-protobuf-support==0.5.4", "numpy"];

/// Where Foxglove is served, once maps are published: who connects now comes late.
pub fn served(live: &Live) -> SocketAddr {
    let begun = Instant::now();
    loop {
        let report: Option<Report<RosBridgeFacts>> = StatusBoard::of(live.root.path()).report(Daemon::RosBridge);
        if let Some(RosBridgeFacts { storey: Some(_), foxglove: Some(address), .. }) = report.map(|r| r.facts) {
            return address;
        }
        assert!(begun.elapsed() < DEADLINE, "{:?}", live.status());
        std::thread::sleep(POLL_INTERVAL);
    }
}

/// A client that prints what comes.
pub fn connect(address: SocketAddr, more: &[&str]) -> Peer {
    let mut command = Command::new(root().join("target/venv/bin/python"));
    let url = format!("ws://{address}");
    Peer::start(command.arg(root().join("scripts/foxglove_peer.py")).args(["--url", &url]).args(more))
}
