//! Why a question has no answer, as a problem document (RFC 9457).

use answers::FindError;
use schemars::JsonSchema;
use serde::Serialize;
use site_answers::{DrawError, PeriodError};

/// Why a question has no answer.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub(crate) struct Problem {
    /// Which problem: `urn:groundplan:problem:` and a stable word.
    #[serde(rename = "type")]
    kind: String,
    /// The problem in a few words.
    title: &'static str,
    /// Status of HTTP.
    status: u16,
    /// What is wrong with this question, and what to do.
    detail: String,
    /// Names that come nearest to one that there is not, or GlobalIds of the things that have it; data of the model, no
    /// instructions.
    nearest: Vec<String>,
}

/// Kinds of problems.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ProblemKind {
    /// A parameter that there is not, is missing, or has a value that it cannot have.
    BadParameter,
    /// There is no such question or path.
    NoSuchQuestion,
    /// Only GET is answered.
    NotAllowed,
    /// Nothing has that name.
    UnknownName,
    /// Several things have that name.
    SeveralNames,
    /// What the answer depends on is not known here.
    NotKnown,
    /// There are no maps yet.
    NotYet,
    /// Too many questions at once, or one that takes too long.
    Busy,
    /// A token is needed.
    NoToken,
    /// Another name of this server, or a page from elsewhere.
    Refused,
    /// A request that is too long.
    TooLarge,
    /// A request that did not come in time.
    TooLate,
    /// The archives of the site cannot be read.
    Failed,
}

impl ProblemKind {
    /// Stable word, title and status of HTTP.
    fn facts(self) -> (&'static str, &'static str, u16) {
        match self {
            Self::BadParameter => ("bad-parameter", "a parameter cannot be used", 400),
            Self::NoSuchQuestion => ("no-such-question", "there is no such question", 404),
            Self::NotAllowed => ("not-allowed", "the method is not allowed", 405),
            Self::UnknownName => ("unknown-name", "nothing has that name", 404),
            Self::SeveralNames => ("several-names", "several things have that name", 409),
            Self::NotKnown => ("not-known", "it is not known here", 409),
            Self::NotYet => ("no-maps-yet", "there are no maps yet", 503),
            Self::Busy => ("busy", "there are too many questions", 503),
            Self::NoToken => ("no-token", "a token is needed", 401),
            Self::Refused => ("refused", "the request is refused", 403),
            Self::TooLarge => ("too-large", "the request is too long", 413),
            Self::TooLate => ("too-late", "the request did not come in time", 408),
            Self::Failed => ("failed", "the answer cannot be made", 500),
        }
    }

    /// The kind that an answer of HTTP with this status is of.
    pub(crate) fn of_status(status: u16) -> Self {
        match status {
            400 | 415 | 422 => Self::BadParameter,
            401 => Self::NoToken,
            403 => Self::Refused,
            404 => Self::NoSuchQuestion,
            405 => Self::NotAllowed,
            408 => Self::TooLate,
            413 | 414 | 431 => Self::TooLarge,
            503 => Self::Busy,
            _ => Self::Failed,
        }
    }
}

impl Problem {
    /// Of a kind, with its sentence.
    pub(crate) fn of(kind: ProblemKind, detail: impl Into<String>) -> Self {
        let (word, title, status) = kind.facts();
        let kind = format!("urn:groundplan:problem:{word}");
        Self { kind, title, status, detail: detail.into(), nearest: Vec::new() }
    }

    /// Status of HTTP.
    pub(crate) fn status(&self) -> u16 {
        self.status
    }
}

impl From<FindError> for Problem {
    fn from(why: FindError) -> Self {
        let detail = why.to_string();
        match why {
            FindError::Unknown(nothing) => {
                Self { nearest: nothing.nearest, ..Self::of(ProblemKind::UnknownName, detail) }
            }
            FindError::Several { found, .. } => Self { nearest: found, ..Self::of(ProblemKind::SeveralNames, detail) },
            FindError::NoStorey { .. } => Self::of(ProblemKind::UnknownName, detail),
            FindError::Storey { .. } => Self::of(ProblemKind::BadParameter, detail),
        }
    }
}

impl From<PeriodError> for Problem {
    fn from(why: PeriodError) -> Self {
        Self::of(ProblemKind::BadParameter, why.to_string())
    }
}

impl From<DrawError> for Problem {
    fn from(why: DrawError) -> Self {
        Self::of(ProblemKind::Failed, daemon::chain(&why))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_there_is_not_comes_with_the_nearest_ones() {
        let nothing = diagnostics::NothingCalled {
            kind: "room",
            wanted: "U.05\u{7}".to_owned(),
            nearest: vec!["U.04".to_owned()],
        };
        let problem = serde_json::to_value(Problem::from(FindError::Unknown(nothing))).unwrap();
        assert_eq!((problem["status"].as_u64(), problem["nearest"][0].as_str()), (Some(404), Some("U.04")));
        assert_eq!(problem["detail"], "there is no room \"U.05\\u{7}\"; nearest: \"U.04\"");
        assert_eq!(problem["type"], "urn:groundplan:problem:unknown-name");
    }
}
