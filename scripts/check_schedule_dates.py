#!/usr/bin/env python3
"""Compares the dates that the evaluation computes for schedule files with those that MPXJ's schedulers compute.

    python3 scripts/check_schedule_dates.py --program PROGRAM [--count 40] [--seed 1] [--keep DIR]

Needs what check_schedule_files.py needs. PROGRAM is the example `plan_dates` of the crate `schedule`. The seed decides plans without dates:
links of all four kinds with lags (positive, negative, elapsed, in per cent), calendars of tasks, of lags and of resources, elapsed
durations, constraints, expected finishes, tasks that are scheduled by hand, levels of effort and WBS summaries. Each is written by MPXJ as
MSPDI and scheduled by its MicrosoftScheduler, and written as XER and scheduled by its PrimaveraScheduler; start and finish of every task
are compared: two instants with no working time of the task between them are the same.
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
    "elapsed lags before finishes, also as part of an elapsed duration: both go on to the end of the lag, and MicrosoftScheduler to the next working time with the whole task",
    "lags before finishes of tasks with resources: MicrosoftScheduler moves the start by them, in another calendar than that of the work",
    "lags in working time before elapsed durations: MicrosoftScheduler is told of these by a calendar of 24 hours, in which it counts the lags, too",
    "lags from a start to a finish in XER that are not counted in the calendar of the successor: PrimaveraScheduler moves the start of the task by them, not its finish, which then is before what the relationship asks for",
    "resource dependent activities whose calendar does not hold that of the resource: PrimaveraScheduler starts them in the time that both share, and ends them by that of the resource",
    "expected finishes of activities that must finish on a day: PrimaveraScheduler lets them go before it, P6 enforces mandatory dates",
    "plans in which MPXJ gives the work of resources another length than its own: PrimaveraScheduler keeps the finish of a relationship where a constraint moves the start",
    "plans in which MPXJ starts a task before the project: nothing starts before it here",
    "plans in which MPXJ gives a task another length than its own",
    "plans in which MPXJ starts a task earlier because it must start no earlier than on a day: PrimaveraScheduler puts the time of the constraint in the place of a later one of the same day",
]

MICROSOFT = ["MUST_START_ON", "MUST_FINISH_ON", "START_NO_EARLIER_THAN", "START_NO_LATER_THAN", "FINISH_NO_EARLIER_THAN", "FINISH_NO_LATER_THAN"]
PRIMAVERA = [*MICROSOFT, "START_ON", "FINISH_ON"]

# Days after the first: Mondays to Fridays, without the holiday.
WORKDAYS = [day for day in range(40) if day % 7 < 5 and day != 9]


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
    if contradicts_itself(plan, expected, start, form):
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
    if is_elapsed(task):
        return int(Span.between(first, last).getSeconds())
    calendars = [assignment.getEffectiveCalendar() for assignment in task.getResourceAssignments()] or [task.getEffectiveCalendar()]
    return max(round(float(calendar.getWork(first, last, TimeUnit.MINUTES).getDuration()) * 60) for calendar in calendars)


def is_elapsed(task):
    return is_elapsed_unit(task.getDuration())


def is_elapsed_unit(length):
    return str(length.getUnits().name()).startswith("ELAPSED")


def is_same(plan, name, read, expected):
    return bool(read) and all(read) and all(work_s(task_of(plan, name), *pair) == 0 for pair in zip(read, expected))


def contradicts_itself(plan, expected, start, form):
    for name, (first, last) in expected.items():
        task = task_of(plan, name)
        if first < text(start) or last < first or has_length(task, last) and work_s(task, first, last) != length_s(task):
            return True
        if changes_work(task, first, last):
            return True
    return form == "xer" and starts_earlier_by_constraint(plan, expected, start)


def has_length(task, last):
    """Whether a task takes the time that it is given: not if others, resources or what is expected decide that."""
    kind = str(task.getActivityType().name())
    is_expected = task.getExpectedFinish() is not None and text(task.getExpectedFinish()) == last
    return kind not in ("LEVEL_OF_EFFORT", "WBS_SUMMARY") and not is_expected and not task.getResourceAssignments()


def changes_work(task, first, last):
    """Whether the last of a task's resources does not end with the task: it has less or more time than its work takes."""
    from java.time import LocalDateTime
    from org.mpxj import TimeUnit

    is_expected = task.getExpectedFinish() is not None and text(task.getExpectedFinish()) == last
    if is_expected or not task.getResourceAssignments():
        return False
    ends = LocalDateTime.parse(first), LocalDateTime.parse(last)
    left = []
    for assignment in task.getResourceAssignments():
        hours = float(assignment.getEffectiveCalendar().getWork(*ends, TimeUnit.HOURS).getDuration())
        left.append(hours - float(assignment.getWork().getDuration()) * 100 / float(assignment.getUnits().doubleValue()))
    return abs(min(left)) > 0.01


def starts_earlier_by_constraint(plan, expected, start):
    """Whether a task starts earlier with a constraint that lets it start later only than without. Takes the constraints away."""
    from org.mpxj import ConstraintType
    from org.mpxj.cpm import PrimaveraScheduler

    for name in expected:
        task = task_of(plan, name)
        if task.getConstraintType() == ConstraintType.START_NO_EARLIER_THAN and task.getPredecessors():
            task.setConstraintType(None)
            PrimaveraScheduler().schedule(plan, start)
            if text(task.getStart()) > expected[name][0]:
                return True
            task.setConstraintType(ConstraintType.START_NO_EARLIER_THAN)
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
    properties.setUseExpectedFinishDates(rng.random() < 0.7)
    resources = add_resources(plan, calendars)
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
        is_elapsed = not is_p6 and rng.random() < 0.25
        unit = TimeUnit.ELAPSED_DAYS if is_elapsed else rng.choice([TimeUnit.DAYS, TimeUnit.HOURS])
        set_length(task, Duration.getInstance(float(rng.randint(1, 9)), unit))
        task.setCalendar(rng.choice(calendars) if is_p6 or rng.random() < 0.4 and not is_elapsed else None)
        if is_p6 and task.getCalendar() is None:
            task.setCalendar(calendars[0])
        if not is_elapsed and rng.random() < 0.25:
            assign(rng, task, resources, is_p6)
        for before in befores:
            kind = rng.choice([RelationType.FINISH_START] * 3 + list(RelationType.values()))
            # MicrosoftScheduler moves starts by lags before finishes, see NOT_COMPARED.
            is_plain = is_p6 or not task.getResourceAssignments() and not is_elapsed_unit(tasks[before].getDuration())
            lag = a_lag(rng, properties.getRelationshipLagCalendar() if is_p6 else None, kind, is_elapsed, is_plain)
            task.addPredecessor(Relation.Builder().predecessorTask(tasks[before]).type(kind).lag(lag))
        if is_p6 and rng.random() < 0.15:
            task.setExpectedFinish(start.plusDays(rng.choice(WORKDAYS)).withHour(rng.choice([12, 17])))
        if not is_p6 and not is_elapsed and not task.getResourceAssignments() and rng.random() < 0.1:
            schedule_by_hand(task, start.plusDays(rng.choice(WORKDAYS)).withHour(rng.choice([8, 10])))
        if rng.random() < 0.25:
            kind = getattr(ConstraintType, rng.choice(PRIMAVERA if is_p6 else MICROSOFT))
            hour = 8 if "START" in str(kind.name()) else 17
            task.setConstraintType(kind)
            if kind == ConstraintType.MUST_FINISH_ON:
                task.setExpectedFinish(None)
            task.setConstraintDate(start.plusDays(rng.choice(WORKDAYS)).withHour(hour))
        tasks.append(task)
    if is_p6:
        add_spans(rng, parent, tasks, calendars[0])
    return plan, start


def set_length(task, length):
    from org.mpxj import Duration

    task.setDuration(length)
    task.setPlannedDuration(length)
    task.setRemainingDuration(length)
    task.setActualDuration(Duration.getInstance(0.0, length.getUnits()))


def schedule_by_hand(task, first):
    """Gives a task the dates that its planner typed in."""
    from org.mpxj import TaskMode

    task.setTaskMode(TaskMode.MANUALLY_SCHEDULED)
    task.setManualDuration(task.getDuration())
    first = task.getEffectiveCalendar().getNextWorkStart(first)
    task.setStart(first)
    task.setFinish(task.getEffectiveCalendar().getDate(first, task.getDuration()))


def add_resources(plan, calendars):
    """A resource for each calendar."""
    from org.mpxj import ResourceType

    resources = []
    for calendar in calendars:
        resource = plan.addResource()
        resource.setName(calendar.getName())
        resource.setResourceID(str(calendar.getName()))
        resource.setType(ResourceType.WORK)
        resource.setCalendar(calendar)
        resources.append(resource)
    return resources


def assign(rng, task, resources, is_p6):
    """Work of one or two resources; in P6 of those whose calendars lie within that of the activity, see NOT_COMPARED."""
    from org.mpxj import ActivityType, Duration, TaskType, TimeUnit

    of_task = next((k for k, resource in enumerate(resources) if resource.getCalendar() == task.getCalendar()), None)
    within = {None: [0, 1, 2], 0: [0], 1: [0, 1], 2: [2]}[of_task] if is_p6 else [0, 1, 2]
    if is_p6:
        task.setActivityType(ActivityType.RESOURCE_DEPENDENT)
    task.setType(TaskType.FIXED_UNITS)
    length = float(rng.randint(1, 40))
    set_length(task, Duration.getInstance(length, TimeUnit.HOURS))
    for k in rng.sample(within, min(len(within), rng.choice([1, 1, 2]))):
        units = rng.choice([50.0, 100.0, 200.0])
        work = Duration.getInstance(length * units / 100.0, TimeUnit.HOURS)
        assignment = task.addResourceAssignment(resources[k])
        assignment.setUnits(units)
        assignment.setRemainingUnits(units)
        assignment.setWork(work)
        assignment.setPlannedWork(work)
        assignment.setRemainingWork(work)
        assignment.setActualWork(Duration.getInstance(0.0, TimeUnit.HOURS))


def add_spans(rng, parent, tasks, calendar):
    """A WBS summary, and a level of effort from the start of a task to the end of another."""
    from org.mpxj import ActivityType, Duration, Relation, RelationType, TimeUnit

    def add(name, kind):
        task = parent.addTask()
        task.setName(name)
        task.setActivityID(name)
        task.setActivityType(kind)
        task.setCalendar(calendar)
        set_length(task, Duration.getInstance(8.0, TimeUnit.HOURS))
        return task

    if rng.random() < 0.5:
        add("TW", ActivityType.WBS_SUMMARY)
    if rng.random() < 0.5:
        effort = add("TE", ActivityType.LEVEL_OF_EFFORT)
        first, last = sorted(rng.sample(range(len(tasks)), 2))
        for task, kind in ((first, RelationType.START_START), (last, RelationType.FINISH_FINISH)):
            effort.addPredecessor(Relation.Builder().predecessorTask(tasks[task]).type(kind).lag(Duration.getInstance(0.0, TimeUnit.HOURS)))


def a_lag(rng, lag_calendar, kind, is_before_elapsed, is_plain):
    """A lag in hours; of MS Project, which has no calendar for all lags, also an elapsed one and one in per cent of the predecessor."""
    from org.mpxj import Duration, RelationshipLagCalendar, TimeUnit

    amount = rng.choice([0, 0, rng.randint(1, 30), -rng.randint(1, 12)])
    to_start = str(kind.name()) in ("FINISH_START", "START_START")
    if lag_calendar is not None:
        is_elapsed = lag_calendar == RelationshipLagCalendar.TWENTY_FOUR_HOUR
        is_finish = str(kind.name()) == "FINISH_FINISH" and not is_elapsed or lag_calendar == RelationshipLagCalendar.SUCCESSOR
        return Duration.getInstance(float(amount if to_start or is_finish else 0), TimeUnit.HOURS)
    if not to_start and not is_plain:
        return Duration.getInstance(0.0, TimeUnit.HOURS)
    if is_before_elapsed:
        return Duration.getInstance(float(amount if to_start else 0), TimeUnit.ELAPSED_HOURS)
    unit = rng.choice([TimeUnit.HOURS, TimeUnit.ELAPSED_HOURS, TimeUnit.PERCENT] if to_start else [TimeUnit.HOURS, TimeUnit.PERCENT])
    return Duration.getInstance(float(rng.choice([25, 50, 100, 150, -50]) if unit == TimeUnit.PERCENT else amount), unit)


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

    for task in plan.getTasks():
        if task.getDuration() is not None and is_elapsed(task):
            task.setCalendar(day_and_night(plan))
    (MicrosoftScheduler if form == "mspdi" else PrimaveraScheduler)().schedule(plan, start)
    leaves = [task for task in plan.getTasks() if not task.hasChildTasks() and str(task.getName()).startswith("T")]
    return {str(task.getName()): [text(task.getStart()), text(task.getFinish())] for task in leaves}


def day_and_night(plan):
    """A calendar for elapsed durations, which begin at once in MS Project, and in MicrosoftScheduler with the working time of the task."""
    from java.time import DayOfWeek, LocalTime
    from org.mpxj import LocalTimeRange

    known = next((calendar for calendar in plan.getCalendars() if str(calendar.getName()) == "Day and night"), None)
    if known is not None:
        return known
    calendar = plan.addCalendar()
    calendar.setName("Day and night")
    for day in DayOfWeek.values():
        calendar.setWorkingDay(day, True)
        calendar.addCalendarHours(day).add(LocalTimeRange(LocalTime.MIDNIGHT, LocalTime.MIDNIGHT))
    return calendar


def text(at):
    from java.time.format import DateTimeFormatter

    return None if at is None else str(at.format(DateTimeFormatter.ISO_LOCAL_DATE_TIME))


def about(plan, name):
    """What a task has that decides its dates."""
    task = task_of(plan, name)
    links = [f"{link.getPredecessorTask().getName()} {link.getType()} {link.getLag()}" for link in task.getPredecessors()]
    calendar = task.getCalendar().getName() if task.getCalendar() else None
    lags = plan.getProjectProperties().getRelationshipLagCalendar()
    work = [f"{a.getResource().getName()} {a.getUnits()} {a.getWork()}" for a in task.getResourceAssignments()]
    kind = f"{task.getActivityType()} {task.getTaskMode()} expected {task.getExpectedFinish()}, work {work}"
    return f"{task.getDuration()}, {calendar}, {task.getConstraintType()} {task.getConstraintDate()}, {kind}, lags in {lags}, behind {links}"


if __name__ == "__main__":
    sys.exit(main())
