#!/usr/bin/env python3
"""Judges the files for Open-RMF of an output folder by its maps, its route graph and its elements.

    python3 scripts/check_open_rmf.py OUT..             judge folders that `groundplan convert MODEL -o OUT --open-rmf` wrote
    python3 scripts/check_open_rmf.py --damage OUT..    damage the files, too; each damage must be noticed

Needs PyYAML, networkx and numpy. Exit codes: 0 all is as it should be, 1 it is not, 2 something cannot be read.

The building map and the navigation graph are read by PyYAML, reachability is networkx's. That Open-RMF's own reader loads the building
map and the site, and finds the same in both, is tested in tests/tests/open_rmf.rs.

- The three files have the same levels, doors, lifts and names of vertices, each once, and each thing is at the same place in all.
- The navigation graph is what `building_map_generator nav` makes of the building map: vertices with lanes, each lane in both directions,
  the names of doors that lanes cross, the lift in whose cabin a vertex lies.
- It is a graph that `rmf_fleet_adapter` takes: names once, lifts that are known, cabins one above the other.
- Lanes lie on free cells of planning.pgm of their level, but for those into lifts.
- Rooms are joined by lanes and lifts exactly if site-graph.json joins them on one storey or by lifts that this robot takes.
- Walls lie on occupied cells of it, but for glass and their ends.
- Doors are elements that stand finished, and lie within their bounds; levels have the heights of floors that the manifest tells.
"""
import argparse
import copy
import json
import math
import pathlib
import sys

import networkx
import numpy as np
import yaml

FREE, OCCUPIED = 254, 0
# Rounding to tenths of a millimetre.
SAME_M = 1e-3
# Bounds of a door's body, which may be narrower than its opening.
DOOR_M = 0.15


def read_pgm(path):
    data = path.read_bytes()
    fields, at = [], 2
    while len(fields) < 3:
        end = at
        while not data[end : end + 1].isspace():
            end += 1
        if end > at:
            fields.append(int(data[at:end]))
        at = end + 1
    width, height, _ = fields
    # The first row of an image is the upper one.
    return np.frombuffer(data[-width * height :], np.uint8).reshape(height, width)[::-1]


class Folder:
    def __init__(self, out):
        load = lambda name: json.loads((out / name).read_text(encoding="utf-8"))
        self.manifest, self.graph, self.semantic = load("manifest.json"), load("site-graph.json"), load("semantic.json")
        (building,) = (out / "open-rmf").glob("*.building.yaml")
        (site,) = (out / "open-rmf").glob("*.site.json")
        self.files = {
            "building": yaml.safe_load(building.read_text(encoding="utf-8")),
            "site": json.loads(site.read_text(encoding="utf-8")),
            "nav": yaml.safe_load((out / "open-rmf/nav_graphs/0.yaml").read_text(encoding="utf-8")),
        }
        self.storeys = {storey["index"]: storey for storey in self.manifest["storeys"]}
        self.maps = {k: read_pgm(out / storey["directory"] / "planning.pgm") for k, storey in self.storeys.items()}
        self.listed = [p.relative_to(out).as_posix() in self.manifest["files"] for p in (out / "open-rmf").rglob("*.*")]

    def level_of(self, names):
        """Storeys by the name of their level."""
        found = {}
        for index, storey in self.storeys.items():
            own = storey["name"] or ""
            for name in (own, f"{own} ({index})".strip()):
                if name in names:
                    found[name] = index
        return found

    def cells_along(self, storey, a, b):
        record, resolution = self.storeys[storey], self.manifest["resolution_m"]
        n = max(2, math.ceil(math.dist(a, b) / (resolution / 2)) + 1)
        places = np.array(a) + np.linspace(0, 1, n)[:, None] * (np.array(b) - np.array(a))
        cells = np.floor((places - np.array(record["origin_m"])) / resolution).astype(int)
        inside = ((cells >= 0) & (cells < np.array(record["size_cells"]))).all(axis=1)
        return self.maps[storey][cells[inside, 1], cells[inside, 0]] if inside.all() else np.zeros(1, np.uint8)


def crosses(a, b, c, d):
    """The rule of building_map_generator."""
    area = (a[0] - b[0]) * (c[1] - d[1]) - (a[1] - b[1]) * (c[0] - d[0])
    if abs(area) < 0.01:
        return False
    t = ((a[0] - c[0]) * (c[1] - d[1]) - (a[1] - c[1]) * (c[0] - d[0])) / area
    u = -((a[0] - b[0]) * (a[1] - c[1]) - (a[1] - b[1]) * (a[0] - c[0])) / area
    return 0 <= t <= 1 and 0 <= u <= 1


def near(a, b):
    return math.dist(a, b) <= SAME_M


def partition(graph, rooms):
    parts = networkx.connected_components(graph)
    return {frozenset(rooms[node] for node in part if node in rooms) for part in parts} - {frozenset()}


class Judge:
    def __init__(self, folder):
        self.folder = folder

    def judge(self, files):
        """What is wrong with files: a sentence each."""
        wrong = []

        def expect(is_so, what):
            if not is_so:
                wrong.append(what)

        expect(all(self.folder.listed), "the manifest does not list the files")
        try:
            self.judge_places(files, expect)
            self.judge_nav(files, expect)
            self.judge_maps(files, expect)
            self.judge_rooms(files, expect)
            self.judge_doors(files, expect)
        except (KeyError, IndexError, TypeError, ValueError) as why:
            wrong.append(f"they do not hang together: {why!r}")
        return wrong

    def judge_places(self, files, expect):
        building, site = files["building"], files["site"]
        levels = {level["properties"]["name"]: level for level in site["levels"].values()}
        expect(building["coordinate_system"] == "cartesian_meters", "coordinates are not in Cartesian metres")
        expect(len(levels) == len(site["levels"]) and set(levels) == set(building["levels"]) == set(files["nav"]["levels"]), "levels differ")
        storeys = self.folder.level_of(building["levels"])
        expect(len(storeys) == len(self.folder.storeys), "levels are not the storeys of the manifest")
        names = []
        for name, level in building["levels"].items():
            floor = self.folder.storeys[storeys[name]]["floor_z_m"]
            heights = [level["elevation"], levels[name]["properties"]["elevation"]]
            expect(all(abs(height - floor) <= SAME_M for height in heights), f"{name} has another height than its floor")
            anchors = levels[name]["anchors"]
            own = [v for v in level["vertices"] if "lift_cabin" not in v[4]]
            told = [anchor["Translate2D"] for _, anchor in sorted(anchors.items(), key=lambda item: int(item[0]))]
            expect(len(own) == len(told) and all(near(v[:2], at) for v, at in zip(own, told)), f"{name}: vertices are not at the anchors of the site")
            names += [v[3] for v in level["vertices"] if v[3]]
            doors = {door["name"]: [anchors[str(end)]["Translate2D"] for end in door["anchors"]] for door in levels[name]["doors"].values()}
            told = {door[2]["name"][1]: [level["vertices"][end][:2] for end in door[:2]] for door in level["doors"]}
            expect(len(told) == len(level["doors"]) and set(doors) == set(told), f"{name}: doors differ")
            expect(all(near(a, b) for door in set(doors) & set(told) for a, b in zip(doors[door], told[door])), f"{name}: doors are at other places in the site")
        located = [location["name"] for location in site["navigation"]["guided"]["locations"].values()]
        expect(len(set(names)) == len(names), "a name of a vertex is used twice")
        expect(sorted(names) == sorted(located), "names of places differ between the building map and the site")
        self.n_names = len(names)

    def judge_nav(self, files, expect):
        building, nav = files["building"], files["nav"]
        expect(nav["building_name"] == building["name"], "the navigation graph is of another building")
        doors, with_lanes, named = {}, set(), []
        for name, level in building["levels"].items():
            graph = nav["levels"][name]
            place = lambda v: tuple(round(c, 4) for c in v[:2])
            named += [v[2]["name"] for v in graph["vertices"] if v[2]["name"]]
            own = {door[2]["name"][1]: [level["vertices"][end][:2] for end in door[:2]] for door in level["doors"]}
            doors.update({door: (name, ends) for door, ends in own.items()})
            lanes = [(place(level["vertices"][a]), place(level["vertices"][b])) for a, b, _ in level["lanes"]]
            told = [(place(graph["vertices"][a]), place(graph["vertices"][b])) for a, b, _ in graph["lanes"]]
            expect(sorted(lanes + [(b, a) for a, b in lanes]) == sorted(told), f"{name}: lanes are not those of the building map in both directions")
            used = {place(level["vertices"][end]) + (level["vertices"][end][3],) for lane in level["lanes"] for end in lane[:2]}
            expect({place(v) + (v[2]["name"],) for v in graph["vertices"]} == used, f"{name}: vertices are not those that lanes use, with their names")
            with_lanes |= {vertex[2] for vertex in used if vertex[2]}
            for a, b, facts in graph["lanes"]:
                ends = [graph["vertices"][end][:2] for end in (a, b)]
                crossed = [door for door, at in own.items() if crosses(*ends, *at)]
                asked = facts.get("door_name")
                expect(asked in crossed if crossed else asked is None or self.is_way_through(name, asked, ends, files), f"{name}: a lane crosses {crossed} and asks for {asked}")
            for vertex in graph["vertices"]:
                expect(vertex[2].get("lift") is None or vertex[2]["lift"] in nav["lifts"], f"{name}: a vertex is in a lift that is not known")
        expect(len(set(named)) == len(named), "a name of a vertex is used twice in the navigation graph")
        expect(set(named) == with_lanes, "names differ between the building map and the navigation graph")
        told = {door: (facts["map"], facts["endpoints"]) for door, facts in nav["doors"].items()}
        expect(set(told) == set(doors) and all(told[d][0] == doors[d][0] and all(map(near, told[d][1], doors[d][1])) for d in doors if d in told), "doors differ between the building map and the navigation graph")
        lifts = {name: [lift["x"], lift["y"], lift["yaw"], lift["width"], lift["depth"]] for name, lift in building["lifts"].items()}
        expect({name: lift["position"] + lift["dims"] for name, lift in nav["lifts"].items()} == lifts, "lifts differ between the building map and the navigation graph")
        for name, lift in building["lifts"].items():
            inside = [v[:2] for level in nav["levels"].values() for v in level["vertices"] if v[2].get("lift") == name]
            expect(all(near(place, [lift["x"], lift["y"]]) for place in inside), f"{name}: vertices in its cabin are not in its middle")
            expect(len(set(lift["level_doors"])) > 1 and set(lift["level_doors"]) <= set(building["levels"]), f"{name} joins no two levels")

    def is_way_through(self, level, door, ends, files):
        """True for a way of the route graph through a door of another level, or where it rounds to beside the opening."""
        ids = {d[2]["name"][1]: d[2]["ifc_guid"][1] for of in files["building"]["levels"].values() for d in of["doors"]}
        storey = self.folder.level_of(files["building"]["levels"])[level]
        graph = self.folder.graph
        ways = [e for e in graph["edges"] if e["class"] == "door" and e["of"] == ids.get(door) and graph["nodes"][e["from"]]["storey"] == storey]
        points = [p for way in ways for p in way["line_m"]]
        return all(any(near(end, p) for p in points) for end in ends)

    def judge_maps(self, files, expect):
        nav = files["nav"]
        storeys = self.folder.level_of(nav["levels"])
        self.n_lanes, off = 0, []
        for name, level in nav["levels"].items():
            for a, b, _ in level["lanes"]:
                ends = [level["vertices"][end] for end in (a, b)]
                if any("lift" in end[2] for end in ends):
                    continue
                self.n_lanes += 1
                cells = self.folder.cells_along(storeys[name], ends[0][:2], ends[1][:2])
                off += [] if (cells == FREE).all() else [(name, ends[0][:2], ends[1][:2])]
        shares = []
        for name, level in files["building"]["levels"].items():
            for a, b, _ in level["walls"]:
                cells = self.folder.cells_along(storeys[name], level["vertices"][a][:2], level["vertices"][b][:2])
                shares.append((cells == OCCUPIED).mean())
        self.n_walls = len(shares)
        expect(not shares or np.mean(np.array(shares) > 0.8) > 0.9, f"{sum(share <= 0.8 for share in shares)} of {len(shares)} walls do not lie on occupied cells")
        expect(not off, f"{len(off)} lanes do not lie on free cells: {off[:2]}")

    def judge_rooms(self, files, expect):
        """Rooms that hang together, by GlobalId."""
        nav, graph = files["nav"], self.folder.graph
        found, rooms = networkx.Graph(), {}
        cabins = {}
        for name, level in nav["levels"].items():
            for k, vertex in enumerate(level["vertices"]):
                found.add_node((name, k))
                if "lift" in vertex[2]:
                    cabins.setdefault(vertex[2]["lift"], []).append((name, k))
                elif "ifc_guid" in vertex[2]:
                    rooms[name, k] = vertex[2]["ifc_guid"]
            found.add_edges_from(((name, a), (name, b)) for a, b, _ in level["lanes"])
        for of in cabins.values():
            found.add_edges_from(zip(of, of[1:]))
        wanted, by_node = networkx.Graph(), {}
        for edge in graph["edges"]:
            ends = [graph["nodes"][edge[end]] for end in ("from", "to")]
            if edge["usable"] and (edge["class"] == "lift" or ends[0]["storey"] == ends[1]["storey"]):
                wanted.add_edge(edge["from"], edge["to"])
        for node in graph["nodes"]:
            if node["kind"] == "space":
                by_node[node["id"]] = node["of"]
        wanted_parts = partition(wanted, by_node)
        expect(partition(found, rooms) == wanted_parts, "lanes join other rooms than the route graph does")
        self.n_rooms, self.n_parts = sum(map(len, wanted_parts)), len(wanted_parts)

    def judge_doors(self, files, expect):
        self.n_doors = 0
        for name, level in files["building"]["levels"].items():
            for a, b, facts in level["doors"]:
                self.n_doors += 1
                id, ends = facts["ifc_guid"][1], [level["vertices"][end][:2] for end in (a, b)]
                element = self.folder.semantic["elements"][id]
                state = (element["schedule"] or {}).get("state")
                expect(state in (None, "built"), f"{id} is {state} and hangs")
                low, high = (np.array(element["aabb_m"][end][:2]) for end in ("min", "max"))
                middle = (np.array(ends[0]) + np.array(ends[1])) / 2
                expect((low - DOOR_M <= middle).all() and (middle <= high + DOOR_M).all(), f"{id} is not where its body is")
                expect(0.3 <= math.dist(*ends), f"{id} is {math.dist(*ends):.2f} m wide")


def damages(files, folder):
    """Files with something wrong in each, and words of what has to be found in it."""

    def changed(change):
        damaged = copy.deepcopy(files)
        change(damaged)
        return damaged

    def n_lanes(name):
        level = files["nav"]["levels"][name]
        return len(level["lanes"]) if sum(v[2]["name"] != "" for v in level["vertices"]) > 1 else -1

    nav_level = max(files["nav"]["levels"], key=n_lanes)
    named = next(v for v in files["nav"]["levels"][nav_level]["vertices"] if v[2]["name"])[2]["name"]

    def turned_round(f):
        for level in f["building"]["levels"].values():
            for vertex in level["vertices"]:
                vertex[1] = -vertex[1]

    def all_turned_round(f):
        turned_round(f)
        for level in f["site"]["levels"].values():
            for anchor in level["anchors"].values():
                anchor["Translate2D"][1] *= -1
        for level in f["nav"]["levels"].values():
            for vertex in level["vertices"]:
                vertex[1] = -vertex[1]
        for door in f["nav"]["doors"].values():
            for end in door["endpoints"]:
                end[1] = -end[1]

    def other_name(f):
        for vertex in f["nav"]["levels"][nav_level]["vertices"]:
            vertex[2]["name"] = vertex[2]["name"].replace(named, f"{named}?")

    def one_direction(f):
        del f["nav"]["levels"][nav_level]["lanes"][0]

    def without_a_room(f):
        level = f["nav"]["levels"][nav_level]
        room = next(k for k, v in enumerate(level["vertices"]) if v[2]["name"] == named)
        level["lanes"] = [lane for lane in level["lanes"] if room not in lane[:2]]

    places = [v[:2] for v in files["nav"]["levels"][nav_level]["vertices"]]
    storey = folder.level_of(files["nav"]["levels"])[nav_level]
    is_lane = lambda k: "lift" not in files["nav"]["levels"][nav_level]["vertices"][k][2]
    pairs = [(a, b) for a in range(len(places)) for b in range(a) if is_lane(a) and is_lane(b)]
    walled = next((pair for pair in pairs if not (folder.cells_along(storey, *(places[k] for k in pair)) == FREE).all()), None)

    def through_walls(f):
        f["nav"]["levels"][nav_level]["lanes"].append([*walled, {}])

    def twice(f):
        named_ones = [v for v in f["building"]["levels"][nav_level]["vertices"] if v[3]]
        named_ones[-1][3] = named_ones[0][3]

    def higher(f):
        f["building"]["levels"][nav_level]["elevation"] += 0.1

    cases = {
        "y turned round in the building map": (turned_round, "are not at the anchors"),
        "y turned round in all files": (all_turned_round, "do not lie on free cells"),
        "another name of a room in the navigation graph": (other_name, "names"),
        "a lane in one direction alone": (one_direction, "in both directions"),
        "a room without lanes": (without_a_room, "lanes join other rooms"),
        "a name twice": (twice, "used twice"),
        "a level 0.1 m higher": (higher, "another height"),
    }
    walls = [(level, wall) for level in files["building"]["levels"].values() for wall in level["walls"]]
    if walls:

        def other_walls(f):
            for level in f["building"]["levels"].values():
                for wall in level["walls"]:
                    level["vertices"][wall[0]][0] += 1.5
                    level["vertices"][wall[0]][1] += 1.5

        cases["walls that are turned"] = (other_walls, "walls do not lie on occupied cells")
    if walled:
        cases["a lane through walls"] = (through_walls, "do not lie on free cells")
    asked = [lane for level in files["nav"]["levels"].values() for lane in level["lanes"] if "door_name" in lane[2]]
    if asked:

        def unasked(f):
            for level in f["nav"]["levels"].values():
                for lane in level["lanes"]:
                    lane[2].pop("door_name", None)

        cases["lanes that ask for no door"] = (unasked, "and asks for None")
    at = [(name, k) for name, level in files["building"]["levels"].items() for k, _ in enumerate(level["doors"])]
    if at:
        name, k = at[0]

        def moved(f):
            level = f["building"]["levels"][name]
            for end in level["doors"][k][:2]:
                level["vertices"][end][0] += 1.0

        def all_moved(f):
            moved(f)
            door = f["building"]["levels"][name]["doors"][k][2]["name"][1]
            for end in f["nav"]["doors"][door]["endpoints"]:
                end[0] += 1.0

        cases["a door 1 m beside its place"] = (moved, "doors differ between the building map and the navigation graph")
        cases["a door 1 m beside its place in both"] = (all_moved, "is not where its body is")
    return {what: (changed(change), word) for what, (change, word) in cases.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--damage", action="store_true", help="damage the files, too: each damage must be noticed")
    parser.add_argument("out", type=pathlib.Path, nargs="+", metavar="OUT")
    options = parser.parse_args()
    failed = 0
    for out in options.out:
        try:
            judge = Judge(Folder(out))
        except (OSError, KeyError, ValueError, yaml.YAMLError) as why:
            print(f"{out} cannot be read: {why!r}", file=sys.stderr)
            return 2
        files = judge.folder.files
        wrong = judge.judge(files)
        if not wrong:
            print(
                f"{out}: {len(files['building']['levels'])} levels, {judge.n_lanes} lanes there or back, {judge.n_doors} doors, {judge.n_walls} walls,"
                f" {len(files['building']['lifts'])} lifts, {judge.n_names} names, {judge.n_rooms} rooms in {judge.n_parts} parts"
            )
        if options.damage:
            for what, (damaged, word) in damages(files, judge.folder).items():
                found = [why for why in judge.judge(damaged) if word in why]
                print(f" with {what}: {found[0] if found else 'nothing'}")
                if not found:
                    wrong.append(f"not noticed: {what}")
        print("\n".join(f"FAIL {out}: {why}" for why in wrong) or "PASS")
        failed |= bool(wrong)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
