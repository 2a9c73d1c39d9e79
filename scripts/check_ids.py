#!/usr/bin/env python3
"""Compares what groundplan says of IFC files and IDS files with ifctester, element by element.

usage: check_ids.py --reporter PROGRAM [--self-test] [--cases FOLDER] [--buildings FOLDER] [--ids FILE]

PROGRAM is the example `ids_report` of the crate `ids`. --cases is a folder of pairs of .ids and .ifc whose names begin with their
answer, as buildingSMART's test cases do; --buildings a folder of IFC files of at most 8 MB, which are checked by the IDS file that
--ids names. Needs ifctester, ifcopenshell. Exit codes: 0 all agree, 1 one does not, 2 something cannot be read.

Compared are, by specification: the outcome, how many elements it applies to, and which fail, by GlobalId or id. Where the two differ
and the text of IDS 1.0 says which is right, the case is listed below with its reason; one that agrees again is reported, too.
"""
import argparse
import copy
import json
import pathlib
import subprocess
import sys

import ifcopenshell
import ifctester.ids
import ifctester.facet

# Test cases on which ifctester gives another answer than the name of the case, with what is different.
CASES_OF_THEIRS = {}

# Differences on buildings: part of the name of a requirement, and why groundplan is right.
BUILDINGS = {}

BYTES_MAX = 8_000_000


def key_of(element):
    return element.GlobalId if element.is_a("IfcRoot") else f"#{element.id()}"


def judge(specification):
    """Outcome, number of applicable elements, and failing elements, as ifctester has them."""
    failed = {key_of(f["element"]) for facet in specification.requirements for f in facet.failures}
    if specification.maxOccurs == 0:
        failed = {key_of(element) for element in specification.applicable_entities}
    return {"passed": bool(specification.status), "n": len(specification.applicable_entities), "failed": failed}


def theirs(ids, ifc):
    try:
        document = ifctester.ids.open(str(ids))
    except Exception as error:
        return {"error": str(error)}
    try:
        document.validate(ifc if isinstance(ifc, ifcopenshell.file) else ifcopenshell.open(str(ifc)))
    except Exception as error:
        return {"error": f"{type(error).__name__}: {error}"}
    return [judge(specification) for specification in document.specifications]


def ours(program, pairs):
    arguments = [str(path) for pair in pairs for path in pair]
    run = subprocess.run([program, *arguments], capture_output=True, text=True, check=True)
    reports = [json.loads(line) for line in run.stdout.splitlines()]
    assert len(reports) == len(pairs), "a report for each pair"
    return reports


def judged(report):
    """A report of ours as `judge` makes them."""
    if "error" in report:
        return report
    key = lambda element: element["global_id"] or f"#{element['id']}"
    found = []
    for specification in report["specifications"]:
        lists = [specification["prohibited"], *(r["failed"] for r in specification["requirements"])]
        failed = {key(element) for elements in lists for element in elements}
        found.append({"passed": specification["outcome"] == "passed", "n": specification["n_applicable"], "failed": failed})
    return found


def differences(mine, other):
    """What differs between two lists of judgements, as sentences."""
    if isinstance(mine, dict) or isinstance(other, dict):
        return [] if isinstance(mine, dict) and isinstance(other, dict) else [f"one refuses: {mine if isinstance(mine, dict) else other}"]
    found = []
    for k, (a, b) in enumerate(zip(mine, other, strict=True)):
        for part in ("passed", "n"):
            if a[part] != b[part]:
                found.append(f"specification {k}: {part} is {a[part]} here and {b[part]} there")
        if a["failed"] != b["failed"]:
            only = [sorted(a["failed"] - b["failed"])[:3], sorted(b["failed"] - a["failed"])[:3]]
            found.append(f"specification {k}: failing only here {only[0]}, only there {only[1]}")
    return found
