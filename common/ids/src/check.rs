//! Checks the elements of an IFC file against the specifications of an IDS file.

use ifc::{Record, StepFile};
use rustc_hash::FxHashSet;

use crate::CheckError;
use crate::document::{Facet, FacetAt, Ids, Specification, SpecificationCardinality};
use crate::facets::{self, applies, judged};
use crate::model::Model;
use crate::report::{
    FailedElement, IdsReport, REPORT_VERSION, RequirementReport, SpecificationOutcome, SpecificationReport,
};

/// Specifications that are checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// Those that are written for the release of the IFC file; others are reported as not checked.
    OfRelease,
    /// All: what a specification says of releases is metadata alone, as the test cases of IDS have it.
    All,
}

/// Checks the bytes of an IFC file: plain STEP or a zip container.
///
/// # Errors
/// Nothing could be made of the file.
pub fn check(ids: &Ids, ifc: &[u8], scope: Scope) -> Result<IdsReport, CheckError> {
    let (file, _) = StepFile::read(ifc)?;
    Ok(check_file(ids, &file, scope))
}

/// Checks a file whose records are found already.
pub fn check_file(ids: &Ids, file: &StepFile<'_>, scope: Scope) -> IdsReport {
    let model = Model::of(file);
    let of_release = |s: &&Specification| scope == Scope::All || s.releases.contains(&model.release);
    let specifications: Vec<SpecificationReport> = ids
        .specifications
        .iter()
        .map(|specification| match Some(specification).filter(of_release) {
            Some(_) => checked(&model, specification),
            None => not_checked(&model, specification),
        })
        .collect();
    IdsReport {
        format_version: REPORT_VERSION,
        title: ids.info.title.clone(),
        ifc_schema: file.schema().to_owned(),
        release: model.release,
        passed: specifications.iter().all(|s| s.outcome != SpecificationOutcome::Failed),
        specifications,
    }
}

/// A report of a specification that nothing is known of yet.
fn blank(specification: &Specification) -> SpecificationReport {
    SpecificationReport {
        name: specification.name.clone(),
        identifier: specification.identifier.clone(),
        description: specification.description.clone(),
        instructions: specification.instructions.clone(),
        cardinality: specification.cardinality,
        outcome: SpecificationOutcome::NotChecked,
        reason: None,
        n_applicable: None,
        n_failed: 0,
        prohibited: Vec::new(),
        requirements: Vec::new(),
    }
}

fn not_checked(model: &Model<'_>, specification: &Specification) -> SpecificationReport {
    let releases: Vec<&str> = specification.releases.iter().map(|release| release.name()).collect();
    let reason = format!("it is for {}, and the file is {}", releases.join(", "), model.release);
    SpecificationReport { reason: Some(reason), ..blank(specification) }
}

fn checked(model: &Model<'_>, specification: &Specification) -> SpecificationReport {
    let mut report = blank(specification);
    report.requirements = specification
        .requirements
        .iter()
        .map(|requirement| RequirementReport {
            requirement: requirement.to_string(),
            cardinality: requirement.cardinality,
            instructions: requirement.instructions.clone(),
            n_passed: 0,
            failed: Vec::new(),
        })
        .collect();
    let mut n_applicable = 0;
    for id in candidates(model, &specification.applicability) {
        let Some(record) = model.file.record(id) else { continue };
        if !specification.applicability.iter().all(|at| applies(model, &record, &at.facet)) {
            continue;
        }
        n_applicable += 1;
        if specification.cardinality == SpecificationCardinality::Prohibited {
            report.prohibited.push(failed(model, &record, "it must not be there".to_owned()));
            continue;
        }
        let mut fails = false;
        for (requirement, report) in std::iter::zip(&specification.requirements, &mut report.requirements) {
            let facet = &requirement.facet.facet;
            match judged(&facets::findings(model, &record, facet), facet, requirement.cardinality) {
                Ok(()) => report.n_passed += 1,
                Err(reason) => {
                    fails = true;
                    report.failed.push(failed(model, &record, reason));
                }
            }
        }
        report.n_failed += usize::from(fails);
    }
    report.n_failed += report.prohibited.len();
    report.n_applicable = Some(n_applicable);
    let lacks = specification.cardinality == SpecificationCardinality::Required && n_applicable == 0;
    if lacks {
        let facets: Vec<String> = specification.applicability.iter().map(|at| at.facet.to_string()).collect();
        report.reason = Some(format!("the file has nothing with {}", facets.join(" and ")));
    }
    let fails = lacks || report.n_failed > 0;
    report.outcome = if fails { SpecificationOutcome::Failed } else { SpecificationOutcome::Passed };
    report
}

/// Ids of the records that an applicability may mean, ascending.
fn candidates(model: &Model<'_>, applicability: &[FacetAt]) -> Vec<u32> {
    let entity = applicability.iter().find_map(|at| match &at.facet {
        Facet::Entity(entity) => Some(entity),
        _ => None,
    });
    let mut ids: Vec<u32> = match entity {
        Some(entity) => {
            let of_class = model.file.entities().filter(|(keyword, _)| entity.name.matches_text(keyword));
            let ids: FxHashSet<u32> = of_class.flat_map(|(_, ids)| ids.iter().copied()).collect();
            // In IFC2X3 an object may be of a class by its type.
            ids.into_iter().chain(model.objects_with_types()).collect()
        }
        None => model.file.entities().flat_map(|(_, ids)| ids.iter().copied()).collect(),
    };
    ids.sort_unstable();
    ids.dedup();
    ids
}

fn failed(model: &Model<'_>, record: &Record<'_>, reason: String) -> FailedElement {
    let entity = model.entity_of(record);
    let is_rooted = entity.is_some_and(|entity| entity.is("IFCROOT"));
    let name = entity.and_then(|entity| entity.position("Name")).map(|at| record.text(at));
    FailedElement {
        id: model.file.written_id(record.id),
        global_id: is_rooted.then(|| record.text(0)),
        class: entity.map_or(record.keyword, |entity| entity.name).to_owned(),
        name: name.filter(|name| !name.is_empty()),
        reason,
    }
}
