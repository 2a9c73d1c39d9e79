#!/usr/bin/env python3
"""Judges what the control of fleets reads of output folders: by the formats' own schemas, and against the maps beside it.

    python3 scripts/check_fleet.py OUT..               judge folders that `groundplan convert --fleet vda5050,lif` wrote of one model
    python3 scripts/check_fleet.py --self-test OUT..   damage the first folder's files, too; each damage must be noticed
    python3 scripts/check_fleet.py --store STORE/SITE  judge the exported files of a site in a store, of all sets of its newest index;
                                                       with --self-test damage what the store alone has

Needs numpy, shapely and jsonschema. Exit codes: 0 all is as it should be, 1 it is not, 2 a folder cannot be read.

- Zone sets satisfy the schema of VDA 5050 3.0.0 and its correction, the layouts that of LIF 1.0.0, maps.json ours.
- Zones are simple polygons, counter-clockwise, on the map; BLOCKED ones overlap nowhere, nor do SPEED_LIMIT ones.
- The BLOCKED zones are the cells of keepout.pgm: all of nine places in a cell, up to a hundredth of a cell from its borders, lie in one
  where it is set, and none where it is not. The lowest SPEED_LIMIT at each of them, rounded down as the mask is, is speed.pgm.
- Closed rooms are those that semantic.json has blocked, work is what it has in progress, drop-offs are near cells that are not free.
- There is a RELEASE zone in the footprint of each door that report.json has closed by its operation alone, and no other.
- Files have the hashes and lengths of maps.json, its actions name them, and the tar has the map files of the storey. Of several folders
  the same map has the same id, the same zones have the same id, and others another one.
- The layouts have the nodes, usable ways and centres of site-graph.json and waypoints.json; ends of edges are nodes, curves begin and end
  there, and lines on a storey are on free cells that are not keep-out.

Of a store: each file has the sha256 and the length of its list; files make up such a folder; the maps of VDA 5050 of each set satisfy the
schema, and link files of the list by the address of the store, to be enabled at the plan time where the site follows a clock.

Told, and no error: how much of the lines a robot passes nearer than its radius to a BLOCKED zone, which it must not touch.
"""
import argparse
import copy
import datetime
import hashlib
import io
import json
import math
import pathlib
import re
import sys
import tarfile
import tempfile
import zoneinfo
from collections import Counter

import jsonschema
import numpy as np
import shapely
from shapely.geometry import LineString, MultiPolygon, Polygon, box, shape

ROOT = pathlib.Path(__file__).resolve().parent.parent
FIXTURES = ROOT / "tests/fixtures/fleet"
FREE = 254
# Places in a cell, as shares of its side.
PLACES = (0.01, 0.5, 0.99)
ID = re.compile(r"[A-Za-z0-9_.:-]+")


def read_json(path):
    return json.loads(path.read_text(encoding="utf-8"))


def validator(path, kind):
    return kind(read_json(path), format_checker=kind.FORMAT_CHECKER)


def read_pgm(path):
    """Pixels from the bottom."""
    data = path.read_bytes()
    head = re.match(rb"P5\s+(\d+)\s+(\d+)\s+255\s", data)
    width, height = int(head[1]), int(head[2])
    return np.frombuffer(data, np.uint8, offset=head.end()).reshape(height, width)[::-1]


def corners_of(zone):
    return np.array([[vertex["x"], vertex["y"]] for vertex in zone["vertices"]], float)


class Storey:
    """The maps of a storey."""

    def __init__(self, out, entry):
        self.index, self.name = entry["index"], entry["directory"].split("/")[-1]
        self.folder = out / entry["directory"]
        yaml = (self.folder / "keepout.yaml").read_text(encoding="utf-8")
        self.side = float(re.search(r"resolution: (\S+)", yaml)[1])
        self.origin = np.array([float(c) for c in re.search(r"origin: \[(.*)\]", yaml)[1].split(",")[:2]])
        self.planning, self.keepout = (read_pgm(self.folder / f"{name}.pgm") for name in ("planning", "keepout"))
        self.speed, self.step = None, 1.0
        if (self.folder / "speed.pgm").exists():
            self.speed = np.round((255.0 - read_pgm(self.folder / "speed.pgm")) / 2.55).astype(int)
            self.step = read_json(self.folder / "safety.json")["speed_step_m_s"]

    def bounds(self):
        height, width = self.keepout.shape
        return box(*self.origin, *(self.origin + np.array([width, height]) * self.side))

    def are_passed(self, places):
        """True if places are on cells that are free and not keep-out."""
        column, row = np.floor((places - self.origin) / self.side + 1e-9).astype(int).T
        height, width = self.keepout.shape
        if not ((0 <= row) & (row < height) & (0 <= column) & (column < width)).all():
            return False
        return bool(((self.planning[row, column] == FREE) & (self.keepout[row, column] != 0)).all())

    def painted(self, corners, out, value):
        """Sets the places of cells within a polygon, row of places by row of places, to the lower of what is there and a value."""
        cells = (corners - self.origin) / self.side
        a, b = cells, np.roll(cells, -1, axis=0)
        height, width = self.keepout.shape
        columns = np.add.outer(np.arange(width), PLACES).ravel()
        first, last = max(0, int(cells[:, 1].min())), min(height - 1, int(cells[:, 1].max()))
        for row in range(first, last + 1):
            for k, share in enumerate(PLACES):
                y = row + share
                crosses = (a[:, 1] <= y) != (b[:, 1] <= y)
                p, q = a[crosses], b[crosses]
                x = np.sort(p[:, 0] + (y - p[:, 1]) / (q[:, 1] - p[:, 1]) * (q[:, 0] - p[:, 0]))
                for left, right in zip(x[::2], x[1::2]):
                    inside = slice(*np.searchsorted(columns, [left, right]))
                    out[3 * row + k, inside] = np.minimum(out[3 * row + k, inside], value)

    def lowest(self, zones, value):
        """The lowest value of the zones at each place of each cell; infinite where there is none. Cells by places."""
        height, width = self.keepout.shape
        places = np.full((3 * height, 3 * width), np.inf)
        for zone in zones:
            self.painted(corners_of(zone), places, value(zone))
        return places.reshape(height, 3, width, 3).transpose(0, 2, 1, 3).reshape(height, width, 9)


class Folder:
    """An output folder: what was written for fleets, and what it is judged by."""

    def __init__(self, out):
        self.out = out
        self.manifest = read_json(out / "manifest.json")
        self.storeys = {entry["index"]: Storey(out, entry) for entry in self.manifest["storeys"]}
        self.semantic, self.report = read_json(out / "semantic.json"), read_json(out / "report.json")
        self.graph, self.waypoints = read_json(out / "site-graph.json"), read_json(out / "waypoints.json")
        self.radius = self.manifest["robot"]["radius_m"]

    def written(self):
        """The documents, and the bytes of the files that maps.json names."""
        maps = read_json(self.out / "fleet/vda5050/maps.json")
        paths = [entry[kind]["path"] for entry in maps["maps"] for kind in ("map", "zone_set")]
        return {
            "maps": maps,
            "bytes": {path: (self.out / path).read_bytes() for path in paths},
            "zones": {entry["storey"]: read_json(self.out / entry["zone_set"]["path"]) for entry in maps["maps"]},
            "lif": read_json(self.out / "fleet/lif/site.lif.json"),
        }


class Judge:
    def __init__(self):
        modern, draft7 = jsonschema.Draft202012Validator, jsonschema.Draft7Validator
        self.zone_schemas = {
            name: validator(FIXTURES / f"vda5050/{name}/zoneSet.schema", modern) for name in ("3.0.0", "corrected")
        }
        self.lif_schema = validator(FIXTURES / "lif/lif-schema.json", draft7)
        self.maps_schema = validator(ROOT / "config/schemas/fleet-maps.schema.json", modern)
        self.store_schema = validator(ROOT / "config/schemas/fleet-store-maps.schema.json", modern)

    def judge(self, folder, written):
        self.wrong, self.folder = [], folder
        self.n_zones, self.n_corners = Counter(), 0
        self.schemas(written)
        entries = {entry["storey"]: entry for entry in written["maps"]["maps"]}
        self.check(set(entries) == set(folder.storeys), "maps.json has other storeys than manifest.json")
        for index, message in written["zones"].items():
            self.zone_set(folder.storeys[index], message["zoneSet"], entries[index])
        self.downloads(written, entries)
        self.near_m = self.length_m = 0.0
        self.layouts(written, entries)
        return self.wrong

    def check(self, holds, why):
        if not holds:
            self.wrong.append(why)
        return holds

    def schemas(self, written):
        def valid(schema, document, what):
            for error in list(schema.iter_errors(document))[:3]:
                self.check(False, f"{what}: schema: {error.json_path}: {error.message[:120]}")

        for index, message in written["zones"].items():
            for name, schema in self.zone_schemas.items():
                valid(schema, message, f"zone set of storey {index}, {name}")
        valid(self.lif_schema, written["lif"], "layouts")
        valid(self.maps_schema, written["maps"], "maps.json")

    def zone_set(self, storey, zone_set, entry):
        zones = zone_set["zones"]
        what = f"storey {storey.index}"
        self.check(zone_set["mapId"] == entry["map_id"], f"{what}: the zone set is of another map id than maps.json")
        self.check(zone_set["zoneSetId"] == entry["zone_set_id"], f"{what}: another zone set id than maps.json")
        ids = [zone["zoneId"] for zone in zones]
        self.check(len(set(ids)) == len(ids), f"{what}: ids of zones are not unique")
        self.check(all(ID.fullmatch(id) for id in ids + [zone_set["mapId"]]), f"{what}: an id has other characters")
        by_type = {kind: [zone for zone in zones if zone["zoneType"] == kind] for kind in ("BLOCKED", "SPEED_LIMIT", "RELEASE")}
        self.n_zones.update({kind: len(of) for kind, of in by_type.items()})
        self.check(sum(map(len, by_type.values())) == len(zones), f"{what}: zones of other types")
        bounds = storey.bounds().buffer(1e-6)
        for kind, of in by_type.items():
            shapes = []
            for zone in of:
                corners = corners_of(zone)
                self.n_corners += len(corners)
                shapes.append(polygon := Polygon(corners))
                name = f"{what}: {zone['zoneId']}"
                if not self.check(polygon.is_valid and polygon.area > 0, f"{name} is no simple polygon"):
                    continue
                self.check(polygon.exterior.is_ccw, f"{name} is clockwise")
                self.check(bounds.covers(polygon), f"{name} lies beyond the map")
            sound = [polygon for polygon in shapes if polygon.is_valid]
            if kind != "RELEASE" and sound:
                overlap = sum(p.area for p in sound) - shapely.union_all(sound).area
                self.check(abs(overlap) < 1e-6, f"{what}: {kind} zones overlap by {overlap:.4f} m2")
        self.blocked(storey, by_type["BLOCKED"])
        self.speeds(storey, by_type["SPEED_LIMIT"])
        self.releases(storey, by_type["RELEASE"])

    def blocked(self, storey, zones):
        what, is_set = f"storey {storey.index}", storey.keepout == 0
        inside = np.isfinite(storey.lowest(zones, lambda zone: 0.0))
        n_open, n_more = (is_set & ~inside.all(axis=2)).sum(), (~is_set & inside.any(axis=2)).sum()
        self.check(n_open == 0, f"{what}: {n_open} keep-out cells are not in a BLOCKED zone")
        self.check(n_more == 0, f"{what}: BLOCKED zones hold {n_more} cells that are not keep-out")
        rooms = {self.id(id): space for id, space in self.folder.semantic["spaces"].items()}
        elements = {self.id(id): element for id, element in self.folder.semantic["elements"].items()}
        reach = int(math.ceil(self.folder.manifest["robot"]["edge_margin_m"] / storey.side)) + 2
        near = storey.planning != FREE
        for axis in (0, 1):
            padded = np.pad(near, [(reach, reach) if k == axis else (0, 0) for k in (0, 1)])
            n = near.shape[axis]
            near = np.logical_or.reduce([np.take(padded, range(k, k + n), axis=axis) for k in range(2 * reach + 1)])
        for zone in zones:
            reason, _, rest = zone["zoneId"].rpartition(":")[0].partition(":")
            if reason == "closed-room":
                self.check(rooms.get(rest, {}).get("state") == "blocked", f"{what}: {zone['zoneId']} is no room that is blocked")
            elif reason == "work":
                state = (elements.get(rest, {}).get("schedule") or {}).get("state")
                self.check(state in ("in_progress", "being_removed"), f"{what}: {zone['zoneId']} is not worked on")
            elif self.check(reason == "drop-off", f"{what}: {zone['zoneId']} has no reason"):
                cells = np.isfinite(storey.lowest([zone], lambda zone: 0.0)).all(axis=2)
                n_far = (cells & ~near).sum()
                self.check(n_far == 0, f"{what}: {n_far} cells of {zone['zoneId']} are on floor, far from where there is none")

    @staticmethod
    def id(text):
        return re.sub(r"[^A-Za-z0-9_.:-]", ".", text)

    def speeds(self, storey, zones):
        what = f"storey {storey.index}"
        if storey.speed is None:
            self.check(not zones, f"{what}: SPEED_LIMIT zones, and no speed.pgm")
            return
        lowest = storey.lowest(zones, lambda zone: zone.get("maximumSpeed", math.inf))
        steps = np.where(np.isfinite(lowest), np.clip(np.floor(lowest / storey.step + 1e-9), 1, 100), 0)
        n_other = (steps != storey.speed[:, :, None]).any(axis=2).sum()
        self.check(n_other == 0, f"{what}: SPEED_LIMIT zones differ from speed.pgm in {n_other} cells")

    def releases(self, storey, zones):
        what = f"storey {storey.index}"
        doors = self.folder.report["doors"]
        shut = {
            self.id(door["global_id"]): door["global_id"]
            for door in doors
            if door["storey"] == storey.index and [reason["code"] for reason in door["reasons"]] == ["operation"]
        }
        found = {zone["zoneId"].split(":")[1] for zone in zones}
        self.check(found == set(shut), f"{what}: RELEASE zones of {sorted(found)}, doors that cannot be opened are {sorted(shut)}")
        for zone in zones:
            door = shut.get(zone["zoneId"].split(":")[1])
            prints = self.folder.semantic["elements"].get(door, {}).get("footprints", {})
            if door and str(storey.index) in prints:
                area = shape(prints[str(storey.index)]) if "type" in prints[str(storey.index)] else MultiPolygon(
                    [(p[0], p[1:]) for p in prints[str(storey.index)]]
                )
                share = Polygon(corners_of(zone)).intersection(area.buffer(0.05)).area / max(area.area, 1e-9)
                self.check(share > 0.25, f"{what}: {zone['zoneId']} is not at its door")

    def downloads(self, written, entries):
        maps, manifest = written["maps"], self.folder.manifest
        for key in ("plan_time", "valid_from", "valid_until"):
            self.check(maps[key] == manifest[key], f"maps.json has another {key} than manifest.json")
        ids = [entry["map_id"] for entry in entries.values()]
        self.check(len(set(ids)) == len(ids), "storeys share a map id")
        for index, entry in entries.items():
            what = f"storey {index}"
            for kind in ("map", "zone_set"):
                told, data = entry[kind], written["bytes"][entry[kind]["path"]]
                same = told["sha256"] == hashlib.sha256(data).hexdigest() == manifest["files"][told["path"]]
                self.check(same and told["bytes"] == len(data), f"{what}: hash or length of {told['path']} is another one")
            storey = self.folder.storeys[index]
            with tarfile.open(fileobj=io.BytesIO(written["bytes"][entry["map"]["path"]])) as tar:
                inside = {member.name: tar.extractfile(member).read() for member in tar}
            names = [f"{layer}.{kind}" for layer in ("planning", "localization", "keepout") for kind in ("pgm", "yaml")]
            same = set(inside) == set(names) and all(inside[name] == (storey.folder / name).read_bytes() for name in names)
            self.check(same, f"{what}: the tar has other files than the storey's folder")
            version = {"mapId": entry["map_id"], "mapVersion": entry["map_version"]}
            of_set = {"zoneSetId": entry["zone_set_id"]}
            expected = [
                ("downloadMap", version | {"mapDownloadLink": entry["map"]["path"], "mapHash": entry["map"]["sha256"]}),
                ("downloadZoneSet", of_set | {"zoneSetDownloadLink": entry["zone_set"]["path"], "zoneSetHash": entry["zone_set"]["sha256"]}),
                ("enableMap", version),
                ("enableZoneSet", of_set),
            ]
            actions = entry["download"] + entry["enable"]
            told = [(a["actionType"], {p["key"]: p["value"] for p in a["actionParameters"]}) for a in actions]
            self.check(told == expected, f"{what}: actions do not say what maps.json does")
            self.check(all(a["blockingType"] == "NONE" for a in actions), f"{what}: an instant action blocks")

    def layouts(self, written, entries):
        layouts, graph = written["lif"]["layouts"], self.folder.graph
        map_ids = {entry["map_id"]: index for index, entry in entries.items()}
        self.check({layout["layoutId"] for layout in layouts} == set(map_ids), "layouts are of other maps than maps.json")
        nodes = {node["nodeId"]: (layout["layoutId"], node) for layout in layouts for node in layout["nodes"]}
        self.check(len(nodes) == sum(len(layout["nodes"]) for layout in layouts), "ids of nodes are not unique")
        edges = [edge["edgeId"] for layout in layouts for edge in layout["edges"]]
        self.check(len(set(edges)) == len(edges), "ids of edges are not unique")
        self.check(all(ID.fullmatch(id) for id in [*nodes, *edges]), "an id of a node or edge has other characters")
        places = lambda found: Counter(found)
        told = places((map_ids.get(node["mapId"]), node["nodePosition"]["x"], node["nodePosition"]["y"]) for _, node in nodes.values())
        meant = places((node["storey"], node["x_m"], node["y_m"]) for node in graph["nodes"])
        self.check(told == meant, "layouts have other nodes than site-graph.json")
        self.check(all(node["mapId"] == layout for layout, node in nodes.values()), "a node is of another map than its layout")
        n_usable = sum(edge["usable"] for edge in graph["edges"])
        self.check(len(edges) == 2 * n_usable, f"{len(edges)} edges, site-graph.json has {n_usable} usable ways")
        centres = Counter((w["storey"], w["x_m"], w["y_m"]) for w in self.folder.waypoints["waypoints"] if w["kind"] == "centre")
        for layout in layouts:
            index = map_ids.get(layout["layoutId"])
            if index is not None:
                self.layout(layout, self.folder.storeys[index], nodes, written["zones"][index])
            for station in layout["stations"]:
                at = station["stationPosition"]
                known = all(id in nodes for id in station["interactionNodeIds"])
                self.check(known and (index, at["x"], at["y"]) in centres, f"station {station['stationId']} is no centre of a room")
        n_stations = sum(len(layout["stations"]) for layout in layouts)
        self.check(n_stations == sum(centres.values()), f"{n_stations} stations, waypoints.json has {sum(centres.values())} centres")

    def layout(self, layout, storey, nodes, message):
        what = f"storey {storey.index}"
        lines = []
        for edge in layout["edges"]:
            ends = [nodes.get(edge[key]) for key in ("startNodeId", "endNodeId")]
            if not self.check(all(ends) and ends[0][0] == layout["layoutId"], f"{what}: {edge['edgeId']} does not begin at a node of it"):
                continue
            line = [[node["nodePosition"]["x"], node["nodePosition"]["y"]] for _, node in ends]
            curve = edge["vehicleTypeEdgeProperties"][0].get("trajectory")
            if curve:
                points = [[point["x"], point["y"]] for point in curve["controlPoints"]]
                knots = curve["knotVector"]
                sound = len(knots) == len(points) + curve["degree"] + 1 and knots == sorted(knots) and knots[0] == 0 and knots[-1] == 1
                self.check(curve["degree"] == 1 and sound, f"{what}: knots of {edge['edgeId']}")
                ends_m = max(math.dist(a, b) for a, b in zip((points[0], points[-1]), line))
                self.check(ends_m < 2e-4, f"{what}: {edge['edgeId']} ends {ends_m:.3f} m from its nodes")
                line = points
            if ends[1][0] == layout["layoutId"]:
                lines.append((edge, line))
        blocked = shapely.union_all([p for z in message["zoneSet"]["zones"] if z["zoneType"] == "BLOCKED" and (p := Polygon(corners_of(z))).is_valid])
        touching = blocked.buffer(self.folder.radius)
        shapely.prepare(touching)
        off = []
        for edge, line in lines:
            places = [np.array(line[:1])]
            for a, b in zip(np.array(line), np.array(line)[1:]):
                n = max(1, int(math.ceil(np.linalg.norm(b - a) / (storey.side / 2))))
                places.append(a + (b - a) * (np.arange(1, n + 1) / n)[:, None])
            if not storey.are_passed(np.concatenate(places)):
                off.append(edge["edgeId"])
            way = LineString(line)
            self.length_m += way.length
            self.near_m += way.intersection(touching).length if touching.intersects(way) else 0.0
        self.check(not off, f"{what}: {len(off)} edges leave the free cells, {off[:1]}")


def blob(site, entry):
    """The bytes of a blob."""
    data = (site / "blobs" / entry["id"][:2] / entry["id"]).read_bytes()
    if hashlib.sha256(data).hexdigest() != entry["id"] or len(data) != entry["bytes"]:
        raise ValueError(f"the blob {entry['id']} has other bytes")
    return data


def exported(site, home):
    """The exported files of all sets of the newest index of a site, each in a folder, with what a store has beside them."""
    index = json.loads((site / "current.jsonl").read_text(encoding="utf-8").splitlines()[2])
    zone = index["clock"]["wall"]["zone"] if isinstance(index["clock"], dict) else None
    for place, plan in enumerate(index["sets"]):
        for robot, maps in plan["robots"].items():
            files = maps["files"]
            if files is None:
                continue
            out = home / f"{place}-{robot}"
            listed = {entry["path"]: entry for entry in json.loads(blob(site, files["list"]))["files"]}
            for path, entry in listed.items():
                (out / path).parent.mkdir(parents=True, exist_ok=True)
                (out / path).write_bytes(blob(site, entry))
            in_store = json.loads(blob(site, files["vda5050_maps"])) if files["vda5050_maps"] else None
            yield out, listed, in_store, {"site": index["site"], "robot": robot, "zone": zone, "plan_time_s": plan["plan_time_s"]}


def judged_in_store(judge, out, listed, in_store, about):
    """What is wrong with the maps of VDA 5050 as a store has them."""
    wrong = [f"{error.json_path}: {error.message[:120]}" for error in list(judge.store_schema.iter_errors(in_store))[:3]]
    if wrong:
        return wrong
    for key in ("site", "robot"):
        if in_store[key] != about[key]:
            wrong.append(f"the maps are of another {key}: {in_store[key]}")
    enable_at = None
    if about["zone"] and about["plan_time_s"] is not None:
        civil = datetime.datetime.fromtimestamp(about["plan_time_s"], datetime.timezone.utc).replace(tzinfo=zoneinfo.ZoneInfo(about["zone"]))
        enable_at = civil.astimezone(datetime.timezone.utc).strftime("%Y-%m-%dT%H:%M:%SZ")
    if in_store["enable_at"] != enable_at:
        wrong.append(f"the maps are enabled at {in_store['enable_at']}, the plan time is {enable_at}")
    # With paths of the output folder in the place of links it is the document of that folder.
    paths = {f"{about['site']}/blobs/{entry['id'][:2]}/{entry['id']}": path for path, entry in listed.items()}
    text = json.dumps({key: value for key, value in in_store.items() if key not in ("site", "robot", "enable_at")})
    links = re.findall(rf'"({re.escape(about["site"])}/blobs/[^"]*)"', text)
    for link in links:
        if link not in paths:
            wrong.append(f"{link} is no file of the list")
        text = text.replace(link, paths.get(link, link))
    n_links = 4 * len(in_store["maps"])
    if len(links) != n_links or json.loads(text) != read_json(out / "fleet/vda5050/maps.json"):
        wrong.append(f"{len(links)} links, and {n_links} files to download: maps.json says something else")
    return wrong


def damages_in_store(in_store):
    """Damaged documents of a store, with a word of what has to be said of each."""

    def changed(change):
        damaged = copy.deepcopy(in_store)
        change(damaged)
        return damaged

    first = lambda document: document["maps"][0]
    parameters = lambda document: {p["key"]: p for p in first(document)["download"][0]["actionParameters"]}
    other = first(in_store)["zone_set"]["path"]
    return {
        "another site": (changed(lambda d: d.__setitem__("site", "x")), "another site"),
        "another robot": (changed(lambda d: d.__setitem__("robot", "x")), "another robot"),
        "another instant": (changed(lambda d: d.__setitem__("enable_at", "2031-01-01T00:00:00Z")), "the plan time is"),
        "a link to no file": (changed(lambda d: first(d)["map"].__setitem__("path", other[:-1] + "x")), "is no file of the list"),
        "a link to another file": (changed(lambda d: parameters(d)["mapDownloadLink"].__setitem__("value", other)), "something else"),
        "another hash": (changed(lambda d: parameters(d)["mapHash"].__setitem__("value", "0" * 64)), "something else"),
        "a document without its protocol": (changed(lambda d: d.pop("protocol")), "protocol"),
    }


def judge_store(site, self_test):
    """Judges the exported files of a site; true if something is wrong."""
    judge, failed, n_sets = Judge(), False, 0
    with tempfile.TemporaryDirectory() as home:
        for out, listed, in_store, about in exported(site, pathlib.Path(home)):
            n_sets += 1
            folder = Folder(out)
            wrong = judge.judge(folder, folder.written()) if "fleet/lif/site.lif.json" in listed and in_store else []
            if in_store:
                wrong += judged_in_store(judge, out, listed, in_store, about)
                for what, (damaged, word) in damages_in_store(in_store).items() if self_test else ():
                    found = [why for why in judged_in_store(judge, out, listed, damaged, about) if word in why]
                    print(f" with {what}: {found[0] if found else 'nothing'}")
                    wrong += [] if found else [f"not noticed: {what}"]
            sums = folder.manifest["files"] | {"manifest.json": listed["manifest.json"]["id"]}
            if sums != {path: entry["id"] for path, entry in listed.items()}:
                wrong.append("the list has other files than manifest.json")
            print(f"{out.name}: {len(listed)} files of {folder.manifest['plan_time']}, enabled at {in_store and in_store['enable_at']}")
            print("\n".join(f"FAIL {why}" for why in wrong) or "PASS")
            failed |= bool(wrong)
    if n_sets == 0:
        print("FAIL no set of the newest index has exported files")
    return failed or n_sets == 0


def compared(all_written):
    """What differs between dates that should not."""
    wrong, maps, sets = [], {}, {}
    for written in all_written:
        for entry in written["maps"]["maps"]:
            if maps.setdefault(entry["storey"], entry["map_id"]) != entry["map_id"]:
                wrong.append(f"storey {entry['storey']} has several map ids")
            for id, hash in ((entry["zone_set_id"], entry["zone_set"]["sha256"]), (entry["map_version"], entry["map"]["sha256"])):
                if sets.setdefault(id, hash) != hash:
                    wrong.append(f"{id} is several contents")
    if len(set(sets.values())) != len(sets):
        wrong.append("one content has several ids")
    return wrong


def damages(folder, written):
    """Damaged documents, with a word of what has to be said of each."""

    def changed(change):
        damaged = copy.deepcopy(written)
        change(damaged)
        return damaged

    def zones(document, kind):
        return [(m["zoneSet"]["zones"], z) for m in document["zones"].values() for z in m["zoneSet"]["zones"] if z["zoneType"] == kind]

    def largest(document, kind):
        return max(zones(document, kind), key=lambda of: abs(Polygon(corners_of(of[1])).area))

    def without(kind):
        def change(document):
            of, zone = largest(document, kind)
            of.remove(zone)
        return change

    def shifted(kind):
        def change(document):
            for vertex in largest(document, kind)[1]["vertices"]:
                vertex["x"] += 1.0
        return change

    def of_zone(kind, key, value):
        return lambda document: largest(document, kind)[1].__setitem__(key, value)

    def turned(document):
        largest(document, "BLOCKED")[1]["vertices"].reverse()

    def crossed(document):
        vertices = min((z["vertices"] for _, z in zones(document, "BLOCKED")), key=len)
        vertices[0], vertices[1] = vertices[1], vertices[0]

    def grown(document):
        side = next(iter(folder.storeys.values())).side
        zone = min((z for _, z in zones(document, "BLOCKED")), key=lambda z: len(z["vertices"]))
        right = max(vertex["x"] for vertex in zone["vertices"])
        for vertex in zone["vertices"]:
            vertex["x"] += side if vertex["x"] == right else 0.0

    def hash_of(document):
        document["maps"]["maps"][0]["zone_set"]["sha256"] = "0" * 64

    def other_map(document):
        document["maps"]["maps"][0]["map_id"] += ":x"

    def map_byte(document):
        path = document["maps"]["maps"][0]["map"]["path"]
        data = bytearray(document["bytes"][path])
        data[1000] ^= 1
        document["bytes"][path] = bytes(data)

    def later(document):
        document["maps"]["valid_from"] = "2031-01-01T00:00:00"

    def action(document):
        document["maps"]["maps"][0]["enable"].reverse()

    def node(document):
        document["lif"]["layouts"][0]["nodes"][0]["nodePosition"]["x"] += 1.0

    def lost_edge(document):
        next(layout for layout in document["lif"]["layouts"] if layout["edges"])["edges"].pop()

    def end(document):
        next(layout for layout in document["lif"]["layouts"] if layout["edges"])["edges"][0]["startNodeId"] = "nowhere"

    def curve(document):
        for layout in document["lif"]["layouts"]:
            for edge in layout["edges"]:
                if (line := edge["vehicleTypeEdgeProperties"][0].get("trajectory")) and edge["endNodeId"] in {n["nodeId"] for n in layout["nodes"]}:
                    line["controlPoints"][1]["x"] += 30.0
                    return

    def lost_key(document):
        del document["lif"]["layouts"][0]["layoutVersion"]

    cases = {
        "a BLOCKED zone removed": (without("BLOCKED"), "are not in a BLOCKED zone"),
        "a BLOCKED zone shifted by 1 m": (shifted("BLOCKED"), "that are not keep-out"),
        "a BLOCKED zone a cell wider": (grown, "that are not keep-out"),
        "a zone clockwise": (turned, "is clockwise"),
        "a zone that crosses itself": (crossed, "is no simple polygon"),
        "a zone of another reason": (of_zone("BLOCKED", "zoneId", "closed-room:x:1"), "no room that is blocked"),
        "a wrong hash": (hash_of, "hash or length"),
        "a map with another byte": (map_byte, "hash or length"),
        "another map id": (other_map, "another map id"),
        "another date": (later, "another valid_from"),
        "actions in another order": (action, "actions do not say"),
        "a node 1 m off": (node, "other nodes"),
        "an edge less": (lost_edge, "usable ways"),
        "an edge from nowhere": (end, "does not begin at a node"),
        "a curve through a wall": (curve, "leave the free cells"),
        "a layout without its version": (lost_key, "schema"),
    }
    if zones(written, "SPEED_LIMIT"):
        cases["a limit removed"] = (without("SPEED_LIMIT"), "differ from speed.pgm")
        cases["a higher limit"] = (of_zone("SPEED_LIMIT", "maximumSpeed", 9.0), "differ from speed.pgm")
        cases["a limit without its speed"] = (lambda d: largest(d, "SPEED_LIMIT")[1].pop("maximumSpeed"), "schema")
    if zones(written, "RELEASE"):
        cases["a release removed"] = (without("RELEASE"), "doors that cannot be opened")
        cases["a release shifted by 1 m"] = (shifted("RELEASE"), "is not at its door")
        cases["a release without its behaviour"] = (lambda d: largest(d, "RELEASE")[1].pop("releaseLossBehavior"), "schema")
    return {what: (changed(change), word) for what, (change, word) in cases.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--self-test", action="store_true", help="damage files of the first folder, or of the store, too: each damage must be noticed")
    parser.add_argument("--store", type=pathlib.Path, metavar="STORE/SITE", help="judge the exported files of a site in a store")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT", nargs="*")
    options = parser.parse_args()
    if bool(options.store) == bool(options.out):
        parser.error("give output folders, or --store")
    if options.store:
        try:
            return int(judge_store(options.store, options.self_test))
        except (OSError, KeyError, ValueError, TypeError, IndexError) as why:
            print(f"{options.store} cannot be read: {why!r}", file=sys.stderr)
            return 2
    judge, failed, folders = Judge(), False, []
    for out in options.out:
        try:
            folder = Folder(out)
            written = folder.written()
        except (OSError, KeyError, ValueError, TypeError) as why:
            print(f"{out} cannot be read: {why!r}", file=sys.stderr)
            return 2
        folders.append((folder, written))
        wrong = judge.judge(folder, written)
        zones = ", ".join(f"{n} {kind}" for kind, n in sorted(judge.n_zones.items()))
        lif = written["lif"]["layouts"]
        print(
            f"{out}: {len(written['zones'])} zone sets: {zones}, {judge.n_corners} corners; {sum(len(l['nodes']) for l in lif)} nodes,"
            f" {sum(len(l['edges']) for l in lif)} edges, {sum(len(l['stations']) for l in lif)} stations;"
            f" {judge.near_m:.1f} of {judge.length_m:.1f} m nearer than {folder.radius} m to BLOCKED"
        )
        if options.self_test and len(folders) == 1:
            for what, (damaged, word) in damages(folder, written).items():
                found = [why for why in judge.judge(folder, damaged) if word in why]
                print(f" with {what}: {found[0] if found else 'nothing'}")
                if not found:
                    wrong.append(f"not noticed: {what}")
        failed |= bool(wrong)
        print("\n".join(f"FAIL {why}" for why in wrong) or "PASS")
    all_written = [written for _, written in folders]
    across = compared(all_written)
    if options.self_test and len(folders) > 1:
        for what, (key, value, word) in {
            "another map id at another date": ("map_id", "x", "several map ids"),
            "the id of other zones": ("zone_set_id", all_written[0]["maps"]["maps"][-1]["zone_set_id"], "is several contents"),
            "two ids of a map": ("map_version", "x", "one content has several ids"),
        }.items():
            damaged = copy.deepcopy(all_written) + copy.deepcopy(all_written[1:])
            damaged[-1]["maps"]["maps"][0][key] = value
            found = [why for why in compared(damaged) if word in why]
            print(f" with {what}: {found[0] if found else 'nothing'}")
            across += [] if found else [f"not noticed: {what}"]
    failed |= bool(across)
    print("\n".join(f"FAIL {why}" for why in across), end="\n" if across else "")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
