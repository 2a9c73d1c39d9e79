#!/usr/bin/env python3
"""Judges the octree of structure of an output folder: OctoMap's own library reads it, and each cell is held against the bodies.

    python3 scripts/check_octomap.py OUT               judge a folder that `groundplan convert --octomap --with-geometry` wrote
    python3 scripts/check_octomap.py --self-test OUT   damage the octree, too; each damage must be noticed

Needs numpy, trimesh and pyoctomap. Exit codes: 0 all is as it should be, 1 it is not, 2 a folder cannot be read.

Bodies are those of semantic.json, which shares no code with the octree: triangles of elements. Of places drawn at random:

- OctoMap reads as many nodes as the file says, and the volumes of occupied and free cells that structure.json says.
- A place on a face of structure lies in an occupied cell, or in the one on the other side of the face where that lies in both: all.
- A place within a closed body of structure, by trimesh's rays, lies in an occupied cell: all.
- An occupied cell meets structure: a face crosses it, by points spread over the faces, or its middle lies within a body: 99.9 %.
- A free cell holds no place of a face of any element that stands: all.
- Outside of the volume nothing is known.
"""
import argparse
import json
import pathlib
import sys
import tempfile

import numpy as np
import pyoctomap
import trimesh

N_PLACES, N_CELLS = 40_000, 4_000
MET_GOAL = 0.999
# How far off a face a place is looked for: more than the rounding of coordinates.
OFF_M = 2e-4


class Octree:
    """What OctoMap reads of a file."""

    def __init__(self, path):
        self.tree = pyoctomap.OcTree(0.1)
        if not self.tree.readBinary(str(path)):
            raise ValueError(f"{path}: OctoMap cannot read it")
        self.resolution = self.tree.getResolution()

    def at(self, place):
        """True if occupied, False if free, None if unknown."""
        node = self.tree.search(place)
        return None if node is None else bool(self.tree.isNodeOccupied(node))

    def leaves(self):
        """Middle, side and whether it is occupied, of all leaves."""
        found = [(leaf.getCoordinate(), leaf.getSize(), self.tree.isNodeOccupied(leaf)) for leaf in self.tree.begin_leafs()]
        if not found:
            return np.zeros((0, 3)), np.zeros(0), np.zeros(0, bool)
        return tuple(np.asarray(part) for part in zip(*found))


def bodies_of(out):
    """Meshes of the elements that stand, by GlobalId."""
    semantic = json.loads((out / "semantic.json").read_text(encoding="utf-8"))
    found = {}
    for global_id, element in semantic["elements"].items():
        state = (element["schedule"] or {}).get("state")
        if element.get("faces") and state not in ("not_started", "removed"):
            found[global_id] = trimesh.Trimesh(np.array(element["vertices"]), np.array(element["faces"]), process=False)
    return found


def sampled(meshes, n, random):
    """Places on faces, and the normals there."""
    corners = np.concatenate([mesh.triangles for mesh in meshes])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1) / 2
    chosen = random.choice(len(corners), n, p=areas / areas.sum())
    s, t = random.random((2, n))
    s, t = np.where(s + t > 1, 1 - s, s), np.where(s + t > 1, 1 - t, t)
    own = corners[chosen]
    places = own[:, 0] + s[:, None] * (own[:, 1] - own[:, 0]) + t[:, None] * (own[:, 2] - own[:, 0])
    return places, normals[chosen] / (2 * areas[chosen])[:, None]


def within(places, low, high):
    return ((places > low) & (places < high)).all(axis=1)


def judge(octree, told, bodies, structure, random):
    """What is wrong with an octree: a sentence each."""
    wrong = []

    def expect(is_so, what):
        if not is_so:
            wrong.append(what)

    low, high = np.array(told["min_m"]), np.array(told["max_m"])
    middles, sides, occupied = octree.leaves()
    for name, kind in (("occupied_m3", occupied), ("free_m3", ~occupied)):
        volume = float((sides[kind] ** 3).sum())
        expect(abs(volume - told[name]) <= 1e-6 * max(volume, 1.0), f"{name} is {told[name]}, and the tree has {volume:.4f}")
    expect(octree.tree.size() == told["nodes"], "structure.json counts other nodes")
    inside_volume = ((middles - sides[:, None] / 2 > low - 1e-6) & (middles + sides[:, None] / 2 < high + 1e-6)).all(axis=1)
    expect(inside_volume.all(), "cells outside of the volume are known")
    if structure:
        places, normals = sampled(structure, N_PLACES, random)
        chosen = within(places, low + 1e-3, high - 1e-3)
        pairs = zip(places[chosen] + OFF_M * normals[chosen], places[chosen] - OFF_M * normals[chosen])
        missed = sum(not octree.at(a) and not octree.at(b) for a, b in pairs)
        print(f"  {chosen.sum()} places on faces: {missed} in cells that are not occupied")
        expect(missed == 0, "faces of structure lie in cells that are not occupied")
        missed, n = 0, 0
        for mesh in [mesh for mesh in structure if mesh.is_watertight]:
            places = random.uniform(*mesh.bounds, (200, 3))
            places = places[within(places, low + 1e-3, high - 1e-3)]
            places = places[mesh.contains(places)] if len(places) else places
            n += len(places)
            missed += sum(not octree.at(place) for place in places)
        print(f"  {n} places within bodies: {missed} in cells that are not occupied")
        expect(missed == 0, "places within bodies of structure lie in cells that are not occupied")
    smallest = occupied & (sides < 1.5 * octree.resolution)
    share, n = share_met(middles[smallest], octree.resolution, structure, random)
    print(f"  {n} occupied cells of the smallest size: {100 * share:.2f} % meet structure")
    expect(share >= MET_GOAL, "occupied cells meet no structure")
    if bodies:
        places, _ = sampled(list(bodies.values()), N_PLACES, random)
        n = sum(octree.at(place) is False and off_lattice(place, octree.resolution) for place in places)
        print(f"  {len(places)} places on faces of all that stands: {n} in free cells")
        expect(n == 0, "free cells hold faces of what stands")
    return wrong


def off_lattice(place, resolution):
    """True if a place does not lie in the face of a cell, where it belongs to none."""
    share = place / resolution
    return bool((np.abs(share - np.round(share)) * resolution > OFF_M).all())


def share_met(middles, resolution, structure, random):
    """Share of cells that structure meets, by the exact distance of the nearest face, or by their middle; and how many were looked at."""
    if len(middles) == 0 or not structure:
        return 1.0, 0
    chosen = middles[random.choice(len(middles), min(N_CELLS, len(middles)), replace=False)]
    met = np.zeros(len(chosen), bool)
    for mesh in structure:
        near = within(chosen, mesh.bounds[0] - resolution, mesh.bounds[1] + resolution) & ~met
        if near.any():
            nearest, _, _ = trimesh.proximity.closest_point_naive(mesh, chosen[near])
            off = np.abs(nearest - chosen[near]).max(axis=1)
            # The nearest place in a straight line may lie outside of a cell that a face crosses at a corner.
            met[near] |= off <= resolution / 2 + OFF_M
            rest = np.flatnonzero(near)[~met[near]]
            for k in rest:
                met[k] = crosses(mesh, chosen[k], resolution)
    for mesh in [mesh for mesh in structure if mesh.is_watertight]:
        near = within(chosen, *mesh.bounds) & ~met
        if near.any():
            met[near] |= mesh.contains(chosen[near])
    return met.mean(), len(met)


def crosses(mesh, middle, resolution):
    """True if a face, cut to the cell by its six planes, leaves something."""
    low, high = middle - resolution / 2 - OFF_M, middle + resolution / 2 + OFF_M
    corners = mesh.triangles
    near = ((corners.min(axis=1) <= high) & (corners.max(axis=1) >= low)).all(axis=1)
    for triangle in corners[near]:
        polygon = triangle
        for axis in range(3):
            for sign, bound in ((1, low[axis]), (-1, -high[axis])):
                polygon = clipped(polygon, axis, sign, bound)
        if len(polygon):
            return True
    return False


def clipped(polygon, axis, sign, bound):
    """The part of a polygon on which sign * coordinate is at least a bound."""
    found = []
    for k in range(len(polygon)):
        a, b = polygon[k], polygon[(k + 1) % len(polygon)]
        da, db = sign * a[axis] - bound, sign * b[axis] - bound
        if da >= 0:
            found.append(a)
        if da * db < 0:
            found.append(a + (b - a) * da / (da - db))
    return np.array(found)


def damaged(path, change):
    """The octree of a file of which the bytes of the tree are changed."""
    data = path.read_bytes()
    start = data.index(b"\ndata\n") + len(b"\ndata\n")
    with tempfile.NamedTemporaryFile(suffix=".bt") as file:
        file.write(data[:start] + change(data[start:]))
        file.flush()
        return Octree(file.name)


def swapped(byte):
    """Free and occupied children exchanged."""
    return sum({1: 2, 2: 1}.get(byte >> 2 * k & 3, byte >> 2 * k & 3) << 2 * k for k in range(4))


def without_occupied(byte):
    return sum({2: 1}.get(byte >> 2 * k & 3, byte >> 2 * k & 3) << 2 * k for k in range(4))


def without_free(byte):
    return sum({1: 2}.get(byte >> 2 * k & 3, byte >> 2 * k & 3) << 2 * k for k in range(4))


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--self-test", action="store_true", help="damage the octree, too: each damage must be noticed")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT")
    options = parser.parse_args()
    path = options.out / "octomap/structure.bt"
    try:
        octree = Octree(path)
        told = json.loads((options.out / "octomap/structure.json").read_text(encoding="utf-8"))
        bodies = bodies_of(options.out)
        structure = [bodies[global_id] for global_id in told["occupied_by"]]
    except (OSError, KeyError, ValueError) as why:
        print(f"{options.out} cannot be read: {why!r}", file=sys.stderr)
        return 2
    print(f"{options.out}: {octree.tree.size()} nodes, {told['occupied_m3']} m3 occupied, {told['free_m3']} m3 free")
    wrong = judge(octree, told, bodies, structure, np.random.default_rng(3))
    if options.self_test:
        shifted = [trimesh.Trimesh(mesh.vertices + [0.3, 0, 0], mesh.faces, process=False) for mesh in structure]
        cases = {
            "free and occupied exchanged": (damaged(path, lambda data: bytes(map(swapped, data))), structure),
            "occupied cells that are free": (damaged(path, lambda data: bytes(map(without_occupied, data))), structure),
            "free cells that are occupied": (damaged(path, lambda data: bytes(map(without_free, data))), structure),
            "structure moved by 30 cm": (octree, shifted),
        }
        for what, (tree, moved) in cases.items():
            print(f" with {what}:")
            # Volumes that differ would tell alone: the places have to tell, too.
            found = [why for why in judge(tree, told, bodies, moved, np.random.default_rng(3)) if "_m3" not in why]
            if not found:
                wrong.append(f"not noticed: {what}")
    print("\n".join(f"FAIL {why}" for why in wrong) or "PASS")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
