#!/usr/bin/env python3
"""Proves the waypoints of exported map folders anew, from the exported files alone: it shares no code with what planned them.

    python3 scripts/check_waypoints.py OUT...          judge the folders that `groundplan convert` or `export` wrote
    python3 scripts/check_waypoints.py --self-test OUT damage copies of a folder in many ways; each must be noticed

Needs numpy and Pillow. Prints what does not hold, and a line with the verdict for each folder. Exit codes: 0 all hold,
1 something does not, 2 a folder cannot be read.

What is proved of each folder:

- the floor: what parts of it there are, how large they are, and that waypoints are only in those that are exported as reached;
- waypoints: in their space, at the height of floor and sensor, with the normal of the ground of elevation.png as their up and the
  quaternions of all files that follow from it, on free floor clear by the robot's radius, off keep-out; all
  in places that the robot can get to from one another, or through stairs and lifts that it can take;
- spaces: each has its centre or a reason for having none, and the map bears out what reasons say of it;
- scans: how many faces each sees, how many of them earlier ones saw, what share all of them see of what can be seen, that no two
  are too near, in which order they register, that those which join others are needed, that the plan is not below its curve;
- tours: each waypoint has its place, a way of the exported length leads to it over floor that the robot can be on;
- the route graph: nodes clear and named as in semantic.json, edges on floor that the robot can be on and as long as exported, every part connected, ways through
  doors marked as such, ways between storeys only for robots that can take them; each storey's `route.geojson` says the same;
- time and energy of edges, where they are told: by length, rise and climb, and as costs of `route.geojson` where they were asked for.

It judges plans for a robot that drives open tours.
"""
import argparse
import csv
import json
import pathlib
import re
import sys
import time
from typing import NamedTuple

import numpy as np

from waypoint_proof import places, route, scans
from waypoint_proof.damage import damaged
from waypoint_proof.storey import Storey, depth_m


class Violation(NamedTuple):
    check: str
    text: str


class Export:
    """What a folder holds. Waypoints and nodes get their `place` and `part`, storeys the faces seen and those that can be."""

    def __init__(self, out):
        def load(name):
            return json.loads((out / name).read_text(encoding="utf-8"))

        self.manifest, plan, self.graph, semantic, self.report = map(
            load, ("manifest.json", "waypoints.json", "site-graph.json", "semantic.json", "report.json"))
        self.elements, self.spaces = semantic["elements"], semantic["spaces"]
        self.plan, self.outcomes = plan, plan["spaces"]
        self.robot, self.resolution_m = self.manifest["robot"], self.manifest["resolution_m"]
        entries = {entry["index"]: entry for entry in self.manifest["storeys"]}
        radius_m = self.robot["radius_m"]
        self.storeys = {i: Storey(out, entry, self.resolution_m, radius_m) for i, entry in entries.items()}
        self.routes = {i: load(f"{entry['directory']}/route.geojson")["features"] for i, entry in entries.items()}
        self.waypoints = sorted(plan["waypoints"], key=lambda w: w["order"])
        self.seen = {}
        self.quaternions = {i: quaternions(out, entry, self.on(i)) for i, entry in entries.items()}
        self.nodes = {node["id"]: node for node in self.graph["nodes"]}
        for thing in self.waypoints + self.graph["nodes"]:
            storey = self.storeys[thing["storey"]]
            thing["place"] = storey.places([thing["x_m"], thing["y_m"]])[0]
            thing["part"] = storey.part_at(thing["place"])

    def on(self, storey, kind=None):
        """Waypoints of a storey, in the order of the tour."""
        return [w for w in self.waypoints if w["storey"] == storey and kind in (None, w["kind"])]

    def reached(self, storey):
        """Its parts that have waypoints."""
        return sorted({w["part"] for w in self.on(storey)} - {0})

    def own_cells(self, space_id, takes, rim_m=0.0):
        """(rows, columns) of the cells whose middles lie in a space, or up to `rim_m` beside it, and not as deep in another one
        whose area `takes` its area."""
        space = self.spaces[space_id]
        storey = self.storeys[space["storey"]]
        rows, columns = storey.cells_around(corners_m(space))
        middles = storey.points_m(np.stack([columns, rows], 1) + 0.5)
        is_own = depth_m(space["polygon_m"], middles) > -rim_m
        others = [o for other_id, o in self.spaces.items() if other_id != space_id and o["polygon_m"]]
        for other in (o for o in others if o["storey"] == space["storey"] and takes(o["area_m2"], space["area_m2"])):
            low, high = corners_m(other).min(0), corners_m(other).max(0)
            near = np.flatnonzero(is_own & ((middles >= low + rim_m) & (middles <= high - rim_m)).all(1))
            is_own[near] = depth_m(other["polygon_m"], middles[near]) < rim_m
        return rows[is_own], columns[is_own]


def quaternions(out, entry, waypoints):
    """(name of the file, id of a waypoint, its quaternion x, y, z, w) in the files of a storey that have some."""
    with (out / "waypoints.csv").open(encoding="utf-8", newline="") as lines:
        rows = [row for row in csv.DictReader(lines) if int(row["storey"]) == entry["index"]]
    found = [("waypoints.csv", int(row["id"]), [float(row[key]) for key in ("qx", "qy", "qz", "qw")]) for row in rows]
    panel = f"{entry['directory']}/waypoints.yaml"
    turns = re.findall(r"orientation: (\[.*\])", (out / panel).read_text(encoding="utf-8"))
    for w, turn in zip(waypoints, map(json.loads, turns)):
        found.append((panel, w["id"], [*turn[1:], turn[0]]))
    return found


def corners_m(space):
    """The corners of a space that has a place on a storey."""
    return np.array([point[:2] for rings in space["polygon_m"] for point in rings[0]])


CHECKS = (
    places.check_numbers, places.check_poses, places.check_orientations, places.check_reach, places.check_spaces, places.check_tours,
    scans.check_scans, route.check_nodes, route.check_edges, route.check_drive, route.check_routes,
)


def judge(out):
    """(what does not hold, one line of figures)."""
    export = Export(out)
    violations = [Violation(*found) for check in CHECKS for found in check(export)]
    n_scans = sum(w["kind"] == "scan" for w in export.waypoints)
    n_seen, n_faces = (sum(seen[k] for seen in export.seen.values()) for k in (0, 1))
    tours_m = sum(w["leg_m"] for w in export.waypoints)
    figures = (
        f"{len(export.storeys)} storeys, {len(export.waypoints) - n_scans} centres, {n_scans} scans of {n_seen} in {n_faces} faces, "
        f"{tours_m:.1f} m of tours, {len(export.nodes)} nodes, {len(export.graph['edges'])} edges"
    )
    return violations, figures


def verdict(out):
    """Prints what is wrong with a folder, and in one line whether anything is; true if nothing is."""
    start = time.monotonic()
    violations, figures = judge(out)
    for violation in violations[:20]:
        print(f"  {violation.check}: {violation.text}")
    if len(violations) > 20:
        print(f"  and {len(violations) - 20} more")
    print(f"{'FAIL' if violations else 'ok  '} {out.name}: {figures}; {time.monotonic() - start:.1f} s", flush=True)
    return not violations


def self_test(out):
    """Prints which damages are noticed; true if the folder is in order and all are."""
    is_good = verdict(out)
    for name, must, did in damaged(out, lambda copy: {violation.check for violation in judge(copy)[0]}):
        is_noticed = must <= did
        is_good &= is_noticed
        print(f"{'ok  ' if is_noticed else 'FAIL'} {name}: {', '.join(sorted(did)) or 'nothing'} "
              f"{'' if is_noticed else 'instead of ' + ', '.join(sorted(must))}".rstrip(), flush=True)
    return is_good


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--self-test", action="store_true", help="damage copies of the folders too: each must be noticed")
    parser.add_argument("folders", metavar="OUT", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    look = self_test if options.self_test else verdict
    try:
        verdicts = [look(out) for out in options.folders]
    except (OSError, ValueError, LookupError, TypeError) as problem:
        print(f"scripts/check_waypoints.py: cannot read the folder: {type(problem).__name__}: {problem}", file=sys.stderr)
        return 2
    return 0 if all(verdicts) else 1


if __name__ == "__main__":
    sys.exit(main())
