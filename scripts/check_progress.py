#!/usr/bin/env python3
"""Compares what MPXJ reads from a `progress.xml` of groundplan with what is expected of it, and planners' files with progress.

    python3 scripts/check_progress.py [--file common/export/tests/golden/progress.xml] [--groundplan PROGRAM]

Needs what check_schedule_files.py needs. What is expected stands beside the file, in `progress.mpxj.json`: by the UID of each task its
per cent complete, its actual start and its actual finish. The test of the crate that writes the file holds it against the same.

With PROGRAM the demo building is compared with a robot's map, with its schedule as XER and as P6 XML. MPXJ reads the planner's file
before and after: tasks have the progress of progress.csv, all else of them is as it was, and damages of the new file are noticed.
Exit codes: 0 they agree, 1 they differ, 2 there is no MPXJ.
"""

import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

from check_schedule_files import start_java

ROOT = pathlib.Path(__file__).resolve().parent.parent
GOLDEN = ROOT / "common/export/tests/golden/progress.xml"


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--file", type=pathlib.Path, default=GOLDEN)
    arguments.add_argument("--groundplan", type=pathlib.Path)
    options = arguments.parse_args()
    path = options.file
    start_java()
    read = progress_of(path)
    expected = json.loads(path.with_suffix(".mpxj.json").read_text(encoding="utf-8"))
    print(f"{'ok  ' if read == expected else 'FAIL'} {path.name}: MPXJ reads progress of {len(read)} tasks")
    if read != expected:
        print(f"     expected {json.dumps(expected)}\n     MPXJ     {json.dumps(read)}")
    is_well = read == expected
    if options.groundplan:
        for plan in [ROOT / "config/demo/demo-schedule.xer", ROOT / "tests/fixtures/demo-schedule.pmxml"]:
            is_well &= planners_file(options.groundplan, plan)
    return 0 if is_well else 1


def planners_file(groundplan, plan):
    """True if the planner's own file has the progress that was seen, and is else as it was."""
    model, robot = ROOT / "config/demo/demo.ifc", ROOT / "config/demo/robot-map.yaml"
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        command = [groundplan, "deviations", model, "--slam", robot, "--date", "2024-04-27", "--schedule-file", plan, "-o", out]
        subprocess.run(command, check=True, capture_output=True)
        new = out / f"progress-{plan.name}"
        with open(out / "progress.csv", newline="", encoding="utf-8") as table:
            rows = {row["task"]: row for row in csv.DictReader(table)}
        good = new.read_bytes()
        faults = faults_of(plan, new, rows)
        begun = sum(1 for row in rows.values() if row["actual_start"])
        print(f"{'FAIL' if faults else 'ok  '} {new.name}: MPXJ reads progress of {begun} tasks" + "".join(f"\n     {fault}" for fault in faults[:5]))
        is_well = not faults and begun > 0
        damages = [(b"TK_Active", b"TK_NotStart"), (b"TK_Complete", b"TK_Active"), (b"2024-03-18 08:00", b"2024-03-19 08:00")]
        if plan.suffix == ".pmxml":
            damages = [(b"<Status>In Progress", b"<Status>Not Started"), (b"<Status>Completed", b"<Status>In Progress"), (b"<PlannedStartDate>2024-03-18", b"<PlannedStartDate>2024-03-19")]
        for old, other in damages:
            if old not in good:
                print(f"ok   self-test: {new.name} has no {old.decode()}")
                continue
            new.write_bytes(good.replace(old, other))
            noticed = bool(faults_of(plan, new, rows))
            print(f"{'ok  ' if noticed else 'FAIL'} self-test: {old.decode()} made {other.decode()} is noticed")
            is_well &= noticed
    return is_well


def faults_of(plan, new, rows):
    """What is wrong with a planner's file with progress."""
    before, after = tasks_of(plan), tasks_of(new)
    if before.keys() != after.keys():
        return ["there are other tasks"]
    faults = []
    for code, (old, old_status) in before.items():
        found, status = after[code]
        if old != found:
            faults.append(f"{code}: {found}, not {old}")
        row = rows.get(code)
        minutes = lambda text: text[:16] or None
        if row is None or not row["actual_start"]:
            expected = old_status
        elif row["actual_finish"]:
            expected = ["COMPLETED", minutes(row["actual_start"]), minutes(row["actual_finish"]), 100.0]
        else:
            expected = ["IN_PROGRESS", minutes(row["actual_start"]), None, float(row["complete_percent"])]
        if status != expected:
            faults.append(f"{code}: {status}, not {expected}")
    return faults


def tasks_of(path):
    """By the code of each activity what progress does not change, and its progress."""
    from org.mpxj.reader import UniversalProjectReader

    def text(value):
        return None if value is None else str(value)

    def values(task):
        rest = [text(task.getName()), text(task.getUniqueID()), text(task.getPlannedStart()), text(task.getPlannedFinish()), text(task.getPlannedDuration())]
        percent = task.getPercentageComplete()
        progress = [text(task.getActivityStatus()), text(task.getActualStart()), text(task.getActualFinish()), round(float(str(percent)), 1) if percent is not None else None]
        return rest, progress

    project = UniversalProjectReader().read(str(path))
    return {str(task.getActivityID()): values(task) for task in project.getTasks() if task.getActivityID() is not None and not task.getSummary()}


def progress_of(path):
    from org.mpxj.reader import UniversalProjectReader

    def text(value):
        return None if value is None else str(value)

    def values(task):
        percent = task.getPercentageComplete()
        return [None if percent is None else float(str(percent)), text(task.getActualStart()), text(task.getActualFinish())]

    project = UniversalProjectReader().read(str(path))
    return {str(task.getUniqueID()): values(task) for task in project.getTasks()}


if __name__ == "__main__":
    sys.exit(main())
