#!/usr/bin/env python3
"""Writes the schedule of the demo building as planners' tools write it: the tasks of scripts/demo_model.py with all dates.

    python3 scripts/demo_schedule.py FILE...

The suffix says the form: .xer (Primavera P6), .pmxml (P6 XML), .xml (MS Project) or .csv. config/demo/demo-schedule.xer is the first of
these, tests/fixtures has the others. Activity numbers are those of the property `4D_Number` that the model's elements have; MS Project
has them in the custom field of this name.
P6 counts all lags in one calendar: one that counts day and night is written as the working time that passes meanwhile.
The same script gives the same bytes.
"""
import argparse
import csv
import io
import pathlib
from datetime import date, datetime, timedelta
from xml.sax.saxutils import escape

from demo_model import HOLIDAY, PHASES, PROJECT_START, SEQUENCES, TASKS, WORKING_DAYS, WORKING_HOURS

DAY_HOURS = 8
CALENDAR = 'Working days'
WEEKDAYS = ['Sunday', 'Monday', 'Tuesday', 'Wednesday', 'Thursday', 'Friday', 'Saturday']
# In P6, in MS Project and in its tables.
KINDS = {'FINISH_START': ('FS', 'Finish to Start', 1), 'START_START': ('SS', 'Start to Start', 3),
         'FINISH_FINISH': ('FF', 'Finish to Finish', 0)}

# ------------------------------------------------------------------ working time and dates


def is_worked(day):
    return day.isoweekday() in WORKING_DAYS and day.isoformat() != HOLIDAY[1]


def periods(day):
    """Working periods of a day and those of the days after it."""
    while True:
        if is_worked(day):
            for hours in WORKING_HOURS:
                yield tuple(datetime.combine(day, datetime.strptime(hour, '%H:%M:%S').time()) for hour in hours)
        day += timedelta(days=1)


def after(at, working):
    """The time at which so much working time has passed; without any the next at which work goes on."""
    for begin, end in periods(at.date()):
        begin = max(begin, at)
        if begin < end and working <= end - begin:
            return begin + working
        working -= max(end - begin, timedelta())


def before(at, working):
    """The latest time from which so much working time passes until then."""
    begin = at
    while between(begin, at) < working:
        begin -= timedelta(hours=1)
    return begin


def between(begin, end):
    """Working time between two times."""
    passed = timedelta()
    for first, last in periods(begin.date()):
        if first >= end:
            return passed
        passed += max(min(last, end) - max(first, begin), timedelta())


def length(text):
    """Working time of a duration such as P5D."""
    return timedelta(hours=DAY_HOURS * int(text[1:-1])) if text else None


def bound(dates, link, duration):
    """The earliest start that a dependency allows."""
    predecessor, _, kind, lag, counted = link
    start, finish = dates[predecessor]
    at = start if kind.startswith('START') else finish
    if lag:
        at = at + 3 * length(lag) if counted == 'ELAPSEDTIME' else after(at, length(lag))
    return before(at, duration) if kind == 'FINISH_FINISH' else at


def task_dates():
    """Start and finish of every task: as the model has them, or as early as its predecessors allow."""
    dates = {}
    for number, task in TASKS.items():
        duration = length(task.duration)
        if task.start:
            start = datetime.fromisoformat(task.start)
        else:
            bounds = [bound(dates, link, duration) for link in SEQUENCES if link[1] == number]
            start = max([datetime.fromisoformat(PROJECT_START), *bounds])
            start = after(start, timedelta()) if duration else start
        finish = datetime.fromisoformat(task.finish) if task.finish else after(start, duration) if duration else start
        dates[number] = (start, finish)
    return dates


def working_lag(dates, predecessor, kind, lag, counted):
    """The lag in working time."""
    if not lag:
        return timedelta()
    if counted == 'WORKTIME':
        return length(lag)
    at = dates[predecessor][0 if kind.startswith('START') else 1]
    return between(at, at + 3 * length(lag))


def hours(working):
    return f'{working.total_seconds() / 3600:g}'


# ------------------------------------------------------------------ Primavera P6


def xer(dates):
    """Tables with tabs between cells."""
    ids = {key: str(n) for n, key in enumerate([*PHASES, *TASKS], 1000)}
    rows = ['ERMHDR\t20.12\t2024-01-15\tProject\tgroundplan\tgroundplan\tdbxDatabaseNoName\tProject Management\tEUR']

    def table(name, columns, cells):
        rows.extend([f'%T\t{name}', '%F\t' + '\t'.join(columns.split())])
        rows.extend('%R\t' + '\t'.join(map(str, row)) for row in cells)

    def text(at):
        return at.strftime('%Y-%m-%d %H:%M')

    start = datetime.fromisoformat(PROJECT_START)
    table('PROJECT', 'proj_id proj_short_name clndr_id plan_start_date last_recalc_date export_flag project_flag',
          [('1', 'DEMO', '1', text(start), text(start), 'Y', 'Y')])
    table('CALENDAR', 'clndr_id default_flag clndr_name proj_id clndr_type day_hr_cnt week_hr_cnt month_hr_cnt year_hr_cnt clndr_data',
          [('1', 'Y', CALENDAR, '', 'CA_Base', '8', '40', '172', '2000', calendar_data())])
    table('SCHEDOPTIONS', 'schedoptions_id proj_id sched_calendar_on_relationship_lag', [('1', '1', 'rcal_Successor')])
    nodes = [('1', '1', '', '0', 'Y', 'WS_Open', 'DEMO', 'Construction schedule')]
    nodes += [(ids[key], '1', '1', key, 'N', 'WS_Open', key, name) for key, (name, _) in PHASES.items()]
    table('PROJWBS', 'wbs_id proj_id parent_wbs_id seq_num proj_node_flag status_code wbs_short_name wbs_name', nodes)
    tasks = []
    for number, task in TASKS.items():
        begin, end = dates[number]
        working = hours(between(begin, end))
        kind = 'TT_FinMile' if begin == end else 'TT_Task'
        tasks.append((ids[number], '1', ids[number[0]], '1', 'CP_Drtn', kind, 'DT_FixedDrtn', 'TK_NotStart', number, task.name, working,
                      working, *[text(begin), text(end)] * 2))
    table('TASK', 'task_id proj_id wbs_id clndr_id complete_pct_type task_type duration_type status_code task_code task_name '
          'remain_drtn_hr_cnt target_drtn_hr_cnt early_start_date early_end_date target_start_date target_end_date', tasks)
    table('TASKPRED', 'task_pred_id task_id pred_task_id proj_id pred_proj_id pred_type lag_hr_cnt',
          [(n, ids[after], ids[before], '1', '1', f'PR_{KINDS[kind][0]}', hours(working_lag(dates, before, kind, lag, counted)))
           for n, (before, after, kind, lag, counted) in enumerate(SEQUENCES, 1)])
    return '\r\n'.join([*rows, '%E', ''])


def calendar_data():
    """The week from Sunday on and the holiday, as records in parentheses; days count from 1899-12-30."""
    worked = ''.join(f'(0||{n}(s|{begin[:5]}|f|{end[:5]})())' for n, (begin, end) in enumerate(WORKING_HOURS))
    week = ''.join(f"(0||{n}()({worked if (n - 1) in WORKING_DAYS else ''}))" for n in range(1, 8))
    holiday = (date.fromisoformat(HOLIDAY[1]) - date(1899, 12, 30)).days
    return f'(0||CalendarData()((0||DaysOfWeek()({week}))(0||VIEW(ShowTotal|N)())(0||Exceptions()((0||0(d|{holiday})())))))'


def element(name, *content, **cells):
    """An XML element on a line: the cells, then the content."""
    inner = ''.join(f'<{key}>{escape(str(value))}</{key}>' for key, value in cells.items())
    return f"<{name}>{inner}{''.join(content)}</{name}>\n"


def pmxml(dates):
    """Business objects of P6; the finish of a working period is its last minute."""
    ids = {key: n for n, key in enumerate([*PHASES, *TASKS], 1000)}
    worked = [element('WorkTime', Start=begin, Finish=f'{int(end[:2]) - 1:02}:59:00') for begin, end in WORKING_HOURS]
    week = [element('StandardWorkHours', *(worked if n in WORKING_DAYS else []), DayOfWeek=day) for n, day in enumerate(WEEKDAYS)]
    calendar = element('Calendar', element('StandardWorkWeek', *week),
                       element('HolidayOrExceptions', element('HolidayOrException', Date=f'{HOLIDAY[1]}T00:00:00')),
                       HoursPerDay=8, HoursPerMonth=172, HoursPerWeek=40, HoursPerYear=2000, IsDefault=1, Name=CALENDAR, ObjectId=1,
                       Type='Global')
    project = [element('WBS', Code=key, Name=name, ObjectId=ids[key], ProjectObjectId=1, SequenceNumber=key)
               for key, (name, _) in PHASES.items()]
    for number, task in TASKS.items():
        begin, end = dates[number]
        start, finish, working = begin.isoformat(), end.isoformat(), hours(between(begin, end))
        project.append(element('Activity', AtCompletionDuration=working, CalendarObjectId=1, DurationType='Fixed Duration/Dates', Id=number, Name=task.name,
                               ObjectId=ids[number], PercentCompleteType='Duration', PlannedDuration=working, PlannedFinishDate=finish,
                               PlannedStartDate=start, ProjectObjectId=1, RemainingDuration=working, RemainingEarlyFinishDate=finish,
                               RemainingEarlyStartDate=start, StartDate=start, FinishDate=finish, Status='Not Started',
                               Type='Finish Milestone' if begin == end else 'Task Dependent', WBSObjectId=ids[number[0]]))
    for n, (before, after, kind, lag, counted) in enumerate(SEQUENCES, 1):
        project.append(element('Relationship', Lag=hours(working_lag(dates, before, kind, lag, counted)), ObjectId=n,
                               PredecessorActivityObjectId=ids[before], PredecessorProjectObjectId=1,
                               SuccessorActivityObjectId=ids[after], SuccessorProjectObjectId=1, Type=KINDS[kind][1]))
    project.append(element('ScheduleOptions', ObjectId=1, ProjectObjectId=1, RelationshipLagCalendar='Successor Activity Calendar'))
    root = 'http://xmlns.oracle.com/Primavera/P6/V20.12/API/BusinessObjects'
    inner = element('Project', *project, ActivityDefaultCalendarObjectId=1, DataDate=PROJECT_START, Id='DEMO',
                    Name='Construction schedule', ObjectId=1, PlannedStartDate=PROJECT_START)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n<APIBusinessObjects xmlns="{root}">\n{calendar}{inner}</APIBusinessObjects>\n'


# ------------------------------------------------------------------ MS Project and spreadsheets

NUMBER_FIELD = 188743731              # Text1


def mspdi(dates):
    """MS Project XML: rows in the order of the outline, lags in tenths of minutes."""
    rows = [key for phase in PHASES for key in (phase, *(number for number in TASKS if number[0] == phase))]
    uids = {key: n for n, key in enumerate(rows, 1)}
    worked = element('WorkingTimes', *(element('WorkingTime', FromTime=begin, ToTime=end) for begin, end in WORKING_HOURS))
    days = [element('WeekDay', worked if n in WORKING_DAYS else '', DayType=n + 1, DayWorking=int(n in WORKING_DAYS)) for n in range(7)]
    span = element('TimePeriod', FromDate=f'{HOLIDAY[1]}T00:00:00', ToDate=f'{HOLIDAY[1]}T23:59:00')
    holiday = element('Exception', span, EnteredByOccurrences=0, Occurrences=1, Name=HOLIDAY[0], Type=1, DayWorking=0)
    calendar = element('Calendar', element('WeekDays', *days), element('Exceptions', holiday), UID=1, Name=CALENDAR, IsBaseCalendar=1,
                       BaseCalendarUID=-1)
    tasks = []
    for key in rows:
        is_phase = key in PHASES
        name = PHASES[key][0] if is_phase else TASKS[key].name
        own = [dates[number] for number in TASKS if number.startswith(key)]
        begin, end = min(start for start, _ in own), max(finish for _, finish in own)
        links = [element('PredecessorLink', PredecessorUID=uids[before], Type=KINDS[kind][2], CrossProject=0,
                         LinkLag=int((3 if counted == 'ELAPSEDTIME' else 1) * length(lag).total_seconds() / 6) if lag else 0,
                         LagFormat=8 if counted == 'ELAPSEDTIME' else 7)
                 for before, after, kind, lag, counted in SEQUENCES if after == key]
        number = '' if is_phase else element('ExtendedAttribute', FieldID=NUMBER_FIELD, Value=key)
        tasks.append(element('Task', *links, number, UID=uids[key], ID=uids[key], Name=name, Type=1, OutlineNumber=key,
                             OutlineLevel=key.count('.') + 1, WBS=key, Start=begin.isoformat(), Finish=end.isoformat(),
                             Duration=f'PT{hours(between(begin, end))}H0M0S', DurationFormat=7, Milestone=int(begin == end),
                             Summary=int(is_phase), CalendarUID=-1))
    field = element('ExtendedAttributes', element('ExtendedAttribute', FieldID=NUMBER_FIELD, FieldName='Text1', Alias='4D_Number'))
    inner = element('Project', field, element('Calendars', calendar), element('Tasks', *tasks), SaveVersion=14, Name='demo-schedule.xml',
                    Title='Construction schedule', StartDate=PROJECT_START, CalendarUID=1, MinutesPerDay=480, MinutesPerWeek=2400)
    inner = inner.replace('<Project>', '<Project xmlns="http://schemas.microsoft.com/project">\n', 1)
    return f'<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n{inner}'


def table(dates):
    """A table of a spreadsheet."""
    out = io.StringIO()
    writer = csv.writer(out, delimiter=';', lineterminator='\r\n')
    writer.writerow(['Activity ID', 'WBS', 'Activity Name', 'Start', 'Finish', 'Duration', 'Predecessors'])
    for phase, (name, _) in PHASES.items():
        writer.writerow([phase, phase, name, '', '', '', ''])
        for number, task in TASKS.items():
            if number[0] != phase:
                continue
            begin, end = dates[number]
            links = [f'{before}{KINDS[kind][0]}' + (f"+{lag[1:-1]}{'ed' if counted == 'ELAPSEDTIME' else 'd'}" if lag else '')
                     for before, after, kind, lag, counted in SEQUENCES if after == number]
            days = f'{between(begin, end) / timedelta(hours=DAY_HOURS):g}d'
            writer.writerow([number, number, task.name, f'{begin:%d.%m.%Y %H:%M}', f'{end:%d.%m.%Y %H:%M}', days, ', '.join(links)])
    return out.getvalue()


FORMS = {'.xer': xer, '.pmxml': pmxml, '.xml': mspdi, '.csv': table}


def main():
    parser = argparse.ArgumentParser(description='Writes the schedule of the demo building as XER, P6 XML, MS Project XML or CSV.')
    parser.add_argument('output', nargs='+', type=pathlib.Path, metavar='FILE', help='.xer, .pmxml, .xml or .csv')
    options = parser.parse_args()
    for path in options.output:
        if path.suffix not in FORMS:
            parser.error(f'{path}: the suffix is none of {", ".join(FORMS)}')
        path.write_text(FORMS[path.suffix](task_dates()), encoding='utf-8', newline='')


if __name__ == '__main__':
    main()
