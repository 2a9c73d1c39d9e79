//! The build of a program, and the rule by which builds work together on a bus.
//!
//! A build is a version and the commit that it was made from, as `--version` prints it: `1.0.0 (commit 0123456789ab)`. Programs of one bus
//! are of one version, and of one commit where both commits are known. A robot's own program is of no build: for it the layout of the
//! archives counts.

use std::sync::OnceLock;

const VERSION: &str = env!("CARGO_PKG_VERSION");
const UNKNOWN: &str = "unknown";

static OWN: OnceLock<String> = OnceLock::new();

/// The commit that the program was built from, by `GROUNDPLAN_COMMIT` in the environment of the compiler; see `scripts/commit`. It is for
/// the `main.rs` of programs: what names it is compiled again for each commit.
#[macro_export]
macro_rules! commit {
    () => {
        option_env!("GROUNDPLAN_COMMIT")
    };
}

/// Says which commit this program was built from, as the first thing that it does. What was said first counts.
pub fn set_commit(commit: Option<&str>) {
    // A program says it once.
    let _ = OWN.set(build_of(commit));
}

/// The build of this program.
pub fn own_build() -> &'static str {
    OWN.get_or_init(|| build_of(None))
}

fn build_of(commit: Option<&str>) -> String {
    let commit = commit.filter(|commit| !commit.is_empty()).unwrap_or(UNKNOWN);
    format!("{VERSION} (commit {commit})")
}

/// True if programs of both builds may work together.
pub fn is_same_build(one: &str, other: &str) -> bool {
    let [(one, its_commit), (other, commit)] = [parts(one), parts(other)];
    one == other && its_commit.zip(commit).is_none_or(|(its, commit)| its == commit)
}

/// Version, and the commit where it is known.
fn parts(build: &str) -> (&str, Option<&str>) {
    let Some((version, rest)) = build.split_once(" (commit ") else { return (build, None) };
    (version, rest.strip_suffix(')').filter(|commit| *commit != UNKNOWN))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn builds_are_the_same_by_version_and_where_it_is_known_by_commit() {
        let check = |one: &str, other: &str, expected: bool| {
            assert_eq!([is_same_build(one, other), is_same_build(other, one)], [expected; 2], "{one}, {other}");
        };
        check("1.0.0 (commit 0123456789ab)", "1.0.0 (commit 0123456789ab)", true);
        check("1.0.0 (commit 0123456789ab)", "1.0.0 (commit ab0123456789)", false);
        check("1.0.0 (commit 0123456789ab)", "1.0.0 (commit 0123456789ab-dirty)", false);
        check("1.0.0 (commit 0123456789ab)", "1.0.1 (commit 0123456789ab)", false);
        check("1.0.0 (commit 0123456789ab)", "1.0.0 (commit unknown)", true);
        check("1.0.1 (commit unknown)", "1.0.0 (commit unknown)", false);
        check("1.0.0 (commit 0123456789ab)", "0.9.0", false);
        check("1.0.0 (commit 0123456789ab)", "", false);
    }

    #[test]
    fn a_commit_that_is_not_named_is_unknown() {
        for (commit, named) in [(Some("0123456789ab"), "0123456789ab"), (Some(""), "unknown"), (None, "unknown")] {
            assert_eq!(build_of(commit), format!("{VERSION} (commit {named})"));
        }
        assert!(is_same_build(own_build(), &build_of(Some("0123456789ab"))));
    }
}
