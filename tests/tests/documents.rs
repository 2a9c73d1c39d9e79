//! The pages of `docs`: their commands and programs run as they are printed, and the messages that they quote are those of the code.
#![expect(clippy::unwrap_used, reason = "a test panics where it fails")]

use end_to_end::pages::{Counts, Page, blocks, has_pieces, pieces, sources};
use end_to_end::root;
use std::collections::BTreeMap;

fn text_of(name: &str) -> String {
    std::fs::read_to_string(root().join("docs").join(name)).unwrap()
}

/// Runs a page; most of its commands have to run.
fn run(name: &str) -> Page {
    let mut page = Page::new(name);
    page.run(&blocks(&text_of(name)));
    let Counts { n_run, n_not_run } = page.end();
    assert!(n_run >= n_not_run && n_run > 0, "{name}: {n_run} commands run, {n_not_run} do not");
    page
}

#[test]
fn my_building_can_be_followed() {
    let page = run("my-building.md");
    for made in ["check.html", "maps/manifest.json", "links.csv", "amcl.yaml", "deviations/progress.csv"] {
        assert!(page.home.path().join(made).exists(), "{made}");
    }
}

#[test]
fn a_site_can_be_run() {
    run("run-on-a-site.md");
}

#[test]
fn programs_can_read_a_site() {
    run("read-in-your-program.md");
}

#[test]
fn troubleshooting_can_be_followed() {
    run("troubleshooting.md");
}

/// Messages of the tables of a page: first cells that are one text in backticks.
fn messages(text: &str) -> Vec<&str> {
    let rows = text.lines().filter_map(|line| line.strip_prefix("| `"));
    rows.filter_map(|row| row.split_once("` |"))
        .map(|(message, _)| message)
        .filter(|message| !message.contains('`'))
        .collect()
}

/// Characters of source text over which a message may go.
const MESSAGE_CHARS_MAX: usize = 500;

/// True if the code has the pieces of a message in their order, close to each other.
fn is_said(sources: &BTreeMap<String, String>, message: &str) -> bool {
    let first = pieces(message).next().unwrap();
    let is_at = |source: &str, at: usize| {
        let near: String = source[at..].chars().take(MESSAGE_CHARS_MAX).collect();
        has_pieces(&near, pieces(message))
    };
    sources.values().any(|source| source.match_indices(first).any(|(at, _)| is_at(source, at)))
}

#[test]
fn messages_are_those_of_the_code() {
    let text = text_of("troubleshooting.md");
    let messages = messages(&text);
    assert!(messages.len() >= 40, "{} messages", messages.len());
    let short: Vec<&&str> =
        messages.iter().filter(|message| pieces(message).map(str::len).sum::<usize>() < 12).collect();
    assert!(short.is_empty(), "nothing tells {short:#?} from other texts");
    let sources = sources();
    let unknown: Vec<&&str> = messages.iter().filter(|message| !is_said(&sources, message)).collect();
    assert!(unknown.is_empty(), "no source file has {unknown:#?}");
}

#[test]
fn a_message_that_changed_is_noticed() {
    let sources = sources();
    assert!(is_said(&sources, "the site is not up; start it with: groundplan up --config .."));
    assert!(!is_said(&sources, "the site is not up; please start it with: groundplan up --config .."));
    assert!(!is_said(&sources, "the site is not up; .. the file is empty; export it again"));
    assert_eq!(messages("| message | cause |\n|---|---|\n| `a .. b` | c `d` |\n| `e` and `f` | g |\n"), ["a .. b"]);
}
