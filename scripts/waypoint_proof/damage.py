"""Damages copies of an exported map folder, each in one way, so that the proofs can show that they notice.

The folder must hold rooms with one door, a space without a waypoint and a stair, as that of the demo building does.
"""
import contextlib
import json
import shutil
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image

FREE, OCCUPIED = 254, 0


@contextlib.contextmanager
def edited(path):
    """The JSON of a file, written back afterwards."""
    content = json.loads(path.read_text(encoding="utf-8"))
    yield content
    path.write_text(json.dumps(content), encoding="utf-8")


class Copy:
    """A copied folder. The first storey is the one that gets damaged."""

    def __init__(self, out):
        self.out = out
        self.manifest, self.semantic = (json.loads((out / n).read_text()) for n in ("manifest.json", "semantic.json"))
        self.storey = self.manifest["storeys"][0]
        self.folder = out / self.storey["directory"]

    def plan(self):
        return edited(self.out / "waypoints.json")

    def graph(self):
        return edited(self.out / "site-graph.json")

    def draw(self, name, points_m, margin_m, pixel):
        """Sets the pixels of the box around points in a map."""
        pixels = np.flipud(np.asarray(Image.open(self.folder / name))).copy()
        points = (np.array(points_m) - self.storey["origin_m"][:2])
        low, high = (points.min(0) - margin_m, points.max(0) + margin_m)
        (x0, y0), (x1, y1) = (np.floor(p / self.manifest["resolution_m"]).astype(int) for p in (low, high))
        pixels[y0:y1 + 1, x0:x1 + 1] = pixel
        Image.fromarray(np.flipud(pixels)).save(self.folder / name)

    def wall_near(self, w, n_cells):
        """The middle of a cell that is `n_cells` from a wall, of those the nearest to a waypoint."""
        pixels = np.flipud(np.asarray(Image.open(self.folder / "planning.pgm")))
        res_m, origin_m = self.manifest["resolution_m"], np.array(self.storey["origin_m"][:2])
        is_wall = pixels == OCCUPIED
        cells = np.argwhere(near(is_wall, n_cells) & (pixels == FREE) if n_cells else is_wall)
        middles = (cells[:, ::-1] + 0.5) * res_m + origin_m
        return middles[np.hypot(*(middles - (w["x_m"], w["y_m"])).T).argmin()].tolist()


def near(cells, n):
    """The cells and those up to `n` away along both axes."""
    for axis in (0, 1):
        cells = np.any([np.roll(cells, k, axis) for k in range(-n, n + 1)], axis=0)
    return cells


def a_scan(plan, best=lambda w: 0):
    """Of the scans in spaces of the first storey the one with the most of something."""
    return max((w for w in plan["waypoints"] if w["kind"] == "scan" and w["storey"] == 0 and w["space"]), key=best)


def door_of_a_room(copy, graph):
    """The edges of a door whose room has no other, on the map of the room: the ground outdoors may show it, too."""
    storey = {node["id"]: node["storey"] for node in graph["nodes"]}
    for space in copy.semantic["spaces"].values():
        doors = [e for e in graph["edges"] if e["class"] == "door" and e["of"] in space["doors"]]
        own = [e for e in doors if storey[e["from"]] == space["storey"]]
        if space["storey"] == 0 and len(space["doors"]) == 1 and len(own) == 2:
            return own
    raise LookupError("no room has one door")


# ------------------------------------------------------------------ damages, by what must notice them


def a_waypoint_in_a_wall(copy):
    with copy.plan() as plan:
        w = a_scan(plan)
        w["x_m"], w["y_m"] = copy.wall_near(w, 0)
    return {"free"}


def a_waypoint_too_near_a_wall(copy):
    with copy.plan() as plan:
        w = a_scan(plan)
        w["x_m"], w["y_m"] = copy.wall_near(w, 1)
    return {"clear"}


def a_waypoint_out_of_its_space(copy):
    with copy.plan() as plan:
        w = a_scan(plan)
        other = next(o for o in plan["waypoints"] if o["storey"] == 0 and o["space"] not in (None, w["space"]))
        w["x_m"], w["y_m"], w["clearance_m"] = other["x_m"], other["y_m"], other["clearance_m"]
    return {"inside"}


def a_waypoint_off_the_floor(copy):
    with copy.plan() as plan:
        a_scan(plan)["z_m"] += 0.5
    return {"height"}


def a_sensor_at_another_height(copy):
    with copy.plan() as plan:
        a_scan(plan)["sensor_z_m"] -= 0.2
    return {"height"}


def a_scan_that_leans(copy):
    with copy.plan() as plan:
        w = a_scan(plan)
        up = [0.05, 0.0, (1 - 0.05 ** 2) ** 0.5]
        place = [w["x_m"], w["y_m"], w["z_m"]]
        w["up"], w["sensor_m"] = up, [at + copy.manifest["robot"]["sensor_height_m"] * u for at, u in zip(place, up)]
        w["sensor_z_m"] = w["sensor_m"][2]
    return {"up", "orientation"}


def a_floor_that_slopes(copy):
    """Heights are drawn under the waypoints of a storey, which stand upright."""
    planning = np.asarray(Image.open(copy.folder / "planning.pgm"))
    rows, columns = np.indices(planning.shape)
    z_m = copy.storey["floor_z_m"]
    values = np.where(planning == FREE, 30_000 + 40 * (columns % 50), 0).astype(np.uint16)
    Image.fromarray(values).save(copy.folder / "elevation.png")
    fields = {"offset": z_m - 3.0, "scale": 1e-4, "none": 0, "origin": copy.storey["origin_m"], "resolution": copy.manifest["resolution_m"]}
    text = "".join(f"{key}: {json.dumps(value)}\n" for key, value in fields.items())
    (copy.folder / "elevation.yaml").write_text(text, encoding="utf-8")
    return {"up"}


def a_quaternion_of_another_heading(copy):
    path = copy.folder / "waypoints.yaml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace("orientation: [", "orientation: [-"), encoding="utf-8")
    return {"orientation"}


def keep_out_around_a_waypoint(copy):
    with copy.plan() as plan:
        w = a_scan(plan)
    copy.draw("keepout.pgm", [[w["x_m"], w["y_m"]]], 0.1, 0)
    return {"free"}


def a_wall_in_the_way(copy):
    with copy.graph() as graph:
        lines = [point for edge in door_of_a_room(copy, graph) for point in edge["line_m"]]
    copy.draw("planning.pgm", lines, copy.manifest["robot"]["radius_m"], OCCUPIED)
    return {"edge", "reach"}


def a_wall_through_a_room(copy):
    with copy.plan() as plan:
        w = a_scan(plan, lambda w: w["covers_m2"])
    copy.draw("planning.pgm", [[w["x_m"] + 0.5, w["y_m"] - 2.0], [w["x_m"] + 0.5, w["y_m"] + 2.0]], 0.0, OCCUPIED)
    return {"faces", "coverage"}


def a_scan_left_out(copy):
    with copy.plan() as plan:
        w = a_scan(plan, lambda w: w["order"])
        plan["waypoints"].remove(w)
        plan["storeys"][0]["scans"] -= 1
        for later in plan["waypoints"]:
            later["order"] -= later["order"] > w["order"]
    return {"coverage"}


def a_scan_that_claims_more_faces(copy):
    with copy.plan() as plan:
        w = a_scan(plan, lambda w: w["faces"])
        w["faces"] = round(1.2 * w["faces"])
    return {"faces"}


def a_scan_that_claims_more_overlap(copy):
    with copy.plan() as plan:
        a_scan(plan, lambda w: -w["overlap"])["overlap"] += 0.1
    return {"overlap"}


def a_scan_that_claims_to_register_better(copy):
    with copy.plan() as plan:
        a_scan(plan, lambda w: -w["registration_overlap"])["registration_overlap"] += 0.1
    return {"registration"}


def a_scan_beside_another(copy):
    with copy.plan() as plan:
        plan["separation_m"] = 50.0
    return {"near"}


def a_curve_that_promises_more(copy):
    with copy.plan() as plan:
        for point in plan["storeys"][0]["curve"]:
            point["coverage"] = 1.5
    return {"curve"}


def a_coverage_that_is_too_good(copy):
    with copy.plan() as plan:
        plan["storeys"][0].update(coverage=1.0, faces=plan["storeys"][0]["faces"] // 2)
        plan["coverage_goal"] = 1.01
    return {"coverage"}


def a_space_that_is_seen_more_than_told(copy):
    with copy.plan() as plan:
        next(s for s in plan["spaces"].values() if s["coverage"])["coverage"] -= 0.1
    return {"coverage"}


def two_waypoints_that_changed_places(copy):
    with copy.plan() as plan:
        ours = sorted((w for w in plan["waypoints"] if w["storey"] == 0), key=lambda w: w["order"])
        ours[1]["order"], ours[-1]["order"] = ours[-1]["order"], ours[1]["order"]
    return {"leg"}


def a_leg_too_short(copy):
    with copy.plan() as plan:
        a_scan(plan, lambda w: w["leg_m"])["leg_m"] *= 0.8
    return {"leg", "tour"}


def a_leg_too_long(copy):
    with copy.plan() as plan:
        a_scan(plan, lambda w: w["leg_m"])["leg_m"] *= 1.3
    return {"leg", "tour"}


def a_space_with_neither_waypoint_nor_reason(copy):
    with copy.plan() as plan:
        next(s for s in plan["spaces"].values() if s["reason"]).update(reason=None, why=None, door=None)
    return {"space"}


def a_reason_that_is_not_true(copy):
    with copy.plan() as plan:
        w = next(w for w in plan["waypoints"] if w["kind"] == "centre")
        plan["spaces"][w["space"]].update(reason="it is too narrow", why="too_narrow")
        plan["waypoints"].remove(w)
    return {"reason"}


def a_node_in_a_wall(copy):
    with copy.graph() as graph:
        node = next(n for n in graph["nodes"] if n["kind"] == "junction" and n["storey"] == 0)
        node["x_m"], node["y_m"] = copy.wall_near(node, 0)
    return {"node", "edge", "route"}


def a_node_of_another_name(copy):
    with copy.graph() as graph:
        next(n for n in graph["nodes"] if n["space_name"])["space_name"] = "elsewhere"
    return {"node"}


def a_part_that_is_not_reached(copy):
    with edited(copy.out / "report.json") as report:
        for part in report["storeys"][0]["reach"]["parts"]:
            part["reached"] = False
    return {"parts"}


def a_part_left_out(copy):
    with edited(copy.out / "report.json") as report:
        report["storeys"][0]["reach"]["parts"].pop()
    return {"parts"}


def an_edge_through_a_wall(copy):
    with copy.graph() as graph:
        floor = next(e for e in graph["edges"] if e["class"] == "floor")
        a, *others = (n for n in graph["nodes"] if n["kind"] == "space" and n["storey"] == 0)
        b = max(others, key=lambda n: abs(n["x_m"] - a["x_m"]))
        line = [[n["x_m"], n["y_m"]] for n in (a, b)]
        length_m = float(np.hypot(*np.subtract(*line)))
        new = dict(floor, id=10 ** 6, to=b["id"], line_m=line, length_m=length_m, clearance_m=0.3)
        graph["edges"].append({**new, "from": a["id"]})
    return {"edge", "route"}


def an_edge_of_a_wrong_length(copy):
    with copy.graph() as graph:
        next(e for e in graph["edges"] if e["class"] == "floor")["length_m"] += 0.05
    return {"edge", "route"}


def an_edge_left_out(copy):
    with copy.graph() as graph:
        graph["edges"].remove(door_of_a_room(copy, graph)[0])
    return {"connected", "route"}


def an_edge_of_another_door(copy):
    with copy.graph() as graph:
        edge = door_of_a_room(copy, graph)[0]
        edge["of"] = next(e["of"] for e in graph["edges"] if e["class"] == "door" and e["of"] != edge["of"])
    return {"door"}


def a_door_closed_to_the_robot(copy):
    with copy.graph() as graph, edited(copy.out / "semantic.json") as semantic:
        door = semantic["elements"][door_of_a_room(copy, graph)[0]["of"]]
        door["attributes"]["passage"]["0"] = "operation"
    return {"door"}


def a_door_elsewhere(copy):
    with copy.graph() as graph, edited(copy.out / "semantic.json") as semantic:
        door = semantic["elements"][door_of_a_room(copy, graph)[0]["of"]]
        for end in ("min", "max"):
            door["aabb_m"][end][0] += 3.0
    return {"door"}


def a_stair_for_a_robot_on_wheels(copy):
    with copy.graph() as graph:
        next(e for e in graph["edges"] if e["class"] == "stair")["usable"] = True
    return {"portal"}


def a_plan_by_time_without_times(copy):
    with copy.plan() as plan:
        plan["drive"] = {"cost": "time", "speed_m_s": 0.5, "climb_s_per_m": 10.0, "mass_kg": None}
    return {"drive"}


def an_edge_that_climbs_in_no_time(copy):
    with copy.plan() as plan, copy.graph() as graph:
        plan["drive"] = {"cost": "length", "speed_m_s": 0.5, "climb_s_per_m": 10.0, "mass_kg": None}
        for edge in graph["edges"]:
            edge["duration_s"] = [edge["length_m"] / 0.5] * 2
        edge = next(e for e in graph["edges"] if e["class"] == "floor")
        edge["rise_m"], edge["slope_rad"] = 1.0, 0.5
    return {"drive"}


def a_route_in_one_direction(copy):
    with edited(copy.folder / "route.geojson") as route:
        edges = [feature for feature in route["features"] if "startid" in feature["properties"]]
        route["features"].remove(edges[-1])
    return {"route"}


DAMAGES = (
    a_waypoint_in_a_wall, a_waypoint_too_near_a_wall, a_waypoint_out_of_its_space, a_waypoint_off_the_floor,
    a_sensor_at_another_height, a_scan_that_leans, a_floor_that_slopes, a_quaternion_of_another_heading, keep_out_around_a_waypoint, a_wall_in_the_way, a_wall_through_a_room, a_scan_left_out,
    a_scan_that_claims_more_faces, a_scan_that_claims_more_overlap, a_scan_that_claims_to_register_better,
    a_scan_beside_another, a_curve_that_promises_more, a_coverage_that_is_too_good,
    a_space_that_is_seen_more_than_told, two_waypoints_that_changed_places, a_leg_too_short, a_leg_too_long,
    a_space_with_neither_waypoint_nor_reason, a_reason_that_is_not_true, a_node_in_a_wall,
    a_node_of_another_name, a_part_that_is_not_reached, a_part_left_out, an_edge_through_a_wall, an_edge_of_a_wrong_length,
    an_edge_left_out,
    an_edge_of_another_door, a_door_closed_to_the_robot, a_door_elsewhere, a_stair_for_a_robot_on_wheels,
    a_plan_by_time_without_times, an_edge_that_climbs_in_no_time, a_route_in_one_direction,
)


def damaged(out, checks_that_fail):
    """Of each damage its name, the checks that must notice it, and those that did, as `checks_that_fail` says of a folder."""
    for damage in DAMAGES:
        with tempfile.TemporaryDirectory() as folder:
            copied = Path(folder) / "copy"
            shutil.copytree(out, copied)
            must = damage(Copy(copied))
            yield damage.__name__.replace("_", " "), must, checks_that_fail(copied)
