//! One check with its result.

use serde::Serialize;

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum CheckResult {
    Ok,
    Warning,
    Failure,
}

/// One check.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub(super) struct Check {
    pub(super) what: &'static str,
    pub(super) verdict: CheckResult,
    pub(super) found: String,
}

pub(super) fn ok(what: &'static str, found: impl Into<String>) -> Check {
    Check { what, verdict: CheckResult::Ok, found: found.into() }
}

pub(super) fn warning(what: &'static str, found: impl Into<String>) -> Check {
    Check { what, verdict: CheckResult::Warning, found: found.into() }
}

pub(super) fn failure(what: &'static str, found: impl Into<String>) -> Check {
    Check { what, verdict: CheckResult::Failure, found: found.into() }
}
