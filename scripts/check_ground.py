#!/usr/bin/env python3
"""Reads ground.ply as a mesh tool does, and compares it with ground.json beside it and with the heights of the maps.

    python3 scripts/check_ground.py OUT...    judge the folders that `groundplan convert --with-ground` or `export --with-ground` wrote

Needs trimesh, numpy and Pillow. Prints a line of JSON for each folder: faces, area in plan, area by class, and by storey the share of
the cells of elevation.png in whose middle a face lies within 2 cm of their height; with `--world`, how many rays that fall into
world/site.glb end at the height of their cell. Exit codes: 0 all agree, 1 one does not, 2 a folder cannot be read.

Every face looks up, is no steeper than it says, has a class, an element and a surface of ground.json; surfaces have the area that is
said there, and their faces are of their class. Of the heights 99.5 % agree.
"""
import json
import pathlib
import sys

import numpy as np
import trimesh

from check_world import elevation, faces_over_cells, first_below, judge_heights

AREA_M2 = 1e-3
SLOPE_RAD = 2e-3
NARROW_M = 0.1
NEAR_M = 0.02
AGREE = 0.995


def nearest_face_m(corners, height, origin, side):
    """How far the nearest face lies above or below the height of each cell, in its middle."""
    nearest = np.full(height.shape, np.inf)
    for part, z, is_over in faces_over_cells(corners, height.shape, origin, side):
        nearest[part] = np.minimum(nearest[part], np.where(is_over, np.abs(z - height[part]), np.inf))
    return nearest


def heights(folder, corners):
    """Share of the cells with ground that agree, by storey."""
    shares = {}
    for yaml in sorted(folder.glob("storeys/*/elevation.yaml")):
        there, height, origin, side = elevation(yaml.parent)
        if there.any():
            shares[yaml.parent.name] = float((nearest_face_m(corners, height, origin, side)[there] <= NEAR_M).mean())
    return shares


def heights_of_model(folder):
    """The verdict on the heights of the world as viewers have it, which is Y up, as `judge_heights` gives it."""
    scene = trimesh.load(folder / "world" / "site.glb")
    x, y, z = np.moveaxis(scene.to_geometry().triangles, 2, 0)
    triangles = np.stack([x, -z, y], axis=2)
    return judge_heights(folder, lambda high: lambda grid, _: first_below(triangles, grid.height + high, grid.origin, grid.cell))


def check(folder):
    document = json.loads((folder / "ground.json").read_text())
    mesh = trimesh.load(folder / "ground.ply", process=False)
    if mesh.is_empty:
        faults = ["the mesh is empty, and there are surfaces"] if document["surfaces"] else []
        return faults, {"faces": 0, "area_m2": 0.0, "classes": {}}
    columns = mesh.metadata["_ply_raw"]["face"]["data"]
    of_face = {name: np.asarray(columns[name]).reshape(-1) for name in ("class", "slope", "element", "surface")}
    corners = mesh.vertices[mesh.faces]
    u, v = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = np.cross(u, v)
    plan_m2 = normals[:, 2] / 2
    slope = np.arccos(np.clip(normals[:, 2] / np.linalg.norm(normals, axis=1), -1, 1))
    names = {entry["id"]: entry["name"] for entry in document["classes"]}
    faults = []

    def expect(is_so, what):
        if not is_so:
            faults.append(what)

    expect((plan_m2 > 0).all(), "a face does not look up")
    # Corners are rounded: a face narrower than this has no slope that they would tell.
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    wide = 2 * plan_m2 / longest > NARROW_M
    expect((np.abs(slope - of_face["slope"])[wide] < SLOPE_RAD).all(), "a slope is not that of its face")
    expect((of_face["slope"] <= document["max_slope_rad"] + 1e-6).all(), "a face is steeper than the limit")
    expect(of_face["element"].max(initial=-1) < len(document["elements"]), "an element is not listed")
    for index, surface in enumerate(document["surfaces"]):
        own = of_face["surface"] == index
        expect(own.sum() == surface["n_faces"], f"surface {index} has another number of faces")
        expect(abs(plan_m2[own].sum() - surface["area_m2"]) < AREA_M2, f"surface {index} has another area")
        expect({names.get(k) for k in of_face["class"][own]} == {surface["class"]}, f"surface {index} has another class")
    expect(of_face["element"].min(initial=0) >= 0, "a face has no element")
    classes = [document["elements"][k]["class"] for k in of_face["element"]]
    expect([names[k] for k in of_face["class"]] == classes, "a face has another class than its element")
    by_class = {}
    for k, area in zip(of_face["class"], plan_m2):
        by_class[names[k]] = by_class.get(names[k], 0.0) + float(area)
    agree = heights(folder, corners)
    for storey, share in agree.items():
        expect(share >= AGREE, f"{storey}: {100 * (1 - share):.2f} % of its heights are not those of the ground")
    counted = {"faces": len(mesh.faces), "area_m2": float(plan_m2.sum()), "classes": by_class, "heights_agree": agree}
    if (folder / "world" / "site.glb").exists():
        n_cells, n_off, wrong = heights_of_model(folder)
        faults += [f"world/site.glb: {line}" for line in wrong]
        counted["heights_in_world"] = [n_cells - n_off, n_cells]
    return faults, counted


def main():
    code = 0
    for folder in map(pathlib.Path, sys.argv[1:]):
        try:
            faults, counted = check(folder)
        except (OSError, ValueError, KeyError) as error:
            print(f"{folder}: cannot be read: {error}", file=sys.stderr)
            return 2
        for fault in faults:
            print(f"{folder}: {fault}", file=sys.stderr)
            code = 1
        print(json.dumps(counted))
    return code


if __name__ == "__main__":
    sys.exit(main())
