#!/usr/bin/env python3
"""Judges the flight waypoints of an output folder by the bodies that IfcOpenShell makes of the model.

    python3 scripts/check_flight.py MODEL OUT             judge a folder that `groundplan convert MODEL -o OUT --waypoints ..` wrote
    python3 scripts/check_flight.py --damage MODEL OUT    damage the document, too; each damage must be noticed

MODEL is the IFC file. Needs ifcopenshell and numpy. Exit codes: 0 all is as it should be, 1 it is not, 2 something cannot be read.

Bodies, their openings and their places come from IfcOpenShell; which elements stand and which rooms are blocked from semantic.json, the
map frame from site-frame.json. Distances are those of triangles, computed here.

- Each waypoint keeps the clearance in all directions, within the 5 mm by which bodies differ, and lies within no closed body.
- Its clearance is that of the nearest triangle, and `nearest` is an element as near as that: 2 cm, of 99 %.
- So does each edge, at places 10 cm apart; no edge is longer than the spacing in plan; parts are what edges connect.
- `height_above_ground_m` is one of the heights, and so far below it lies ground: a face of a slab, covering, ramp, terrain or pavement,
  of the highest within the clearance around it outdoors.
- No waypoint lies in a room that is blocked, or is said to.
- Over rooms, and over terrain and roads, at places drawn at random: one that keeps the clearance and a step of the lattice more has a
  waypoint near it; where a room has none, there is no such place, nor one farther from everything than it says.
"""
import argparse
import copy
import json
import math
import pathlib
import sys
from collections import defaultdict

import ifcopenshell
import ifcopenshell.geom
import numpy as np

BODY_M, MEASURED_M, AGREE = 5e-3, 2e-2, 0.99
SAMPLE_M = 0.1
N_PLACES = 150
# What is drawn of an element besides its body.
NO_BODIES = ("Clearance", "FootPrint", "Axis", "Annotation", "Box", "Profile", "Reference", "Lighting", "CoG")
GROUND = (
    "IfcSlab", "IfcCovering", "IfcRamp", "IfcRampFlight", "IfcSite", "IfcRoad", "IfcGeographicElement", "IfcPavement", "IfcCourse",
    "IfcEarthworks", "IfcKerb", "IfcFooting", "IfcCivilElement", "IfcGeotechnicalStratum", "IfcSolidStratum",
)
OUTDOORS = (
    "IfcSite", "IfcRoad", "IfcGeographicElement", "IfcPavement", "IfcCourse", "IfcEarthworks", "IfcKerb", "IfcCivilElement",
    "IfcGeotechnicalStratum", "IfcSolidStratum",
)
# Ground within this of what is said: cells of the maps show the height in their middle.
GROUND_M, GROUND_OUTDOORS_M = 0.02, 0.08
# So far above a floor something is not another one.
FLOOR_M = 0.3


class Bodies:
    """Triangles of what stands, by GlobalId, and of blocked rooms; in `map`."""

    def __init__(self, model, out):
        semantic = json.loads((out / "semantic.json").read_text(encoding="utf-8"))
        frame = json.loads((out / "site-frame.json").read_text(encoding="utf-8"))["map_from_world"]
        cos, sin = math.cos(frame["yaw_rad"]), math.sin(frame["yaw_rad"])
        self.turn = np.array([[cos, -sin, 0], [sin, cos, 0], [0, 0, 1]])
        self.shift = np.array([frame["x_m"], frame["y_m"], frame["z_m"]])
        self.spaces = semantic["spaces"]
        state = lambda element: (element["schedule"] or {}).get("state")
        absent = {id for id, element in semantic["elements"].items() if state(element) in ("not_started", "removed")}
        stands = set(semantic["elements"]) - absent
        blocked = {id for id, space in self.spaces.items() if space["state"] == "blocked" and not space.get("metadata_only")}
        file = ifcopenshell.open(str(model))
        settings = ifcopenshell.geom.settings()
        settings.set("use-world-coords", True)
        self.ids, self.types, meshes = [], [], []
        self.rooms = []
        iterator = ifcopenshell.geom.iterator(settings, file, 2, exclude=["IfcOpeningElement", "IfcVirtualElement", "IfcAnnotation"])
        going = iterator.initialize()
        while going:
            shape = iterator.get()
            self.add(shape, stands, meshes)
            going = iterator.next()
        for space in file.by_type("IfcSpace"):
            if space.GlobalId in blocked and space.Representation:
                shape = ifcopenshell.geom.create_shape(settings, space)
                self.rooms.append((space.GlobalId, self.corners(shape)))
        self.of = np.concatenate([np.full(len(mesh), k) for k, mesh in enumerate(meshes)])
        self.triangles = np.concatenate(meshes)
        self.low, self.high = self.triangles.min(axis=1), self.triangles.max(axis=1)
        ground = np.array([self.types[k].startswith(GROUND) for k in range(len(self.ids))])
        normals = np.cross(self.triangles[:, 1] - self.triangles[:, 0], self.triangles[:, 2] - self.triangles[:, 0])
        length = np.linalg.norm(normals, axis=1)
        # Open terrain may be turned either way.
        steep = np.abs(normals[:, 2]) > 0.3 * np.maximum(length, 1e-12)
        self.ground = self.triangles[ground[self.of] & steep]
        outdoors = np.array([self.types[k].startswith(OUTDOORS) for k in range(len(self.ids))])
        self.outdoors = self.triangles[outdoors[self.of] & steep]

    def corners(self, shape):
        vertices = np.array(shape.geometry.verts).reshape(-1, 3) @ self.turn.T + self.shift
        return vertices[np.array(shape.geometry.faces, int).reshape(-1, 3)]

    def add(self, shape, stands, meshes):
        is_terrain = shape.type in ("IfcSite", "IfcRoad", "IfcRoadPart", "IfcFacility", "IfcFacilityPart")
        is_body = shape.context not in NO_BODIES and len(shape.geometry.faces) > 0
        if (shape.guid in stands or is_terrain) and is_body:
            self.ids.append(shape.guid)
            self.types.append(shape.type)
            meshes.append(self.corners(shape))


def dot(a, b):
    return np.einsum("...k,...k->...", a, b)


def distances(places, triangles):
    """Distance of each place from the triangle in the same row."""
    best = np.full(len(places), np.inf)
    for k in range(3):
        a, along = triangles[:, k], triangles[:, (k + 1) % 3] - triangles[:, k]
        share = np.clip(dot(places - a, along) / np.maximum(dot(along, along), 1e-18), 0, 1)
        best = np.minimum(best, np.linalg.norm(places - a - share[:, None] * along, axis=1))
    normal = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    area = np.linalg.norm(normal, axis=1)
    over = area > 1e-12
    for k in range(3):
        side = np.cross(triangles[:, (k + 1) % 3] - triangles[:, k], places - triangles[:, k])
        over &= dot(side, normal) >= 0
    height = np.abs(dot(places - triangles[:, 0], normal)) / np.maximum(area, 1e-12)
    return np.where(over, np.minimum(best, height), best)


def nearest(places, bodies, reach):
    """Distance to the nearest triangle, at most `reach`, and by body as near as within 2 cm of it, of each place."""
    least, found = np.full(len(places), reach), [set() for _ in places]
    # Places near each other look at the same triangles.
    order = np.lexsort(np.floor(places / 4.0).T)
    for start in range(0, len(order), 200):
        part = order[start : start + 200]
        at = places[part]
        around = (bodies.high >= at.min(axis=0) - reach) & (bodies.low <= at.max(axis=0) + reach)
        near = np.flatnonzero(around.all(axis=1))
        off = np.maximum(np.maximum(bodies.low[near] - at[:, None], at[:, None] - bodies.high[near]), 0)
        place, candidate = np.nonzero(dot(off, off) < reach * reach)
        far = distances(at[place], bodies.triangles[near[candidate]])
        np.minimum.at(least, part[place], far)
        for k in np.flatnonzero((far <= least[part[place]] + MEASURED_M) & (far < reach)):
            found[part[place[k]]].add(bodies.ids[bodies.of[near[candidate[k]]]])
    return least, found


def heights_over(at, triangles):
    """Heights of triangles at a place in plan."""
    a, b, c = (triangles[:, k, :2] for k in range(3))
    turn = lambda p, q: p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]
    area = turn(b - a, c - a)
    shares = np.stack([turn(b - at, c - at), turn(c - at, a - at), turn(a - at, b - at)]) / np.where(area == 0, np.inf, area)
    inside = (shares >= -1e-9).all(axis=0) & (area != 0)
    return (shares[:, inside] * triangles[inside, :, 2].T).sum(axis=0)


def disc(radius):
    """Places over a disc, its rim included."""
    places = [(0.0, 0.0)]
    for share in (1 / 3, 2 / 3, 1.0):
        places += [(share * radius * math.cos(a), share * radius * math.sin(a)) for a in np.arange(0, 2 * math.pi, math.pi / 8)]
    return np.array(places)


def bodies_around(at, triangles, of):
    """Numbers of closed bodies that a place lies within: the line upwards meets faces that look up more often than others, or less."""
    above = triangles[:, :, 2].max(axis=1) > at[2]
    low, high = triangles[:, :, :2].min(axis=1), triangles[:, :, :2].max(axis=1)
    # Off the lattice, where the line would meet sides of faces.
    plan = at[:2] + [1.234e-5, 0.777e-5]
    near = above & ((low <= plan) & (plan <= high)).all(axis=1)
    sums = defaultdict(int)
    for corners, body in zip(triangles[near], of[near]):
        z = heights_over(plan, corners[None])
        if len(z) and z[0] > at[2]:
            u, v = corners[1] - corners[0], corners[2] - corners[0]
            sums[body] += 1 if u[0] * v[1] - u[1] * v[0] > 0 else -1
    return {body for body, turns in sums.items() if turns != 0}


def is_closed(corners):
    """True if each edge is used as often in one direction as in the other."""
    keys = np.round(corners * 1e4).astype(np.int64)
    count = defaultdict(int)
    for triangle in keys:
        points = [tuple(p) for p in triangle]
        for k in range(3):
            a, b = points[k], points[(k + 1) % 3]
            if a != b:
                count[(min(a, b), max(a, b))] += 1 if a < b else -1
    return all(n == 0 for n in count.values())


class Judge:
    def __init__(self, model, out):
        self.bodies = Bodies(model, out)
        self.flight = json.loads((out / "flight.json").read_text(encoding="utf-8"))
        manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
        self.ground_storeys = {storey["index"] for storey in manifest["storeys"] if storey["floor"] == "ground"}
        self.is_listed = "flight.json" in manifest["files"]
        closed = {}
        for k in range(len(self.bodies.ids)):
            closed[k] = is_closed(self.bodies.triangles[self.bodies.of == k])
        self.closed = closed
        self.drawn, self.drawn_outdoors = {}, []
        # What was found of places before they were damaged.
        self.bodies_around, self.over_ground, self.along = {}, {}, {}

    def places(self, space, height, ground_m):
        """Places drawn over a room."""
        rng = np.random.default_rng(abs(hash((space["floor_z_m"], height))) % 2**32)
        rings = [ring for polygon in space["polygon_m"] for ring in polygon]
        corners = np.array([p for ring in rings for p in ring])
        places = rng.uniform(corners.min(axis=0), corners.max(axis=0), (N_PLACES, 2))
        inside = np.zeros(N_PLACES, bool)
        for ring in rings:
            a = np.array(ring)
            for p, q in zip(a, np.roll(a, -1, axis=0)):
                crosses = (p[1] > places[:, 1]) != (q[1] > places[:, 1])
                with np.errstate(divide="ignore", invalid="ignore"):
                    x = p[0] + (places[:, 1] - p[1]) * (q[0] - p[0]) / (q[1] - p[1])
                inside ^= crosses & (places[:, 0] < x)
        z = np.full((inside.sum(), 1), ground_m + height)
        return np.hstack([places[inside], z])

    def judge(self, flight):
        """What is wrong with a document: a sentence each."""
        wrong = []

        def expect(is_so, what):
            if not is_so:
                wrong.append(what)

        clearance, step = flight["clearance_m"], flight["step_m"] or 0.0
        waypoints = flight["waypoints"]
        expect(flight["frame"] == "map" and [w["id"] for w in waypoints] == list(range(len(waypoints))), "ids are not in order")
        at = np.array([[w["x_m"], w["y_m"], w["z_m"]] for w in waypoints]).reshape(-1, 3)
        least, found = nearest(at, self.bodies, flight["measured_m"])
        expect((least >= clearance - BODY_M).all(), f"waypoints are nearer than {clearance} m to a body: {least.min():.3f} m")
        told = np.array([w["clearance_m"] for w in waypoints])
        expect((np.abs(told - least) <= MEASURED_M).mean() >= AGREE, "clearances are not those measured")
        is_nearest = [w["nearest"] in found[k] or w["nearest"] is None and not found[k] for k, w in enumerate(waypoints)]
        expect(np.mean(is_nearest) >= AGREE, "`nearest` names bodies that are not")
        within = [w["id"] for w, place in zip(waypoints, at) if any(self.closed[k] for k in self.around(place))]
        expect(not within, f"waypoints lie within bodies: {within[:5]}")
        blocked = [w["id"] for w, place in zip(waypoints, at) if self.is_blocked(w, place)]
        expect(not blocked, f"waypoints lie in rooms that are blocked: {blocked[:5]}")
        off = []
        for waypoint, place in zip(waypoints, at):
            key = (*place, waypoint["height_above_ground_m"], waypoint["storey"])
            if key not in self.over_ground:
                self.over_ground[key] = self.is_over_ground(flight, waypoint, place)
            off += [] if self.over_ground[key] else [waypoint["id"]]
        expect(not off, f"waypoints are not as high above the ground as they say: {off[:5]} of {len(off)}")
        self.judge_edges(flight, at, expect)
        self.judge_rooms(flight, at, step, expect)
        self.judge_outdoors(flight, at, step, expect)
        expect(self.is_listed, "the manifest does not list the document")
        return wrong

    def around(self, place):
        key = tuple(place)
        if key not in self.bodies_around:
            self.bodies_around[key] = bodies_around(place, self.bodies.triangles, self.bodies.of)
        return self.bodies_around[key]

    def is_blocked(self, waypoint, place):
        space = self.bodies.spaces.get(waypoint["space"])
        inside = (bodies_around(place, corners, np.zeros(len(corners), int)) for _, corners in self.bodies.rooms)
        return space is not None and space["state"] == "blocked" or any(inside)

    def is_over_ground(self, flight, waypoint, place):
        if waypoint["height_above_ground_m"] not in flight["heights_m"]:
            return False
        want = place[2] - waypoint["height_above_ground_m"]
        is_outdoors = waypoint["storey"] in self.ground_storeys
        near_m = GROUND_OUTDOORS_M if is_outdoors else GROUND_M
        radius = flight["clearance_m"]
        samples = self.ground_around(self.bodies.ground, place, radius)
        below = np.concatenate(samples)
        below = below[below < place[2]]
        here = samples[0][samples[0] < place[2]]
        if not len(here) or here.max() > want + (near_m if is_outdoors else FLOOR_M):
            return False
        if is_outdoors:
            terrain = np.concatenate(self.ground_around(self.bodies.outdoors, place, radius))
            highest = max(terrain[terrain < place[2]], default=-math.inf)
            # Floor to which one gets from the ground may lie higher.
            return abs(highest - want) <= near_m or highest < want and np.abs(below - want).min() <= near_m
        return np.abs(below - want).min() <= near_m

    def ground_around(self, triangles, place, radius):
        """Heights of triangles at places over a disc, its middle first."""
        low, high = triangles[:, :, :2].min(axis=1), triangles[:, :, :2].max(axis=1)
        near = triangles[((low <= place[:2] + radius) & (high >= place[:2] - radius)).all(axis=1)]
        return [heights_over(place[:2] + off, near) for off in disc(radius)]

    def judge_edges(self, flight, at, expect):
        clearance, long, new = flight["clearance_m"], 0, {}
        part = list(range(len(at)))

        def first(k):
            while part[k] != k:
                part[k] = part[part[k]]
                k = part[k]
            return k

        for a, b in flight["edges"]:
            long += np.linalg.norm(at[a, :2] - at[b, :2]) > flight["spacing_m"] + 1e-6
            key = (*at[a], *at[b])
            if key not in self.along:
                n = max(2, math.ceil(np.linalg.norm(at[a] - at[b]) / SAMPLE_M) + 1)
                new[key] = at[a] + np.linspace(0, 1, n)[:, None] * (at[b] - at[a])
            part[max(first(a), first(b))] = min(first(a), first(b))
        expect(long == 0, f"{long} edges are longer than the spacing")
        if new:
            places = np.concatenate(list(new.values()))
            distance, _ = nearest(places, self.bodies, clearance + 0.1)
            ends = np.cumsum([len(line) for line in new.values()])
            self.along.update((key, of.min()) for key, of in zip(new, np.split(distance, ends[:-1])))
            inside = [1 for _, corners in self.bodies.rooms for p in places[::3] if bodies_around(p, corners, np.zeros(len(corners), int))]
            expect(not inside, "edges lead through rooms that are blocked")
        least = min((self.along[(*at[a], *at[b])] for a, b in flight["edges"]), default=math.inf)
        expect(least >= clearance - BODY_M, f"edges come nearer than {clearance} m to a body: {least:.3f} m")
        numbers = defaultdict(set)
        for k, waypoint in enumerate(flight["waypoints"]):
            numbers[waypoint["part"]].add(first(k))
        connected = len({first(k) for k in range(len(at))})
        expect(all(len(of) == 1 for of in numbers.values()) and len(numbers) == connected == flight["parts"], "parts are not what edges connect")

    def judge_rooms(self, flight, at, step, expect):
        """Places over rooms that have room for the drone have a waypoint near them."""
        clearance, bare, more = flight["clearance_m"], [], []
        n = 0
        for global_id, told in flight["spaces"].items():
            space = self.bodies.spaces[global_id]
            own = [w for w in flight["waypoints"] if w["space"] == global_id]
            if space["state"] == "blocked" or space["storey"] is None or not space["polygon_m"] or space.get("external"):
                continue
            for entry in told["heights"]:
                here = [w["id"] for w in own if w["height_above_ground_m"] == entry["height_m"]]
                expect(len(here) == entry["waypoints"], f"{global_id}: another number of waypoints is told")
                expect((entry["why"] is None) == (len(here) > 0), f"{global_id}: a reason is told although there are waypoints, or none")
                if entry["why"] not in (None, "too_narrow"):
                    continue
                ground = {round(w["z_m"] - w["height_above_ground_m"], 4) for w in own} or {space["floor_z_m"]}
                # Where the floor of a room is not level its places have no height that is known here.
                if len(ground) > 1:
                    continue
                places = self.drawn.get((global_id, entry["height_m"]))
                if places is None:
                    places = self.places(space, entry["height_m"], *ground)
                    least, _ = nearest(places, self.bodies, 5.0)
                    solid = np.array([any(self.closed[k] for k in self.around(p)) for p in places], bool)
                    room = np.array([bool(len(self.floor(p, space))) for p in places], bool)
                    places = self.drawn[global_id, entry["height_m"]] = (places[~solid & room], least[~solid & room])
                places, least = places
                n += len(places)
                free = places[least >= clearance + 1.5 * step + 0.05]
                if len(here):
                    off = np.linalg.norm(free[:, None, :2] - at[here][None, :, :2], axis=2).min(axis=1) if len(free) else np.zeros(0)
                    bare += [global_id] * int((off > flight["spacing_m"] / 2 + 1.5 * step).sum())
                elif len(free):
                    bare.append(global_id)
                if entry["largest_clearance_m"] is not None and len(least):
                    more += [global_id] * int(least.max() > entry["largest_clearance_m"] + step + 0.05)
        self.n_drawn = n
        expect(not bare, f"places over rooms are free and have no waypoint near them: {sorted(set(bare))[:5]}")
        expect(not more, f"places over rooms are farther from everything than it is told: {sorted(set(more))[:5]}")

    def judge_outdoors(self, flight, at, step, expect):
        """Places over terrain and roads that have room for the drone have a waypoint near them, on slopes as anywhere."""
        over = np.array([w["storey"] in self.ground_storeys for w in flight["waypoints"]], bool)
        if not over.any():
            return
        if not self.drawn_outdoors:
            rng = np.random.default_rng(5)
            low, high = at[over].min(axis=0), at[over].max(axis=0)
            for x, y in rng.uniform(low[:2], high[:2], (4 * N_PLACES, 2)):
                around = self.ground_around(self.bodies.outdoors, np.array([x, y, 0.0]), flight["clearance_m"])
                floors = heights_over(np.array([x, y]), self.bodies.ground)
                # What has a floor over it may be indoors.
                if len(around[0]) and floors.max() <= around[0].max() + 0.05:
                    self.drawn_outdoors.append([x, y, np.concatenate(around).max() + flight["heights_m"][0]])
        places = np.array(self.drawn_outdoors).reshape(-1, 3)
        least, _ = nearest(places, self.bodies, 5.0)
        free = places[least >= flight["clearance_m"] + 1.5 * step + 0.05]
        level = at[np.array([w["height_above_ground_m"] == flight["heights_m"][0] for w in flight["waypoints"]], bool)]
        off = [np.linalg.norm(place[:2] - level[:, :2], axis=1).min() for place in free]
        self.n_drawn += len(places)
        bare = sum(far > flight["spacing_m"] for far in off)
        expect(bare == 0, f"{bare} of {len(free)} places over the ground outdoors are free and have no waypoint near them")

    def floor(self, place, space):
        heights = heights_over(place[:2], self.bodies.ground)
        return heights[np.abs(heights - space["floor_z_m"]) <= 0.05]


def damages(flight, judge):
    """Documents with something wrong in each, and words of what has to be found in it."""
    chosen = min(flight["waypoints"], key=lambda w: (w["clearance_m"], w["id"]))
    at = np.array([[w["x_m"], w["y_m"], w["z_m"]] for w in flight["waypoints"]])

    def changed(change):
        document = copy.deepcopy(flight)
        change(document)
        return document

    def toward_a_wall(document):
        # The first of those with the least clearance that comes too near to something so: others have it below them.
        turns = np.arange(0, 2 * math.pi, math.pi / 18)
        moves = 0.5 * np.stack([np.cos(turns), np.sin(turns), np.zeros(len(turns))], axis=1)
        for waypoint in sorted(document["waypoints"], key=lambda w: (w["clearance_m"], w["id"])):
            least, _ = nearest(at[waypoint["id"]] + moves, judge.bodies, 1.0)
            if least.min() < document["clearance_m"] - 0.1:
                waypoint["x_m"], waypoint["y_m"] = (at[waypoint["id"]] + moves[least.argmin()])[:2]
                return
        raise ValueError("no waypoint has a wall within half a metre more than its clearance")

    def higher(document):
        document["waypoints"][chosen["id"]]["z_m"] += 0.2

    def said_higher(document):
        document["waypoints"][chosen["id"]]["height_above_ground_m"] += 0.2

    def edge_through_a_wall(document):
        # The nearest pair of waypoints of one height that something stands between.
        pairs = []
        for a in range(len(at)):
            far = np.linalg.norm(at - at[a], axis=1)
            for b in np.flatnonzero((far > 0.1) & (far < flight["spacing_m"])):
                if a < b and [a, int(b)] not in flight["edges"]:
                    pairs.append((far[b], a, int(b)))
        for _, a, b in sorted(pairs):
            line = at[a] + np.linspace(0, 1, 50)[:, None] * (at[b] - at[a])
            if nearest(line, judge.bodies, 1.0)[0].min() < 0.05:
                document["edges"].append([a, b])
                return
        raise ValueError("no two waypoints have a wall between them")

    def without_waypoints_of_a_room(document):
        spaces = [w["space"] for w in document["waypoints"] if w["space"]]
        most = max(sorted(set(spaces)), key=spaces.count)
        kept = [w for w in document["waypoints"] if w["space"] != most]
        number = {w["id"]: k for k, w in enumerate(kept)}
        document["waypoints"] = [dict(w, id=number[w["id"]]) for w in kept]
        document["edges"] = [[number[a], number[b]] for a, b in document["edges"] if a in number and b in number]
        for entry in document["spaces"][most]["heights"]:
            entry.update(waypoints=0, why="too_narrow", reason="no place", largest_clearance_m=0.1)

    def wrong_nearest(document):
        ids = sorted({w["nearest"] for w in document["waypoints"] if w["nearest"]})
        for waypoint in document["waypoints"]:
            waypoint["nearest"] = ids[(ids.index(waypoint["nearest"]) + 1) % len(ids)] if waypoint["nearest"] else None

    def other_parts(document):
        document["waypoints"][-1]["part"] = (document["waypoints"][-1]["part"] + 1) % (document["parts"] + 1)

    def less_clearance(document):
        for waypoint in document["waypoints"]:
            waypoint["clearance_m"] = document["clearance_m"] + 0.3 * waypoint["clearance_m"]

    def without_a_hill(document):
        middle = at[[w["storey"] in judge.ground_storeys for w in document["waypoints"]]].mean(axis=0)
        kept = [w for w, place in zip(document["waypoints"], at) if np.abs(place[:2] - middle[:2]).max() > 12]
        number = {w["id"]: k for k, w in enumerate(kept)}
        document["waypoints"] = [dict(w, id=number[w["id"]]) for w in kept]
        document["edges"] = [[number[a], number[b]] for a, b in document["edges"] if a in number and b in number]

    cases = {
        "a waypoint 0.5 m nearer to a wall": (toward_a_wall, "waypoints are nearer"),
        "a waypoint 0.2 m higher": (higher, "not as high above the ground"),
        "another height above the ground": (said_higher, "not as high above the ground"),
        "an edge through a wall": (edge_through_a_wall, "edges come nearer"),
        "other bodies that are nearest": (wrong_nearest, "`nearest` names"),
        "another part": (other_parts, "parts are not"),
        "clearances that were not measured": (less_clearance, "clearances are not"),
    }
    if any(w["storey"] in judge.ground_storeys for w in flight["waypoints"]):
        cases["ground outdoors without its waypoints"] = (without_a_hill, "places over the ground outdoors")
    if any(w["space"] for w in flight["waypoints"]):
        cases["a room without its waypoints"] = (without_waypoints_of_a_room, "places over rooms are free")
    return {what: (changed(change), word) for what, (change, word) in cases.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--damage", action="store_true", help="damage the document, too: each damage must be noticed")
    parser.add_argument("model", type=pathlib.Path, metavar="MODEL")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT")
    options = parser.parse_args()
    try:
        judge = Judge(options.model, options.out)
    except (OSError, KeyError, ValueError, RuntimeError) as why:
        print(f"{options.out} cannot be read: {why!r}", file=sys.stderr)
        return 2
    flight = judge.flight
    n_triangles = len(judge.bodies.triangles)
    wrong = judge.judge(flight)
    print(
        f"{options.out}: {len(flight['waypoints'])} waypoints, {len(flight['edges'])} edges, {flight['parts']} parts;"
        f" {n_triangles} triangles, {judge.n_drawn} places over rooms"
    )
    if options.damage:
        for what, (document, word) in damages(flight, judge).items():
            found = [why for why in judge.judge(document) if word in why]
            print(f" with {what}: {found[0] if found else 'nothing'}")
            if not found:
                wrong.append(f"not noticed: {what}")
    print("\n".join(f"FAIL {why}" for why in wrong) or "PASS")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
