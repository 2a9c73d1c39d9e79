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
    is_there = np.isin(storey.part, parts) & (storey.part > 0) & ~storey.stairs
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
        faces = Faces(storey, plan["classes"])
        everything = np.arange(len(faces.middles))
        places = np.array([w["place"] for w in scans]).reshape(-1, 2)
        pairs = seen(storey, sensor, faces, everything, places, np.array([w["yaw_rad"] for w in scans]))
        known = np.zeros(len(everything), bool)
        seen_by = [pairs[pairs[:, 0] == k, 1] for k in range(len(scans))]
        yield from check_registration(plan, index, scans, seen_by, len(everything))
        yield from check_distances(plan, index, storey, scans, places)
        for w in scans:
            if storey.stairs[storey.cell(w["place"])]:
                yield "stair", f"the scan {w['id']} stands on a stair"
        for k, (w, own) in enumerate(zip(scans, seen_by)):
            overlap = known[own].sum() / max(1, len(own))
            known[own] = True
            if abs(len(own) - w["faces"]) > N_FACES:
                yield "faces", f"the scan {w['id']} sees {len(own)} faces, the export has {w['faces']}"
            if abs(overlap - w["overlap"]) > OVERLAP_TOLERANCE + N_FACES / max(1, len(own)):
                yield "overlap", f"scans before {w['id']} saw {overlap:.3f} of its faces, the export has {w['overlap']}"
        others = np.array([w["place"] for w in export.on(index)]).reshape(-1, 2)
        can = seen_from_anywhere(storey, sensor, faces, known, export.reached(index), others)
        export.seen[index] = int(known.sum()), int(can.sum())
        yield from check_coverage(plan, index, outcome, storey.resolution_m, *export.seen[index])
        yield from check_curve(index, outcome, len(scans), *export.seen[index])
        yield from check_spaces(export, index, faces, known, can)


def registered(overlap_goal, n_more, scans, seen_by, n_faces):
    """Which scans register with some faces more than needed, and the overlaps of the others. Those register of whose
    faces others that register saw enough, and the first of each part of the floor."""
    known, has_scan, left, overlaps = np.zeros(n_faces, bool), set(), set(range(len(scans))), {}
    while left:
        overlap = {k: known[seen_by[k]].sum() / max(1, len(seen_by[k])) for k in left}
        enough = [k for k in left if scans[k]["part"] in has_scan and overlap[k] >= overlap_goal - 1e-9 + n_more / max(1, len(seen_by[k]))]
        first = [k for k in left if scans[k]["part"] not in has_scan]
        if not enough and not first:
            return overlaps, overlap
        k = max(enough, key=overlap.get) if enough else max(first, key=lambda k: len(seen_by[k]))
        left.remove(k)
        has_scan.add(scans[k]["part"])
        overlaps[k] = overlap[k]
        known[seen_by[k]] = True
    return overlaps, {}


def check_registration(plan, index, scans, seen_by, n_faces):
    """The order in which scans register, and that those that join others are needed."""
    by_id, known, has_scan, n_not = {w["id"]: k for k, w in enumerate(scans)}, np.zeros(n_faces, bool), set(), 0
    for k in sorted(range(len(scans)), key=lambda k: scans[k]["registration_order"]):
        w, own = scans[k], seen_by[k]
        overlap = known[own].sum() / max(1, len(own))
        if abs(overlap - w["registration_overlap"]) > OVERLAP_TOLERANCE + N_FACES / max(1, len(own)):
            yield "registration", f"scans registered before {w['id']} saw {overlap:.3f} of its faces, the export has {w['registration_overlap']}"
        n_not += w["part"] in has_scan and overlap < plan["overlap_goal"] - OVERLAP_TOLERANCE - N_FACES / max(1, len(own))
        known[own] = True
        has_scan.add(w["part"])
    if n_not and all(notice["code"] != "scan_not_joined" for notice in plan["notices"]):
        yield "registration", f"{n_not} scans of storey {index} do not register with the others"
    for w in (w for w in scans if w["connects"]):
        others = [k for k, other in enumerate(scans) if other is not w]
        those = [scans[k] for k in others], [seen_by[k] for k in others], n_faces
        joined = others.index(by_id[w["joins"]])
        # Faces that may be seen or not decide neither way.
        if joined in registered(plan["overlap_goal"], N_FACES, *those)[0]:
            yield "registration", f"the scan {w['joins']} registers without {w['id']}, which is there to join it"
            continue
        _, overlap = registered(plan["overlap_goal"], 0, *those)
        if joined in overlap and abs(overlap[joined] - w["joins_overlap_without"]) > 2 * OVERLAP_TOLERANCE:
            yield "registration", f"without {w['id']} others saw {overlap[joined]:.3f} of {w['joins']}, the export has {w['joins_overlap_without']}"


def check_distances(plan, index, storey, scans, places):
    """No two scans are too near, but in spaces that reach their share in no other way: those have both scans."""
    least = plan["separation_m"] / storey.resolution_m - 0.01
    for k, place in enumerate(places):
        far = np.hypot(*(places[k + 1:] - place).T)
        for other in k + 1 + np.flatnonzero((far > 0.01) & (far < least)):
            if scans[k]["space"] != scans[other]["space"]:
                yield "near", f"the scans {scans[k]['id']} and {scans[other]['id']} of storey {index} are too near"


def check_curve(index, outcome, n_scans, n_seen, n_faces):
    """The curve grows, and the plan sees at least what it says for as many scans."""
    curve = outcome["curve"]
    if [point["scans"] for point in curve] != list(range(1, len(curve) + 1)):
        yield "curve", f"the curve of storey {index} leaves out numbers of scans"
    shares = [0.0] + [point["coverage"] for point in curve]
    if any(a > b for a, b in zip(shares, shares[1:])) or shares[-1] > 1:
        yield "curve", f"the curve of storey {index} falls, or ends at {shares[-1]}"
    elif n_faces and n_seen / n_faces < shares[min(n_scans, len(curve))] - COVERAGE_TOLERANCE:
        yield "curve", f"the {n_scans} scans of storey {index} see {n_seen / n_faces:.4f}, the curve has {shares[min(n_scans, len(curve))]}"


def check_coverage(plan, index, outcome, resolution_m, n_seen, n_faces):
    goal, has_budget = plan["coverage_goal"], plan["scans_max"] is not None or plan["mission_max_s"] is not None
    if goal == 0 or n_faces == 0 == outcome["faces"]:
        return
    coverage, exported = n_seen / max(1, n_faces), outcome["coverage"]
    if abs(n_seen - outcome["faces_seen"]) > N_FACES:
        yield "coverage", f"the scans of storey {index} see {n_seen} faces, the export has {outcome['faces_seen']}"
    if exported is None or abs(coverage - exported) > COVERAGE_TOLERANCE:
        yield "coverage", f"the scans of storey {index} see {coverage:.4f} of what can be seen, the export has {exported}"
    # Less is seen where a budget ends the plan, or where no scan adds enough: behind the last one of the curve that does.
    shares = [0.0] + [point["coverage"] for point in outcome["curve"]]
    least = plan["min_gain_m"] / resolution_m / n_faces
    worth = max((b for a, b in zip(shares, shares[1:]) if b - a >= least), default=0.0)
    if coverage < min(goal, worth) - COVERAGE_TOLERANCE and not has_budget:
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
        exported = outcome["coverage"]
        # Both counts may be off by so many: those that are seen, and those that can be.
        if abs(n_seen / n_faces - exported) > COVERAGE_TOLERANCE + (1 + exported) * N_FACES / n_faces:
            yield "coverage", f"the scans see {n_seen / n_faces:.4f} of what can be seen of space {space_id}, the export has {exported}"
