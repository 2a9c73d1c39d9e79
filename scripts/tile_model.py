#!/usr/bin/env python3
"""Puts copies of a building beside and above each other in one IFC file: a large site for measurements.

usage: scripts/tile_model.py MODEL.ifc OUT.ifc [--columns 4] [--rows 3] [--levels 5] [--pitch X Y Z] [--days 1]

Each copy has entities and GlobalIds of its own, and lies PITCH further in the file's units; units, contexts and the
project are shared. The dates of its tasks are later by a number of days for each copy, so that every date changes little
of the whole. The file must have one entity a line, and one IfcSite without a placement relative to anything.
"""

import argparse
import datetime
import re
import sys

ENTITY = re.compile(r"#(\d+)\s*=\s*([A-Z0-9_]+)\s*\((.*)\)\s*;\s*$")
# Strings are left alone, references are not.
TOKEN = re.compile(r"'(?:[^']|'')*'|#\d+")
GLOBAL_ID = re.compile(r"^'([0-3][0-9A-Za-z_$]{21})'")
DATE = re.compile(r"'(\d{4})-(\d{2})-(\d{2})(T[^']*)?'")
DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$"
SHARED = {"IFCPROJECT", "IFCUNITASSIGNMENT", "IFCSIUNIT", "IFCCONVERSIONBASEDUNIT", "IFCMEASUREWITHUNIT",
          "IFCDIMENSIONALEXPONENTS", "IFCGEOMETRICREPRESENTATIONCONTEXT", "IFCGEOMETRICREPRESENTATIONSUBCONTEXT",
          "IFCMAPCONVERSION", "IFCPROJECTEDCRS", "IFCOWNERHISTORY", "IFCPERSON", "IFCORGANIZATION",
          "IFCPERSONANDORGANIZATION", "IFCAPPLICATION"}


def arguments_of(text):
    """Top-level arguments of an entity."""
    found, depth, start, quoted = [], 0, 0, False
    for at, letter in enumerate(text):
        if letter == "'":
            quoted = not quoted
        elif not quoted and letter == "(":
            depth += 1
        elif not quoted and letter == ")":
            depth -= 1
        elif not quoted and letter == "," and depth == 0:
            found.append(text[start:at])
            start = at + 1
    return found + [text[start:]]


def later(text, days):
    def shift(match):
        date = datetime.date(*map(int, match.group(1, 2, 3))) + datetime.timedelta(days)
        return f"'{date.isoformat()}{match.group(4) or ''}'"
    return DATE.sub(shift, text)


def read(path):
    with open(path, encoding="utf-8") as file:
        head, _, rest = file.read().partition("DATA;")
    body, _, tail = rest.partition("ENDSEC;")
    entities = {}
    for line in filter(None, map(str.strip, body.splitlines())):
        match = ENTITY.match(line)
        if not match:
            sys.exit(f"{path}: not one entity on this line: {line[:80]}")
        entities[int(match.group(1))] = (match.group(2), match.group(3))
    return head, entities, tail


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("model")
    parser.add_argument("out")
    parser.add_argument("--columns", type=int, default=4)
    parser.add_argument("--rows", type=int, default=3)
    parser.add_argument("--levels", type=int, default=5)
    parser.add_argument("--pitch", type=float, nargs=3, default=[26000.0, 19000.0, 6400.0], metavar=("X", "Y", "Z"))
    parser.add_argument("--days", type=int, default=1)
    options = parser.parse_args()

    head, entities, tail = read(options.model)
    sites = [arguments for kind, arguments in entities.values() if kind == "IFCSITE"]
    if len(sites) != 1:
        sys.exit(f"{options.model}: {len(sites)} IfcSite, one is needed")
    site_placement = int(arguments_of(sites[0])[5].strip("# "))
    step = max(entities) + 4
    shared = {number for number, (kind, _) in entities.items() if kind in SHARED}
    lines = []
    cells = [(c, r, l) for l in range(options.levels) for r in range(options.rows) for c in range(options.columns)]
    for copy, cell in enumerate(cells):
        offset = copy * step
        move = [n * p for n, p in zip(cell, options.pitch)]

        def renumber(match):
            token = match.group(0)
            if token[0] == "'" or int(token[1:]) in shared:
                return token
            return f"#{int(token[1:]) + offset}"

        for number, (kind, arguments) in entities.items():
            if copy > 0 and number in shared:
                continue
            arguments = TOKEN.sub(renumber, arguments) if copy else arguments
            identity = GLOBAL_ID.match(arguments)
            if copy > 0 and identity:
                digits = DIGITS[copy // 64] + DIGITS[copy % 64]
                arguments = f"'{identity.group(1)[:-2]}{digits}'" + arguments[identity.end():]
            if kind == "IFCTASKTIME":
                arguments = later(arguments, copy * options.days)
            if number == site_placement:
                point, axis = offset + step - 2, offset + step - 1
                lines.append(f"#{point}=IFCCARTESIANPOINT(({move[0]!r},{move[1]!r},{move[2]!r}));")
                lines.append(f"#{axis}=IFCAXIS2PLACEMENT3D(#{point},$,$);")
                arguments = f"$,#{axis}"
            if kind == "IFCBUILDINGSTOREY":
                storey = arguments_of(arguments)
                storey[-1] = repr(float(storey[-1]) + move[2])
                arguments = ",".join(storey)
            lines.append(f"#{number if number in shared else number + offset}={kind}({arguments});")
    with open(options.out, "w", encoding="utf-8", newline="\n") as file:
        file.write(f"{head}DATA;\n" + "\n".join(lines) + f"\nENDSEC;{tail}")


main()
