#!/usr/bin/env python3
"""Lets a robot localize on exported maps by a localizer that is not ours while it drives through the world beside them.

    python3 scripts/check_localization.py OUT...              judge the folders that `groundplan convert --world` wrote
    python3 scripts/check_localization.py --self-test OUT...  drive on damaged maps too; each damage must be noticed
    python3 scripts/check_localization.py --localizer mrpt .. MRPT's pf-localization instead of AMCL, the particle filter of Nav2

Needs numpy, Pillow, and amcl (PyPI, GPL-3.0) or MRPT (Debian's mrpt-apps, which root gets by apt-get). Prints a line with the verdict for
each storey. Exit codes: 0 all are good, 1 one is not, 2 a folder cannot be read, 3 there is no such localizer.

The way leads through the waypoints of a storey over the free cells of `planning.pgm`, the first 40 m of it. Scans are of the collision
shapes of the world's static models, furniture too, cut at the height of the lidar; doors are open and their leaves out of sight. The
localizer gets them with an odometry that is 5 % too long all the way, off by another 5 % and by 3 degrees at random in each step, and
a first pose that is 0.36 m and 8 degrees off; its map is `localization.pgm`. The same folder always gives the same drive.

A storey is good if
- from 5 m of way on the pose is never more than 1 m off: a robot that is farther off than a door is wide drives into its jamb, or
  takes itself to be in another room;
- half of all poses are less than 0.15 m off, which is three cells;
- of each wall that 100 rays or more have met where there is free floor before it, 90 % of what they truly met lies on occupied cells of
  the map or within 0.1 m of them, and there is such a wall. Without this a wrong wall would pass where others suffice to localize.
Storeys with less than 15 m of way are not driven through; where less than 70 % of all rays meet anything within the range of the
lidar, as on a roof or in a hall, scans do not tell the place well enough, and the storey is not judged.
"""
import argparse
import json
import math
import pathlib
import sys
import time
import xml.etree.ElementTree as ElementTree

import numpy as np
from PIL import Image

from check_world import Plans, World
from localizers import FREE, LOCALIZERS, OCCUPIED, UNKNOWN, Task, is_available
from slam_drive import STEP_M, Drive, Layer

MOST_WAY_M, LEAST_WAY_M = 40.0, 15.0
CONVERGED_AFTER_M, LOST_M, MEDIAN_M = 5.0, 1.0, 0.15
LEAST_MET = 0.7
WALL_RAYS, WALL_SHARE, WALL_M, BEFORE_WALL_M = 100, 0.9, 0.1, 0.15

# The robot turns on the spot where its way does; so far from one scan to the next.
TURN_RAD = 0.5
LIDAR_RANGE_M, LIDAR_NOISE_M, N_RAYS = 12.0, 0.01, 60
ODOMETRY_OFF, TURN_OFF_RAD = 0.05, math.radians(3)
# The first pose that the localizer is told: along, across, turn in the robot's frame.
START_OFF = (0.3, -0.2, math.radians(8))


def wrapped(angle):
    return (angle + math.pi) % (2 * math.pi) - math.pi


def moved(pose, along, across, turn):
    """A pose after a motion in its frame."""
    x, y, yaw = pose
    cos, sin = math.cos(yaw), math.sin(yaw)
    return x + cos * along - sin * across, y + sin * along + cos * across, wrapped(yaw + turn)


def poses_along(places):
    """(x, y, yaw) of a robot that turns on the spot and drives straight on from place to place."""
    yaws = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in zip(places, places[1:])]
    poses = [(*places[0], yaws[0])]
    for place, before, yaw in zip(places[1:], yaws, yaws[1:] + yaws[-1:]):
        turn = wrapped(yaw - before)
        n_turns = math.ceil(abs(turn) / TURN_RAD)
        poses += [(*place, before)] + [(*place, wrapped(before + turn * (k + 1) / n_turns)) for k in range(n_turns)]
    return poses


def odometry_along(poses, draw):
    """What the odometry takes them for; it begins at 0, 0."""
    believed = [(0.0, 0.0, 0.0)]
    for before, after in zip(poses, poses[1:]):
        along = math.dist(before[:2], after[:2]) * (1 + ODOMETRY_OFF + draw.normal(0, ODOMETRY_OFF))
        believed.append(moved(believed[-1], along, 0.0, wrapped(after[2] - before[2]) + draw.normal(0, TURN_OFF_RAD)))
    return believed


# From the right to the left, all around.
BEARINGS = (np.arange(N_RAYS) + 0.5) / N_RAYS * 2 * math.pi - math.pi


def ends_of(pose, ranges):
    angles = pose[2] + BEARINGS
    return np.array(pose[:2]) + ranges[:, None] * np.stack([np.cos(angles), np.sin(angles)], 1)


class Run:
    """A drive through a storey: true poses, odometry, scans, and which link of the world each ray meets; the map to localize on."""

    def __init__(self, out, world, manifest, entry, places):
        draw = np.random.default_rng(1)
        self.poses = poses_along(places)
        self.odometry = odometry_along(self.poses, draw)
        height = entry["floor_z_m"] + manifest["robot"]["lidar_height_m"]
        found = world.plans_of_links(height - 1e-3, height + 1e-3)
        plans, self.plans = Plans([plan for _, plan in found]), found
        casts = [plans.hits(np.array(pose[:2]), ends_of((0, 0, pose[2]), np.ones(N_RAYS))) for pose in self.poses]
        ranges = np.array([lengths for lengths, _ in casts])
        is_hit = ranges < LIDAR_RANGE_M
        # A ray that meets nothing has the longest range.
        self.ranges = np.where(is_hit, np.maximum(ranges + draw.normal(0, LIDAR_NOISE_M, ranges.shape), 0), LIDAR_RANGE_M)
        names = np.array([link for link, _ in found] + [""])
        self.met = np.where(is_hit, names[np.array([owners for _, owners in casts])], "")
        pixels = np.array(Image.open(out / entry["directory"] / "localization.pgm"))[::-1]
        self.map = np.select([pixels == 0, pixels == 254], [OCCUPIED, FREE], UNKNOWN)
        self.cell, self.origin = manifest["resolution_m"], np.array(entry["origin_m"][:2])
        ways = [math.dist(a[:2], b[:2]) for a, b in zip(self.poses, self.poses[1:])]
        self.way_m = np.concatenate([[0.0], np.cumsum(ways)])

    def met_share(self):
        """Share of the rays that meet anything."""
        return np.mean(self.met != "")

    def task(self, cells):
        """What a localizer gets."""
        start = moved(self.poses[0], *START_OFF)
        return Task(cells, self.cell, self.origin, start, self.odometry, self.ranges, BEARINGS, LIDAR_RANGE_M)

    def cells_of(self, points):
        return np.floor((points - self.origin) / self.cell).astype(int)

    def along_rays(self, cells, before_m):
        """True for rays whose end, or the place so far before it, is on one of these cells."""
        points = np.array([ends_of(pose, ranges - before_m) for pose, ranges in zip(self.poses, self.ranges)])
        columns, rows = self.cells_of(points).transpose(2, 0, 1)
        inside = (0 <= rows) & (rows < cells.shape[0]) & (0 <= columns) & (columns < cells.shape[1])
        return inside & cells[np.where(inside, rows, 0), np.where(inside, columns, 0)]

    def walls_off(self, cells):
        """Walls that are elsewhere on a map: name, number of rays that met it, share of those that end where the map has something."""
        near = widened(cells == OCCUPIED, WALL_M / self.cell)
        is_near = self.along_rays(near, 0.0)
        shares = ((name, int(of_wall.sum()), is_near[of_wall].mean()) for name, of_wall in self.seen_walls())
        return [found for found in shares if found[2] < WALL_SHARE]

    def seen_walls(self):
        """Names of the walls that enough rays have met, the one most seen first, and which rays these are."""
        over_floor = self.along_rays(self.map == FREE, BEFORE_WALL_M)
        walls = [(name, over_floor & (self.met == name)) for name in np.unique(self.met) if name.startswith("wall_")]
        return sorted((wall for wall in walls if wall[1].sum() >= WALL_RAYS), key=lambda wall: -wall[1].sum())

    def cells_with_wall(self, name):
        """Which cells a wall takes, and those beside it."""
        taken = np.zeros(self.map.shape, bool)
        for plan in (plan for link, plan in self.plans if link == name):
            (left, low), (right, high) = self.cells_of(plan.min(0)) - 2, self.cells_of(plan.max(0)) + 3
            taken[max(low, 0):high, max(left, 0):right] = True
        return taken

    def faults(self, cells, localizer):
        """What is wrong with how a robot localizes on a map, and the figures in words."""
        found = localizer(self.task(cells))
        off = np.array([math.dist(a[:2], b[:2]) for a, b in zip(found, self.poses)])
        yaw_off = [abs(wrapped(a[2] - b[2])) for a, b in zip(found, self.poses)]
        after = off[self.way_m >= CONVERGED_AFTER_M]
        median, worst = float(np.median(off)), float(after.max())
        faults = [f"it is lost: {worst:.2f} m off"] if worst > LOST_M else []
        if median >= MEDIAN_M:
            faults.append(f"{BESIDE} {median:.3f} m off or more")
        walls = self.walls_off(cells)
        faults += [] if self.seen_walls() else ["no wall is seen over free floor"]
        faults += [f"{name} {ELSEWHERE}: {share:.0%} of {n} rays end on it" for name, n, share in walls]
        drift = math.dist(moved(self.poses[0], *self.odometry[-1])[:2], self.poses[-1][:2])
        return faults, (f"way {self.way_m[-1]:.0f} m, {len(self.poses)} scans; off by {median:.3f} m and "
                        f"{math.degrees(np.median(yaw_off)):.1f} degrees in the middle, {worst:.2f} m at most (by odometry "
                        f"{drift:.1f} m at the end); {len(self.seen_walls())} walls seen")


def widened(cells, n):
    """Cells that have one of these within n cells."""
    reach = math.ceil(n)
    padded, found = np.pad(cells, reach), np.zeros(cells.shape, bool)
    height, width = cells.shape
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            if math.hypot(dx, dy) <= n:
                found |= padded[reach + dy:reach + dy + height, reach + dx:reach + dx + width]
    return found


def runs_of(out):
    """Drives through the storeys of a folder; a line for each storey without."""
    manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
    waypoints = json.loads((out / "waypoints.json").read_text(encoding="utf-8"))["waypoints"]
    world = World(out / "world")
    for entry in manifest["storeys"]:
        own = sorted((w for w in waypoints if w["storey"] == entry["index"]), key=lambda w: w["order"])
        planning = Layer(out / entry["directory"] / "planning.pgm", entry["origin_m"][:2])
        places = Drive.places_through(planning, own, MOST_WAY_M)[:round(MOST_WAY_M / STEP_M) + 1]
        if len(places) * STEP_M < LEAST_WAY_M:
            print(f"     {out.name} {entry['index']}: not driven, a way of {len(places)} places")
            continue
        run = Run(out, world, manifest, entry, places)
        if run.met_share() < LEAST_MET:
            print(f"     {out.name} {entry['index']}: not judged, {run.met_share():.0%} of the rays meet anything")
            continue
        yield f"{out.name} {entry['index']}", run


# Words of faults.
BESIDE, ELSEWHERE = "half of all poses are", "is elsewhere"


def damages(run):
    """Maps on which the wall that is seen most is missing or stands elsewhere, or all walls do: what is wrong, the map, the fault."""
    name, _ = run.seen_walls()[0]
    taken = run.cells_with_wall(name)
    missing = np.where(taken & (run.map == OCCUPIED), FREE, run.map)
    is_along_x = np.ptp(np.nonzero(taken)[1]) > np.ptp(np.nonzero(taken)[0])
    elsewhere = np.roll(taken & (run.map == OCCUPIED), round(0.5 / run.cell), 0 if is_along_x else 1)
    yield f"{name} is missing", missing, ELSEWHERE
    yield f"{name} stands 0.5 m beside", np.where(elsewhere, OCCUPIED, missing), ELSEWHERE
    yield "all walls stand 0.3 m beside", np.roll(run.map, round(0.3 / run.cell), 1), BESIDE


def verdict(out, localizer, with_damages):
    is_good = True
    for name, run in runs_of(out):
        begun = time.monotonic()
        faults, words = run.faults(run.map, localizer)
        is_good &= not faults
        print(f"{'FAIL' if faults else 'ok  '} {name}: {words}; {time.monotonic() - begun:.1f} s", flush=True)
        print("".join(f"       {fault}\n" for fault in faults), end="")
        for damage, cells, expected in damages(run) if with_damages else ():
            noticed = [fault for fault in run.faults(cells, localizer)[0] if expected in fault]
            is_good &= bool(noticed)
            print(f"{'ok  ' if noticed else 'FAIL'} {name}: {damage}: {noticed[0] if noticed else 'not noticed'}", flush=True)
    return is_good


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--localizer", choices=list(LOCALIZERS), default="amcl", help="whose poses are judged (default: amcl)")
    parser.add_argument("--self-test", action="store_true", help="damage the maps too: each damage must be noticed")
    parser.add_argument("folders", metavar="OUT", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    if not is_available(options.localizer):
        print(f"** SKIPPED: localization by {options.localizer}: it is not installed", file=sys.stderr)
        return 3
    try:
        verdicts = [verdict(out, LOCALIZERS[options.localizer], options.self_test) for out in options.folders]
    except (OSError, ValueError, LookupError, TypeError, ElementTree.ParseError) as problem:
        print(f"scripts/check_localization.py: cannot read the folder: {type(problem).__name__}: {problem}", file=sys.stderr)
        return 2
    return 0 if all(verdicts) else 1


if __name__ == "__main__":
    sys.exit(main())
