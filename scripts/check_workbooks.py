#!/usr/bin/env python3
"""Compares what `common/schedule-files` reads from workbooks of other programs with what it reads from the same plan as CSV.

    python3 scripts/check_workbooks.py --reader PROGRAM [--count 30] [--seed 1] [--keep FOLDER]

Needs openpyxl and xlsxwriter; with `soffice` (LibreOffice) on the path its files are compared, too. PROGRAM is the example
`dump_plan` of the crate. Plans are random (the seed decides all of them): each is written as CSV and as workbooks with titles above the
headings, further sheets, dates as serial numbers of both systems or as texts, shares of 1 or of 100, formulas with the values that
were computed, merged headings and hidden rows. Look-aheads with crosses below days are compared with the CSV of their first and last
days. Prints a line for each file. Exit codes: 0 all agree, 1 one does not, 2 a file cannot be written.
"""

import argparse
import csv
import datetime
import json
import pathlib
import random
import shutil
import subprocess
import sys
import tempfile

HEADINGS = ["ID", "Name", "WBS", "Start", "Finish", "Duration", "% Complete", "Predecessors", "Area", "4D_Number"]
DATES = (3, 4)
PERCENT = 6
NAMES = ["Rohbau Süd", "Wände <EG> & Stürze", 'Tür "T30"', "Außenputz", "Decke; 1. OG", "Fenster, Läden", "Estrich", "Gerüst"]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--reader", type=pathlib.Path, required=True)
    arguments.add_argument("--count", type=int, default=30)
    arguments.add_argument("--seed", type=int, default=1)
    arguments.add_argument("--keep", type=pathlib.Path, help="folder for the files, instead of a temporary one")
    options = arguments.parse_args()
    try:
        import openpyxl  # noqa: F401
        import xlsxwriter  # noqa: F401
    except ImportError as error:
        print(f"workbooks cannot be written: {error}", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as folder:
        folder = options.keep or pathlib.Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        return compare_all(options, folder)


def compare_all(options, folder):
    writers = {"openpyxl": by_openpyxl, "xlsxwriter": by_xlsxwriter, "crosses": crosses_by_openpyxl}
    n_wrong = n_files = 0
    for k in range(options.count):
        rng = random.Random(f"{options.seed} {k}")
        plan = generate(rng, 3 + 2 * k)
        for name, writer in writers.items():
            path = folder / f"plan-{k:02}-{name}.xlsx"
            expected = path.with_suffix(".csv")
            write_csv(expected, writer(path, plan, rng))
            paths = [path] + libre_office(path, folder / "libreoffice")
            for path in paths:
                differences = compare(options.reader, expected, path)
                n_files += 1
                n_wrong += bool(differences)
                print(f"{'FAIL' if differences else 'ok  '} {path.parent.name}/{path.name}: {len(plan)} tasks")
                print("".join(f"     {line}\n" for line in differences[:20]), end="")
    print(f"{n_files - n_wrong} of {n_files} workbooks are read as their CSV")
    if not shutil.which("soffice"):
        print("\n** SKIPPED: workbooks of LibreOffice: there is no soffice")
    return 1 if n_wrong else 0


def compare(reader, expected, path):
    """Lines that say what differs."""
    read = []
    for file in (expected, path):
        run = subprocess.run([reader, file], capture_output=True, encoding="utf-8", check=False)
        if run.returncode != 0:
            return [f"{file.name}: {run.stderr.strip()}"]
        read.append(json.loads(run.stdout))
    a, b = read
    if a == b:
        return []
    lines = [f"{key}: CSV {a[key]}, workbook {b[key]}" for key in a if key != "tasks" and a[key] != b[key]]
    for one, other in zip(a["tasks"], b["tasks"], strict=False):
        lines += [f"{one['name']}/{key}: CSV {one[key]}, workbook {other[key]}" for key in one if one[key] != other[key]]
    return lines or [f"CSV has {len(a['tasks'])} tasks, workbook {len(b['tasks'])}"]


def generate(rng, n):
    """Rows with values of Python in the order of HEADINGS."""
    first = datetime.datetime(2024, rng.randint(1, 12), rng.randint(1, 28))
    rows = []
    for k in range(n):
        start = first + datetime.timedelta(days=rng.randint(0, 200))
        finish = start + datetime.timedelta(days=rng.randint(1, 60))
        if rng.random() < 0.5:
            start, finish = start.replace(hour=8), finish.replace(hour=17, minute=rng.choice([0, 30]), second=rng.choice([0, 1]))
        rows.append([
            k + 1, f"{rng.choice(NAMES)} {k + 1}", f"{1 + k // 5}.{k % 5}", start, finish,
            rng.choice([None, "5 days", "2 w", "1,5 Tage", rng.randint(1, 30)]), rng.randint(0, 100) / 100,
            f"{rng.randint(1, k)}FS+{rng.randint(1, 5)}d" if k and rng.random() < 0.6 else None,
            rng.choice(["North", "South", None]), f"W-{rng.randint(1, 99):03}" if rng.random() < 0.8 else None,
        ])
    return rows


def write_csv(path, rows):
    with open(path, "w", encoding="utf-8", newline="") as file:
        csv.writer(file).writerows(rows)


def as_text(k, value):
    if value is None:
        return ""
    if k in DATES:
        return value.date().isoformat() if value.time() == datetime.time() else value.isoformat()
    return f"{round(value * 100)}%" if k == PERCENT else str(value)


def text_rows(plan):
    return [HEADINGS] + [[as_text(k, value) for k, value in enumerate(row)] for row in plan]


def by_openpyxl(path, plan, rng):
    import openpyxl

    book = openpyxl.Workbook()
    if rng.random() < 0.5:
        book.epoch = openpyxl.utils.datetime.CALENDAR_MAC_1904
    if rng.random() < 0.5:
        book.active.title = "Legend"
        book.active.append(["Colour", "Trade"])
        sheet = book.create_sheet("Plan", rng.randint(0, 1))
    else:
        sheet = book.active
    first = rng.randint(1, 6)
    if first > 1:
        sheet.cell(1, 1, "Terminplan, Stand")
        sheet.cell(1, 4, datetime.datetime(2024, 1, 2))
        sheet.merge_cells("A1:C1")
    column = rng.randint(1, 3)
    dates_are_texts, is_of_100 = rng.random() < 0.3, rng.random() < 0.3
    for k, heading in enumerate(HEADINGS):
        sheet.cell(first, column + k, heading)
    for n, row in enumerate(plan):
        for k, value in enumerate(row):
            if k in DATES and dates_are_texts:
                value = as_text(k, value) if rng.random() < 0.5 else value.strftime("%d.%m.%Y %H:%M:%S" if as_text(k, value)[10:] else "%d.%m.%Y")
            cell = sheet.cell(first + 1 + n + n // 7, column + k)
            if k == PERCENT:
                cell.value, cell.number_format = (f"{round(value * 100)} %", "General") if is_of_100 else (value, "0%")
            else:
                cell.value = value
        if rng.random() < 0.1:
            sheet.row_dimensions[first + 1 + n + n // 7].hidden = True
    if dates_are_texts:
        # One date decides the order of all.
        sheet.cell(first + 1, column + DATES[0]).value = plan[0][DATES[0]]
        plan[0][DATES[1]] = plan[0][DATES[1]].replace(day=28)
        sheet.cell(first + 1, column + DATES[1]).value = plan[0][DATES[1]].strftime("%d.%m.%Y %H:%M:%S")
        plan[0][DATES[0]] = min(plan[0][DATES[0]], plan[0][DATES[1]])
        sheet.cell(first + 1, column + DATES[0]).value = plan[0][DATES[0]]
        if plan[0][DATES[1]].time() == datetime.time():
            sheet.cell(first + 1, column + DATES[1]).value = plan[0][DATES[1]].strftime("%d.%m.%Y")
    book.save(path)
    return text_rows(plan)


def by_xlsxwriter(path, plan, rng):
    import xlsxwriter

    book = xlsxwriter.Workbook(str(path), {"date_1904": rng.random() < 0.5, "constant_memory": rng.random() < 0.5})
    sheet = book.add_worksheet("Plan")
    date = book.add_format({"num_format": rng.choice(["dd.mm.yyyy hh:mm:ss", "d mmm yy", "[$-407]ddd dd/mm/yy;@"])})
    percent, padded = book.add_format({"num_format": "0%"}), book.add_format({"num_format": '0" days"'})
    sheet.write_row(0, 0, ["Project", "Neubau"])
    groups = [""] * len(HEADINGS)
    for k, heading in enumerate(HEADINGS):
        sheet.write(3, k, {"Start": "Start", "Finish": "Finish"}.get(heading, heading))
    for n, row in enumerate(plan):
        for k, value in enumerate(row):
            at = (4 + n, k)
            if value is None:
                continue
            if k in DATES:
                sheet.write_datetime(*at, value, date)
            elif k == PERCENT and rng.random() < 0.5:
                sheet.write_formula(*at, f"={value}*1", percent, value)
            elif k == PERCENT:
                sheet.write_number(*at, value, percent)
            elif k == 5 and isinstance(value, int):
                sheet.write_number(*at, value, padded)
            elif k == 1 and rng.random() < 0.3:
                sheet.write_formula(*at, '="x"', None, value)
            elif k == 8 and rng.random() < 0.5:
                sheet.write_rich_string(*at, value[:2], book.add_format({"bold": True}), value[2:])
            else:
                sheet.write(*at, value)
    if rng.random() < 0.5:
        sheet.autofilter(3, 0, 3 + len(plan), len(groups) - 1)
        sheet.set_row(4, None, None, {"hidden": True})
    book.add_worksheet("Empty").hide()
    book.close()
    return text_rows(plan)


def crosses_by_openpyxl(path, plan, rng):
    import openpyxl

    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "Takt"
    weekly = rng.random() < 0.3
    monday = datetime.date(2024, 4, 15)
    days = [monday + datetime.timedelta(days=(7 if weekly else 1) * k) for k in range(12 if weekly else 28)]
    if not weekly and rng.random() < 0.5:
        days = [day for day in days if day.weekday() < 5]
    for k, day in enumerate(days):
        sheet.cell(3, 4 + k, day)
        sheet.cell(2, 4 + k, day.strftime("%a"))
    for k, heading in enumerate(["ID", "Task", "Crew"]):
        sheet.cell(rng.choice([3]), 1 + k, heading)
    rows = [["ID", "Task", "Crew", "Start", "Finish"]]
    for n, row in enumerate(plan):
        sheet.cell(4 + n, 1, row[0])
        sheet.cell(4 + n, 2, row[1])
        sheet.cell(4 + n, 3, row[8])
        first = rng.randrange(len(days))
        last = rng.randrange(first, len(days))
        for k in range(first, last + 1):
            if k in (first, last) or rng.random() < 0.9:
                sheet.cell(4 + n, 4 + k, rng.choice(["x", "X", 1, "■"]))
        finish = days[last] + datetime.timedelta(days=6 if weekly else 0)
        rows.append([row[0], row[1], row[8] or "", days[first].isoformat(), finish.isoformat()])
    book.save(path)
    return rows


def libre_office(path, folder):
    """The workbook as LibreOffice writes it again, if there is LibreOffice."""
    if not shutil.which("soffice"):
        return []
    folder.mkdir(exist_ok=True)
    run = subprocess.run(["soffice", "--headless", "--convert-to", "xlsx", "--outdir", folder, path], capture_output=True, check=False)
    again = folder / path.name
    if run.returncode != 0 or not again.is_file():
        print(f"LibreOffice cannot write {path.name}: {run.stderr.decode(errors='replace').strip()}", file=sys.stderr)
        sys.exit(2)
    return [again]


if __name__ == "__main__":
    sys.exit(main())
