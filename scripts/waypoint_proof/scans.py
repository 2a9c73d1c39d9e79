"""Proofs about scans: what each sees, what was seen before it, what all of them see of what can be seen."""
import math
from typing import NamedTuple

import numpy as np

from .storey import SIDES, Faces, are_clear, flood

# Faces to which a line touches a corner may be seen or not.
N_FACES = 3
OVERLAP_TOLERANCE = 0.01
# What can be seen at all depends on the places from which it is tried.
COVERAGE_TOLERANCE = 0.01
# Distance of the places from which it is tried what can be seen at all.
PLACES_M = 0.1
DIAGONALS = np.array([(1, 1), (1, -1), (-1, 1), (-1, -1)])


class Sensor(NamedTuple):
    """What is seen of a face that nothing hides, in cells."""

    near: float
    far: float
    cos: float
    half_view_rad: float

    def sees(self, places, middles, normals, sides, yaws_rad=None):
        way = middles - places
        far = np.hypot(way[..., 0], way[..., 1])
        ok = (self.near - 1e-6 <= far) & (far <= self.far + 1e-6)
        ok &= (way * sides).sum(-1) < 0
        ok &= -(way * normals).sum(-1) >= (self.cos - 1e-9) * far
        if yaws_rad is not None and self.half_view_rad < math.pi - 1e-9:
            turn = np.remainder(np.arctan2(way[..., 1], way[..., 0]) - yaws_rad + math.pi, 2 * math.pi) - math.pi
            ok &= np.abs(turn) <= self.half_view_rad + 1e-9
        return ok


def seen(storey, sensor, faces, which, places, yaws_rad=None):
    """Pairs (place, face) such that the place sees the face, of the faces `which`."""
    pairs = []
    n_at_once = max(1, 300_000 // max(1, len(which)))
    for first in range(0, len(places), n_at_once):
        some = places[first:first + n_at_once]
        yaws = None if yaws_rad is None else yaws_rad[first:first + n_at_once, None]
        ok = sensor.sees(some[:, None], faces.middles[which], faces.normals[which], faces.sides[which], yaws)
        place, k = np.nonzero(ok)
        face = which[k]
        # The face itself is the border of a wall: the line ends in front of it.
        ends = faces.middles[face] + 1e-3 * faces.sides[face]
        clear = are_clear(storey.leap, some[place], ends)
        pairs.append(np.stack([place[clear] + first, face[clear]], 1))
    return np.concatenate(pairs) if pairs else np.zeros((0, 2), int)


def seen_from_anywhere(storey, sensor, faces, known, parts, places):
    """Which faces can be seen from the places or from any other in the parts; `known` ones can."""
    is_there = np.isin(storey.part, parts) & (storey.part > 0)
    rows, columns = np.nonzero(is_there)
    every = max(1, round(PLACES_M / storey.resolution_m))
    on = (rows % every == 0) & (columns % every == 0)
    lattice = np.stack([columns[on], rows[on]], 1) + 0.5
    # Far from one another first: most of what can be seen is seen early.
    places = np.concatenate([places, np.random.default_rng(0).permutation(lattice)])
    # No line leads to where no way over free cells does.
    airy = np.zeros(storey.free.size, np.int8)
    flood(storey.free, np.flatnonzero(is_there), airy, 1, np.concatenate([SIDES, DIAGONALS]))
    fronts = faces.fronts[:, 1] * storey.free.shape[1] + faces.fronts[:, 0]
    can = known.copy()
    for first in range(0, len(places), 64):
        rest = np.flatnonzero(~can & (airy[fronts] == 1))
        can[seen(storey, sensor, faces, rest, places[first:first + 64])[:, 1]] = True
    return can


def check_scans(export):
    exported, plan = {s["storey"]: s for s in export.plan["storeys"]}, export.plan
    for index, storey in export.storeys.items():
        scans, outcome = export.on(index, "scan"), exported.get(index)
        if outcome is None:
            continue
        sensor = Sensor(plan["sensor"]["min_range_m"] / storey.resolution_m, plan["sensor"]["range_m"] / storey.resolution_m,
                        math.cos(plan["sensor"]["max_incidence_rad"]), plan["sensor"]["field_of_view_rad"] / 2)
        faces = Faces(storey)
        everything = np.arange(len(faces.middles))
        places = np.array([w["place"] for w in scans]).reshape(-1, 2)
        pairs = seen(storey, sensor, faces, everything, places, np.array([w["yaw_rad"] for w in scans]))
        known = np.zeros(len(everything), bool)
        for k, w in enumerate(scans):
            own = pairs[pairs[:, 0] == k, 1]
            overlap = known[own].sum() / max(1, len(own))
            known[own] = True
            if abs(len(own) - w["faces"]) > N_FACES:
                yield "faces", f"the scan {w['id']} sees {len(own)} faces, the export has {w['faces']}"
            if abs(overlap - w["overlap"]) > OVERLAP_TOLERANCE + N_FACES / max(1, len(own)):
                yield "overlap", f"scans before {w['id']} saw {overlap:.3f} of its faces, the export has {w['overlap']}"
        others = np.array([w["place"] for w in export.on(index)]).reshape(-1, 2)
        can = seen_from_anywhere(storey, sensor, faces, known, export.reached(index), others)
        export.seen[index] = int(known.sum()), int(can.sum())
        yield from check_coverage(plan["coverage_goal"], index, outcome, *export.seen[index])
        yield from check_spaces(export, index, faces, known, can)


def check_coverage(goal, index, outcome, n_seen, n_faces):
    if goal == 0 or n_faces == 0 == outcome["faces"]:
        return
    coverage, exported = n_seen / max(1, n_faces), outcome["coverage"]
    if abs(n_seen - outcome["faces_seen"]) > N_FACES:
        yield "coverage", f"the scans of storey {index} see {n_seen} faces, the export has {outcome['faces_seen']}"
    if exported is None or abs(coverage - exported) > COVERAGE_TOLERANCE:
        yield "coverage", f"the scans of storey {index} see {coverage:.4f} of what can be seen, the export has {exported}"
    if coverage < goal - COVERAGE_TOLERANCE:
        yield "coverage", f"the scans of storey {index} see {coverage:.4f} of what can be seen, the goal was {goal}"


def check_spaces(export, index, faces, known, can):
    """The share of the faces in a space: those in front of which its cells are."""
    for space_id, outcome in export.outcomes.items():
        if export.spaces[space_id]["storey"] != index or outcome["coverage"] is None:
            continue
        is_own = np.zeros(export.storeys[index].free.shape, bool)
        is_own[export.own_cells(space_id, np.less)] = True
        own = is_own[faces.fronts[:, 1], faces.fronts[:, 0]]
        n_seen, n_faces = (known & own).sum(), max(1, (can & own).sum())
        if abs(n_seen / n_faces - outcome["coverage"]) > COVERAGE_TOLERANCE + N_FACES / n_faces:
            exported = outcome["coverage"]
            yield "coverage", f"the scans see {n_seen / n_faces:.4f} of what can be seen of space {space_id}, the export has {exported}"
