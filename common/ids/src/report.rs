//! The findings of a check, as a document and as a text.

use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::Serialize;

use crate::document::{Cardinality, SpecificationCardinality};
use crate::schema::Release;

/// Elements that a text names for each requirement.
const NAMED_MAX: usize = 10;

/// Version of the document; higher when a reader must change.
pub const REPORT_VERSION: u32 = 1;

/// What a check of an IFC file against an IDS file found.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct IdsReport {
    /// Version of this document.
    pub format_version: u32,
    /// Title of the IDS file.
    pub title: String,
    /// FILE_SCHEMA of the IFC file.
    pub ifc_schema: String,
    /// The release of IFC that it was checked by.
    pub release: Release,
    /// True if no specification that was checked fails.
    pub passed: bool,
    /// In the order of the IDS file.
    pub specifications: Vec<SpecificationReport>,
}

/// A specification and what meets it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct SpecificationReport {
    /// For people.
    pub name: String,
    /// For machines; null if the file gives none.
    pub identifier: Option<String>,
    /// Why it is asked for; null if the file does not say.
    pub description: Option<String>,
    /// How to do it; null if the file does not say.
    pub instructions: Option<String>,
    /// How many elements it must apply to.
    pub cardinality: SpecificationCardinality,
    /// What came out.
    pub outcome: SpecificationOutcome,
    /// Why it fails as a whole, or was not checked; null where its elements say why, or it passes.
    pub reason: Option<String>,
    /// Elements that it applies to; null if it was not checked.
    pub n_applicable: Option<usize>,
    /// Elements that fail a requirement or are prohibited.
    pub n_failed: usize,
    /// Elements that must not be there.
    pub prohibited: Vec<FailedElement>,
    /// In the order of the IDS file; empty if it was not checked.
    pub requirements: Vec<RequirementReport>,
}

/// Outcome of a specification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpecificationOutcome {
    /// All that it applies to meets it.
    Passed,
    /// Something does not, or what it asks for is not there.
    Failed,
    /// It is written for another release of IFC.
    NotChecked,
}

/// A requirement and what fails it.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct RequirementReport {
    /// What is asked for, in a few words.
    pub requirement: String,
    /// How it is meant.
    pub cardinality: Cardinality,
    /// How to do it; null if the file does not say.
    pub instructions: Option<String>,
    /// Elements that meet it.
    pub n_passed: usize,
    /// Those that do not, by id.
    pub failed: Vec<FailedElement>,
}

/// An element and what is wrong with it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct FailedElement {
    /// Id of its record.
    pub id: u64,
    /// GlobalId; null for a record without one.
    pub global_id: Option<String>,
    /// Its class, as the schema spells it.
    pub class: String,
    /// Its name; null if it has none.
    pub name: Option<String>,
    /// What is wrong.
    pub reason: String,
}

impl IdsReport {
    /// For people: each specification with its outcome, and the first elements that fail each requirement.
    pub fn text(&self) -> String {
        let mut out = String::new();
        for specification in &self.specifications {
            specification.write(&mut out);
        }
        let n = |outcome| self.specifications.iter().filter(|s| s.outcome == outcome).count();
        let counts = format!(
            "{} passed, {} failed, {} not checked",
            n(SpecificationOutcome::Passed),
            n(SpecificationOutcome::Failed),
            n(SpecificationOutcome::NotChecked)
        );
        // Writing to a string does not fail.
        let _ = writeln!(out, "{} on {}: {counts}", self.title, self.ifc_schema);
        out
    }
}

impl SpecificationReport {
    fn write(&self, out: &mut String) {
        let outcome = match self.outcome {
            SpecificationOutcome::Passed => "passed",
            SpecificationOutcome::Failed => "FAILED",
            SpecificationOutcome::NotChecked => "not checked",
        };
        let identifier = self.identifier.as_ref().map_or(String::new(), |identifier| format!("{identifier}: "));
        let counts = match (self.n_applicable, &self.reason) {
            (_, Some(reason)) => reason.clone(),
            (Some(0), None) => "applies to nothing".to_owned(),
            (Some(n), None) if self.n_failed == 0 => format!("{n} of {n}"),
            (Some(n), None) => format!("{} of {n} fail", self.n_failed),
            (None, None) => String::new(),
        };
        let _ = writeln!(out, "{outcome:<11} {identifier}{} ({counts})", self.name);
        write_failed(out, &self.prohibited);
        let mut told = None;
        for requirement in self.requirements.iter().filter(|requirement| !requirement.failed.is_empty()) {
            let _ = writeln!(out, "  {}: {} fail", requirement.requirement, requirement.failed.len());
            write_failed(out, &requirement.failed);
            if let Some(instructions) = &requirement.instructions {
                told = Some(());
                let _ = writeln!(out, "    {instructions}");
            }
        }
        if let Some(instructions) =
            self.instructions.as_ref().filter(|_| self.outcome == SpecificationOutcome::Failed && told.is_none())
        {
            let _ = writeln!(out, "  {instructions}");
        }
    }
}

fn write_failed(out: &mut String, failed: &[FailedElement]) {
    for element in failed.iter().take(NAMED_MAX) {
        let global_id = element.global_id.as_deref().unwrap_or("-");
        let name = element.name.as_ref().map_or(String::new(), |name| format!(" {name:?}"));
        let _ = writeln!(out, "    {} {global_id}{name} (#{}): {}", element.class, element.id, element.reason);
    }
    if failed.len() > NAMED_MAX {
        let _ = writeln!(out, "    and {} more", failed.len() - NAMED_MAX);
    }
}
