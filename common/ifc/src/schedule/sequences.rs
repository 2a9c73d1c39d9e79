//! Task sequences and lags: IfcRelSequence, IfcLagTime.

use super::context::{Context, tell};
use super::model::{DurationType, Lag, LagValue, Sequence, SequenceType};
use super::times;
use crate::kernel::Record;
use crate::products::named;
use diagnostics::{DiagnosticCode, Named, Report, Severity};

/// IfcRelSequence between tasks that exist; others are reported and dropped.
pub(super) fn sequences(context: &Context<'_, '_>, report: &mut Report) -> Vec<Sequence> {
    let mut sequences = Vec::new();
    for relation in context.file.records("IfcRelSequence", report) {
        let id = named(context.file, &relation);
        let ends = [4, 5].map(|k| relation.at(k).reference());
        let tasks = ends.map(|end| end.and_then(|id| context.task_idx.get(&id).copied()));
        let [Some(predecessor), Some(successor)] = tasks else {
            let missing = ends.iter().zip(tasks).find(|(_, task)| task.is_none()).and_then(|(end, _)| *end);
            let what = missing.map_or("nothing".to_owned(), |id| {
                format!("#{}, which is no task of the file", context.file.written_id(id))
            });
            let message = format!("the sequence ends at {what}; it is dropped");
            tell(report, Severity::Error, DiagnosticCode::SequenceDangling, &id, message);
            continue;
        };
        let kind = match relation.at(7).enumeration().unwrap_or_default().to_ascii_uppercase().as_str() {
            "START_START" => SequenceType::StartStart,
            "START_FINISH" => SequenceType::StartFinish,
            "FINISH_FINISH" => SequenceType::FinishFinish,
            "USERDEFINED" => {
                let message = "its type is user-defined; it is taken as FINISH_START".to_owned();
                tell(report, Severity::Info, DiagnosticCode::SequenceUserDefined, &id, message);
                SequenceType::FinishStart
            }
            _ => SequenceType::FinishStart,
        };
        let lag = lag(context, &relation, &id, report);
        sequences.push(Sequence { id, predecessor, successor, kind, lag });
    }
    sequences
}

/// TimeLag: an IfcLagTime, or a number of the project's time unit in IFC2X3, where it is required and mostly 0.
fn lag(context: &Context<'_, '_>, relation: &Record<'_>, id: &Named, report: &mut Report) -> Option<Lag> {
    let file = context.file;
    if let Some(count) = relation.at(6).number() {
        return match &context.time_unit_s {
            _ if count == 0.0 => None,
            Ok(unit_s) => Some(Lag {
                value: LagValue::Duration(times::duration_text(count * unit_s)),
                duration_type: DurationType::ElapsedTime,
            }),
            Err(why) => {
                tell(
                    report,
                    Severity::Error,
                    DiagnosticCode::TimeUnitUnknown,
                    id,
                    format!("its lag is skipped, because {why}"),
                );
                None
            }
        };
    }
    let lag_id = relation.at(6).reference()?;
    let Some(lag) = file.short_record_of(lag_id, "IFCLAGTIME") else {
        let message = format!("its lag #{} is missing or no IfcLagTime; there is none", file.written_id(lag_id));
        tell(report, Severity::Error, DiagnosticCode::LagMissing, id, message);
        return None;
    };
    let value = file.attribute(&lag, "LagValue");
    let value = match (value.text(), value.number()) {
        (Some(text), _) => LagValue::Duration(text.trim().to_owned()),
        (None, Some(ratio)) => LagValue::Ratio(ratio),
        (None, None) => {
            let message = format!("its lag #{} has no value that can be read; there is none", file.written_id(lag_id));
            tell(report, Severity::Error, DiagnosticCode::LagMissing, id, message);
            return None;
        }
    };
    Some(Lag { value, duration_type: times::duration_type(file.attribute(&lag, "DurationType")) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{file, read};

    const TASKS: &str = "#1=IFCTASK('a',$,'A',$,$,$,$,$,$,.F.,$,$,$);#2=IFCTASK('b',$,'B',$,$,$,$,$,$,.F.,$,$,$);";

    fn first(records: &str) -> (Option<Sequence>, Vec<&'static str>) {
        let (mut model, diagnostics) = read(&file(&format!("{TASKS}{records}"))).unwrap();
        let codes = diagnostics.iter().map(|d| d.code.name()).filter(|c| !c.starts_with("length"));
        (model.schedule.sequences.pop(), codes.collect())
    }

    #[test]
    fn sequences_have_ends_a_type_and_a_lag() {
        let (sequence, _) = first(
            "#3=IFCRELSEQUENCE('s',$,$,$,#1,#2,#4,.START_START.,$);#4=IFCLAGTIME($,$,$,IFCDURATION('P1D'),.WORKTIME.);",
        );
        let sequence = sequence.unwrap();
        assert_eq!((sequence.predecessor, sequence.successor, sequence.kind), (0, 1, SequenceType::StartStart));
        let lag = sequence.lag.unwrap();
        assert_eq!((lag.value, lag.duration_type), (LagValue::Duration("P1D".to_owned()), DurationType::WorkTime));
        let (ratio, _) =
            first("#3=IFCRELSEQUENCE('s',$,$,$,#1,#2,#4,$,$);#4=IFCLAGTIME($,$,$,IFCRATIOMEASURE(0.5),.ELAPSEDTIME.);");
        let ratio = ratio.unwrap();
        assert_eq!(ratio.lag.map(|lag| lag.value), Some(LagValue::Ratio(0.5)));
        assert_eq!(ratio.kind, SequenceType::FinishStart, "what the file does not say");
    }

    #[test]
    fn sequences_and_lags_that_lead_nowhere_are_named() {
        assert_eq!(
            first("#3=IFCRELSEQUENCE('s',$,$,$,#1,#9,$,$,$);"),
            (None, vec!["reference_dangling", "sequence_dangling"])
        );
        let (sequence, codes) = first("#3=IFCRELSEQUENCE('s',$,$,$,#1,#2,#9,$,$);");
        assert_eq!((sequence.unwrap().lag, codes), (None, vec!["reference_dangling", "lag_missing"]));
    }
}
