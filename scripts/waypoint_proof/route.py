"""Proofs about the route graph: nodes, ways over the floor, through doors and between storeys, and what Nav2 gets of them."""
import math

import numpy as np

from .places import CAN_PASS
from .storey import ROUNDED_M, are_clear, depth_m

# The place in a passage may be at the other side of its wall than the leaf.
DOOR_M = 0.3


def check_nodes(export):
    radius_m = export.robot["radius_m"]
    for node in export.graph["nodes"]:
        name, storey = f"node {node['id']}", export.storeys[node["storey"]]
        clearance_m = storey.clearance_m(node["place"][None])
        floor_z_m = storey.z_m([node["x_m"], node["y_m"]])[0]
        if abs(node["z_m"] - floor_z_m) > ROUNDED_M:
            yield "node", f"{name} is at {node['z_m']} m, the floor at {floor_z_m} m"
        if clearance_m < radius_m - ROUNDED_M or node["part"] == 0:
            yield "node", f"{name} is {clearance_m:.3f} m from what is not free, or on keep-out"
        elif abs(node["clearance_m"] - clearance_m) > ROUNDED_M:
            yield "node", f"{name} is {clearance_m:.3f} m from what is not free, the export has {node['clearance_m']} m"
        known = export.spaces if node["kind"] == "space" else export.elements
        # No element carries a place that two maps show, and a step may have none.
        may_be_none = node["kind"] in ("junction", "staging")
        if node["kind"] == "junction" and node["of"] or node["of"] not in known and not (node["of"] is None and may_be_none):
            yield "node", f"{name} is a {node['kind']} of {node['of']}"
        elif names_of(export, node) != (node["name"], node["space_name"]):
            yield "node", f"{name} has other names than semantic.json: {node['name']}, {node['space_name']}"
        elif node["space"] is not None:
            # Its cell is the space's, perhaps by an edge only; where spaces overlap it may be another one's.
            for space_id, least_m in ((node["space"], -export.resolution_m), (node["of"], -ROUNDED_M)):
                space = export.spaces.get(space_id)
                if space and depth_m(space["polygon_m"], [node["x_m"], node["y_m"]])[0] < least_m:
                    yield "node", f"{name} is not in the space {space_id}"
    spaces = {node["of"] for node in export.graph["nodes"] if node["kind"] == "space"}
    for w in export.waypoints:
        if w["kind"] == "centre" and w["space"] not in spaces:
            yield "node", f"space {w['space']} has a centre and no node"


def names_of(export, node):
    """(name of what a node is, name of the space that it lies in), both with long names; None where there is none."""
    def room(space_id):
        space = export.spaces.get(space_id, {})
        return " ".join(filter(None, (space.get("name"), space.get("long_name")))) or None

    own = room(node["of"]) if node["kind"] == "space" else export.elements.get(node["of"], {}).get("name")
    return own, room(node["space"])


def check_edges(export):
    ids = [thing["id"] for thing in export.graph["nodes"] + export.graph["edges"]]
    if len(set(ids)) != len(ids):
        yield "edge", "two nodes or edges have one id"
    for edge in export.graph["edges"]:
        ends = [export.nodes[edge[end]] for end in ("from", "to")]
        for node, point in zip(ends, (edge["line_m"][0], edge["line_m"][-1])):
            if math.dist(point, (node["x_m"], node["y_m"])) > ROUNDED_M:
                yield "edge", f"the line of edge {edge['id']} does not end at node {node['id']}"
        if edge["class"] in ("floor", "door"):
            yield from check_level_edge(export, edge, ends)
        else:
            yield from check_portal(export, edge, ends)
    for index in export.storeys:
        yield from check_connected(export, index)


def check_level_edge(export, edge, ends):
    name, storey = f"edge {edge['id']}", export.storeys[ends[0]["storey"]]
    if ends[0]["storey"] != ends[1]["storey"] or not edge["usable"]:
        yield "edge", f"{name} is on the floor, and joins two storeys or cannot be used"
        return
    length_m = sum(math.dist(a, b) for a, b in zip(edge["line_m"], edge["line_m"][1:]))
    # Over slopes it is longer than in plan, but for steps that the robot takes by no more than the steepest makes it.
    longest_m = length_m / math.cos(edge["slope_rad"] or 0)
    rows, columns = np.floor(along(storey.places(edge["line_m"])) + 1e-9).astype(int)[:, ::-1].T
    if storey.stairs[rows, columns].any():
        # Up risers and along treads.
        longest_m += np.nansum(np.abs(np.diff(storey.height_m[rows, columns])))
    if not length_m - ROUNDED_M <= edge["length_m"] <= longest_m * (1 if storey.height_m is None else 1.02) + ROUNDED_M:
        yield "edge", f"{name} is {length_m:.4f} to {longest_m:.4f} m long, the export has {edge['length_m']} m"
    if edge["line_z_m"]:
        off_m = np.abs(np.array(edge["line_z_m"]) - storey.z_m(edge["line_m"]))
        if np.nanmax(off_m, initial=0) > ROUNDED_M:
            yield "edge", f"{name} is up to {np.nanmax(off_m):.3f} m off the ground"
    line = storey.places(edge["line_m"])
    # The robot fits at the nodes, though perhaps not at the middles of their cells.
    can_be = storey.stands.copy()
    for node in ends:
        if node["part"]:
            can_be[storey.cell(node["place"])] = True
    if not are_clear(can_be, line[:-1], line[1:]).all():
        yield "edge", f"{name} leads over floor on which the robot cannot be"
    # Both look along the line in steps.
    clearance_m = storey.clearance_m(along(line))
    if abs(clearance_m - edge["clearance_m"]) > storey.resolution_m / 2:
        yield "edge", f"{name} is {clearance_m:.3f} m from what is not free, the export has {edge['clearance_m']} m"
    if edge["class"] == "door":
        yield from check_door(export, edge, ends, line)
        return
    doors = [guid for guid in doors_on(export, ends[0]["storey"]) if beside_m(storey, export.elements[guid], line) == 0]
    if edge["of"] is not None or doors:
        yield "door", f"{name} is exported to lead over floor alone, and there is the door {edge['of'] or doors[0]}"


def doors_on(export, index):
    """The doors that the robot passes on a storey."""
    doors = {guid: e for guid, e in export.elements.items() if e["class"] == "door" and e["aabb_m"]}
    if export.storeys[index].is_outdoors:
        doors = {guid: door for guid, door in doors.items() if is_at_ground(export.storeys[index], door)}
    return [guid for guid, door in doors.items() if "passable" in passages(export, door, index)]


def is_at_ground(storey, door):
    """True if a door begins at the height of the ground around it."""
    low, high = (np.array(door["aabb_m"][end]) for end in ("min", "max"))
    around = storey.cells_around([low[:2] - DOOR_M, high[:2] + DOOR_M])
    return bool((np.abs(storey.height_m[around] - low[2]) < DOOR_M).any())


def passages(export, door, index):
    """What a door is on a storey; on the ground outdoors, which has no doors of its own, what it is on that of its floor."""
    of_storeys = door["attributes"].get("passage", {})
    if export.storeys[index].is_outdoors:
        bottom_m = door["aabb_m"]["min"][2]
        nearest = min(of_storeys, key=lambda k: abs(export.storeys[int(k)].floor_z_m - bottom_m), default=None)
        return {of_storeys.get(nearest)}
    return {of_storeys.get(str(index))}


def along(line):
    """Places half a cell apart on a line."""
    steps = [np.linspace(a, b, 2 + int(2 * np.hypot(*(b - a)))) for a, b in zip(line, line[1:])]
    return np.concatenate(steps)


def check_door(export, edge, ends, line):
    name, door = f"edge {edge['id']}", export.elements.get(edge["of"], {})
    if door.get("class") != "door" or not any(n["kind"] == "door" and n["of"] == edge["of"] for n in ends):
        yield "door", f"{name} leads through {edge['of']}, which is no door with a node at one end"
        return
    attributes, storey = door["attributes"], export.storeys[ends[0]["storey"]]
    if not passages(export, door, ends[0]["storey"]) & set(CAN_PASS):
        yield "door", f"{name} leads through the door {edge['of']}, which is closed to the robot"
    if edge["clear_width_m"] is None or abs(edge["clear_width_m"] - attributes["clear_width_m"]) > ROUNDED_M:
        yield "door", f"the door of {name} is {attributes['clear_width_m']} m wide, the export has {edge['clear_width_m']} m"
    if beside_m(storey, door, line) > DOOR_M:
        yield "door", f"{name} does not come to its door {edge['of']}"
    for node in (n for n in ends if n["kind"] != "door" and None not in attributes["spaces"]):
        polygons = [export.spaces[space_id]["polygon_m"] for space_id in attributes["spaces"]]
        if max(depth_m(polygon, [node["x_m"], node["y_m"]])[0] for polygon in polygons) < -export.resolution_m:
            yield "door", f"{name} leads to node {node['id']}, which is in neither space of its door"


def beside_m(storey, door, line):
    """How far a line stays off the box of a door."""
    low, high = (storey.places(door["aabb_m"][end][:2])[0] for end in ("min", "max"))
    places = along(line)
    return np.hypot(*np.maximum(np.maximum(low - places, places - high), 0).T).min() * storey.resolution_m


def check_portal(export, edge, ends):
    name, robot = f"the {edge['class']} {edge['id']}", export.robot
    (a, b), element = ends, export.elements.get(edge["of"])
    is_of_nothing = element is None and not (edge["class"] in ("step", "ground") and edge["of"] is None)
    if is_of_nothing or a["storey"] == b["storey"] or {a["of"], b["of"]} != {edge["of"]}:
        yield "portal", f"{name} does not join two storeys by an element, with a place before it on either"
        return
    rise_m, plan_m = abs(b["z_m"] - a["z_m"]), math.dist((a["x_m"], a["y_m"]), (b["x_m"], b["y_m"]))
    line = [(*point, z_m) for point, z_m in zip(edge["line_m"], edge["line_z_m"])]
    length_m = sum(math.dist(p, q) for p, q in zip(line, line[1:]))
    # Every point is rounded.
    if abs(edge["length_m"] - length_m) > ROUNDED_M * len(line):
        yield "portal", f"{name} is {length_m:.4f} m long, the export has {edge['length_m']} m"
    for node, point in zip(ends, (line[0], line[-1])):
        if abs(node["z_m"] - point[2]) > ROUNDED_M:
            yield "portal", f"the line of {name} does not end at the height of node {node['id']}"
    if abs(b["z_m"] - a["z_m"] - edge["rise_m"]) > ROUNDED_M:
        yield "portal", f"{name} rises by {b['z_m'] - a['z_m']:.4f} m, the export has {edge['rise_m']} m"
    can_take = {"stair": robot["climbs_stairs"], "lift": True, "escalator": False,
                "ramp": (edge["slope_rad"] or 0) <= robot["max_slope_rad"] + 2e-3,
                "ground": True,
                "step": rise_m <= robot["step_height_m"] + ROUNDED_M or robot["climbs_stairs"] and rise_m <= 0.25}
    if edge["class"] == "ground" and (plan_m > ROUNDED_M or rise_m > robot["step_height_m"] + ROUNDED_M):
        yield "portal", f"{name} joins two places: they are {plan_m:.3f} m apart, and {rise_m:.3f} m in height"
    if edge["usable"] and not can_take.get(edge["class"], False):
        yield "portal", f"{name} cannot be taken by this robot"


def check_connected(export, index):
    """All nodes in a part of the storey that the robot gets to hang together over its floor; outdoors, where no waypoint tells which
    these are, those that the report names."""
    beside = {}
    for edge in export.graph["edges"]:
        if edge["class"] in ("floor", "door"):
            beside.setdefault(edge["from"], []).append(edge["to"])
            beside.setdefault(edge["to"], []).append(edge["from"])
    storey, reached = export.storeys[index], export.reached(index)
    if storey.is_outdoors:
        told = export.report["storeys"][index]["reach"]["parts"]
        reached = sorted({storey.part_at(storey.places(p["at_m"])[0]) for p in told if p["reached"]} - {0})
    for part in reached:
        own = {n["id"] for n in export.graph["nodes"] if (n["storey"], n["part"]) == (index, part)}
        found, waiting = set(), sorted(own)[:1]
        while waiting:
            node = waiting.pop()
            if node not in found:
                found.add(node)
                waiting.extend(beside.get(node, []))
        if not own <= found:
            yield "connected", f"{len(own - found)} of {len(own)} nodes of storey {index} are not joined with the others"


def check_drive(export):
    """Time and energy of edges over floor: there and back differ by what the rise between the ends takes, and what falls gives nothing."""
    drive, tour_m = export.plan.get("drive"), sum(s["tour_m"] for s in export.plan["storeys"])
    speed_m_s = drive["speed_m_s"] if drive else tour_m / (export.plan["driving_s"] or math.inf) or math.inf
    climb_s_per_m, mass_kg = (drive["climb_s_per_m"], drive["mass_kg"]) if drive else (0, None)
    if export.plan["driving_s"] < tour_m / speed_m_s - ROUNDED_M * len(export.storeys) / speed_m_s:
        yield "drive", f"tours of {tour_m:.3f} m take {export.plan['driving_s']} s"
    if (mass_kg is not None) != ("mission_wh" in export.plan):
        yield "drive", "energies are told without a mass, or none with one"
    for edge in export.graph["edges"]:
        name, is_told = f"edge {edge['id']}", "duration_s" in edge
        if is_told != (drive is not None or bool(edge["slope_rad"])) or ("energy_wh" in edge) != (mass_kg is not None):
            yield "drive", f"{name} tells {'a' if is_told else 'no'} time with the slope {edge['slope_rad']}"
        elif is_told and edge["class"] in ("floor", "door"):
            level_s, rise_m = edge["length_m"] / speed_m_s, edge["rise_m"] or 0.0
            # Ends are at the heights of their cells, climbs between the middles of cells.
            off_m = 2 * export.resolution_m * math.tan(edge["slope_rad"] or 0) + 2 * ROUNDED_M
            for time_s, energy_wh, up_m in zip(edge["duration_s"], edge.get("energy_wh", (None, None)), (rise_m, -rise_m)):
                climb_m = edge["length_m"] * math.sin(edge["slope_rad"] or 0) + off_m
                least_s = level_s + climb_s_per_m * max(up_m - off_m, 0.0) - ROUNDED_M / speed_m_s
                if not least_s <= time_s <= level_s + climb_s_per_m * climb_m + ROUNDED_M / speed_m_s:
                    yield "drive", f"{name} rises by {up_m:.3f} m over {edge['length_m']} m in {time_s} s"
                if energy_wh is not None:
                    yield from check_energy(drive, edge, name, time_s, energy_wh, (up_m - off_m, climb_m))
            if abs(edge["duration_s"][0] - edge["duration_s"][1] - climb_s_per_m * rise_m) > climb_s_per_m * off_m + 2 * ROUNDED_M:
                yield "drive", f"{name} takes {edge['duration_s']} s there and back, and rises by {rise_m} m"


def check_energy(drive, edge, name, time_s, energy_wh, climbs_m):
    """The energy is that of rolling, of at least the rise and at most all climbs, and of what runs all the time."""
    plan_m = sum(math.dist(a, b) for a, b in zip(edge["line_m"], edge["line_m"][1:]))
    work_j = [9.80665 * drive["mass_kg"] * (up_m + drive["rolling_resistance"] * plan_m) for up_m in climbs_m]
    least_wh, most_wh = ((max(w, 0.0) / drive["drive_efficiency"] + drive["idle_w"] * time_s) / 3600 for w in work_j)
    if not least_wh - ROUNDED_M <= energy_wh <= most_wh + ROUNDED_M:
        yield "drive", f"{name} takes {energy_wh} Wh, and {least_wh:.4f} to {most_wh:.4f} by its rise"


def check_routes(export):
    """The storeys' files for Nav2 hold the nodes and usable edges of the graph, edges in both directions, with the costs asked for."""
    cost_key = {"time": "duration_s", "energy": "energy_wh"}.get(export.plan.get("drive", {}).get("cost"))
    for index, features in export.routes.items():
        ids = [f["properties"]["id"] for f in features]
        if len(set(ids)) != len(ids):
            yield "route", f"two features of the route of storey {index} have one id"
        exported = {}
        for feature in features:
            properties, geometry = feature["properties"], feature["geometry"]
            # A way to another storey is a collection of one line, which Nav2 skips.
            geometry = geometry["geometries"][0] if geometry["type"] == "GeometryCollection" else geometry
            coordinates = geometry["coordinates"]
            if geometry is not feature["geometry"] or geometry["type"] == "Point":
                exported[properties["id"]] = coordinates
            else:
                edge = properties["startid"], properties["endid"], properties["cost"], str(coordinates)
                exported[edge] = properties["metadata"]["class"]
        nodes = [node for node in export.graph["nodes"] if node["storey"] == index]
        wanted = {node["id"]: [node["x_m"], node["y_m"]] for node in nodes}
        for edge in export.graph["edges"]:
            if edge["usable"] and edge["from"] in wanted and edge["to"] in wanted:
                ways = (edge["from"], edge["to"], edge["line_m"]), (edge["to"], edge["from"], edge["line_m"][::-1])
                for (a, b, line), cost in zip(ways, edge.get(cost_key, 2 * [edge["length_m"]])):
                    wanted[a, b, cost, str([line])] = edge["class"]
            elif (edge["from"] in wanted) != (edge["to"] in wanted):
                wanted[edge["id"]] = [[*point, z_m] for point, z_m in zip(edge["line_m"], edge["line_z_m"])]
        if exported != wanted:
            n = sum(exported.get(k) != wanted.get(k) for k in {**exported, **wanted})
            yield "route", f"{n} nodes or edges of storey {index} are not the same in route.geojson and site-graph.json"
