//! The commands of README.md, as they are printed, in a clone of the repository.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::pages::{Page, blocks};
use end_to_end::{announce, client, root};
use std::process::Command;

/// Begins the part of README.md that is about a running site.
const LIVE: &str = "\n## Live use\n";

/// README.md before the part about a running site, and that part with what follows it.
fn parts() -> [String; 2] {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let (first, live) = readme.split_once(LIVE).unwrap();
    [first.to_owned(), live.to_owned()]
}

#[test]
fn first_commands_work_as_they_are_printed() {
    let mut page = Page::new("README.md");
    page.run(&blocks(&parts()[0]));
    let counts = page.end();
    assert!(counts.n_run >= 20 && counts.n_run > counts.n_not_run, "{counts:?}");
    for made in
        ["maps/manifest.json", "maps-world/world/world.sdf", "demo.mcap", "amcl.yaml", "drive", "page/index.html"]
    {
        assert!(page.home.path().join(made).exists(), "{made}");
    }
}

#[test]
fn live_commands_work_as_they_are_printed() {
    // There is one demo site for each user.
    if Command::new(client()).args(["status", "--demo"]).output().unwrap().status.success() {
        announce("SKIPPED: live commands of README.md: this user's demo site runs");
        return;
    }
    let mut page = Page::new("README.md");
    page.run(&blocks(&parts()[1]));
    let counts = page.end();
    assert!(counts.n_run >= 12 && counts.n_run > counts.n_not_run, "{counts:?}");
    assert!(page.home.path().join("maps/manifest.json").is_file());
}
