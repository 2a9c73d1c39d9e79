//! Words, progress, dates and work breakdown that both formats of Primavera P6 share.
//!
//! - P6 has no dates without a time of day, and no time zone.
//! - Percentages of XER are those of 100; those of P6 XML are of 1.
//! - "Start" and "finish" on the planner's screen are the actual date, else the early date of what remains, else the planned date. XER
//!   does not write them; P6 XML does.
//! - A milestone has one date, that of its start or of its finish by its kind; some versions write another date beside it.
//! - An activity has three percentages (of its duration, of its units, and the physical one, which is typed in), and says which it goes by.
//! - A resource dependent activity takes as long as the work of its resources, units by units for each hour, in their calendars; others
//!   go by their own calendar.
//! - Expected finishes count in projects whose schedule options say so. Level of effort spans what it is linked with, a WBS summary all
//!   activities below its node.
//! - Lags are working time of the predecessor, unless the schedule options say otherwise.

mod activity;
mod record;

pub(crate) use activity::{ActivityColumns, AssignmentColumns, LinkColumns, activity, assignment, read_link};
pub(crate) use record::Record;

use crate::calendars::{DAY_S, in_order};
use crate::plan::{ConstraintKind, DependencyKind, LagCalendar, PlanFile, PlanTaskKind};

/// Bytes of a work breakdown code.
const MAX_WBS_LEN: usize = 500;

/// Working periods of Monday to Friday where a calendar does not say them: eight hours from eight o'clock.
const USUAL_DAY_S: [[u32; 2]; 1] = [[8 * 3600, 16 * 3600]];

/// Kind of activity; the second is true for a finish milestone.
pub(crate) fn task_kind(word: &str) -> Option<(PlanTaskKind, bool)> {
    Some(match word {
        "TT_Task" | "TT_Rsrc" | "Task Dependent" | "Resource Dependent" | "" => (PlanTaskKind::Task, false),
        "TT_LOE" | "Level of Effort" => (PlanTaskKind::Span, false),
        "TT_WBS" | "WBS Summary" => (PlanTaskKind::WbsSummary, false),
        "TT_Mile" | "Start Milestone" => (PlanTaskKind::Milestone, false),
        "TT_FinMile" | "Finish Milestone" => (PlanTaskKind::Milestone, true),
        _ => return None,
    })
}

/// True for the kind of an activity that goes by its resources.
pub(crate) fn goes_by_resources(kind: &str) -> bool {
    ["TT_Rsrc", "Resource Dependent"].contains(&kind)
}

/// True for the kind of a resource that works: people and machines.
pub(crate) fn works(kind: &str) -> bool {
    !["RT_Mat", "Material"].contains(&kind)
}

/// How a date binds an activity.
pub(crate) fn constraint_kind(word: &str) -> Option<ConstraintKind> {
    Some(match word {
        "CS_ALAP" | "As Late As Possible" => ConstraintKind::AsLateAsPossible,
        "CS_MSO" | "Start On" => ConstraintKind::MustStartOn,
        "CS_MEO" | "Finish On" => ConstraintKind::MustFinishOn,
        "CS_MSOA" | "Start On or After" => ConstraintKind::StartNotEarlierThan,
        "CS_MSOB" | "Start On or Before" => ConstraintKind::StartNotLaterThan,
        "CS_MEOA" | "Finish On or After" => ConstraintKind::FinishNotEarlierThan,
        "CS_MEOB" | "Finish On or Before" => ConstraintKind::FinishNotLaterThan,
        "CS_MANDSTART" | "Mandatory Start" => ConstraintKind::MandatoryStart,
        "CS_MANDFIN" | "Mandatory Finish" => ConstraintKind::MandatoryFinish,
        _ => return None,
    })
}

/// Which ends a relationship joins.
pub(crate) fn dependency_kind(word: &str) -> Option<DependencyKind> {
    Some(match word {
        "PR_FS" | "Finish to Start" => DependencyKind::FinishStart,
        "PR_SS" | "Start to Start" => DependencyKind::StartStart,
        "PR_FF" | "Finish to Finish" => DependencyKind::FinishFinish,
        "PR_SF" | "Start to Finish" => DependencyKind::StartFinish,
        _ => return None,
    })
}

/// In whose working time lags are counted; `None`: day and night.
pub(crate) fn lag_calendar(word: &str) -> Option<LagCalendar> {
    match word {
        "rcal_24Hour" | "24 Hour Calendar" => None,
        "rcal_Successor" | "Successor Activity Calendar" => Some(LagCalendar::Successor),
        "rcal_ProjDefault" | "Project Default Calendar" => Some(LagCalendar::Project),
        _ => Some(LagCalendar::Predecessor),
    }
}

/// Where a calendar does not say a day, or has no working time at all, P6 works eight hours from Monday to Friday.
pub(crate) fn fill_week(week: &mut [Option<Vec<[u32; 2]>>; 7]) {
    let has_work = week.iter().flatten().any(|day| !day.is_empty());
    for (k, day) in week.iter_mut().enumerate() {
        if day.is_none() || !has_work {
            *day = Some(if k < 5 { USUAL_DAY_S.to_vec() } else { Vec::new() });
        }
    }
}

/// Periods of a day in which an end that is not after its start is the end of the day.
pub(crate) fn exception_day(mut periods: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
    for [from, to] in &mut periods {
        if *to <= *from {
            *to = DAY_S;
        }
    }
    in_order(periods)
}

/// Uid of a node of the work breakdown: nodes and activities count apart.
pub(crate) fn node_uid(id: &str) -> String {
    format!("wbs:{id}")
}

/// Gives every task its place in the work breakdown: nodes have their short name in `code`, activities have that of their node.
///
/// A path that grows too long for P6 begins anew.
pub(crate) fn fill_wbs(file: &mut PlanFile) {
    for k in 0..file.tasks.len() {
        let parent = file.tasks[k].parent.map(|parent| file.tasks[parent].wbs.as_str());
        let task = &file.tasks[k];
        let wbs = match parent {
            Some(parent) if task.kind != PlanTaskKind::Summary => parent.to_owned(),
            Some(parent) if parent.len() + task.code.len() < MAX_WBS_LEN => format!("{parent}.{}", task.code),
            _ if task.kind == PlanTaskKind::Summary => task.code.clone(),
            _ => String::new(),
        };
        file.tasks[k].wbs = wbs;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::PlanTask;

    #[test]
    fn a_node_that_nests_without_end_keeps_a_short_path() {
        let mut file = PlanFile::default();
        for k in 0..5000_usize {
            let (parent, kind) = (k.checked_sub(1), PlanTaskKind::Summary);
            file.tasks.push(PlanTask { code: "node".into(), parent, kind, ..Default::default() });
        }
        file.tasks.push(PlanTask { parent: Some(2), ..Default::default() });
        fill_wbs(&mut file);
        assert_eq!((file.tasks[1].wbs.as_str(), file.tasks[5000].wbs.as_str()), ("node.node", "node.node.node"));
        assert!(file.tasks.iter().all(|task| task.wbs.len() <= MAX_WBS_LEN));
    }
}
