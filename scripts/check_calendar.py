#!/usr/bin/env python3
"""Reads the calendar that `groundplan tasks --ics` writes with the package icalendar, and compares it with the tasks in JSON.

    python3 scripts/check_calendar.py --groundplan PROGRAM

Exit codes: 0 they agree, 1 they do not, 2 a file cannot be written.
"""

import argparse
import datetime
import json
import pathlib
import subprocess
import sys
import tempfile
import zoneinfo

import icalendar

ROOT = pathlib.Path(__file__).resolve().parent.parent
SITE = [ROOT / "config/demo/demo.ifc", "--schedule-file", ROOT / "config/demo/demo-schedule.xer"]
# Days, a milestone, names that a calendar must escape and a line that must be folded within a character.
TABLE = 'ID,Name,Start,Finish\nW;1,"Wand, ""Süd""\\West; ' + "ÄÖÜ" * 40 + '",2024-07-01,2024-07-03\nM,Übergabe,2024-07-04T12:00:00,2024-07-04T12:00:00\n'


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--groundplan", type=pathlib.Path, required=True)
    program = arguments.parse_args().groundplan
    n_wrong = 0
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        table, rules = folder / "plan.csv", folder / "rules.toml"
        table.write_text(TABLE, encoding="utf-8")
        rules.write_text('site_zone = "Europe/Amsterdam"\n', encoding="utf-8")
        for zone in (None, "Europe/Amsterdam"):
            for window in ([], ["--from", "2024-04-15", "--weeks", "3"]):
                n_wrong += check(program, folder, [table, *(["--schedule", rules] if zone else []), *window], zone)
    return 1 if n_wrong else 0


def check(program, folder, more, zone):
    ics = folder / "tasks.ics"
    run = subprocess.run([program, "tasks", *SITE, "--schedule-file", *more, "--json", "--ics", ics], capture_output=True, encoding="utf-8", check=False)
    if run.returncode != 0:
        print(run.stderr, file=sys.stderr)
        sys.exit(2)
    tasks = {f"{task['global_id']}@tasks.groundplan": task for task in json.loads(run.stdout)["tasks"]
             if task["start"] and not task["is_summary"]}
    calendar = icalendar.Calendar.from_ical(ics.read_bytes())
    events = {str(event["UID"]): event for event in calendar.walk("VEVENT")}
    wrong = [f"{uid}: only on one side" for uid in set(tasks) ^ set(events)]
    for uid in set(tasks) & set(events):
        task, event = tasks[uid], events[uid]
        wrong += [f"{uid}: {error}" for error in event.errors]
        wrong += [f"{uid}: {key} {value(event, key, zone)}, not {expected}" for key, expected in expected_of(task).items()
                  if value(event, key, zone) != expected]
    print(f"{'FAIL' if wrong else 'ok  '} {len(events)} events in {zone or 'local time'}, {' '.join(map(str, more[-4:])) if '--from' in more else 'all'}")
    print("".join(f"     {line}\n" for line in wrong[:20]), end="")
    return len(wrong)


def expected_of(task):
    start, finish = (datetime.datetime.fromisoformat(task[key]) for key in ("start", "finish"))
    words = [word for word in (task["identification"], task["name"]) if word]
    return {"DTSTART": start, "DTEND": None if start == finish else finish, "SUMMARY": " ".join(words) or task["global_id"]}


def value(event, key, zone):
    if key not in event:
        return None
    if key == "SUMMARY":
        return str(event[key])
    at = event[key].dt
    if not isinstance(at, datetime.datetime):
        return datetime.datetime.combine(at, datetime.time())
    if zone and at.tzinfo is None or not zone and at.tzinfo is not None:
        return f"{at} in no zone that is expected"
    return at.astimezone(zoneinfo.ZoneInfo(zone)).replace(tzinfo=None) if zone else at


if __name__ == "__main__":
    sys.exit(main())
