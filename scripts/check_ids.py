#!/usr/bin/env python3
"""Compares what groundplan says of IFC files and IDS files with ifctester, element by element.

usage: check_ids.py --reporter PROGRAM [--self-test] [--cases FOLDER] [--buildings FOLDER] [--ids FILE]

PROGRAM is the example `ids_report` of the crate `ids`. --cases is a folder of pairs of .ids and .ifc whose names begin with their
answer, as buildingSMART's test cases do; --buildings a folder of IFC files of at most 8 MB, which are checked by the IDS file that
--ids names. Needs ifctester, ifcopenshell. Exit codes: 0 all agree, 1 one does not, 2 something cannot be read.

Compared are, by specification: the outcome, how many elements it applies to, and which fail, by GlobalId or id. Where the two
differ and the text of IDS 1.0 says which is right, it is listed below with its reason. ifctester also validates each IDS file by the XML
schema of IDS.
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

# Test cases to which ifctester 0.9.0 gives another answer than their names, or beginnings of their names.
CASES_OF_THEIRS = {
    "tolerance/": "ifctester has a relative tolerance alone, and none for bounds",
    "attribute/pass-an_optional_attribute_passes_if_null": "ifctester fails an optional attribute without a value",
    "ids/pass-specification_optionality_and_facet_optionality_can_be_combined": "as the one before",
}

# Specifications on which ifctester 0.9.0 differs on buildings, and why.
BUILDINGS = {
    "doors.operation.door": "ifctester fails an optional attribute without a value",
    "storeys.description": "an empty attribute that is prohibited passes there; the user manual: not even empty",
    "doors.storey": "parts of what is contained pass there; the user manual: only the relation that is named",
}

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
        document = ifctester.ids.open(str(ids), validate=True)
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
        both = isinstance(mine, dict) and isinstance(other, dict)
        return [] if both else [f"one refuses: {mine if isinstance(mine, dict) else other}"]
    found = []
    for k, (a, b) in enumerate(zip(mine, other, strict=True)):
        for part in ("passed", "n"):
            if a[part] != b[part]:
                found.append(f"specification {k}: {part} is {a[part]} here and {b[part]} there")
        if a["failed"] != b["failed"]:
            only = [sorted(a["failed"] - b["failed"])[:3], sorted(b["failed"] - a["failed"])[:3]]
            found.append(f"specification {k}: failing only here {only[0]}, only there {only[1]}")
    return found


def check_cases(program, folder):
    """Faults of groundplan's answers to cases, and of ours against theirs."""
    pairs = [(path, path.with_suffix(".ifc")) for path in sorted(folder.glob("*/*.ids"))]
    if not pairs:
        sys.exit(f"{folder} has no pairs of .ids and .ifc")
    faults, agree, other = [], 0, {}
    for (ids, ifc), report in zip(pairs, ours(program, pairs), strict=True):
        name = f"{ids.parent.name}/{ids.stem}"
        expected = ids.stem.split("-", 1)[0]
        mine = judged(report)
        answer = "invalid" if isinstance(mine, dict) else "pass" if all(s["passed"] for s in mine) else "fail"
        if answer != expected:
            faults.append(f"{name}: groundplan says {answer}")
        # What is invalid is refused here, and checked there.
        if expected == "invalid":
            continue
        other[name] = (mine, theirs(ids, ifc))
        found = differences(*other[name])
        known = next((reason for begin, reason in CASES_OF_THEIRS.items() if name.startswith(begin)), None)
        if found and known is None:
            faults += [f"{name}: {difference}" for difference in found]
        elif not found and known is not None and name in CASES_OF_THEIRS:
            faults.append(f"{name}: it is listed as different, and agrees")
        agree += not found
    print(f"{len(pairs)} cases: {len(other)} compared with ifctester, {agree} the same, {len(other) - agree} known to differ")
    return faults, other


def check_buildings(program, folder, ids):
    paths = [path for path in sorted(folder.glob("*.ifc")) if path.stat().st_size <= BYTES_MAX]
    faults, n, elements, known = [], 0, 0, 0
    for path, report in zip(paths, ours(program, [(ids, path) for path in paths]), strict=True):
        mine = judged(report)
        if isinstance(mine, dict):
            print(f"{path.name}: not read here: {mine['error']}")
            continue
        other = theirs(ids, path)
        if isinstance(other, dict):
            print(f"{path.name}: not read there: {other['error']}")
            continue
        names = [specification["identifier"] for specification in report["specifications"]]
        for name, a, b in zip(names, mine, other, strict=True):
            found = differences([a], [b])
            if found and name in BUILDINGS:
                known += 1
            else:
                faults += [f"{path.name}, {name}: {difference}" for difference in found]
            n += 1
            elements += a["n"]
    print(f"{len(paths)} buildings: {n} specifications on {elements} elements compared with ifctester, {known} known to differ")
    return faults


def self_test(other):
    """Damages that must be noticed; `other` are judgements of cases by both."""
    name, (mine, theirs_) = next((n, pair) for n, pair in other.items() if pair[0][0]["failed"] and not differences(*pair))

    def flip(s):
        s["passed"] = not s["passed"]

    damages = {
        "another outcome": flip,
        "an element more": lambda s: s.update(n=s["n"] + 1),
        "a failing element that is not told": lambda s: s["failed"].pop(),
        "a failing element of another GlobalId": lambda s: s.update(failed={key + "x" for key in s["failed"]}),
    }
    for what, damage in damages.items():
        damaged = copy.deepcopy(mine)
        damage(damaged[0])
        if not differences(damaged, theirs_):
            sys.exit(f"self-test: {what} in {name} was not noticed")
    if not differences({"error": "x"}, theirs_):
        sys.exit("self-test: a file that only one of both reads was not noticed")
    print(f"self-test: {len(damages) + 1} damages were noticed")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--reporter", required=True)
    parser.add_argument("--self-test", action="store_true")
    parser.add_argument("--cases", type=pathlib.Path)
    parser.add_argument("--buildings", type=pathlib.Path)
    parser.add_argument("--ids", type=pathlib.Path)
    options = parser.parse_args()
    faults = []
    if options.cases:
        faults, other = check_cases(options.reporter, options.cases)
        if options.self_test:
            self_test(other)
    if options.buildings:
        faults += check_buildings(options.reporter, options.buildings, options.ids)
    for fault in faults:
        print(fault)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
