#!/usr/bin/env python3
"""A robot's SLAM node in the ROS 2 graph, with CycloneDDS and without ROS: publishes maps as nav_msgs/OccupancyGrid, latched.

usage: ros_slam.py [--domain N] [--topic /map] [--on-line] KIND PATH [--cells N]

drive FOLDER     the growing map of a drive through the building that `groundplan export` wrote, and the robot's pose on /tf
large FILE.yaml  a map of the map server amid N x N cells of which nothing is known (5000: 25 MB), a cell another one each time
faulty FILE.yaml messages that are no map, and the map after each of them

The next map comes each second, or with --on-line for each line of standard input; the last one is repeated, as SLAM does. Each
new map is one JSON line; those of a drive come after the true pose of the robot's frame in the building.
"""

import argparse
import json
import math
import pathlib
import random
import struct
import sys
import time
import types
from dataclasses import dataclass, replace

from cyclonedds.core import Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, uint8
from cyclonedds.pub import DataWriter, Publisher, ddspy_write
from cyclonedds.topic import Topic
from ros_peer import (
    LATCHED,
    VOLATILE,
    Header,
    MapMetaData,
    OccupancyGrid,
    Point,
    Pose,
    Quaternion,
    TFMessage,
    Time,
    Transform,
    TransformStamped,
    Vector3,
    n_lines,
    read_map,
)
from slam_drive import OCCUPIED, RESOLUTION_M, UNKNOWN, Drive

MOST = 2**32 - 1


@dataclass
class Published:
    """A message as bytes, and what a person wants to know of it."""

    words: dict
    cdr: bytes
    robot: tuple | None = None
    # False for bytes that no writer of grids sends.
    is_grid: bool = True


def about_z(yaw_rad: float) -> Quaternion:
    return Quaternion(0.0, 0.0, math.sin(yaw_rad / 2), math.cos(yaw_rad / 2))


def info_of(width: int, height: int, origin: list) -> MapMetaData:
    return MapMetaData(Time(0, 0), RESOLUTION_M, width, height, Pose(Point(*origin, 0.0), about_z(0.0)))


def cdr_of(info: MapMetaData, cells: bytes, length: int | None = None) -> bytes:
    """A grid; `length` is what it says of its cells where that is another number. Lists of a large map would take seconds."""
    head = OccupancyGrid(Header(Time(0, 0), "map"), info, []).serialize()
    return bytes(head[:-4]) + struct.pack("<I", len(cells) if length is None else length) + cells


def so_many_bytes(n: int) -> type:
    """A type with the name of a grid that takes any bytes of that number: a writer refuses what its type does not describe."""
    fields = {"__annotations__": {"content": array[uint8, n]}}
    keywords = {"typename": OccupancyGrid.__idl_typename__}
    kind = types.new_class(f"Bytes{n}", (IdlStruct,), keywords, lambda own: own.update(fields))
    return dataclass(kind)


def maps_of_drive(folder: pathlib.Path):
    drive = Drive(folder)
    x, y, yaw = drive.site_from_slam
    print(json.dumps({"topic": "drive", "x_m": x, "y_m": y, "yaw_rad": yaw, "scans": len(drive.places)}), flush=True)
    for number, (slam_map, robot) in enumerate(drive.maps(), 1):
        size = [slam_map.width, slam_map.height]
        words = {"map": number, "size": size, "origin_m": slam_map.origin, "robot_m": robot[:2]}
        yield Published(words, cdr_of(info_of(*size, slam_map.origin), slam_map.cells), robot)


def large_maps(file: pathlib.Path, side: int):
    grid = read_map(file)
    info, width = grid.info, grid.info.width
    known, unknown = bytes(grid.data), bytes([UNKNOWN])
    margins = [(side - n) // 2 for n in (width, info.height)]
    rows = [known[k * width : (k + 1) * width] for k in range(info.height)]
    rows = [unknown * margins[0] + row + unknown * (side - width - margins[0]) for row in rows]
    empty = unknown * side
    cells = bytearray(b"".join([empty] * margins[1] + rows + [empty] * (side - info.height - margins[1])))
    corner = info.origin.position
    origin = [c - n * info.resolution for c, n in zip((corner.x, corner.y), margins)]
    # A cell becomes another one each time, among those that are known: these are not in one row.
    known_at = [k for k, cell in enumerate(cells) if cell != UNKNOWN]
    for number, at in enumerate(known_at, 1):
        cells[at] = OCCUPIED - cells[at]
        yield Published({"map": number, "size": [side, side]}, cdr_of(info_of(side, side, origin), bytes(cells)))


def faulty_maps(file: pathlib.Path):
    grid = read_map(file)
    info, cells = grid.info, bytes(grid.data)
    good, at = cdr_of(info, cells), info.origin

    def other(**fields) -> bytes:
        return cdr_of(replace(info, **fields), cells)

    def turned(*quaternion: float) -> bytes:
        return other(origin=Pose(at.position, Quaternion(*quaternion)))

    faults = {
        "a column more than cells": other(width=info.width + 1),
        "the largest width and height": other(width=MOST, height=MOST),
        "no cells": cdr_of(replace(info, width=0, height=0), b""),
        "only unknown cells": cdr_of(info, bytes([UNKNOWN]) * len(cells)),
        "no resolution": other(resolution=0.0),
        "a negative resolution": other(resolution=-0.05),
        "a resolution that is no number": other(resolution=math.nan),
        "an origin that is no number": other(origin=Pose(Point(math.nan, 0.0, 0.0), at.orientation)),
        "a tilted origin": turned(math.sin(0.2), 0.0, 0.0, math.cos(0.2)),
        "a turn that is no number": turned(0.0, 0.0, math.nan, 1.0),
        "a cell of 101": cdr_of(info, b"\x65" + cells[1:]),
        "a cell of -2": cdr_of(info, b"\xfe" + cells[1:]),
        "a frame that is no text": good.replace(b"map\0", b"\xff\xff\xff\0", 1),
        "an unknown encoding": b"\x7f\xff\0\0" + good[4:],
    }
    no_grids = {
        "more cells than bytes": cdr_of(info, cells, MOST),
        "cut off": good[: len(good) // 8 * 4],
        "cut off in its head": good[:16],
        "random bytes": good[:4] + random.Random(1).randbytes(5000),
    }
    for name, cdr in (faults | no_grids).items():
        yield Published({"map": name}, cdr, is_grid=name in faults)
        yield Published({"map": "good"}, good)


class SlamNode:
    """The participant and its publishers."""

    def __init__(self, domain: int, topic: str) -> None:
        self.topic, self.participant = topic, DomainParticipant(domain)
        self.publisher = Publisher(self.participant)
        self.maps = self.writer(f"rt{topic}", OccupancyGrid, LATCHED)
        self.transforms = self.writer("rt/tf", TFMessage, VOLATILE)
        # Of the bytes that were published last, if they are no grid.
        self.others = None

    def writer(self, topic: str, kind: type, qos: Qos) -> DataWriter:
        return DataWriter(self.publisher, Topic(self.participant, topic, kind), qos=qos)

    def publish(self, published: Published) -> None:
        # The writer's own method takes messages that are well formed; bytes have to fill whole words.
        cdr = published.cdr.ljust(-(-len(published.cdr) // 4) * 4, b"\0")
        if published.is_grid:
            writer, self.others = self.maps, None
        else:
            self.others = self.others or self.writer(f"rt{self.topic}", so_many_bytes(len(cdr) - 4), LATCHED)
            writer = self.others
        if ddspy_write(writer._ref, cdr) < 0:
            raise ValueError(f"{published.words} cannot be sent")

    def place(self, robot: tuple) -> None:
        x, y, yaw = robot
        transform = Transform(Vector3(x, y, 0.0), about_z(yaw))
        self.transforms.write(TFMessage([TransformStamped(Header(Time(0, 0), "map"), "base_link", transform)]))


def run(node: SlamNode, maps, on_line: bool) -> None:
    current, n_wanted = None, 0
    map_due = tf_due = time.monotonic()
    while (lines := n_lines() if on_line else 0) is not None:
        now, n_wanted = time.monotonic(), n_wanted + lines
        is_due = now >= map_due
        following = None
        if n_wanted > 0 or (is_due and not on_line):
            following, n_wanted = next(maps, None), max(n_wanted - 1, 0)
        if following:
            current = following
            # Making a map may have taken its time.
            now = time.monotonic()
            print(json.dumps({"topic": node.topic, **current.words}), flush=True)
        if current and (following or is_due):
            node.publish(current)
            map_due = now + 1
        if current and current.robot and now >= tf_due:
            node.place(current.robot)
            tf_due = now + 0.1
        time.sleep(0.01)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--domain", type=int, default=0)
    parser.add_argument("--topic", default="/map")
    parser.add_argument("--on-line", action="store_true")
    parser.add_argument("kind", choices=["drive", "large", "faulty"])
    parser.add_argument("path", type=pathlib.Path)
    parser.add_argument("--cells", type=int, default=5000)
    arguments = parser.parse_args()
    kinds = {
        "drive": lambda: maps_of_drive(arguments.path),
        "large": lambda: large_maps(arguments.path, arguments.cells),
        "faulty": lambda: faulty_maps(arguments.path),
    }
    run(SlamNode(arguments.domain, arguments.topic), kinds[arguments.kind](), arguments.on_line)


if __name__ == "__main__":
    try:
        main()
    except (KeyboardInterrupt, BrokenPipeError):
        sys.exit(0)
