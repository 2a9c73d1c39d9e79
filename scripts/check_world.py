#!/usr/bin/env python3
"""Compares exported worlds with the planning maps beside them, from the exported files alone.

    python3 scripts/check_world.py OUT...          judge the folders that `groundplan convert` or `export` wrote
    python3 scripts/check_world.py --self-test OUT take and add pieces in copies of the world; each must be noticed. Of several folders,
                                                   of one site at several dates, the world of each is none of the next one

Needs numpy and Pillow. Prints a line with the verdict for each folder. Exit codes: 0 all agree, 1 one does not, 2 a folder cannot
be read.

Rays start on free cells of each storey's planning map, at the same place and in the same directions in both:

- in the map they end at the first cell that is occupied by anything but a door;
- in the world they end at the first collision shape of a static model, cut to the heights that the map shows and seen in plan: a
  map is the projection of what stands between the robot's step and its height, so a ray at one height would pass over a table.

Doors move in the world and are passable on maps, so that they are left out on both sides, as are cells that are occupied only
because their room is closed, barriers, and the shapes of sites and roads themselves, which are no obstacles on maps of levels. On
ramps what stands in the way is told by its height above them: rays start on the level of the storey, and are compared up to the edge
of a ramp. On the ground outdoors, where ground.json beside says what that is, rays follow the heights of the map, and end at what
stands on it. A map takes a cell that is touched anywhere, so that along a wall its rays end earlier.
Two ends agree if they are no farther apart than a cell and its diagonal, or if each lies as near to what the other side holds.
99.5 % of all rays have to agree.

Where a storey has heights (elevation.png), a ray falls on the middle of each free cell from the height of the robot, and ends within
2 cm of its height: in 99.5 % of the cells, as it stands where the map says.

Every mesh that collides but that of ground outdoors, in moving models too, is closed when its faces are fanned from their first
corners, as readers do, and convex: engines that take the hull of a mesh and engines that take its triangles then agree.
"""
import argparse
import json
import math
import pathlib
import re
import shutil
import sys
import tempfile
import time
import xml.etree.ElementTree as ElementTree

import numpy as np
from PIL import Image

DOOR = 3
N_STARTS = 400
# How near to its height on the map the ground of the world is.
NEAR_M = 0.02
N_DIRECTIONS = 36
RANGE_M = 20.0
GOAL = 0.995
# A ramp begins within a cell of where its map says so, and a cell that it touches at its side has no height.
RAMP_EDGE_CELLS = 3
# A cell has the height of its middle, in millimetres; its higher side may be in the way before that.
ROUNDED_M = 0.005
# Terrain may be larger than what Pillow takes for an attack.
Image.MAX_IMAGE_PIXELS = None

# Corners of meshes are known to this, in metres.
KNOWN_M = 2e-5


def rotation(roll, pitch, yaw):
    """Roll, pitch, yaw about fixed axes, as SDF has them."""
    cr, sr, cp, sp, cy, sy = (f(a) for a in (roll, pitch, yaw) for f in (math.cos, math.sin))
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])


def pose_of(element):
    values = [float(x) for x in (element.findtext("pose") or "0 0 0 0 0 0").split()]
    return rotation(*values[3:]), np.array(values[:3])


CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
CUBE_FACES = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]


class World:
    """The collision shapes of static models, barriers left out: corners in `map` and faces, and of which link each is."""

    def __init__(self, folder):
        self.meshes = {}
        self.shapes = []
        self.links = []
        self.ground = ground_links(folder)
        root = ElementTree.parse(folder / "world.sdf").getroot()
        for model in root.iter("model"):
            if (model.findtext("static") or "") != "true" or model.get("name").startswith("door_"):
                continue
            for link in model.findall("link"):
                if link.get("name").startswith("barrier_"):
                    continue
                for collision in link.findall("collision"):
                    shape = self.shape(folder, collision)
                    shapes = faces_of(*shape) if link.get("name") in self.ground else [shape]
                    self.shapes += shapes
                    self.links += [link.get("name")] * len(shapes)

    def shape(self, folder, collision):
        turn, shift = pose_of(collision)
        size = collision.findtext("geometry/box/size")
        if size is not None:
            corners, faces = CUBE * np.array([float(x) for x in size.split()]), CUBE_FACES
        else:
            corners, faces = self.mesh(folder / collision.findtext("geometry/mesh/uri"))
        return corners @ turn.T + shift, faces

    def mesh(self, path):
        if path not in self.meshes:
            self.meshes[path] = read_mesh(path)
        return self.meshes[path]

    def plans(self, low, high):
        """Convex plans of what the shapes are between two heights."""
        return [plan for _, plan in self.plans_of_links(low, high)]

    def plans_of_links(self, low, high):
        """Such plans with the name of the link of each."""
        met = ((link, shape) for link, shape in zip(self.links, self.shapes) if meets(shape[0], low, high))
        found = ((link, len(shape[1]), convex_plan(clipped(*shape, low, high))) for link, shape in met)
        # A face that is upright is a line in plan.
        return [(link, plan) for link, n_faces, plan in found if len(plan) >= (3 if n_faces > 1 else 2)]

    def triangles(self):
        """Corners of all faces."""
        fans = [corners[[face[0], face[k], face[k + 1]]] for corners, faces in self.shapes for face in faces for k in range(1, len(face) - 1)]
        return np.array(fans).reshape(-1, 3, 3)


def ground_links(folder):
    """Names of the links of ground outdoors, whose meshes are not convex."""
    elements = json.loads((folder / "lookup.json").read_text(encoding="utf-8"))["elements"]
    return {element["link"] for element in elements.values() if "mesh" in element["pieces"]}


def links_outdoors(out):
    """Names of the links of terrain and roads, by ground.json; None if there is none."""
    if not (out / "ground.json").exists():
        return None
    ground = json.loads((out / "ground.json").read_text(encoding="utf-8"))["elements"]
    outdoors = {element["global_id"] for element in ground if element["class"] in ("terrain", "road")}
    listed = json.loads((out / "world" / "lookup.json").read_text(encoding="utf-8"))["elements"]
    return {element["link"] for global_id, element in listed.items() if global_id in outdoors}


def shapes_of_sites(out):
    """Names of the links of sites and roads with a shape of their own, which are no elements: maps of levels do not have them."""
    elements = json.loads((out / "semantic.json").read_text(encoding="utf-8"))["elements"]
    listed = json.loads((out / "world" / "lookup.json").read_text(encoding="utf-8"))["elements"]
    return {element["link"] for global_id, element in listed.items() if global_id not in elements}


def faces_of(corners, faces):
    """A shape for each face."""
    return [(corners[face], [list(range(len(face)))]) for face in faces]


def faces_over_cells(triangles, shape, origin, side):
    """Of each face that has an area in plan the part of a grid around it, its height in the middle of each cell there, and whether it
    lies over that."""
    for face, z in zip((triangles[:, :, :2] - origin) / side, triangles[:, :, 2]):
        low = np.maximum(np.floor(face.min(axis=0) - 0.5).astype(int), 0)
        high = np.minimum(np.ceil(face.max(axis=0) + 0.5).astype(int), shape[::-1])
        (ax, ay), (bx, by), (cx, cy) = face
        double_area = (by - cy) * (ax - cx) + (cx - bx) * (ay - cy)
        if (low >= high).any() or abs(double_area) < 1e-12:
            continue
        x, y = np.meshgrid(np.arange(low[0], high[0]) + 0.5, np.arange(low[1], high[1]) + 0.5)
        u = ((by - cy) * (x - cx) + (cx - bx) * (y - cy)) / double_area
        v = ((cy - ay) * (x - cx) + (ax - cx) * (y - cy)) / double_area
        is_over = (u >= -1e-6) & (v >= -1e-6) & (u + v <= 1 + 1e-6)
        yield (slice(low[1], high[1]), slice(low[0], high[0])), u * z[0] + v * z[1] + (1 - u - v) * z[2], is_over


def first_below(triangles, start, origin, side):
    """Height of the first face below `start`, a height for each cell, over the middle of the cell; -infinity without one."""
    found = np.full(start.shape, -np.inf)
    for part, height, is_over in faces_over_cells(triangles, start.shape, origin, side):
        found[part] = np.maximum(found[part], np.where(is_over & (height <= start[part]), height, -np.inf))
    return found


def flaw(corners, faces):
    """What keeps a mesh from being closed and convex; None if nothing does."""
    fans = [(face[0], face[k], face[k + 1]) for face in faces for k in range(1, len(face) - 1)]
    edges = [(t[k], t[(k + 1) % 3]) for t in fans for k in range(3)]
    known = set(edges)
    if len(known) < len(edges) or any((b, a) not in known for a, b in edges):
        return "is not closed"
    fans = np.array(fans)
    a, b, c = (corners[fans[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    doubled = np.linalg.norm(normals, axis=1)
    longest = np.max([np.linalg.norm(side, axis=1) for side in (b - a, c - b, a - c)], axis=0)
    # The plane of a narrow triangle is known less well.
    width = doubled / longest
    wide = width > KNOWN_M
    normals = normals[wide] / doubled[wide, None]
    extent = np.linalg.norm(corners.max(0) - corners.min(0))
    before = ((corners[None] - a[wide][:, None]) * normals[:, None]).sum(2).max(1)
    return "is not convex" if (before > 2 * KNOWN_M * (1 + extent / width[wide])).any() else None


def flaws(out):
    """A line for each mesh that collides, is no ground, and is not closed and convex."""
    folder = out / "world"
    ground = ground_links(folder)
    links = (link for link in ElementTree.parse(folder / "world.sdf").getroot().iter("link") if link.get("name") not in ground)
    uris = {e.text for link in links for c in link.iter("collision") for e in c.iter("uri")}
    found = []
    for uri in sorted(uris):
        what = flaw(*read_mesh(folder / uri))
        if what:
            found.append(f"{uri} {what}")
    return found


def read_mesh(path):
    """Corners and faces of an OBJ file."""
    words = [line.split() for line in path.read_text().splitlines()]
    corners = np.array([[float(x) for x in w[1:4]] for w in words if w and w[0] == "v"])
    return corners, [[int(x) - 1 for x in w[1:]] for w in words if w and w[0] == "f"]


def meets(corners, low, high):
    return corners[:, 2].min() < high and low < corners[:, 2].max()


def clipped(corners, faces, low, high):
    inside = [c[:2] for c in corners if low <= c[2] <= high]
    for face in faces:
        for a, b in zip(face, face[1:] + face[:1]):
            a, b = corners[a], corners[b]
            for z in (low, high):
                if (a[2] < z) != (b[2] < z):
                    inside.append((a + (z - a[2]) / (b[2] - a[2]) * (b - a))[:2])
    return inside


def convex_plan(points):
    """Counter-clockwise convex hull by Andrew's monotone chain."""
    points = sorted({(round(float(x), 7), round(float(y), 7)) for x, y in points})
    if len(points) < 2:
        return np.zeros((0, 2))

    def chain(points):
        out = []
        for p in points:
            while len(out) >= 2 and ((out[-1][0] - out[-2][0]) * (p[1] - out[-2][1])
                                     - (out[-1][1] - out[-2][1]) * (p[0] - out[-2][0])) <= 0:
                out.pop()
            out.append(p)
        return out[:-1]

    return np.array(chain(points) + chain(points[::-1]))


class Plans:
    """Convex plans as edges in a lattice of buckets, for rays and for distances."""

    def __init__(self, plans):
        starts = [p for p in plans]
        ends = [np.roll(p, -1, 0) for p in plans]
        self.a = np.concatenate(starts) if starts else np.zeros((0, 2))
        self.b = np.concatenate(ends) if ends else np.zeros((0, 2))
        self.owners = np.array([k for k, p in enumerate(plans) for _ in p], int)

    def cast(self, origin, directions):
        """Length of each ray to the first edge; infinity without one."""
        return self.hits(origin, directions)[0]

    def hits(self, origin, directions):
        """Length of each ray to the first edge, infinity without one, and the number of the plan that it meets."""
        low, high = np.minimum(self.a, self.b), np.maximum(self.a, self.b)
        near = np.flatnonzero(((low <= origin + RANGE_M) & (high >= origin - RANGE_M)).all(1))
        if len(near) == 0:
            return np.full(len(directions), np.inf), np.full(len(directions), -1)
        a, d = self.a[near] - origin, (self.b - self.a)[near]
        u, v = directions[:, :1], directions[:, 1:]
        # a + s d = t (u, v); a row for each ray.
        cross = d[:, 0] * v - d[:, 1] * u
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (a[:, 1] * u - a[:, 0] * v) / cross
            t = (d[:, 0] * a[:, 1] - d[:, 1] * a[:, 0]) / cross
        t[(cross == 0) | (s < -1e-9) | (1 + 1e-9 < s) | (t < 0)] = np.inf
        first = t.argmin(1)
        return t[np.arange(len(t)), first], self.owners[near[first]]

    def distances(self, points):
        """Distance of each point from the nearest edge."""
        d = self.b - self.a
        squared = np.maximum((d * d).sum(1), 1e-18)
        out = np.full(len(points), np.inf)
        for k, p in enumerate(points):
            s = np.clip(((p - self.a) * d).sum(1) / squared, 0, 1)
            off = p - (self.a + s[:, None] * d)
            if len(off):
                out[k] = math.sqrt((off * off).sum(1).min())
        return out


def elevation(folder):
    """Where a storey has ground, its heights in metres, the origin and the side of a cell; rows from below."""
    text = (folder / "elevation.yaml").read_text(encoding="utf-8")

    def value(key):
        return json.loads(re.search(rf"^{key}: (.+)$", text, re.MULTILINE).group(1))

    pixels = np.asarray(Image.open(folder / "elevation.png"), dtype=np.int64)[::-1]
    height = value("offset") + value("scale") * pixels
    return pixels != value("none"), height, np.array(value("origin")[:2]), value("resolution")


class Map:
    """A storey's planning map, row 0 at the bottom; `step_m` is the step that the robot takes."""

    def __init__(self, out, entry, resolution_m, step_m):
        folder = out / entry["directory"]
        planning = np.array(Image.open(folder / "planning.pgm"))[::-1]
        classes = np.array(Image.open(folder / "classes.png"))[::-1]
        self.cell, self.origin = resolution_m, np.array(entry["origin_m"])
        self.solid = (planning == 0) & (classes != 0) & (classes != DOOR)
        self.free = (planning == 254) & (classes == 0)
        # Ground off the level of the storey by more than a step: ramps.
        self.sloped = np.zeros(planning.shape, bool)
        self.has_height, self.height = np.zeros(planning.shape, bool), np.zeros(planning.shape)
        if (folder / "elevation.yaml").exists():
            self.has_height, self.height, _, _ = elevation(folder)
            self.sloped = self.has_height & (np.abs(self.height - entry["floor_z_m"]) > step_m - ROUNDED_M)

    def wrong_heights(self, cast, n_most):
        """(cells, cells that are wrong, one of them): of free cells with a height, evenly taken, those that have another in the world.
        `cast` is given this and which cells are looked at, and gives for each cell the height at which a ray ends that falls on it."""
        looked = self.free & self.has_height
        there = np.flatnonzero(looked)
        if len(there) > n_most:
            looked = np.zeros(looked.shape, bool)
            looked.flat[there[np.linspace(0, len(there) - 1, n_most).astype(int)]] = True
        found = cast(self, looked)
        is_wrong = looked & ~(np.abs(found - self.height) <= NEAR_M)
        wrong = None
        if is_wrong.any():
            row, column = np.argwhere(is_wrong)[is_wrong.sum() // 2]
            x, y = self.origin + (np.array([column, row]) + 0.5) * self.cell
            wrong = f"at ({x:.2f}, {y:.2f}) the map is at {self.height[row, column]:.3f} m, the world at {found[row, column]:.3f} m"
        return int(looked.sum()), int(is_wrong.sum()), wrong

    def starts(self, n):
        """Middles of free cells on the level of the storey, evenly taken."""
        rows, columns = np.nonzero(self.free & ~self.sloped)
        if len(rows) == 0:
            return np.zeros((0, 2))
        chosen = np.linspace(0, len(rows) - 1, min(n, len(rows))).astype(int)
        return self.origin + (np.stack([columns[chosen], rows[chosen]], 1) + 0.5) * self.cell

    def cast(self, origin, directions, cells_that_end):
        """Length of each ray to the first cell that ends it; infinity without one in range. Walks from cell border to cell border."""
        position = np.tile((origin - self.origin) / self.cell, (len(directions), 1))
        cells = np.floor(position).astype(int)
        step = np.where(directions > 0, 1, -1)
        with np.errstate(divide="ignore"):
            per_cell = 1 / np.abs(directions)
        border = np.where(directions > 0, cells + 1 - position, position - cells)
        next_at = np.where(np.abs(directions) > 1e-12, border * per_cell, np.inf)
        lengths = np.full(len(directions), np.inf)
        alive = np.ones(len(directions), bool)
        height, width = cells_that_end.shape
        while alive.any():
            rows = np.flatnonzero(alive)
            axis = np.argmin(next_at[rows], 1)
            at = next_at[rows, axis]
            cells[rows, axis] += step[rows, axis]
            next_at[rows, axis] += per_cell[rows, axis]
            x, y = cells[rows, 0], cells[rows, 1]
            inside = (x >= 0) & (y >= 0) & (x < width) & (y < height) & (at * self.cell <= RANGE_M)
            ends = np.zeros(len(rows), bool)
            ends[inside] = cells_that_end[y[inside], x[inside]]
            lengths[rows[ends]] = at[ends] * self.cell
            alive[rows[ends | ~inside]] = False
        return lengths

    def is_near(self, cells, points, reach):
        """True for points with one of these cells within reach."""
        n = math.ceil(reach / self.cell)
        out = np.zeros(len(points), bool)
        for k, p in enumerate((points - self.origin) / self.cell):
            x, y = (int(math.floor(c)) for c in p)
            block = cells[max(0, y - n):y + n + 1, max(0, x - n):x + n + 1]
            rows, columns = np.nonzero(block)
            if len(rows):
                dx = np.maximum(np.abs(columns + max(0, x - n) + 0.5 - p[0]) - 0.5, 0)
                dy = np.maximum(np.abs(rows + max(0, y - n) + 0.5 - p[1]) - 0.5, 0)
                out[k] = (np.hypot(dx, dy) * self.cell).min() <= reach
        return out


def judge(out):
    """(rays, rays that agree, rays whose ends are as near along the ray, one wrong ray of each storey)."""
    manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
    world = World(out / "world")
    cell, (low, high) = manifest["resolution_m"], manifest["slab_m"]
    reach = cell * math.sqrt(2) + 1e-6
    no_obstacles = shapes_of_sites(out)
    angles = (np.arange(N_DIRECTIONS) + 0.5) / N_DIRECTIONS * 2 * math.pi
    directions = np.stack([np.cos(angles), np.sin(angles)], 1)
    n_rays = n_agree = n_along = 0
    wrong = []
    for entry in manifest["storeys"]:
        grid = Map(out, entry, cell, low)
        if entry["floor"] == "ground":
            outdoors = links_outdoors(out)
            if outdoors is None:
                continue
            stands = [shape for link, shape in zip(world.links, world.shapes) if link not in outdoors]
            counts, line = judge_ground(grid, stands, [low, high], directions, reach)
            n_rays, n_agree, n_along = (a + b for a, b in zip((n_rays, n_agree, n_along), counts))
            wrong += [f"storey {entry['index']}: {line}"] if line else []
            continue
        floor = entry["floor_z_m"]
        found = world.plans_of_links(floor + low + 1e-4, floor + high - 1e-4)
        plans = Plans([plan for link, plan in found if link not in no_obstacles])
        worst = None
        for start in grid.starts(N_STARTS):
            # Behind the edge of a ramp what stands in the way is told by its height above the ramp.
            ramps = grid.cast(start, directions, grid.sloped) - RAMP_EDGE_CELLS * cell
            limit = np.clip(ramps, 0.0, RANGE_M)
            in_map = np.minimum(grid.cast(start, directions, grid.solid), limit)
            in_world = np.minimum(plans.cast(start, directions), limit)
            along = np.abs(in_map - in_world) <= reach
            agree = along.copy()
            rest = np.flatnonzero(~along)
            if len(rest):
                map_ends = start + in_map[rest, None] * directions[rest]
                world_ends = start + in_world[rest, None] * directions[rest]
                known_to_world = (plans.distances(map_ends) <= reach) | (in_map[rest] >= limit[rest])
                known_to_map = grid.is_near(grid.solid, world_ends, reach) | (in_world[rest] >= limit[rest])
                agree[rest] = known_to_world & known_to_map
            n_rays, n_agree, n_along = n_rays + len(directions), n_agree + agree.sum(), n_along + along.sum()
            for k in np.flatnonzero(~agree):
                off = abs(in_map[k] - in_world[k])
                if worst is None or off > worst[0]:
                    worst = (off, start, directions[k], in_map[k], in_world[k])
        if worst is not None:
            _, start, u, m, w = worst
            wrong.append(f"storey {entry['index']}: from ({start[0]:.2f}, {start[1]:.2f}) towards ({u[0]:.2f}, {u[1]:.2f}) "
                         f"the map ends after {m:.2f} m, the world after {w:.2f} m")
    return n_rays, n_agree, n_along, wrong


def judge_ground(grid, stands, slab, directions, reach):
    """((rays, rays that agree, rays whose ends are as near along the ray), one that does not) of the map of the ground outdoors: in the
    world a ray over a cell is at the heights above the ground there, and ends where a shape of those that are no ground stands. Both are
    compared as far as there is ground: not where it is too steep."""
    solid = world_cells(grid, stands, slab)
    nowhere = ~grid.has_height & ~grid.solid
    n_agree = n_along = 0
    wrong = None
    rows, columns = np.nonzero(grid.free)
    chosen = np.linspace(0, len(rows) - 1, min(N_STARTS, len(rows))).astype(int)
    for row, column in zip(rows[chosen], columns[chosen]):
        start = grid.origin + (np.array([column, row]) + 0.5) * grid.cell
        limit = np.clip(grid.cast(start, directions, nowhere) - grid.cell, 0.0, RANGE_M)
        in_map, in_world = (np.minimum(grid.cast(start, directions, cells), limit) for cells in (grid.solid, solid))
        along = np.abs(in_map - in_world) <= reach
        ends = (start + length[:, None] * directions for length in (in_map, in_world))
        known = [grid.is_near(cells, points, reach) | (length >= limit)
                 for cells, points, length in zip((solid, grid.solid), ends, (in_map, in_world))]
        agree = along | (known[0] & known[1])
        n_agree, n_along = n_agree + agree.sum(), n_along + along.sum()
        for k in np.flatnonzero(~agree)[:1]:
            wrong = (f"from ({start[0]:.2f}, {start[1]:.2f}) towards ({directions[k, 0]:.2f}, {directions[k, 1]:.2f}) the map ends after "
                     f"{in_map[k]:.2f} m, the world after {in_world[k]:.2f} m")
    return (len(chosen) * len(directions), n_agree, n_along), wrong


def world_cells(grid, shapes, slab):
    """Cells in which a convex shape stands between heights above the ground there, or above the highest of the nearest cells with ground
    (an edge from which it breaks off): looked for in the middles of quarters of cells."""
    height = np.where(grid.has_height, grid.height, np.nan)
    while np.isnan(height).any() and not np.isnan(height).all():
        padded = np.pad(height, 1, constant_values=np.nan)
        around = [padded[1 + dy:padded.shape[0] - 1 + dy, 1 + dx:padded.shape[1] - 1 + dx] for dx, dy in ((0, 1), (1, 0), (0, -1), (-1, 0))]
        highest = np.where(np.isnan(around), -np.inf, around).max(0)
        height = np.where(np.isnan(height) & np.isfinite(highest), highest, height)
    fine, side = np.kron(height, np.ones((2, 2))), grid.cell / 2
    found = np.zeros(fine.shape, bool)
    for corners, faces in shapes:
        low = np.clip(np.floor((corners[:, :2].min(0) - grid.origin) / side).astype(int), 0, fine.shape[::-1])
        high = np.clip(np.ceil((corners[:, :2].max(0) - grid.origin) / side).astype(int), 0, fine.shape[::-1])
        part = (slice(low[1], high[1]), slice(low[0], high[0]))
        fans = np.array([corners[[face[0], face[k], face[k + 1]]] for face in faces for k in range(1, len(face) - 1)])
        above = np.full(fine[part].shape, np.inf)
        origin = grid.origin + low * side
        top, bottom = first_below(fans, above, origin, side), -first_below(fans * [1, 1, -1], above, origin, side)
        found[part] |= (top > fine[part] + slab[0]) & (bottom < fine[part] + slab[1]) & np.isfinite(top)
    return found.reshape(grid.free.shape[0], 2, grid.free.shape[1], 2).any(axis=(1, 3))


def judge_heights(out, cast_from, n_most=sys.maxsize):
    """(cells with heights, those that are wrong, a line for each storey on which too many are): `cast_from` is given the height above
    the ground from which rays fall, and gives what casts them; `n_most` cells of a storey are looked at."""
    manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
    low, high = manifest["slab_m"]
    n_cells, n_off, wrong = 0, 0, []
    for entry in manifest["storeys"]:
        n, n_wrong, line = Map(out, entry, manifest["resolution_m"], low).wrong_heights(cast_from(high), n_most)
        n_cells, n_off = n_cells + n, n_off + n_wrong
        if n_wrong > (1 - GOAL) * n:
            wrong.append(f"storey {entry['index']}: {n_wrong} of {n} cells are at other heights: {line}")
    return n_cells, n_off, wrong


def heights_of_world(out):
    """The verdict on the heights of a world, as `judge_heights` gives it."""
    triangles = World(out / "world").triangles()
    return judge_heights(out, lambda high: lambda grid, _: first_below(triangles, grid.height + high, grid.origin, grid.cell))


def verdict(out):
    start = time.monotonic()
    n_rays, n_agree, n_along, wrong = judge(out)
    share = n_agree / n_rays if n_rays else 1.0
    bad_meshes = flaws(out)
    n_heights, n_off, wrong_heights = heights_of_world(out)
    is_good = share >= GOAL and not bad_meshes and not wrong_heights
    if not is_good:
        print("\n".join(f"  {line}" for line in (bad_meshes + wrong_heights + wrong)[:20]))
    print(f"{'ok  ' if is_good else 'FAIL'} {out.name}: {n_agree} of {n_rays} rays agree ({100 * share:.2f} %), "
          f"{100 * n_along / max(n_rays, 1):.1f} % along the ray, {n_heights - n_off} of {n_heights} heights; {time.monotonic() - start:.1f} s", flush=True)
    return is_good


def self_test(out):
    """Takes every fifth collision of the world away, shifts all by 0.2 m, dents and opens a mesh, sinks and moves the ground: all must be
    noticed."""
    is_good = verdict(out)
    dented = np.vstack([CUBE, [[0.2, 0.0, 0.0]]]), [[4, 6, 8], [6, 7, 8], [7, 5, 8], [5, 4, 8], *CUBE_FACES[:1], *CUBE_FACES[2:]]
    for name, mesh, expected in (("a cube", (CUBE, CUBE_FACES), None), ("an open cube", (CUBE, CUBE_FACES[1:]), "is not closed"),
                                 ("a dented cube", dented, "is not convex")):
        is_noticed = flaw(*mesh) == expected
        is_good &= is_noticed
        print(f"{'ok  ' if is_noticed else 'FAIL'} {name}: {flaw(*mesh)}", flush=True)
    for name, damage in (("a fifth of the pieces is missing", thinned), ("the world is shifted", shifted)):
        with tempfile.TemporaryDirectory() as home:
            copy = pathlib.Path(home) / name.replace(" ", "-")
            shutil.copytree(out, copy)
            path = copy / "world" / "world.sdf"
            tree = ElementTree.parse(path)
            damage(tree.getroot())
            tree.write(path)
            n_rays, n_agree, _, _ = judge(copy)
            is_noticed = n_agree < GOAL * n_rays
            is_good &= is_noticed
            print(f"{'ok  ' if is_noticed else 'FAIL'} {name}: {100 * n_agree / max(n_rays, 1):.2f} % agree", flush=True)
    ground = ground_links(out / "world")
    for name, by in (("the ground lies 5 cm lower", (0.0, 0.0, -0.05)), ("the ground lies 1 m farther east", (1.0, 0.0, 0.0))):
        if ground:
            is_good &= is_height_noticed(name, out, lambda world: move_ground(world, ground, by))
    return is_good


def is_height_noticed(name, out, damage):
    """Damages the world in a copy of a folder: its heights must be wrong."""
    with tempfile.TemporaryDirectory() as home:
        copy = pathlib.Path(home) / "copy"
        shutil.copytree(out, copy)
        damage(copy / "world")
        n_heights, n_off, wrong = heights_of_world(copy)
    print(f"{'ok  ' if wrong else 'FAIL'} {name}: {n_off} of {n_heights} heights are wrong", flush=True)
    return bool(wrong)


def move_ground(world, links, by):
    """Moves the collisions of links."""
    tree = ElementTree.parse(world / "world.sdf")
    for link in (link for link in tree.getroot().iter("link") if link.get("name") in links):
        for collision in link.findall("collision"):
            pose = collision.find("pose")
            if pose is None:
                pose = ElementTree.SubElement(collision, "pose")
            values = [float(x) for x in (pose.text or "0 0 0 0 0 0").split()]
            pose.text = " ".join(str(x) for x in [*np.add(values[:3], by), *values[3:]])
    tree.write(world / "world.sdf")


def dates_are_told_apart(folders):
    """The world of a folder beside the maps of the next one, which is of another date, must be noticed."""
    def replaced(world, other):
        shutil.rmtree(world)
        shutil.copytree(other / "world", world)

    pairs = list(zip(folders, folders[1:]))
    return all([is_height_noticed(f"the world of {a.name} at {b.name}", b, lambda world, a=a: replaced(world, a)) for a, b in pairs])


def thinned(root):
    n = 0
    for link in root.iter("link"):
        for collision in link.findall("collision"):
            n += 1
            if n % 5 == 0:
                link.remove(collision)


def shifted(root):
    for collision in root.iter("collision"):
        pose = collision.find("pose")
        if pose is not None:
            values = pose.text.split()
            pose.text = " ".join([str(float(values[0]) + 0.2), *values[1:]])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--self-test", action="store_true", help="damage copies of the worlds too: each must be noticed")
    parser.add_argument("folders", metavar="OUT", nargs="+", type=pathlib.Path)
    options = parser.parse_args()
    look = self_test if options.self_test else verdict
    try:
        verdicts = [look(out) for out in options.folders]
        if options.self_test:
            verdicts.append(dates_are_told_apart(options.folders))
    except (OSError, ValueError, LookupError, TypeError, ElementTree.ParseError) as problem:
        print(f"scripts/check_world.py: cannot read the folder: {type(problem).__name__}: {problem}", file=sys.stderr)
        return 2
    return 0 if all(verdicts) else 1


if __name__ == "__main__":
    sys.exit(main())
