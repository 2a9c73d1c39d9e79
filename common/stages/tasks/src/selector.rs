//! Selectors of rules: a pattern, or a value of the task.

use crate::folded::fold;
use crate::task_values::TaskValue;
use wildmatch::WildMatch;

/// A pattern with `*` for any text and `?` for one character.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Pattern(WildMatch);

impl Pattern {
    pub(crate) fn new(text: &str) -> Self {
        Self(WildMatch::new(&fold(text)))
    }

    /// True if a folded text fits.
    pub(crate) fn fits(&self, folded: &str) -> bool {
        self.0.matches(folded)
    }
}

/// What a value has to be.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Selector {
    /// It fits a pattern.
    Fits(Pattern),
    /// It equals a value of the task.
    Equals(TaskValue),
}

impl Selector {
    /// A selector as rules write it: `=code`, `=id`, `=wbs`, `=name` or `=field:NAME` for a value of the task, else a pattern.
    ///
    /// # Errors
    /// A value that tasks do not have.
    pub(crate) fn parse(text: &str) -> Result<Self, String> {
        match text.strip_prefix('=') {
            Some(value) => Ok(Self::Equals(TaskValue::parse(value)?)),
            None if text.trim().is_empty() => Err("is empty; write * for anything".to_owned()),
            None => Ok(Self::Fits(Pattern::new(text))),
        }
    }
}
