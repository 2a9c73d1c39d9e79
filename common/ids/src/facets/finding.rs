//! The finding of a facet for an element, before it is known whether that is wanted.

/// A finding; texts tell people what there is instead of what was asked for.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Finding {
    /// It is there, and as the facet says.
    Match,
    /// It is there, and not as the facet says.
    Mismatch(String),
    /// It is there, and an empty text or list, or unknown.
    Empty(String),
    /// It is there without a value.
    Null(String),
    /// It is not there.
    Absent(String),
}

impl Finding {
    /// Why it is no match; empty for a match.
    pub(crate) fn reason(&self) -> &str {
        match self {
            Self::Match => "",
            Self::Mismatch(why) | Self::Empty(why) | Self::Null(why) | Self::Absent(why) => why,
        }
    }

    fn has_value(&self) -> bool {
        matches!(self, Self::Match | Self::Mismatch(_))
    }
}

/// Of several things that one name means, those with values count, if there are any.
pub(crate) fn with_values(findings: Vec<Finding>) -> Vec<Finding> {
    if findings.iter().any(Finding::has_value) {
        findings.into_iter().filter(Finding::has_value).collect()
    } else {
        findings.into_iter().take(1).collect()
    }
}
