//! Progress of an ingestion: what is being done, and the share of the whole work that is done.

use ifc::Named;

/// Progress of an ingestion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress<'a> {
    /// Stage of the work.
    pub stage: Stage,
    /// Base name of the file; empty where it is done to all files.
    pub file: &'a str,
    /// Steps done in this stage of the file.
    pub done: usize,
    /// Steps of this stage.
    pub total: usize,
    /// The element that is meshed in another process now, else the most detailed one that is not meshed yet: what the work waits
    /// for, where it waits.
    pub waits_for: Option<&'a Named>,
    /// Share of the whole work that is done, from 0 to 1. It falls where the kernel begins again after a panic.
    pub share: f64,
}

/// Stage of the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Stage {
    /// Records and relations of a file.
    Reading,
    /// Meshes of a file.
    Meshing,
    /// The files become one site.
    Joining,
}

impl Progress<'_> {
    /// Description of the stage.
    pub fn doing(&self) -> String {
        match self.stage {
            Stage::Reading => format!("reading {}", self.file),
            Stage::Meshing => {
                let Self { file, done, total, .. } = self;
                let at =
                    |named: &Named| format!(", at #{} {} {} or another", named.step_id, named.global_id, named.name);
                format!("meshing {file}, {done} of {total}{}", self.waits_for.map(at).unwrap_or_default())
            }
            Stage::Joining => "joining the files".to_owned(),
        }
    }
}

/// Share of the work of a file that is done when it is read: most of the time goes into meshes.
const READ: f64 = 0.15;

/// Share of the whole work that is done when all files are meshed.
const MESHED: f64 = 0.9;

/// Shares of the whole work at which the work on each file begins and ends, by the bytes of the files.
pub(crate) fn spans(lengths: &[usize]) -> Vec<[f64; 2]> {
    let bytes = |lengths: &[usize]| lengths.iter().sum::<usize>() as f64;
    let share = |n_files: usize| MESHED * bytes(&lengths[..n_files]) / bytes(lengths).max(1.0);
    (0..lengths.len()).map(|k| [share(k), share(k + 1)]).collect()
}

/// The progress of the reader of a file, whose work lies in a span of the whole.
pub(crate) fn of_file<'a>(file: &'a str, [begin, end]: [f64; 2], step: ifc::Progress<'a>) -> Progress<'a> {
    let ifc::Progress { stage, done, total, waits_for } = step;
    let part = done as f64 / total.max(1) as f64;
    let (stage, of_file) = match stage {
        ifc::Stage::Reading => (Stage::Reading, READ * part),
        ifc::Stage::Meshing => (Stage::Meshing, READ + (1.0 - READ) * part),
    };
    Progress { stage, file, done, total, waits_for, share: begin + (end - begin) * of_file }
}

/// All files are meshed.
pub(crate) const JOINING: Progress<'static> =
    Progress { stage: Stage::Joining, file: "", done: 0, total: 1, waits_for: None, share: MESHED };

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_rise_over_all_files_by_their_bytes() {
        let spans = spans(&[300, 0, 100]);
        let steps = |span: &[f64; 2]| {
            let step =
                |stage, done| of_file("a.ifc", *span, ifc::Progress { stage, done, total: 2, waits_for: None }).share;
            [step(ifc::Stage::Reading, 0), step(ifc::Stage::Reading, 2), step(ifc::Stage::Meshing, 2)]
        };
        let shares: Vec<f64> = spans.iter().flat_map(steps).chain([JOINING.share]).collect();
        assert!(shares.is_sorted() && shares[0] == 0.0, "{shares:?}");
        assert!((shares[2] - 0.75 * MESHED).abs() < 1e-9 && (shares[8] - MESHED).abs() < 1e-9, "{shares:?}");
    }
}
