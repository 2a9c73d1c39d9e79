"""Proofs about waypoints as places: where they are, which spaces have them, how the robot gets from one to the next."""
import math

import numpy as np

from .storey import ROUNDED_M, are_clear, depth_m

# Ways over cells are at most this much longer than straight ones: steps to eight neighbours.
OCTILE = 1.0824
# Smaller parts of a floor are left out.
LEAST_PART_M2 = 0.1
CAN_PASS = ("passable", "absent")
UPRIGHT = (0, 0, 1)
# Heights are rounded to the steps of a picture, and cells at the rim of the robot may count or not.
TILT_RAD = 0.005


def check_numbers(export):
    n, exported = len(export.waypoints), {s["storey"]: s for s in export.plan["storeys"]}
    if [w["order"] for w in export.waypoints] != list(range(n)):
        yield "order", f"the waypoints are not in the places 0 to {n - 1} of the tour"
    if len({w["id"] for w in export.waypoints}) != n:
        yield "order", "two waypoints have one id"
    if set(exported) != set(export.storeys):
        yield "order", f"the plan is of the storeys {sorted(exported)}, the maps of {sorted(export.storeys)}"
    for index, outcome in exported.items():
        n_scans = len(export.on(index, "scan"))
        if outcome["scans"] != n_scans:
            yield "order", f"storey {index} has {n_scans} scans, the export has {outcome['scans']}"


def check_poses(export):
    radius_m = export.robot["radius_m"]
    for w in export.waypoints:
        name, storey = f"waypoint {w['id']}", export.storeys[w["storey"]]
        floor_z_m = storey.z_m([w["x_m"], w["y_m"]])[0]
        if abs(w["z_m"] - floor_z_m) > ROUNDED_M:
            yield "height", f"{name} is at {w['z_m']} m, the floor at {floor_z_m} m"
        up = np.array(w.get("up", UPRIGHT))
        sensor_m = np.array([w["x_m"], w["y_m"], floor_z_m]) + export.robot["sensor_height_m"] * up
        if abs(w["sensor_z_m"] - sensor_m[2]) > ROUNDED_M or "up" in w and np.abs(w["sensor_m"] - sensor_m).max() > ROUNDED_M:
            yield "height", f"{name} has its sensor at {w.get('sensor_m', w['sensor_z_m'])} m, it is at {sensor_m} m"
        normal = storey.normal([w["x_m"], w["y_m"]], radius_m)
        if abs(np.linalg.norm(up) - 1) > 1e-6 or ("up" in w) != ("sensor_m" in w) or np.linalg.norm(up - normal) > TILT_RAD:
            yield "up", f"{name} has {up} up, the normal of the ground is {normal}"
        if w["space"] is not None:
            yield from check_inside(export, w, name)
        cell, clearance_m = storey.cell(w["place"]), storey.clearance_m(w["place"][None])
        if cell is None or not storey.free[cell] or storey.keep_out[cell]:
            yield "free", f"{name} is not on free floor"
        elif clearance_m < radius_m - ROUNDED_M:
            yield "clear", f"{name} is {clearance_m:.3f} m from what is not free, the robot needs {radius_m} m"
        elif abs(w["clearance_m"] - clearance_m) > ROUNDED_M:
            yield "clear", f"{name} is {clearance_m:.3f} m from what is not free, the export has {w['clearance_m']} m"
        elif w["part"] == 0:
            yield "reach", f"{name} has no place around it on which the robot can stand"


def check_orientations(export):
    """Quaternions turn Z to what is up for a waypoint, and look in plan where its yaw says."""
    waypoints = {w["id"]: w for w in export.waypoints}
    for index, found in export.quaternions.items():
        if sorted(id_ for _, id_, _ in found) != sorted(2 * [w["id"] for w in export.on(index)]):
            yield "orientation", f"not all waypoints of storey {index} have a quaternion in each file"
        for file, id_, (x, y, z, w) in (f for f in found if f[1] in waypoints):
            waypoint = waypoints[id_]
            up = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)]
            yaw_rad = math.atan2(2 * (x * y + w * z), 1 - 2 * (y * y + z * z))
            off_rad = math.remainder(yaw_rad - waypoint["yaw_rad"], 2 * math.pi)
            if np.abs(np.subtract(up, waypoint.get("up", UPRIGHT))).max() > 1e-6 or abs(off_rad) > 1e-6:
                yield "orientation", f"{file} turns waypoint {id_} to {yaw_rad:.4f} rad with {np.round(up, 4)} up"


def check_inside(export, w, name):
    space = export.spaces.get(w["space"])
    if space is None or space["storey"] != w["storey"]:
        yield "inside", f"{name} is in the space {w['space']}, which is not on its storey"
        return
    if depth_m(space["polygon_m"], [w["x_m"], w["y_m"]])[0] < -ROUNDED_M:
        yield "inside", f"{name} is outside of its space {w['space']}"
    if math.dist(w["centroid_m"][:2], space["centroid_m"]) > ROUNDED_M:
        yield "inside", f"{name} tells another centroid than that of its space"


def check_reach(export):
    """Waypoints can be got to from one part of each storey at most, and what is exported of reached floor is so."""
    groups = {}

    def group(part):
        while part in groups:
            part = groups[part]
        return part

    for edge in export.graph["edges"]:
        ends = [export.nodes[edge[end]] for end in ("from", "to")]
        a, b = (group((node["storey"], node["part"])) for node in ends)
        if edge["usable"] and ends[0]["storey"] != ends[1]["storey"] and a != b:
            groups[a] = b
    for index in export.storeys:
        on_it = {group((index, part)) for part in export.reached(index)}
        elsewhere = {group((i, part)) for i in export.storeys if i != index for part in export.reached(i)}
        # Ways over storeys that are left out are left out.
        if len(on_it - elsewhere) > 1 and not export.manifest["storeys_left_out"]:
            yield "reach", f"there are waypoints in parts of storey {index} that no way joins"
    yield from check_parts(export)
    cell_m2 = export.resolution_m ** 2
    for outcome in export.plan["storeys"]:
        n_cells, reached = export.storeys[outcome["storey"]].n_cells, export.reached(outcome["storey"])
        name, standing_m2 = f"storey {outcome['storey']}", n_cells.sum() * cell_m2
        if outcome["parts"] != len(reached):
            yield "reach", f"the waypoints of {name} are in {len(reached)} parts, the export has {outcome['parts']}"
        if abs(outcome["reached_m2"] + outcome["unreached_m2"] - standing_m2) > 0.001 * standing_m2 + cell_m2:
            yield "reach", f"the robot can stand on {standing_m2:.2f} m2 of {name}, the export has " \
                f"{outcome['reached_m2']} and {outcome['unreached_m2']}"
        if n_cells[reached].sum() * cell_m2 > 1.001 * outcome["reached_m2"] + cell_m2:
            yield "reach", f"the robot gets to more of {name} than the {outcome['reached_m2']} m2 exported"


def check_parts(export):
    """The parts of the floors in report.json are those of the maps, and waypoints are in parts that the robot gets to."""
    cell_m2 = export.resolution_m ** 2
    for entry in (e for e in export.report["storeys"] if e["index"] in export.storeys):
        storey, exported, name = export.storeys[entry["index"]], entry["reach"]["parts"], f"storey {entry['index']}"
        parts = [storey.part_at(storey.places(part["at_m"])[0]) for part in exported]
        sizes_m2 = [storey.n_cells[part] * cell_m2 for part in parts]
        if 0 in parts or len(set(parts)) != len(parts) or (storey.n_cells * cell_m2 >= LEAST_PART_M2).sum() != len(parts):
            yield "parts", f"the {len(parts)} parts of {name} that are the export has not those of its map"
        elif any(abs(part["area_m2"] - size_m2) > 0.001 + ROUNDED_M for part, size_m2 in zip(exported, sizes_m2)):
            yield "parts", f"parts of {name} have other areas on its map"
        elif not set(export.reached(entry["index"])) <= {p for p, part in zip(parts, exported) if part["reached"]} | small(storey, cell_m2):
            yield "parts", f"there are waypoints in parts of {name} that are exported as not reached"


def small(storey, cell_m2):
    """Parts that are too small to be listed."""
    return set(np.flatnonzero(storey.n_cells * cell_m2 < LEAST_PART_M2).tolist())


def check_spaces(export):
    centres = [w["space"] for w in export.waypoints if w["kind"] == "centre"]
    if set(export.outcomes) != set(export.spaces):
        yield "space", "semantic.json and waypoints.json are of different spaces"
    if len(set(centres)) != len(centres):
        yield "space", "a space has two centres"
    # Without centres, scans are what a space has.
    visited = set(centres) or {w["space"] for w in export.waypoints}
    for space_id, outcome in export.outcomes.items():
        has_reason = outcome["reason"] is not None and outcome["why"] is not None
        if not has_reason and space_id not in visited or has_reason and space_id in centres:
            yield "space", f"space {space_id} has a waypoint and a reason for none, or neither"
        elif has_reason:
            yield from check_reason(export, space_id, outcome)
        yield from check_access(export, space_id, outcome)


def check_access(export, space_id, outcome):
    """Reached only if the robot can stand there, without a way only if no waypoint lies in a part of it; what the schedule closes is
    closed."""
    space, access = export.spaces[space_id], outcome["access"]
    if (access == "no_way") != (outcome["access_reason"] is not None):
        yield "access", f"space {space_id} is {access}, with the reason {outcome['access_reason']!r}"
    if access is None or space["storey"] is None:
        return
    if (access == "closed") != (space["state"] == "blocked"):
        yield "access", f"space {space_id} is {space['state']} by the schedule, and {access} to the robot"
    storey = export.storeys[space["storey"]]
    is_reached = np.isin(storey.part, export.reached(space["storey"])) & storey.stands
    can_be_true = {
        "reached": storey.stands[export.own_cells(space_id, np.less, export.resolution_m)].any(),
        "no_way": not is_reached[export.own_cells(space_id, np.less_equal, -export.resolution_m)].any(),
    }
    if not can_be_true.get(access, True):
        yield "access", f"the map does not bear out that space {space_id} is {access}"


def check_reason(export, space_id, outcome):
    space, why = export.spaces[space_id], outcome["why"]
    never = ("metadata_only", "external", "no_body", "not_mapped")
    if (why == "blocked") != (space["state"] == "blocked" and why not in never):
        yield "reason", f"space {space_id} is {space['state']}, and the reason is {outcome['reason']!r}"
    # A space that was not asked for may have a closed door on the way, too.
    if why == "closed_door" and outcome["door"] is None or outcome["door"] is not None and outcome["access"] != "no_way":
        yield "reason", f"space {space_id} has the reason {outcome['reason']!r} and the door {outcome['door']}"
    elif why == "closed_door":
        door = export.elements[outcome["door"]]["attributes"]
        is_own = space_id in door["spaces"]
        passage = door["passage"][str(space["storey"] if is_own else door["storey"])]
        if f"{'its' if is_own else 'the'} door {outcome['door']} " not in outcome["reason"] or passage in CAN_PASS:
            yield "reason", f"the door {outcome['door']} does not keep the robot out of {space_id}"
    if why not in ("no_floor", "keepout", "too_narrow", "closed_door", "unreachable"):
        return
    storey = export.storeys[space["storey"]]
    # Of two spaces of one size in one place only one has the cells, and cells on the border of two are either's.
    surely = export.own_cells(space_id, np.less_equal, -export.resolution_m)
    perhaps = export.own_cells(space_id, np.less, export.resolution_m)
    is_reached = np.isin(storey.part, export.reached(space["storey"])) & storey.stands
    can_be_true = {
        "no_floor": not storey.free[surely].any(),
        "keepout": storey.free[perhaps].any() and not (storey.free & ~storey.keep_out)[surely].any(),
        "too_narrow": not storey.stands[surely].any(),
        "closed_door": storey.stands[perhaps].any() and not is_reached[surely].any(),
        "unreachable": storey.stands[perhaps].any() and not is_reached[surely].any(),
    }
    if not can_be_true[why]:
        yield "reason", f"the map does not bear out of space {space_id} that {outcome['reason']!r}"


def check_tours(export):
    for outcome in export.plan["storeys"]:
        index, storey = outcome["storey"], export.storeys[outcome["storey"]]
        waypoints = export.on(index)
        legs_m = sum(w["leg_m"] for w in waypoints)
        if abs(outcome["tour_m"] - legs_m) > ROUNDED_M + 1e-4 * len(waypoints):
            yield "tour", f"the legs of storey {index} are {legs_m:.3f} m long, the tour is exported as {outcome['tour_m']} m"
        if outcome["tour_bound_m"] > outcome["tour_m"] + ROUNDED_M:
            yield "tour", f"the tour of storey {index} is shorter than the bound for any: {outcome['tour_bound_m']} m"
        for before, w in zip(waypoints, waypoints[1:]):
            if before["part"] == w["part"] != 0:
                yield from check_leg(storey, before, w)


def check_leg(storey, before, w):
    """A straight leg is as long as its line. Another one is no longer than the way over cells, but for the two cells at its
    ends, and no shorter than any way can be."""
    name = f"the way from waypoint {before['id']} to {w['id']}"
    straight_m = float(np.hypot(*(w["place"] - before["place"]))) * storey.resolution_m
    slack_m = 2 * storey.resolution_m
    if w["leg_m"] < straight_m - ROUNDED_M:
        yield "leg", f"{name} is {straight_m:.3f} m as the crow flies, the export has {w['leg_m']} m"
    elif w["leg_m"] > straight_m + ROUNDED_M or not are_clear(storey.stands, before["place"][None], w["place"][None])[0]:
        way_m = storey.way_m(before["place"], w["place"], OCTILE * w["leg_m"] + slack_m)
        if math.isinf(way_m):
            yield "leg", f"{name} is exported as {w['leg_m']} m long, and there is no way that short"
        elif w["leg_m"] > 1.01 * way_m + slack_m:
            yield "leg", f"{name} is exported as {w['leg_m']} m long, and there is one of {way_m:.3f} m"
