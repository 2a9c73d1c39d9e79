#!/usr/bin/env python3
"""The growing map of a robot with a lidar that drives through an exported building, as SLAM makes it.

usage: scripts/slam_drive.py FOLDER OUT [--storey 0]

FOLDER is what `groundplan export` writes: the lidar sees what `localization.pgm` shows, and the way leads through the waypoints
over free cells of `planning.pgm`. The robot's frame begins where the robot does, turned from that of the building. OUT gets a map
of a map server for every two metres of the way (001.yaml ..), and drive.json: the true pose of the robot's frame, and the robot's
places.
The same folder always gives the same maps. Python 3.9 or later, no packages.
"""

import argparse
import collections
import functools
import json
import math
import operator
import pathlib
import random
import re
from dataclasses import dataclass

RESOLUTION_M = 0.05
# A usual lidar: a ray a degree, some millimetres of noise.
RAYS = 360
RANGE_M = 8.0
NOISE_M = 0.008
# Metres of way between two scans, and scans from one map to the next.
STEP_M = 0.5
SCANS_PER_MAP = 4
# Cells between the robot's middle and what is not free.
CLEARANCE = 4
# Turn of the robot's frame from that of the building.
START_YAW_RAD = 0.4
# A cell is occupied if more than this share of the rays that came to it ended there.
OCCUPIED_SHARE = 0.1
OCCUPIED, FREE, UNKNOWN = 100, 0, 255


@dataclass
class SlamMap:
    """Row-major from the lower left corner: 0 free, 100 occupied, 255 unknown (-1 of an int8)."""

    width: int
    height: int
    origin: list
    cells: bytes


def read_pgm(path: pathlib.Path) -> tuple:
    """Width, height and pixels, the lowest row first."""
    content = path.read_bytes()
    header = re.match(rb"P5\s+(?:#.*\s+)*(\d+)\s+(\d+)\s+255\s", content)
    assert header, f"{path} is no gray image of one byte a pixel"
    width, height = int(header[1]), int(header[2])
    pixels = content[header.end() :]
    return width, height, b"".join(pixels[k * width : (k + 1) * width] for k in reversed(range(height)))


class Layer:
    """A map of the exported building, looked up by cell."""

    def __init__(self, path: pathlib.Path, origin: list) -> None:
        self.width, self.height, self.pixels = read_pgm(path)
        self.origin = origin

    def pixel(self, column: int, row: int) -> int:
        inside = 0 <= column < self.width and 0 <= row < self.height
        return self.pixels[row * self.width + column] if inside else 205

    def cell(self, x: float, y: float) -> tuple:
        return tuple(math.floor((c - o) / RESOLUTION_M) for c, o in zip((x, y), self.origin))

    def centre(self, cell: tuple) -> tuple:
        return tuple(o + (c + 0.5) * RESOLUTION_M for c, o in zip(cell, self.origin))


def cells_along(x: float, y: float, angle_rad: float, far: float):
    """Cells of a raster with sides of 1 that a ray passes, each with the distance at which it enters."""
    directions = math.cos(angle_rad), math.sin(angle_rad)
    cell = [math.floor(x), math.floor(y)]
    steps = [1 if d > 0 else -1 for d in directions]
    per_cell = [abs(1 / d) if d else math.inf for d in directions]
    borders = [c + 1 if s > 0 else c for c, s in zip(cell, steps)]
    due = [(b - p) / d if d else math.inf for b, p, d in zip(borders, (x, y), directions)]
    entered = 0.0
    while entered < far:
        yield cell[0], cell[1], entered
        k = 0 if due[0] < due[1] else 1
        entered = due[k]
        due[k] += per_cell[k]
        cell[k] += steps[k]


def way_over(clear: set, start: tuple, goal: tuple) -> list:
    """Cells of the shortest way over clear ones, with the start and the goal; nothing if there is none."""
    before, queue = {start: start}, collections.deque([start])
    while queue and goal not in before:
        column, row = cell = queue.popleft()
        for step in ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)):
            beside = (column + step[0], row + step[1])
            if beside in clear and beside not in before:
                before[beside] = cell
                queue.append(beside)
    way = [goal] if goal in before else []
    while way and way[-1] != start:
        way.append(before[way[-1]])
    return way[::-1]


def clear_cells(planning: Layer) -> set:
    """Cells on which the robot's middle may be."""
    width, height, around = planning.width, planning.height, range(-CLEARANCE, CLEARANCE + 1)
    digits = planning.pixels.translate(bytes(b"01"[pixel == 254] for pixel in range(256)))
    # A row as a number: the bit of a column is set where the cell is free, then where all cells of a square around it are.
    rows = [int(digits[k * width : (k + 1) * width][::-1], 2) for k in range(height)]
    rows = [functools.reduce(operator.and_, (row << k if k > 0 else row >> -k for k in around)) for row in rows]
    inner = range(CLEARANCE, height - CLEARANCE)
    rows = [(y, functools.reduce(operator.and_, (rows[y + k] for k in around))) for y in inner]
    return {(x, y) for y, row in rows for x in range(width) if row >> x & 1}


class Drive:
    """The places of the robot and what it maps on its way."""

    def __init__(self, folder: pathlib.Path, storey: int = 0) -> None:
        manifest = json.loads((folder / "manifest.json").read_text())
        assert abs(manifest["resolution_m"] - RESOLUTION_M) < 1e-9, "a map with cells of 0.05 m is meant"
        record = manifest["storeys"][storey]
        directory, origin = folder / record["directory"], record["origin_m"][:2]
        self.walls = Layer(directory / "localization.pgm", origin)
        waypoints = json.loads((folder / "waypoints.json").read_text())["waypoints"]
        waypoints = sorted((w for w in waypoints if w["storey"] == storey), key=lambda w: w["order"])
        self.places = self.places_through(Layer(directory / "planning.pgm", origin), waypoints)
        assert self.places, "no waypoint of the storey can be driven to"
        # As SLAM has it: the first place is the origin.
        self.site_from_slam = (*self.places[0], START_YAW_RAD)

    @staticmethod
    def places_through(planning: Layer, waypoints: list, most_m: float = math.inf) -> list:
        """Places that are STEP_M apart; the first of a way that is longer than `most_m`. None if no waypoint can be driven to."""
        clear, way = clear_cells(planning), []
        for waypoint in waypoints:
            goal = planning.cell(waypoint["x_m"], waypoint["y_m"])
            if goal in clear and len(way) * RESOLUTION_M <= most_m:
                way += way_over(clear, way[-1], goal)[1:] if way else [goal]
        places = [planning.centre(cell) for cell in way]
        kept = places[:1]
        for place in places:
            if math.dist(place, kept[-1]) >= STEP_M:
                kept.append(place)
        return kept

    def in_slam(self, place: tuple) -> tuple:
        x, y, yaw = self.site_from_slam
        dx, dy, cos, sin = place[0] - x, place[1] - y, math.cos(yaw), math.sin(yaw)
        return cos * dx + sin * dy, cos * dy - sin * dx

    def robot_poses(self) -> list:
        """(x, y, yaw) in the robot's frame at each place, heading for the next one."""
        places = [self.in_slam(place) for place in self.places]
        heads = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in zip(places, places[1:])]
        return [(*place, yaw) for place, yaw in zip(places, (heads + heads[-1:]) or [0.0])]

    def maps(self):
        """The map and the robot's pose in its frame, for every few scans; the last one is the map of the whole way."""
        passed, ended = collections.Counter(), collections.Counter()
        noise = random.Random(1)
        poses = self.robot_poses()
        for k, (place, pose) in enumerate(zip(self.places, poses), 1):
            for ray in range(RAYS):
                self.cast(place, pose, math.tau * ray / RAYS, noise.gauss(0.0, NOISE_M), passed, ended)
            if k % SCANS_PER_MAP == 0 or k == len(self.places):
                yield map_of(passed, ended), pose

    def cast(self, place: tuple, pose: tuple, angle_rad: float, noise_m: float, passed: dict, ended: dict) -> None:
        """One ray, from the building's walls into the robot's map; one that meets nothing tells nothing."""
        side, far = RESOLUTION_M, RANGE_M / RESOLUTION_M
        x, y = ((p - o) / side for p, o in zip(place, self.walls.origin))
        hits = (at for column, row, at in cells_along(x, y, angle_rad, far) if self.walls.pixel(column, row) == 0)
        hit = next(hits, None)
        if hit is None:
            return
        measured, angle_rad = hit + noise_m / side, angle_rad - self.site_from_slam[2]
        x, y = pose[0] / side, pose[1] / side
        end = (math.floor(x + measured * math.cos(angle_rad)), math.floor(y + measured * math.sin(angle_rad)))
        for column, row, _ in cells_along(x, y, angle_rad, measured):
            passed[column, row] += 1
        passed[end] += end not in passed
        ended[end] += 1


def map_of(passed: dict, ended: dict) -> SlamMap:
    """What rays have passed and where they ended, as a map of its own extent."""
    (left, low), (right, high) = ([pick(c[k] for c in passed) for k in (0, 1)] for pick in (min, max))
    # Maps of slam_toolbox have a border of cells that nothing is known of.
    left, low, right, high = left - 2, low - 2, right + 2, high + 2
    width, height = right - left + 1, high - low + 1
    cells = bytearray([UNKNOWN]) * (width * height)
    for (column, row), n in passed.items():
        is_wall = ended[column, row] > OCCUPIED_SHARE * n
        cells[(row - low) * width + column - left] = OCCUPIED if is_wall else FREE
    return SlamMap(width, height, [left * RESOLUTION_M, low * RESOLUTION_M], bytes(cells))


def write_map(slam_map: SlamMap, yaml: pathlib.Path) -> None:
    """A map of the map server."""
    width, height = slam_map.width, slam_map.height
    pixels = slam_map.cells.translate(bytes(0 if c == OCCUPIED else 254 if c == FREE else 205 for c in range(256)))
    rows = [pixels[k * width : (k + 1) * width] for k in reversed(range(height))]
    image = yaml.with_suffix(".pgm")
    image.write_bytes(f"P5\n{width} {height}\n255\n".encode() + b"".join(rows))
    origin = [round(c, 6) for c in slam_map.origin] + [0.0]
    yaml.write_text(
        f"image: {image.name}\nresolution: {RESOLUTION_M}\norigin: {origin}\nnegate: 0\n"
        "occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    parser.add_argument("--storey", type=int, default=0)
    arguments = parser.parse_args()
    drive = Drive(arguments.folder, arguments.storey)
    arguments.out.mkdir(parents=True, exist_ok=True)
    n = 0
    for n, (slam_map, _) in enumerate(drive.maps(), 1):
        write_map(slam_map, arguments.out / f"{n:03}.yaml")
    truth = {"site_from_slam": drive.site_from_slam, "places": drive.places}
    (arguments.out / "drive.json").write_text(json.dumps(truth) + "\n")
    print(f"{n} maps of {len(drive.places)} scans in {arguments.out}")


if __name__ == "__main__":
    main()
