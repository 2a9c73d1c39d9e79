#!/usr/bin/env python3
"""Compares what MPXJ reads from a `progress.xml` of groundplan with what is expected of it.

    python3 scripts/check_progress.py [--file common/export/tests/golden/progress.xml]

Needs what check_schedule_files.py needs. What is expected stands beside the file, in `progress.mpxj.json`: by the UID of each task its
per cent complete, its actual start and its actual finish. The test of the crate that writes the file holds it against the same.
Exit codes: 0 they agree, 1 they differ, 2 there is no MPXJ.
"""

import argparse
import json
import pathlib
import sys

from check_schedule_files import start_java

GOLDEN = pathlib.Path(__file__).resolve().parent.parent / "common/export/tests/golden/progress.xml"


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--file", type=pathlib.Path, default=GOLDEN)
    path = arguments.parse_args().file
    start_java()
    read = progress_of(path)
    expected = json.loads(path.with_suffix(".mpxj.json").read_text(encoding="utf-8"))
    print(f"{'ok  ' if read == expected else 'FAIL'} {path.name}: MPXJ reads progress of {len(read)} tasks")
    if read != expected:
        print(f"     expected {json.dumps(expected)}\n     MPXJ     {json.dumps(read)}")
    return 0 if read == expected else 1


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
