#!/usr/bin/env python3
"""Proves that maps of scripts/slam-maps are where their files say, from the files alone: walls, trajectory and model fit together.

usage: scripts/check_slam_maps.py [--pictures] [--self-test] FOLDER

Each wall cell of a SLAM map is moved as the pose of the trajectory that is nearest to it says, so that a bent map is no error. Those
within 3 m of the trajectory lie on the walls of the model best where they are: of all shifts up to 0.3 m along both axes none by more
than a cell brings them closer. Furniture has no shift that fits it: a map is not judged where most of what is in view is furniture.
--pictures leaves NAME-overlay.png beside each map: walls of the model in gray, of the SLAM map in red, the true way in blue. With
--self-test maps that are moved by 0.25 m must not pass.
"""
import argparse
import csv
import math
import pathlib
import sys

import numpy
import PIL.Image

AROUND_M = 3.0
# Cells count that are closer than this to a wall's face of the model, by how close they are; shifts that are tried: metres.
OF_WALLS_M = 0.15
SHIFTS_M = [0.05 * k for k in range(-6, 7)]
MAX_SHIFT_M = 0.05
# With less of it, furniture is most of what is in view.
LEAST_CLOSENESS = 0.4
# What the self-test moves maps by.
MOVED_M = [0.15, -0.2]


def read_map(path):
    """(array of gray pixels with the lowest row first, metres per cell, (x, y) of the lower left corner)"""
    description = dict(line.split(": ", 1) for line in path.read_text().splitlines() if ": " in line)
    origin = [float(word) for word in description["origin"].strip("[]").split(",")]
    gray = numpy.asarray(PIL.Image.open(path.parent / description["image"]).convert("L"))
    return gray[::-1], float(description["resolution"]), numpy.array(origin[:2])


def walls(gray, resolution, origin):
    """Middles of the occupied cells, one a row."""
    rows, columns = numpy.nonzero(gray < 90)
    return numpy.stack([columns + 0.5, rows + 0.5], 1) * resolution + origin


def poses(path):
    """Poses of the trajectory in the map and in the model: x, y, yaw."""
    with open(path, newline="") as file:
        rows = list(csv.DictReader(file))
    keys = ("x_m", "y_m", "yaw_rad")
    return tuple(numpy.array([[float(row[f"{kind}_{key}"]) for key in keys] for row in rows]) for kind in ("slam", "true"))


def moved(points, believed, true):
    """Points moved as their nearest pose says, and their distances from that."""
    apart = numpy.hypot(*(points[:, None, :] - believed[None, :, :2]).transpose(2, 0, 1))
    nearest = apart.argmin(1)
    turn = (true - believed)[nearest, 2]
    offset = points - believed[nearest, :2]
    cos, sin = numpy.cos(turn), numpy.sin(turn)
    at = numpy.stack([cos * offset[:, 0] - sin * offset[:, 1], sin * offset[:, 0] + cos * offset[:, 1]], 1)
    return at + true[nearest, :2], apart.min(1)


def closeness(reference):
    """Of each cell of a model map: 1 on a wall cell that has another cell beside it, 0 at OF_WALLS_M from all."""
    gray, resolution, _ = reference
    reach = math.ceil(OF_WALLS_M / resolution)
    wall = numpy.pad(gray < 90, reach + 1)
    face = wall & ~(numpy.roll(wall, 1, 0) & numpy.roll(wall, -1, 0) & numpy.roll(wall, 1, 1) & numpy.roll(wall, -1, 1))
    found = numpy.zeros(face.shape)
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            close = max(0.0, 1 - math.hypot(dx, dy) * resolution / OF_WALLS_M)
            found = numpy.maximum(found, close * numpy.roll(face, (dy, dx), (0, 1)))
    return found[reach + 1:-reach - 1, reach + 1:-reach - 1]


def best_shift(points, reference):
    """The shift (x, y) in metres that brings points closest to walls of a model map, and how close they are then and without, of 1."""
    close = closeness(reference)
    _, resolution, origin = reference

    def score(shift):
        columns, rows = numpy.floor((points + shift - origin) / resolution).astype(int).T
        inside = (0 <= columns) & (columns < close.shape[1]) & (0 <= rows) & (rows < close.shape[0])
        return float(close[rows[inside], columns[inside]].sum() / len(points))

    shift = max(((x, y) for x in SHIFTS_M for y in SHIFTS_M), key=score)
    return shift, score(shift), score((0, 0))


def is_moved(shift):
    return max(map(abs, shift)) > MAX_SHIFT_M + 1e-9


def picture(path, reference, points, true):
    gray, resolution, origin = reference
    image = numpy.full((*gray.shape, 3), 255, numpy.uint8)
    image[gray < 90] = 170
    for places, colour in ((true[:, :2], (60, 90, 220)), (points, (210, 30, 30))):
        columns, rows = numpy.floor((places - origin) / resolution).astype(int).T
        inside = (0 <= columns) & (columns < gray.shape[1]) & (0 <= rows) & (rows < gray.shape[0])
        image[rows[inside], columns[inside]] = colour
    PIL.Image.fromarray(image[::-1]).save(path)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--pictures", action="store_true", help="leave NAME-overlay.png beside each map")
    parser.add_argument("--self-test", action="store_true", help="damaged maps must not pass")
    parser.add_argument("folder", type=pathlib.Path, metavar="FOLDER")
    options = parser.parse_args()
    n_judged, wrong = 0, 0
    names = sorted(path.name.removesuffix("-trajectory.csv") for path in options.folder.glob("*-trajectory.csv"))
    for name in names:
        slam, reference = (read_map(options.folder / f"{name}-{kind}.yaml") for kind in ("slam", "reference"))
        believed, true = poses(options.folder / f"{name}-trajectory.csv")
        points, apart = moved(walls(*slam), believed, true)
        around = points[apart <= AROUND_M]
        shift, best, here = best_shift(around, reference)
        is_judged, is_wrong = best >= LEAST_CLOSENESS, is_moved(shift)
        verdict = "not judged" if not is_judged else "WRONG" if is_wrong else "right"
        n_judged += is_judged
        wrong += is_judged and is_wrong
        print(f"{verdict} {name}: {len(around)} wall cells, on walls of the model by {here:.3f}, at most {best:.3f} if "
              f"moved by {shift[0]:.2f}, {shift[1]:.2f} m")
        if options.pictures:
            picture(options.folder / f"{name}-overlay.png", reference, points, true)
        if options.self_test and is_judged:
            shift, _, _ = best_shift(around + MOVED_M, reference)
            if not is_moved(shift):
                wrong += 1
                print(f"WRONG {name}: moved by {MOVED_M} m it would be right")
    print(f"{len(names)} maps, {n_judged} with walls enough in view, {wrong} wrong")
    sys.exit(1 if wrong or not n_judged else 0)


if __name__ == "__main__":
    main()
