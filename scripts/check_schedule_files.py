#!/usr/bin/env python3
"""Compares what `common/schedule-files` reads from schedules with what MPXJ reads from them.

    python3 scripts/check_schedule_files.py --reader PROGRAM [--count 20] [--seed 1]
    python3 scripts/check_schedule_files.py --write-fixtures DIR

Needs mpxj and jpype1 and a Java runtime. PROGRAM is the example `dump_plan` of the crate. MPXJ generates schedules (the seed
decides all of them), computes their dates and writes each as MSPDI, XER and PMXML; both sides read every file back.
`--write-fixtures` writes small ones and what MPXJ reads from them: the fixtures of the crate's own tests, which need no Java.
Prints a line with the verdict for each file. Exit codes: 0 all agree, 1 one does not, 2 a file cannot be read or written.

Both sides give the form of `common/schedule-files/tests/plan_json`; lengths are seconds, ratios have six decimals; progress and float of which a
file says nothing are 0:

    {"name": .., "calendars": [{"name", "is_default", "week": 7 days of [[from, to], ..], "days": {"2024-05-01": [[from, to], ..]}}],
     "tasks": [{"name", "parent", "kind", "code", "calendar", "duration": [seconds, is_elapsed], "remaining", "complete", "physical",
                "dates": {"current": [start, finish], ..}, "constraints": [[kind, date], ..], "fields": [[name, value], ..],
                "is_inactive"}],
     "links": [[predecessor, successor, kind, lag, is_elapsed, unit of the lag], ..]}

Tasks and calendars are named by their names, which are unique here. `days` are those of 2024 and 2025 that differ from the week.
What is not compared, and why, is in KNOWN_DIFFERENCES.
"""

import argparse
import json
import pathlib
import random
import re
import subprocess
import sys
import tempfile

FORMATS = {"mspdi": ("xml", "MSPDIWriter"), "xer": ("xer", "PrimaveraXERFileWriter"), "pmxml": ("pmxml", "PrimaveraPMFileWriter")}

P6 = ("xer", "pmxml")

# Formats, kinds of tasks, what of them is not compared, and why. Differences of single values stand where they are dumped.
KNOWN_DIFFERENCES = [
    (P6, ("summary",), "dates", "MPXJ computes the dates of nodes of the work breakdown; files of P6 do not have them"),
    (P6, ("summary",), "duration", "as the dates"),
    (P6, ("summary",), "remaining", "as the dates"),
    (P6, ("summary",), "complete", "as the dates"),
    (P6, ("summary",), "physical", "as the dates"),
    (P6, ("summary",), "total_float_s", "as the dates"),
    (P6, ("summary",), "free_float_s", "as the dates"),
    (P6, ("summary",), "calendar", "as the dates"),
    (P6, ("summary",), "code", "MPXJ gives a node the path of codes that is its work breakdown here"),
    (P6, ("summary", "task", "milestone"), "wbs", "MPXJ begins with the node of the project or not, by what it finds above it"),
    (("pmxml",), (), "the node of the project", "MPXJ has it in XER only; it is added to what MPXJ reads"),
    (("pmxml",), ("task", "milestone"), "free_float_s", "MPXJ does not write it, and computes it"),
    (P6, ("task", "milestone"), "dates/baseline", "MPXJ takes planned dates for a baseline where the file has none"),
]

NAMES = ["Rohbau Süd", "Wände <EG> & Stürze", 'Tür "T30"', "Außenputz", "Decke über 1. OG", "Fenster & Läden", "Estrich", "Gerüst"]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--reader", type=pathlib.Path)
    arguments.add_argument("--count", type=int, default=20)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--write-fixtures", type=pathlib.Path)
    arguments.add_argument("--keep", type=pathlib.Path, help="folder for the files, instead of a temporary one")
    options = arguments.parse_args()
    if not options.reader and not options.write_fixtures:
        arguments.error("one of --reader and --write-fixtures is needed")
    start_java()
    if options.write_fixtures:
        write_fixtures(options.write_fixtures, options.seed)
    if not options.reader:
        return 0
    with tempfile.TemporaryDirectory() as folder:
        return compare_all(options, options.keep or pathlib.Path(folder))


def start_java():
    try:
        import jpype
        import mpxj  # noqa: F401  It adds its jars to the class path.

        # Its messages about the terminal are of no use here.
        jpype.startJVM("-Djava.awt.headless=true")
    except Exception as error:  # noqa: BLE001  Whatever is wrong with Java, there is none.
        print(f"MPXJ cannot be run: {error}", file=sys.stderr)
        sys.exit(2)


def compare_all(options, folder):
    folder.mkdir(parents=True, exist_ok=True)
    n_wrong = 0
    for k in range(options.count):
        plan = generate(random.Random(f"{options.seed} {k}"), n_tasks=12 + 6 * k)
        for form, (suffix, _) in FORMATS.items():
            path = folder / f"plan-{k:02}.{suffix}"
            write(plan, form, path)
            expected = dump(path, form)
            path.with_suffix(f".{suffix}.json").write_text(text_of(expected), encoding="utf-8")
            run = subprocess.run([options.reader, path], capture_output=True, encoding="utf-8", check=False)
            if run.returncode != 0:
                print(f"FAIL {path.name}: {run.stderr.strip()}")
                n_wrong += 1
                continue
            differences = compare(expected, json.loads(run.stdout))
            print(f"{'FAIL' if differences else 'ok  '} {path.name}: {len(expected['tasks'])} tasks, {len(expected['links'])} links, "
                  f"{len(expected['calendars'])} calendars, {len(differences)} differences")
            print("".join(f"     {line}\n" for line in differences[:20]), end="")
            n_wrong += bool(differences)
    return 1 if n_wrong else 0


def compare(expected, read, path=""):
    """Lines that say what differs."""
    if isinstance(expected, dict) and isinstance(read, dict):
        # What MPXJ's side does not have is a known difference, but for the days of calendars and in lists.
        is_part = "/tasks/" in path and len(path.split("/")) > 2 or not path
        keys = sorted(set(expected) if is_part else set(expected) | set(read))
        return [line for key in keys for line in compare(expected.get(key), read.get(key), f"{path}/{key}")]
    if isinstance(expected, list) and isinstance(read, list) and expected and isinstance(expected[0], dict):
        def by_name(items):
            return {item["name"]: item for item in items}
        return compare(by_name(expected), by_name(read), path)
    return [] if expected == read else [f"{path}: MPXJ {json.dumps(expected, ensure_ascii=False)}, here {json.dumps(read, ensure_ascii=False)}"]


# Schedules

def generate(rng, n_tasks, n_shifts=4):
    """A schedule with whatever the formats can hold, its dates computed by MPXJ."""
    from java.time import LocalDateTime
    from org.mpxj import ProjectFile, RelationType, TimeUnit
    from org.mpxj.cpm import MicrosoftScheduler

    plan = ProjectFile()
    plan.getProjectProperties().setName("Neubau Süd <&\">")
    plan.getProjectProperties().setProjectTitle("Neubau Süd <&\">")
    start = LocalDateTime.of(2024, rng.randint(1, 6), rng.randint(1, 28), 8, 0)
    plan.getProjectProperties().setStartDate(start)
    plan.getProjectProperties().setStatusDate(start.plusDays(20))
    calendars = add_calendars(plan, rng, n_shifts)
    fields = add_fields(plan, rng)
    tasks = add_tasks(plan, rng, n_tasks)
    for number, task in enumerate(tasks):
        fill(plan, rng, task, calendars, fields, start)
        # Backwards only: no cycles. MPXJ's writers keep one relation for a pair of tasks.
        for before in {rng.randrange(number) for _ in range(rng.choice([0, 1, 1, 2]))} if number else ():
            from org.mpxj import Relation
            kind = rng.choice([RelationType.FINISH_START] * 3 + list(RelationType.values()))
            task.addPredecessor(Relation.Builder().predecessorTask(tasks[before]).type(kind).lag(a_lag(rng)))
    MicrosoftScheduler().schedule(plan, start)
    # Afterwards, as it would leave them out.
    for task in rng.sample(tasks, len(tasks) // 8):
        task.setActive(False)
    for number, task in enumerate(tasks):
        add_history(rng, task, number)
    return plan


def add_calendars(plan, rng, n_shifts):
    from java.time import DayOfWeek, LocalDate, LocalTime
    from org.mpxj import LocalTimeRange

    def at(text):
        return LocalTime.MIDNIGHT if text == "24:00" else LocalTime.parse(text)

    def fill_ranges(hours, ranges):
        hours.clear()
        for first, last in ranges:
            hours.add(LocalTimeRange(at(first), at(last)))

    usual = plan.addDefaultBaseCalendar()
    usual.setName("Standard")
    plan.setDefaultCalendar(usual)
    usual.addCalendarException(LocalDate.of(2024, 12, 24), LocalDate.of(2025, 1, 1)).setName("Weihnachten & Neujahr")
    for month, day in [(5, 1), (10, 3)]:
        usual.addCalendarException(LocalDate.of(2024, month, day))
    shifts = {
        "Zwei Schichten": [("06:00", "14:00"), ("14:30", "22:00")],
        "Nachtschicht <22-6>": [("00:00", "06:00"), ("22:00", "24:00")],
        "Tag und Nacht": [("00:00", "24:00")],
        "Baustelle früh": [("07:15", "11:30"), ("12:00", "16:45")],
    }
    calendars = [usual]
    for name, ranges in rng.sample(sorted(shifts.items()), n_shifts):
        calendar = plan.addCalendar()
        calendar.setName(name)
        for day in DayOfWeek.values():
            calendar.setWorkingDay(day, name == "Tag und Nacht" or day.getValue() <= 5)
            fill_ranges(calendar.addCalendarHours(day), ranges if calendar.isWorkingDay(day) else [])
        for _ in range(rng.randrange(4)):
            day = LocalDate.of(2024, rng.randint(1, 12), rng.randint(1, 28))
            if calendar.getException(day) is None:
                exception = calendar.addCalendarException(day)
                if rng.random() < 0.5:
                    exception.add(LocalTimeRange(LocalTime.of(9, 0), LocalTime.of(12, 0)))
        calendars.append(calendar)
    for recurring in recurring_days(rng):
        calendars[-1].addCalendarException(recurring)
    based = plan.addDefaultDerivedCalendar()
    based.setParent(usual)
    based.setName("Samstags auch")
    based.setWorkingDay(DayOfWeek.SATURDAY, True)
    fill_ranges(based.addCalendarHours(DayOfWeek.SATURDAY), [("08:00", "12:00")])
    based.addCalendarException(LocalDate.of(2024, 7, 1), LocalDate.of(2024, 7, 5))
    return [*calendars, based]


def recurring_days(rng):
    """Holidays of the last calendar with shifts."""
    from java.lang import Integer
    from java.time import DayOfWeek, LocalDate
    from org.mpxj import RecurrenceType, RecurringData

    weekly = RecurringData()
    weekly.setRecurrenceType(RecurrenceType.WEEKLY)
    weekly.setFrequency(Integer(rng.randint(1, 3)))
    weekly.setWeeklyDay(DayOfWeek.of(rng.randint(1, 5)), True)
    monthly = RecurringData()
    monthly.setRecurrenceType(RecurrenceType.MONTHLY)
    monthly.setFrequency(Integer(1))
    monthly.setRelative(True)
    monthly.setDayNumber(Integer(rng.choice([1, 2, 5])))
    monthly.setDayOfWeek(DayOfWeek.FRIDAY)
    yearly = RecurringData()
    yearly.setRecurrenceType(RecurrenceType.YEARLY)
    yearly.setFrequency(Integer(1))
    yearly.setMonthNumber(Integer(8))
    yearly.setDayNumber(Integer(15))
    for recurring in (weekly, monthly, yearly):
        recurring.setStartDate(LocalDate.of(2024, 2, 1))
        recurring.setUseEndDate(True)
        recurring.setFinishDate(LocalDate.of(2025, 3, 31))
    return [weekly, monthly, yearly]


def add_fields(plan, rng):
    """Fields of MS Project, and activity codes and user-defined fields of P6."""
    from java.lang import Integer
    from org.mpxj import ActivityCode, ActivityCodeScope, ActivityCodeValue, DataType, FieldTypeClass, TaskField, UserDefinedField

    for field, alias in [(TaskField.TEXT1, "4D_Number"), (TaskField.TEXT2, "Gewerk"), (TaskField.NUMBER1, "Kolonne")]:
        plan.getCustomFields().getOrCreate(field).setAlias(alias)
    code = ActivityCode.Builder(plan).name("Bauabschnitt").scope(ActivityCodeScope.GLOBAL).sequenceNumber(Integer(1)).build()
    plan.getActivityCodes().add(code)
    values = []
    for number, name in enumerate(["BA1", "BA2", "Höfe & Wege"], start=1):
        value = ActivityCodeValue.Builder(plan).activityCode(code).name(name).description(f"Abschnitt {name}").sequenceNumber(Integer(number)).build()
        code.addValue(value)
        values.append(value)
    field = (UserDefinedField.Builder(plan).fieldTypeClass(FieldTypeClass.TASK).dataType(DataType.STRING)
             .internalName("user_text1").externalName("Raumliste").build())
    plan.getUserDefinedFields().add(field)
    plan.getCustomFields().getOrCreate(field).setAlias("Raumliste")
    return {"values": values, "field": field}


def add_tasks(plan, rng, n_tasks):
    """Work breakdown of up to four levels; returns the tasks that hold no others."""
    levels = [plan]
    leaves = []
    for number in range(n_tasks):
        if rng.random() < 0.3 or len(levels) == 1:
            del levels[rng.randint(1, min(len(levels), 3)) :]
            summary = levels[-1].addTask()
            summary.setName(f"{rng.choice(NAMES)} S{number}")
            summary.setWBS(f"S{number}")
            levels.append(summary)
        task = levels[-1].addTask()
        task.setName(f"{rng.choice(NAMES)} {number}")
        leaves.append(task)
    return leaves


def fill(plan, rng, task, calendars, fields, start):
    from org.mpxj import ActivityType, ConstraintType, Duration, PercentCompleteType, TimeUnit

    number = int(str(task.getName()).rsplit(" ", 1)[1])
    task.setActivityID(f"A{1000 + 10 * number}")
    is_milestone = rng.random() < 0.12
    task.setMilestone(is_milestone)
    task.setActivityType(ActivityType.START_MILESTONE if is_milestone else ActivityType.TASK_DEPENDENT)
    task.setPercentCompleteType(rng.choice([PercentCompleteType.PHYSICAL, PercentCompleteType.DURATION]))
    unit = rng.choice([TimeUnit.DAYS, TimeUnit.DAYS, TimeUnit.HOURS, TimeUnit.WEEKS])
    length = 0.0 if is_milestone else rng.choice([0.5, 1.0, 2.0, 3.0, 5.0, 8.0])
    if unit == TimeUnit.WEEKS:
        length = min(length, 2.0)
    task.setDuration(Duration.getInstance(length, unit))
    task.setPlannedDuration(task.getDuration())
    task.setRemainingDuration(task.getDuration())
    task.setActualDuration(Duration.getInstance(0.0, unit))
    if rng.random() < 0.4:
        task.setCalendar(rng.choice(calendars[1:]))
    if rng.random() < 0.2:
        kinds = [ConstraintType.START_NO_EARLIER_THAN, ConstraintType.START_NO_LATER_THAN, ConstraintType.FINISH_NO_EARLIER_THAN,
                 ConstraintType.FINISH_NO_LATER_THAN, ConstraintType.MUST_START_ON, ConstraintType.MUST_FINISH_ON]
        task.setConstraintType(rng.choice(kinds))
        task.setConstraintDate(start.plusDays(rng.randint(0, 120)))
    if rng.random() < 0.1:
        task.setConstraintType(ConstraintType.AS_LATE_AS_POSSIBLE)
        task.setConstraintDate(None)
    if rng.random() < 0.3:
        task.setOutlineCode(1, rng.choice(["Nord", "Süd & West"]))
    if rng.random() < 0.6:
        task.setText(1, f"4D-{number:03}")
    if rng.random() < 0.4:
        task.setText(2, rng.choice(["Maurer & Co", "Maler <innen>", "Böden"]))
    if rng.random() < 0.3:
        task.setNumber(1, rng.randint(1, 9))
    if rng.random() < 0.5:
        task.addActivityCodeValue(rng.choice(fields["values"]))
    if rng.random() < 0.3:
        task.set(fields["field"], f"Räume {number} & {number + 1}")


def a_lag(rng):
    from org.mpxj import Duration, TimeUnit

    unit = rng.choice([TimeUnit.DAYS, TimeUnit.HOURS, TimeUnit.ELAPSED_DAYS, TimeUnit.ELAPSED_HOURS, TimeUnit.WEEKS, TimeUnit.PERCENT])
    return Duration.getInstance(rng.choice([0.0, 0.0, 1.0, 2.0, 4.0, -1.0]), unit)


def add_history(rng, task, number):
    """Baseline of most tasks; progress of the first ones."""
    from org.mpxj import Duration

    if rng.random() < 0.8:
        task.setBaselineStart(task.getStart())
        task.setBaselineFinish(task.getFinish())
        task.setBaselineDuration(task.getDuration())
    task.setPlannedStart(task.getStart())
    task.setPlannedFinish(task.getFinish())
    task.setRemainingEarlyStart(task.getEarlyStart())
    task.setRemainingEarlyFinish(task.getEarlyFinish())
    if rng.random() < 0.3 / (1 + number / 10):
        is_done = rng.random() < 0.5 or task.getMilestone()
        task.setActualStart(task.getStart())
        task.setActualFinish(task.getFinish() if is_done else None)
        # A fifth, as P6 writes hours with two decimals.
        share = 1.0 if is_done else 0.2
        task.setPercentageComplete(100 * share)
        task.setPhysicalPercentComplete(100 * share)
        planned = task.getDuration()
        task.setActualDuration(Duration.getInstance(planned.getDuration() * share, planned.getUnits()))
        task.setRemainingDuration(Duration.getInstance(planned.getDuration() * (1 - share), planned.getUnits()))


def write(plan, form, path):
    import org.mpxj.mspdi
    import org.mpxj.primavera

    writer = FORMATS[form][1]
    package = org.mpxj.mspdi if form == "mspdi" else org.mpxj.primavera
    getattr(package, writer)().write(plan, str(path))


# What MPXJ reads

KINDS = {"FINISH_START": "FS", "START_START": "SS", "FINISH_FINISH": "FF", "START_FINISH": "SF"}

CONSTRAINTS = {
    "AS_LATE_AS_POSSIBLE": "AsLateAsPossible",
    "START_NO_EARLIER_THAN": "StartNotEarlierThan",
    "START_NO_LATER_THAN": "StartNotLaterThan",
    "FINISH_NO_EARLIER_THAN": "FinishNotEarlierThan",
    "FINISH_NO_LATER_THAN": "FinishNotLaterThan",
    "START_ON": "MustStartOn",
    "FINISH_ON": "MustFinishOn",
}

# MPXJ has one name for the strongest dates of both products.
STRONGEST = {
    "mspdi": {"MUST_START_ON": "MustStartOn", "MUST_FINISH_ON": "MustFinishOn"},
    "xer": {"MUST_START_ON": "MandatoryStart", "MUST_FINISH_ON": "MandatoryFinish"},
    "pmxml": {"MUST_START_ON": "MandatoryStart", "MUST_FINISH_ON": "MandatoryFinish"},
}


def dump(path, form):
    from org.mpxj.reader import UniversalProjectReader

    plan = UniversalProjectReader().read(str(path))
    default = plan.getDefaultCalendar()
    tasks = [task for task in plan.getTasks() if task.getUniqueID() != 0 or form != "mspdi"]
    properties = plan.getProjectProperties()
    dumped = [dump_task(plan, task, form) for task in tasks]
    if form == "pmxml":
        name = text_or_empty(properties.getName())
        for task in dumped:
            task["parent"] = task["parent"] or name
        dumped.append({"name": name, "parent": None, "kind": "summary", "constraints": [], "fields": [], "is_inactive": False})
    return {
        # MPXJ writes no node of the project into XER, whose name it would be.
        **({} if form == "xer" else {"name": text_or_empty(properties.getName())}),
        "calendars": by_name(dump_calendar(calendar, default) for calendar in plan.getCalendars()),
        "tasks": by_name(dumped),
        "links": by_name(dump_link(plan, link) for task in tasks for link in task.getPredecessors()),
    }


def by_name(items):
    return sorted(items, key=lambda item: item["name"])


def text_or_empty(text):
    return "" if text is None else str(text)


def dump_calendar(calendar, default):
    from java.time import DayOfWeek, LocalDate

    def usual(day):
        return ranges(calendar.getHours(day)) if calendar.isWorkingDay(day) else []

    week = [usual(day) for day in DayOfWeek.values()]
    days = {}
    day = LocalDate.of(2024, 1, 1)
    while day.getYear() < 2026:
        hours = ranges(calendar.getHours(day)) if calendar.isWorkingDate(day) else []
        if hours != week[day.getDayOfWeek().getValue() - 1]:
            days[str(day)] = hours
        day = day.plusDays(1)
    is_default = default is not None and calendar.getUniqueID() == default.getUniqueID()
    return {"name": str(calendar.getName()), "is_default": is_default, "week": week, "days": days}


def ranges(hours):
    def seconds(time):
        return time.toSecondOfDay()

    if hours is None:
        return []
    return sorted([seconds(r.getStart()), seconds(r.getEnd()) or 86400] for r in hours if r.getStart() is not None)


def dump_task(plan, task, form):
    is_p6 = form != "mspdi"
    properties = plan.getProjectProperties()
    dates = {
        "current": (task.getStart(), task.getFinish()),
        "planned": (task.getPlannedStart(), task.getPlannedFinish()) if is_p6 else (None, None),
        "early": (task.getEarlyStart(), task.getEarlyFinish()),
        "late": (task.getLateStart(), task.getLateFinish()),
        "actual": (task.getActualStart(), task.getActualFinish()),
        "baseline": (task.getBaselineStart(), task.getBaselineFinish()),
        "remaining": (task.getRemainingEarlyStart(), task.getRemainingEarlyFinish()) if is_p6 else (None, None),
    }
    if is_p6 and task.getMilestone():
        # A milestone has one date; MPXJ computes another one where constraints contradict each other.
        dates["current"] = (task.getStart(), task.getStart())
    kind = "summary" if task.hasChildTasks() or task.getSummary() else "milestone" if task.getMilestone() else "task"
    parent = task.getParentTask()
    # What was typed in counts in P6 where the activity goes by it.
    has_physical = not is_p6 or str(task.getPercentCompleteType()) == "PHYSICAL"
    dumped = {
        "name": str(task.getName()),
        "parent": str(parent.getName()) if parent is not None and parent.getUniqueID() != 0 else None,
        "kind": kind,
        "code": text_or_empty(task.getActivityID() if is_p6 else task.getID()),
        "wbs": text_or_empty(task.getWBS()),
        "calendar": None if task.getCalendar() is None else str(task.getCalendar().getName()),
        "duration": length(task.getPlannedDuration() if is_p6 else task.getDuration(), properties),
        "remaining": length(task.getRemainingDuration(), properties),
        "complete": share(task.getPercentageComplete()),
        "physical": share(task.getPhysicalPercentComplete()) if has_physical else 0.0,
        "total_float_s": seconds_of(task.getTotalSlack(), properties),
        "free_float_s": seconds_of(task.getFreeSlack(), properties),
        "dates": {name: [None if at is None else at_text(at) for at in pair] for name, pair in dates.items()},
        "constraints": constraints(task, CONSTRAINTS | STRONGEST[form]),
        "fields": sorted(fields_of(plan, task)),
        "is_inactive": not task.getActive(),
    }
    if is_p6 and task.getActualFinish() is not None:
        # MPXJ forgets the float of completed activities.
        del dumped["total_float_s"], dumped["free_float_s"]
    for forms, kinds, what, _ in KNOWN_DIFFERENCES:
        if form in forms and kind in kinds:
            *folder, key = what.split("/")
            (dumped.get(folder[0], {}) if folder else dumped).pop(key, None)
    return dumped


def at_text(at):
    from java.time.format import DateTimeFormatter

    return str(at.format(DateTimeFormatter.ISO_LOCAL_DATE_TIME))


def share(percent):
    return 0.0 if percent is None else round(float(percent.doubleValue()) / 100, 6)


def length(duration, properties):
    if duration is None:
        return None
    unit = str(duration.getUnits().name())
    if "PERCENT" in unit:
        return [f"{float(duration.getDuration())}%", unit.startswith("ELAPSED")]
    is_elapsed = unit.startswith("ELAPSED")
    day = 1440.0 if is_elapsed else float(properties.getMinutesPerDay().doubleValue())
    week = 7 * 1440.0 if is_elapsed else float(properties.getMinutesPerWeek().doubleValue())
    month = 30 * 1440.0 if is_elapsed else day * float(properties.getDaysPerMonth().doubleValue())
    minutes = {"MINUTES": 1.0, "HOURS": 60.0, "DAYS": day, "WEEKS": week, "MONTHS": month}[unit.removeprefix("ELAPSED_")]
    return [round(float(duration.getDuration()) * minutes * 60), is_elapsed]


def seconds_of(duration, properties):
    seconds = length(duration, properties)
    return seconds[0] if seconds else 0


def constraints(task, names):
    pairs = [
        (task.getConstraintType(), task.getConstraintDate()),
        (task.getSecondaryConstraintType(), task.getSecondaryConstraintDate()),
    ]
    named = [(None if kind is None else names.get(str(kind.name())), at) for kind, at in pairs]
    return [[name, None if name == "AsLateAsPossible" or at is None else at_text(at)] for name, at in named if name]


def fields_of(plan, task):
    for field in plan.getCustomFields():
        kind = field.getFieldType()
        if str(kind.getFieldTypeClass().name()) == "TASK":
            value = task.getCachedValue(kind) if hasattr(task, "getCachedValue") else task.get(kind)
            if value is not None and str(value):
                yield [str(field.getAlias() or kind.getName()), str(value).removesuffix(".0")]
    for code in plan.getActivityCodes():
        value = task.getActivityCodeValues().get(code)
        if value is not None:
            yield [str(code.getName()), str(value.getName())]


def dump_link(plan, link):
    properties = plan.getProjectProperties()
    ends = [str(task.getName()) for task in (link.getPredecessorTask(), link.getSuccessorTask())]
    lag = length(link.getLag(), properties)
    return {"name": f"{ends[0]} > {ends[1]} {KINDS[str(link.getType().name())]}", "lag": lag if lag and lag[0] != 0 else None}


def text_of(plan):
    """JSON with a line for each task, link and calendar."""
    def line(item):
        return json.dumps(item, ensure_ascii=False)

    lists = [f'"{key}": [\n' + ",\n".join(line(item) for item in plan[key]) + "\n]" for key in ("calendars", "tasks", "links")]
    name = [f'"name": {line(plan["name"])}'] if "name" in plan else []
    return "{" + ",\n".join(name + lists) + "}\n"


def write_fixtures(folder, seed):
    folder.mkdir(parents=True, exist_ok=True)
    for k in range(3):
        plan = generate(random.Random(f"{seed} small {k}"), n_tasks=5 + 2 * k, n_shifts=1)
        for form, (suffix, _) in FORMATS.items():
            path = folder / f"plan-{k}.{suffix}"
            write(plan, form, path)
            if form != "xer":
                path.write_text(re.sub(r"\n +", "\n", path.read_text(encoding="utf-8")), encoding="utf-8")
            (folder / f"{path.name}.expected.json").write_text(text_of(dump(path, form)), encoding="utf-8")


if __name__ == "__main__":
    sys.exit(main())
