//! Cost of reading schedules: linear in tasks. A hundred thousand are to take one second at most.

use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use schedule_files::{ReadOptions, read};
use std::fmt::Write;
use std::hint::black_box;

/// Activities of a node of the work breakdown.
const PER_NODE: usize = 20;

/// A schedule of P6 with as many activities, two relationships, a code and a field each.
fn xer(n: usize) -> String {
    let mut text = "ERMHDR\t19.12\n".to_owned();
    let mut table = |name: &str, columns: &str, n: usize, row: &dyn Fn(usize) -> String| {
        let _ = writeln!(text, "%T\t{name}\n%F\t{}", columns.replace(' ', "\t"));
        for k in 0..n {
            let _ = writeln!(text, "%R\t{}", row(k));
        }
    };
    table("PROJWBS", "wbs_id parent_wbs_id wbs_short_name wbs_name", n / PER_NODE + 1, &|k| {
        format!("{k}\t{}\tN{k}\tPart {k} of the building", if k == 0 { String::new() } else { (k / 8).to_string() })
    });
    let columns = "task_id wbs_id task_code task_name task_type status_code complete_pct_type total_float_hr_cnt \
                   free_float_hr_cnt target_drtn_hr_cnt remain_drtn_hr_cnt target_start_date target_end_date \
                   early_start_date early_end_date late_start_date late_end_date restart_date reend_date cstr_type cstr_date";
    table("TASK", columns, n, &|k| {
        let (start, end) = (format!("2024-03-{:02} 08:00", k % 28 + 1), format!("2024-04-{:02} 17:00", k % 28 + 1));
        let dates = format!("{start}\t{end}");
        format!(
            "{k}\t{}\tA{k}\tWall {k} on the ground floor\tTT_Task\tTK_NotStart\tCP_Drtn\t16\t8\t40\t40\t{dates}\t{dates}\t{dates}\t{dates}\t\
             CS_MSOA\t{start}",
            k / PER_NODE
        )
    });
    table("TASKPRED", "task_id pred_task_id pred_type lag_hr_cnt", 2 * n, &|k| {
        format!("{}\t{}\tPR_FS\t8", k / 2, (k / 2).saturating_sub(k % 2 + 1))
    });
    table("ACTVTYPE", "actv_code_type_id actv_code_type", 1, &|_| "1\tZone".to_owned());
    table("ACTVCODE", "actv_code_id actv_code_type_id short_name", 9, &|k| format!("{k}\t1\tZ{k}"));
    table("TASKACTV", "task_id actv_code_id", n, &|k| format!("{k}\t{}", k % 9));
    table("UDFTYPE", "udf_type_id table_name udf_type_label", 1, &|_| "1\tTASK\t4D_Number".to_owned());
    table("UDFVALUE", "udf_type_id fk_id udf_text", n, &|k| format!("1\t{k}\tW-{k}"));
    text + "%E\n"
}

/// The same in XML.
fn pmxml(n: usize) -> String {
    fn cell(text: &mut String, name: &str, value: impl std::fmt::Display) {
        let _ = writeln!(text, "<{name}>{value}</{name}>");
    }
    let mut text = "<APIBusinessObjects><ActivityCodeType><ObjectId>1</ObjectId><Name>Zone</Name></ActivityCodeType>\
                    <ActivityCode><ObjectId>1</ObjectId><CodeValue>Z1</CodeValue></ActivityCode>\
                    <UDFType><ObjectId>1</ObjectId><Title>4D_Number</Title></UDFType><Project><ObjectId>1</ObjectId>\n"
        .to_owned();
    for k in 0..=n / PER_NODE {
        let parent = if k == 0 { String::new() } else { (k / 8).to_string() };
        text += "<WBS>\n";
        for (name, value) in [("ObjectId", k.to_string()), ("Code", format!("N{k}")), ("ParentObjectId", parent)] {
            cell(&mut text, name, value);
        }
        text += "</WBS>\n";
    }
    for k in 0..n {
        text += "<Activity>\n<Code><TypeObjectId>1</TypeObjectId><ValueObjectId>1</ValueObjectId></Code>\n";
        for (name, value) in
            [("ObjectId", k.to_string()), ("Id", format!("A{k}")), ("WBSObjectId", (k / PER_NODE).to_string())]
        {
            cell(&mut text, name, value);
        }
        cell(&mut text, "Name", format_args!("Wall {k} on the ground floor"));
        for (name, value) in
            [("Type", "Task Dependent"), ("Status", "Not Started"), ("PercentCompleteType", "Duration")]
        {
            cell(&mut text, name, value);
        }
        for name in ["PlannedDuration", "RemainingDuration", "AtCompletionDuration"] {
            cell(&mut text, name, 40);
        }
        for name in ["PlannedStartDate", "StartDate", "RemainingEarlyStartDate", "RemainingLateStartDate"] {
            cell(&mut text, name, format_args!("2024-03-{:02}T08:00:00", k % 28 + 1));
        }
        for name in ["PlannedFinishDate", "FinishDate", "RemainingEarlyFinishDate", "RemainingLateFinishDate"] {
            cell(&mut text, name, format_args!("2024-04-{:02}T17:00:00", k % 28 + 1));
        }
        let _ = writeln!(text, "<UDF><TypeObjectId>1</TypeObjectId><TextValue>W-{k}</TextValue></UDF>\n</Activity>");
    }
    for k in 0..2 * n {
        text += "<Relationship>\n";
        cell(&mut text, "SuccessorActivityObjectId", k / 2);
        cell(&mut text, "PredecessorActivityObjectId", (k / 2).saturating_sub(k % 2 + 1));
        cell(&mut text, "Type", "Finish to Start");
        cell(&mut text, "Lag", 8);
        text += "</Relationship>\n";
    }
    text + "</Project></APIBusinessObjects>"
}

/// The same of MS Project, with the elements that it writes for each task.
fn mspdi(n: usize) -> String {
    let mut text = "<Project xmlns=\"http://schemas.microsoft.com/project\"><ExtendedAttributes><ExtendedAttribute>\
                    <FieldID>188743731</FieldID><FieldName>Text1</FieldName><Alias>4D_Number</Alias></ExtendedAttribute>\
                    </ExtendedAttributes><Tasks>\n"
        .to_owned();
    let others =
        ["Type", "IsNull", "Priority", "ResumeValid", "EffortDriven", "Recurring", "OverAllocated", "Estimated"];
    let more =
        ["Critical", "IsSubproject", "ExternalTask", "StartVariance", "FinishVariance", "Work", "FixedCost", "ACWP"];
    for k in 0..n {
        let (level, parent) = (1 + usize::from(k % PER_NODE != 0), k / PER_NODE);
        let (start, end) =
            (format!("2024-03-{:02}T08:00:00", k % 28 + 1), format!("2024-04-{:02}T17:00:00", k % 28 + 1));
        let _ = write!(
            text,
            "<Task>\n<UID>{}</UID>\n<ID>{}</ID>\n<Name>Wall {k} on the ground floor</Name>\n<WBS>{parent}.{k}</WBS>\n\
             <OutlineNumber>{parent}.{k}</OutlineNumber>\n<OutlineLevel>{level}</OutlineLevel>\n<Start>{start}</Start>\n\
             <Finish>{end}</Finish>\n<Duration>PT40H0M0S</Duration>\n<DurationFormat>7</DurationFormat>\n",
            k + 1,
            k + 1,
        );
        for name in others.iter().chain(&more) {
            let _ = writeln!(text, "<{name}>0</{name}>");
        }
        let _ = write!(
            text,
            "<EarlyStart>{start}</EarlyStart>\n<EarlyFinish>{end}</EarlyFinish>\n<LateStart>{start}</LateStart>\n\
             <LateFinish>{end}</LateFinish>\n<FreeSlack>4800</FreeSlack>\n<TotalSlack>9600</TotalSlack>\n\
             <PercentComplete>0</PercentComplete>\n<ConstraintType>4</ConstraintType>\n\
             <ConstraintDate>{start}</ConstraintDate>\n<CalendarUID>-1</CalendarUID>\n"
        );
        for before in [k.saturating_sub(1), k.saturating_sub(2)] {
            let _ = write!(
                text,
                "<PredecessorLink>\n<PredecessorUID>{before}</PredecessorUID>\n<Type>1</Type>\n<CrossProject>0</CrossProject>\n\
                 <LinkLag>4800</LinkLag>\n<LagFormat>7</LagFormat>\n</PredecessorLink>\n"
            );
        }
        let _ = write!(
            text,
            "<ExtendedAttribute>\n<FieldID>188743731</FieldID>\n<Value>W-{k}</Value>\n</ExtendedAttribute>\n\
             <Baseline>\n<Number>0</Number>\n<Start>{start}</Start>\n<Finish>{end}</Finish>\n</Baseline>\n</Task>\n"
        );
    }
    text + "</Tasks></Project>"
}

/// The same as a table.
fn csv(n: usize) -> String {
    let mut text = "ID;Name;Outline Level;Duration;Start;Finish;Predecessors;% Complete;Zone;4D_Number\n".to_owned();
    for k in 0..n {
        let (day, level) = (k % 28 + 1, 1 + usize::from(k % PER_NODE != 0));
        let _ = writeln!(
            text,
            "{k};\"Wall {k}; on the ground floor\";{level};5 days;{day:02}.03.2024 08:00;{day:02}.04.2024 17:00;\
             \"{}FS+1d;{}SS\";0%;Z1;W-{k}",
            k.saturating_sub(1),
            k.saturating_sub(2),
        );
    }
    text
}

fn bench(c: &mut Criterion) {
    let mut group = c.benchmark_group("read");
    group.sample_size(10);
    for n in [10_000, 100_000] {
        let plans = [("plan.xer", xer(n)), ("plan.xml", pmxml(n)), ("mspdi.xml", mspdi(n)), ("plan.csv", csv(n))];
        for (name, text) in plans {
            let id = BenchmarkId::new(name, format!("{n} tasks, {} kB", text.len() / 1000));
            group.bench_function(id, |b| {
                b.iter(|| read(name, black_box(text.as_bytes()), &ReadOptions::default()).expect("it is whole"));
            });
        }
    }
    group.finish();
}

criterion_group!(benches, bench);
criterion_main!(benches);
