#!/usr/bin/env python3
"""Judges heights in a recording of `groundplan convert --date all --mcap FILE --grid-map -o OUT` by the files in OUT, or the end of
one of `groundplan record FILE --grid-map` by those of `groundplan export OUT`.

    python3 scripts/check_grid_map.py FILE OUT               judge the recording
    python3 scripts/check_grid_map.py --self-test FILE OUT   damage its messages, too; each damage must be noticed

Needs rosbags, numpy and Pillow. Exit codes: 0 all is as it should be, 1 it is not, 2 the files cannot be read.

rosbags reads the messages, by the definitions of grid_map_msgs and foxglove_msgs as those packages have them. Of each cell of the
files the middle is computed from the origin in the YAML beside them, and grid_map's rule says which value of the message is meant:
from the middle of the map half its length towards the largest x and y, then cells downwards, rows along x, columns along y, the
layers in column-major order.

- elevation is that of elevation.png above the floor of the storey in manifest.json, to half a step of its pixels, and NaN where that
  has none. Without the file the storey is level: 0 on all free cells, nothing but 0 and NaN elsewhere.
- slope is that of slope.png in the same way.
- traversability is 0 where planning.pgm is occupied or keepout.pgm is set, else NaN where planning.pgm is unknown, else one less the
  share of the slope in the robot's max_slope_rad, at least 0.01.
- The topic elevation has the same numbers, row by row from the lower left.
- There is a message at each change instant, in the frame and of the instant that it should have.

Prints one JSON document: what was counted, and the sha256 of the numbers of the last message of each topic grid_map.
"""
import argparse
import copy
import datetime
import hashlib
import json
import pathlib
import sys

import numpy as np
from check_ros_messages import typestore
from PIL import Image
from rosbags.rosbag2 import Reader
from slam_drive import read_pgm

GRID_MAP, GRID = "grid_map_msgs/msg/GridMap", "foxglove_msgs/msg/Grid"
LAYERS = ["elevation", "slope", "traversability"]
LEAST = 0.01
# Of numbers that were rounded to 32 bits.
ROUNDING = 1e-5


def load(path):
    return json.loads(path.read_text(encoding="utf-8"))


class Files:
    """What the files of a storey say, rows from below."""

    def __init__(self, out, manifest, number):
        storey = manifest["storeys"][number]
        self.folder, self.floor_z_m = out / storey["directory"], storey["floor_z_m"]
        self.max_slope_rad = manifest["robot"]["max_slope_rad"]
        self.planning, self.keepout = (self.pgm(name) for name in ("planning", "keepout"))
        self.resolution, self.origin = self.place("planning")

    def yaml(self, name):
        lines = (self.folder / f"{name}.yaml").read_text(encoding="utf-8").splitlines()
        return dict(line.split(": ", 1) for line in lines)

    def place(self, name):
        facts = self.yaml(name)
        return float(facts["resolution"]), json.loads(facts["origin"])[:2]

    def pgm(self, name):
        width, height, pixels = read_pgm(self.folder / f"{name}.pgm")
        return np.frombuffer(pixels, np.uint8).reshape(height, width)

    def layer(self, name):
        """Values, NaN where there are none, and half a step of them; None where there is no file."""
        path = self.folder / f"{name}.png"
        if not path.exists():
            return None
        assert self.place(name) == (self.resolution, self.origin), f"{path}: lies elsewhere"
        facts = self.yaml(name)
        pixels = np.asarray(Image.open(path)).astype(np.int64)[::-1]
        scale, offset, none = float(facts["scale"]), float(facts["offset"]), int(facts["none"])
        return np.where(pixels == none, np.nan, offset + scale * pixels), scale / 2

    def middles(self):
        height, width = self.planning.shape
        x = self.origin[0] + (np.arange(width) + 0.5) * self.resolution
        y = self.origin[1] + (np.arange(height) + 0.5) * self.resolution
        return np.meshgrid(x, y)


def by_place(message, x, y):
    """The layers at places, by grid_map's rule; NaN outside of the map."""
    info, middle = message.info, message.info.pose.position
    found = []
    for layer in message.data:
        dimensions = layer.layout.dim
        labels = [dimension.label for dimension in dimensions]
        if labels != ["column_index", "row_index"]:
            return f"its dimensions are {labels}"
        columns, rows = (dimension.size for dimension in dimensions)
        strides = [dimension.stride for dimension in dimensions]
        lengths = [round(info.length_x / info.resolution), round(info.length_y / info.resolution)]
        if [rows, columns] != lengths or strides != [rows * columns, rows] or len(layer.data) != rows * columns:
            return f"{rows} rows and {columns} columns with strides {strides} are no matrix of {lengths}"
        matrix = np.asarray(layer.data).reshape(columns, rows)
        row = np.floor((middle.x + info.length_x / 2 - x) / info.resolution).astype(int)
        column = np.floor((middle.y + info.length_y / 2 - y) / info.resolution).astype(int)
        inside = (row >= 0) & (row < rows) & (column >= 0) & (column < columns)
        found.append(np.where(inside, matrix[column.clip(0, columns - 1), row.clip(0, rows - 1)], np.nan))
    return found


def differing(found, expected, tolerance):
    """Number of cells that are not as expected, of which either is NaN alone, too."""
    is_same = (np.isnan(found) & np.isnan(expected)) | (np.abs(found - expected) <= tolerance)
    return int(np.count_nonzero(~is_same))


def faults(message, files):
    """What of a message is not as the files say."""
    if message.layers != LAYERS or message.basic_layers != ["elevation"] or len(message.data) != len(LAYERS):
        return [f"its layers are {message.layers}, basic {message.basic_layers}"]
    turn = message.info.pose.orientation
    if (message.outer_start_index, message.inner_start_index, turn.x, turn.y, turn.z, turn.w) != (0, 0, 0, 0, 0, 1):
        return ["it is scrolled or turned"]
    size, expected = [message.info.length_x, message.info.length_y], np.array(files.planning.shape[::-1]) * files.resolution
    if abs(message.info.resolution - files.resolution) > 1e-9 or np.abs(expected - size).max() > 1e-6:
        return [f"its size is {size} at {message.info.resolution} instead of {expected} at {files.resolution}"]
    found = by_place(message, *files.middles())
    if isinstance(found, str):
        return [found]
    free, unknown = files.planning == 254, files.planning == 205
    kept_out = (files.planning == 0) | (files.keepout == 0)
    wrong = []
    for name, below, values in zip(LAYERS, [files.floor_z_m, 0.0], found):
        layer = files.layer(name)
        if layer is None:
            n = differing(values, np.where(free | ~np.isnan(values), 0.0, np.nan), 0.0)
            tolerance = 0.0
        else:
            tolerance = layer[1] + ROUNDING
            n = differing(values, layer[0] - below, tolerance)
        wrong += [f"{n} cells of {name} are more than {tolerance:.6f} off"] if n else []
    if not np.array_equal(np.isnan(found[0]), np.isnan(found[1])):
        wrong.append("there are heights without slopes, or slopes without heights")
    slope = files.layer("slope")
    rad, half_step = slope if slope is not None else (np.where(free, 0.0, np.nan), 0.0)
    share = np.divide(rad, files.max_slope_rad) if files.max_slope_rad else np.where(rad > 0, np.inf, 0.0)
    expected = np.maximum(1.0 - share, LEAST)
    expected[unknown] = np.nan
    expected[kept_out] = 0.0
    tolerance = np.where(kept_out, 0.0, half_step / max(files.max_slope_rad, 1e-9) + ROUNDING)
    n = differing(found[2], expected, tolerance)
    wrong += [f"{n} cells of traversability are not as slope, planning map and mask say"] if n else []
    return wrong


def faults_of_grid(grid, message):
    """What of a grid for Foxglove is not as the map of several layers, whose cells lie in reverse."""
    height, width = (dimension.size for dimension in message.data[0].layout.dim)
    fields = [(field.name, field.offset, field.type) for field in grid.fields]
    if fields != [(name, 4 * k, 7) for k, name in enumerate(LAYERS)]:
        return [f"elevation: its fields are {fields}"]
    if (grid.column_count, grid.row_stride, grid.cell_stride) != (width, 12 * width, 12):
        return ["elevation: it has other columns or strides"]
    lengths = (message.info.length_x, message.info.length_y)
    middle, corner = message.info.pose.position, grid.pose.position
    places = (middle.x - lengths[0] / 2 - corner.x, middle.y - lengths[1] / 2 - corner.y, corner.z)
    if max(map(abs, places)) > 1e-6 or (grid.cell_size.x, grid.cell_size.y) != (message.info.resolution,) * 2:
        return ["elevation: it lies elsewhere"]
    cells = np.asarray(grid.data, np.uint8).view("<f4").reshape(height * width, len(LAYERS))
    same = [np.array_equal(cells[::-1, k], layer.data, equal_nan=True) for k, layer in enumerate(message.data)]
    return [] if all(same) else ["elevation: its numbers are others"]


def damages(message):
    """Damaged copies of a message, by what was done."""

    def damaged(change):
        copied = copy.deepcopy(message)
        change(copied)
        return copied

    columns, rows = (dimension.size for dimension in message.data[0].layout.dim)

    def each(turn):
        def change(copied):
            for layer in copied.data:
                layer.data = np.ascontiguousarray(turn(np.asarray(layer.data).reshape(columns, rows))).reshape(-1)

        return damaged(change)

    def one(layer, is_wanted, value):
        def change(copied):
            data = np.array(copied.data[layer].data)
            data[np.flatnonzero(is_wanted(data))[0]] = value
            copied.data[layer].data = data

        return damaged(change)

    def moved(copied):
        copied.info.pose.position.x += copied.info.resolution

    def swapped(copied):
        copied.data[0], copied.data[1] = copied.data[1], copied.data[0]

    def relabelled(copied):
        for layer in copied.data:
            first, second = layer.layout.dim
            first.label, second.label = second.label, first.label

    def lower_left(copied):
        copied.info.pose.position.x -= copied.info.length_x / 2
        copied.info.pose.position.y -= copied.info.length_y / 2

    def raised(copied):
        copied.data[0].data = np.asarray(copied.data[0].data) + np.float32(0.002)

    yield "rows from the other side", each(lambda matrix: matrix[:, ::-1])
    yield "columns from the other side", each(lambda matrix: matrix[::-1])
    yield "rows for columns", each(lambda matrix: matrix.T)
    yield "moved by a cell", damaged(moved)
    yield "the place of the lower left corner", damaged(lower_left)
    yield "labels of a row-major matrix", damaged(relabelled)
    yield "slopes for heights", damaged(swapped)
    yield "2 mm higher", damaged(raised)
    yield "one height more", one(0, np.isnan, 0.0)
    yield "one height less", one(0, lambda data: ~np.isnan(data), np.nan)
    yield "one cell that the robot must not be in is free", one(2, lambda data: data == 0, 1.0)
    yield "one free cell is none", one(2, lambda data: data > 0, 0.0)


def messages_of(path):
    """Messages of the two types by topic and instant."""
    store, found = typestore(), {GRID_MAP: {}, GRID: {}}
    with Reader(path) as reader:
        wanted = [connection for connection in reader.connections if connection.msgtype in found]
        for connection in wanted:
            assert connection.digest in ("", store.hash_rihs01(connection.msgtype)), f"{connection.topic}: hash {connection.digest}"
        for connection, at_ns, data in reader.messages(connections=wanted):
            message = store.deserialize_cdr(data, connection.msgtype)
            found[connection.msgtype].setdefault(connection.topic, {})[at_ns] = message
    return found


def digest(message):
    """Of the numbers of all layers."""
    return hashlib.sha256(b"".join(np.asarray(layer.data, "<f4").tobytes() for layer in message.data)).hexdigest()


def nanoseconds(plan_time):
    """Civil time at the site as if it were UTC."""
    at = datetime.datetime.fromisoformat(plan_time).replace(tzinfo=datetime.timezone.utc)
    return int(at.timestamp()) * 1_000_000_000


def is_stamped(header_stamp, frame_id, at_ns, frame):
    return header_stamp.sec * 1_000_000_000 + header_stamp.nanosec == at_ns and frame_id == frame


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--self-test", action="store_true", help="damage the messages, too: each damage must be noticed")
    parser.add_argument("recording", type=pathlib.Path)
    parser.add_argument("out", type=pathlib.Path)
    options = parser.parse_args()
    found, out = messages_of(options.recording), options.out
    manifest = load(out / "manifest.json")
    if "dates" in manifest:
        dates = {nanoseconds(date["plan_time"]): out / date["directory"] for date in manifest["dates"]}
    else:
        # Of a running site only the last maps can be exported afterwards.
        last = max((at for messages in found[GRID_MAP].values() for at in messages), default=0)
        dates = {last: out}
        found = {kind: {topic: {at: messages[at] for at in messages if at == last} for topic, messages in topics.items()}
                 for kind, topics in found.items()}
    manifests = {at: load(folder / "manifest.json") for at, folder in dates.items()}
    names = [pathlib.PurePath(storey["directory"]).name.replace("-", "_") for storey in manifests[max(dates)]["storeys"]]
    frames = ["map"] if len(names) == 1 else [f"storey_{name}" for name in names]
    wrong, n_cells, n_sloped, to_damage = [], 0, 0, None
    for number, frame in enumerate(frames):
        prefix = "/groundplan" if len(frames) == 1 else f"/groundplan/{frame}"
        maps, grids = found[GRID_MAP].get(f"{prefix}/grid_map", {}), found[GRID].get(f"{prefix}/elevation", {})
        if set(maps) != set(dates) or set(grids) != set(dates):
            wrong.append(f"{prefix}: {len(maps)} and {len(grids)} messages at {len(dates)} change instants")
            continue
        for at, folder in dates.items():
            message, grid, files = maps[at], grids[at], Files(folder, manifests[at], number)
            new = faults(message, files) or faults_of_grid(grid, message)
            if not is_stamped(message.header.stamp, message.header.frame_id, at, frame):
                new.append("grid_map: another stamp or frame")
            if not is_stamped(grid.timestamp, grid.frame_id, at, frame):
                new.append("elevation: another stamp or frame")
            wrong += [f"{prefix} at {folder.name}: {fault}" for fault in new]
            n_cells += files.planning.size
            slopes = np.asarray(message.data[1].data)
            n_sloped += int(np.count_nonzero(slopes > 0))
            traversability = np.asarray(message.data[2].data)
            has_all = (slopes > 0).any() and (traversability == 0).any() and (traversability > 0).any()
            if has_all and np.isnan(message.data[0].data).any():
                to_damage = (message, files)
    if options.self_test and not wrong:
        if to_damage is None:
            wrong.append("no message has slopes, free cells, and cells without ground: it says nothing when one is damaged")
        else:
            unnoticed = [what for what, damaged in damages(to_damage[0]) if not faults(damaged, to_damage[1])]
            wrong += [f"not noticed: {what}" for what in unnoticed]
    if wrong:
        sys.exit("\n".join(f"FAIL {fault}" for fault in wrong))
    sums = {topic: digest(messages[max(messages)]) for topic, messages in found[GRID_MAP].items()}
    n_damages = len(list(damages(to_damage[0]))) if options.self_test else 0
    json.dump({"storeys": len(frames), "change_instants": len(dates), "cells": n_cells, "sloped_cells": n_sloped,
               "damages_noticed": n_damages, "sha256": sums}, sys.stdout)
    print()


if __name__ == "__main__":
    try:
        main()
    except (OSError, KeyError) as error:
        print(f"FAIL {error!r}", file=sys.stderr)
        sys.exit(2)
