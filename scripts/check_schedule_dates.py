#!/usr/bin/env python3
"""Compares the dates that the evaluation computes for schedule files with those that MPXJ's schedulers compute.

    python3 scripts/check_schedule_dates.py --program PROGRAM [--count 40] [--seed 1] [--keep DIR]

Needs what check_schedule_files.py needs. PROGRAM is the example `plan_dates` of the crate `schedule`. The seed decides plans without dates:
links of all four kinds with lags (positive, negative, elapsed), calendars of tasks and of lags, elapsed durations, constraints. Each is written by MPXJ as MSPDI and scheduled by its MicrosoftScheduler, and written as XER and scheduled by its
PrimaveraScheduler; start and finish of every task are compared: two instants with no working time of the task between them are the same.
Prints a line with the verdict for each plan. Exit codes: 0 all agree, 1 one does not, 2 there is no MPXJ, or a plan cannot be written.

What is not compared, and why, is in NOT_COMPARED.
"""

import argparse
import pathlib
import random
import subprocess
import sys
import tempfile

from check_schedule_files import start_java

NOT_COMPARED = [
    "constraints on days without work: MicrosoftScheduler starts tasks on them",
    "lags in per cent: MicrosoftScheduler leaves them out",
    "elapsed durations behind others: MicrosoftScheduler begins them in working time, MS Project at once",
    "elapsed lags before finishes: both go on to the end of the lag, and MicrosoftScheduler to the next working time with the whole task",
    "lags from a start to a finish in XER: PrimaveraScheduler ends some tasks before their lag",
    "plans in which MPXJ starts a task before the project: nothing starts before it here",
    "plans in which MPXJ gives a task another length than its own",
]

MICROSOFT = ["MUST_START_ON", "MUST_FINISH_ON", "START_NO_EARLIER_THAN", "START_NO_LATER_THAN", "FINISH_NO_EARLIER_THAN", "FINISH_NO_LATER_THAN"]
PRIMAVERA = [*MICROSOFT, "START_ON", "FINISH_ON"]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--program", type=pathlib.Path, required=True)
    arguments.add_argument("--count", type=int, default=40)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--keep", type=pathlib.Path, help="folder for the files, instead of a temporary one")
    options = arguments.parse_args()
    start_java()
    with tempfile.TemporaryDirectory() as folder:
        folder = options.keep or pathlib.Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        verdicts = [check(options, folder, k, form) for k in range(options.count) for form in ("mspdi", "xer")]
    compared = [verdict for verdict in verdicts if verdict is not None]
    print(f"{sum(compared)} of {len(compared)} plans have the dates of MPXJ, {len(verdicts) - len(compared)} are not compared")
    return 0 if compared and all(compared) else 1


def check(options, folder, k, form):
    rng = random.Random(f"{options.seed} {k} {form}")
    plan, start = generate(rng, form)
    path = folder / f"plan-{k:02}.{'xml' if form == 'mspdi' else 'xer'}"
    write(plan, form, path)
    expected = scheduled(plan, form, start)
    run = subprocess.run([options.program, path], capture_output=True, encoding="utf-8", check=False)
    if run.returncode != 0:
        print(f"FAIL {path.name}: {run.stderr.strip()}")
        return False
    if contradicts_itself(plan, expected, start):
        print(f"-    {path.name}: not compared, MPXJ contradicts the plan")
        return None
    read = {line.split("\t")[0]: line.split("\t")[1:3] for line in run.stdout.splitlines()}
    wrong = [f"     {name}: MPXJ {dates}, here {read.get(name)}; {about(plan, name)}\n" for name, dates in expected.items() if not is_same(plan, name, read.get(name), dates)]
    print(f"{'FAIL' if wrong else 'ok  '} {path.name}: {len(expected)} tasks, {len(wrong)} differences\n{''.join(wrong[:3])}", end="")
    return not wrong


def task_of(plan, name):
    return next(task for task in plan.getTasks() if str(task.getName()) == name)


def work_s(task, first, last):
    """Working time of a task between two instants."""
    from java.time import Duration as Span, LocalDateTime
    from org.mpxj import TimeUnit

    first, last = LocalDateTime.parse(first), LocalDateTime.parse(last)
    if last.isBefore(first):
        first, last = last, first
    if str(task.getDuration().getUnits().name()).startswith("ELAPSED"):
        return int(Span.between(first, last).getSeconds())
    return round(float(task.getEffectiveCalendar().getWork(first, last, TimeUnit.MINUTES).getDuration()) * 60)


def is_same(plan, name, read, expected):
    return bool(read) and all(read) and all(work_s(task_of(plan, name), *pair) == 0 for pair in zip(read, expected))


def contradicts_itself(plan, expected, start):
    for name, (first, last) in expected.items():
        task = task_of(plan, name)
        if first < text(start) or last < first or work_s(task, first, last) != length_s(task):
            return True
    return False


def length_s(task):
    unit = str(task.getDuration().getUnits().name())
    return round(float(task.getDuration().getDuration()) * {"DAYS": 8, "HOURS": 1, "ELAPSED_DAYS": 24}[unit] * 3600)


def generate(rng, form):
    """A plan without dates: tasks behind each other, each with what the product can have."""
    from java.time import LocalDateTime
    from org.mpxj import ActivityType, ConstraintType, Duration, ProjectFile, Relation, RelationshipLagCalendar, RelationType, TimeUnit

    is_p6 = form == "xer"
    plan = ProjectFile()
    start = LocalDateTime.of(2024, 3, 4, 8, 0)
    properties = plan.getProjectProperties()
    properties.setName("Dates")
    properties.setStartDate(start)
    properties.setPlannedStart(start)
    properties.setStatusDate(start)
    properties.setHonorConstraints(True)
    calendars = add_calendars(plan)
    if is_p6:
        kinds = [RelationshipLagCalendar.PREDECESSOR, RelationshipLagCalendar.SUCCESSOR, RelationshipLagCalendar.PROJECT_DEFAULT, RelationshipLagCalendar.TWENTY_FOUR_HOUR]
        properties.setRelationshipLagCalendar(rng.choice(kinds))
    tasks = []
    parent = plan.addTask() if is_p6 else plan
    if is_p6:
        parent.setName("Plan")
        parent.setSummary(True)
    for number in range(rng.randint(4, 12)):
        task = parent.addTask()
        task.setName(f"T{number}")
        task.setActivityID(f"T{number}")
        task.setActivityType(ActivityType.TASK_DEPENDENT)
        befores = sorted({rng.randrange(number) for _ in range(rng.choice([0, 1, 1, 2]))} if number else ())
        is_elapsed = not is_p6 and not befores and rng.random() < 0.4
        unit = TimeUnit.ELAPSED_DAYS if is_elapsed else rng.choice([TimeUnit.DAYS, TimeUnit.HOURS])
        length = Duration.getInstance(float(rng.randint(1, 9)), unit)
        task.setDuration(length)
        task.setPlannedDuration(length)
        task.setRemainingDuration(length)
        task.setActualDuration(Duration.getInstance(0.0, unit))
        task.setCalendar(rng.choice(calendars) if is_p6 or rng.random() < 0.4 else None)
        if is_p6 and task.getCalendar() is None:
            task.setCalendar(calendars[0])
        for before in befores:
            kind = rng.choice([RelationType.FINISH_START] * 3 + list(RelationType.values()))
            task.addPredecessor(Relation.Builder().predecessorTask(tasks[before]).type(kind).lag(a_lag(rng, properties.getRelationshipLagCalendar() if is_p6 else None, kind)))
        if rng.random() < 0.25:
            kind = getattr(ConstraintType, rng.choice(PRIMAVERA if is_p6 else MICROSOFT))
            hour = 8 if "START" in str(kind.name()) else 17
            # Mondays to Fridays, without the holiday.
            day = rng.choice([day for day in range(40) if day % 7 < 5 and day != 9])
            task.setConstraintType(kind)
            task.setConstraintDate(start.plusDays(day).withHour(hour))
        tasks.append(task)
    return plan, start


def a_lag(rng, lag_calendar, kind):
    """A lag in hours; of MS Project, which has no calendar for all lags, also an elapsed one."""
    from org.mpxj import Duration, RelationshipLagCalendar, TimeUnit

    amount = rng.choice([0, 0, rng.randint(1, 30), -rng.randint(1, 12)])
    to_start = str(kind.name()) in ("FINISH_START", "START_START")
    if lag_calendar is not None:
        is_elapsed = lag_calendar == RelationshipLagCalendar.TWENTY_FOUR_HOUR
        is_drawn = to_start or not is_elapsed and str(kind.name()) == "FINISH_FINISH"
        return Duration.getInstance(float(amount if is_drawn else 0), TimeUnit.HOURS)
    unit = rng.choice([TimeUnit.HOURS, TimeUnit.ELAPSED_HOURS] if to_start else [TimeUnit.HOURS])
    return Duration.getInstance(float(amount), unit)


def add_calendars(plan):
    """Five days, seven days, and two shifts with a holiday."""
    from java.time import DayOfWeek, LocalDate, LocalTime
    from org.mpxj import LocalTimeRange

    usual = plan.addDefaultBaseCalendar()
    usual.setName("Five days")
    plan.setDefaultCalendar(usual)
    calendars = [usual]
    for name, n_days, ranges in [("Seven days", 7, [(8, 12), (13, 17)]), ("Shifts", 5, [(6, 14), (15, 21)])]:
        calendar = plan.addCalendar()
        calendar.setName(name)
        for day in DayOfWeek.values():
            is_working = day.getValue() <= n_days
            calendar.setWorkingDay(day, is_working)
            hours = calendar.addCalendarHours(day)
            for first, last in ranges if is_working else []:
                hours.add(LocalTimeRange(LocalTime.of(first, 0), LocalTime.of(last, 0)))
        calendars.append(calendar)
    calendars[2].addCalendarException(LocalDate.of(2024, 3, 13))
    return calendars


def write(plan, form, path):
    from org.mpxj.mspdi import MSPDIWriter
    from org.mpxj.primavera import PrimaveraXERFileWriter

    (MSPDIWriter if form == "mspdi" else PrimaveraXERFileWriter)().write(plan, str(path))


def scheduled(plan, form, start):
    """Start and finish of each task that holds no others."""
    from org.mpxj.cpm import MicrosoftScheduler, PrimaveraScheduler

    (MicrosoftScheduler if form == "mspdi" else PrimaveraScheduler)().schedule(plan, start)
    leaves = [task for task in plan.getTasks() if not task.hasChildTasks() and str(task.getName()).startswith("T")]
    return {str(task.getName()): [text(task.getStart()), text(task.getFinish())] for task in leaves}


def text(at):
    from java.time.format import DateTimeFormatter

    return None if at is None else str(at.format(DateTimeFormatter.ISO_LOCAL_DATE_TIME))


def about(plan, name):
    """What a task has that decides its dates."""
    task = task_of(plan, name)
    links = [f"{link.getPredecessorTask().getName()} {link.getType()} {link.getLag()}" for link in task.getPredecessors()]
    calendar = task.getCalendar().getName() if task.getCalendar() else None
    lags = plan.getProjectProperties().getRelationshipLagCalendar()
    return f"{task.getDuration()}, {calendar}, {task.getConstraintType()} {task.getConstraintDate()}, lags in {lags}, behind {links}"


if __name__ == "__main__":
    sys.exit(main())
