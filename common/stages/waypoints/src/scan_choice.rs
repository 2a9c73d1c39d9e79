//! Chooses the scans of a storey: few that reach the goals, or a number of scans that see most.

use crate::options::MissionPlanOptions;
use crate::scan_registration::RegisteredScan;
use crate::scan_survey::ScanSurvey;
use crate::set_cover::{completed, cover};
use crate::tabu_search::more_faces;

/// Few scans that reach the goals, joining scans included, in the order in which they register.
pub(crate) fn fewest_scans(survey: &ScanSurvey, options: &MissionPlanOptions) -> Vec<RegisteredScan> {
    let (instance, registration) = (&survey.instance, survey.registration(options.overlap));
    let searched = registration.joined(&cover(instance, options.search_steps));
    // Scans that grow from each other need fewer joining scans.
    let grown = survey.growth_to_goal().iter().map(|scan| scan.set).collect();
    let grown = registration.joined(&completed(instance, grown));
    let rank = |scans: &[RegisteredScan]| {
        let sets: Vec<u32> = scans.iter().map(|scan| scan.set).collect();
        (
            scans.iter().filter(|scan| !scan.registers).count(),
            sets.len(),
            std::cmp::Reverse(instance.n_covered_by(&sets)),
        )
    };
    if rank(&grown) < rank(&searched) { grown } else { searched }
}

/// The first `n` scans of the growth, exchanged for others while that sees more, in the order in which they register.
pub(crate) fn best_scans(survey: &ScanSurvey, options: &MissionPlanOptions, n: usize) -> Vec<RegisteredScan> {
    let (grown, registration) = (&survey.growth[..n], survey.registration(options.overlap));
    let first: Vec<u32> = grown.iter().map(|scan| scan.set).collect();
    let n_unregistered = registration.n_unregistered(&first);
    let fits = |sets: &[u32]| registration.n_unregistered(sets) <= n_unregistered;
    let chosen = more_faces(&survey.instance, first, options.search_steps, fits);
    let joins: Vec<u32> = grown.iter().filter(|scan| scan.connects).map(|scan| scan.set).collect();
    registration.with_reasons(&chosen, &joins)
}
