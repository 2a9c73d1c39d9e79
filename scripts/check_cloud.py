#!/usr/bin/env python3
"""Judges the cloud of structure of an output folder by programs of others: what MuJoCo's rays find, and where small_gicp puts scans.

    python3 scripts/check_cloud.py OUT               judge a folder that `groundplan convert --world --cloud` wrote
    python3 scripts/check_cloud.py --self-test OUT   damage the cloud, too; each damage must be noticed

Needs numpy, Pillow, mujoco, pypcd4, trimesh and small_gicp. Exit codes: 0 all is as it should be, 1 it is not, 2 a folder cannot be
read.

- pypcd4 and trimesh read the same points, normals, classes and elements from structure.pcd and structure.ply.
- A ray that goes back to a point from 5 cm in front of it ends within 2 cm of it: 99.5 % of those in front of which it is clear.
- Where rays of a lidar at the scan poses of the mission meet an element of the cloud, points are near: within 1.5 spacings, 99.5 %.
- A scan of such a lidar, with noise, is put within 5 cm of where it was made by small_gicp, which begins 30 cm and 5 degrees off: 95 %.
"""
import argparse
import json
import math
import pathlib
import sys

import numpy as np
import small_gicp
import trimesh
from pypcd4 import PointCloud

from check_mujoco import Simulation

IN_FRONT_M, NEAR_M, SURFACE_GOAL = 0.05, 0.02, 0.995
N_POINTS, N_SCANS = 20_000, 24
RINGS = np.radians(np.linspace(-40, 40, 32))
AZIMUTHS = np.radians(np.arange(0, 360, 1.0))
RANGE_M, NOISE_M = 30.0, 0.01
COVERED_SPACINGS, COVERED_GOAL = 1.5, 0.995
BEGIN_OFF_M, BEGIN_OFF_RAD = 0.3, math.radians(5)
# From coarse to fine: how far a point of the scan may be from that of the cloud to which it belongs.
REACHES_M = (0.6, 0.3, 0.1)
FOUND_M, FOUND_GOAL = 0.05, 0.95


def read(out):
    """Points, normals, classes and elements of both files, which have to be the same; and what structure.json says."""
    pcd = PointCloud.from_path(out / "cloud/structure.pcd")
    points, normals = (np.asarray(pcd.numpy(names)) for names in [("x", "y", "z"), ("normal_x", "normal_y", "normal_z")])
    classes, elements = (np.asarray(pcd.pc_data[name]) for name in ["label", "element"])
    ply = trimesh.load(out / "cloud/structure.ply", process=False)
    rows = ply.metadata["_ply_raw"]["vertex"]["data"]
    same = [np.array_equal(np.stack([rows[axis] for axis in names], 1), part)
            for names, part in [(("x", "y", "z"), points), (("nx", "ny", "nz"), normals)]]
    same += [np.array_equal(rows["class"], classes), np.array_equal(rows["element"], elements)]
    told = json.loads((out / "cloud/structure.json").read_text(encoding="utf-8"))
    wrong = [] if all(same) else ["structure.pcd and structure.ply differ"]
    counts = np.bincount(elements.astype(int), minlength=len(told["elements"]))
    if len(points) != told["points"] or [entry["points"] for entry in told["elements"]] != counts.tolist():
        wrong.append("structure.json counts other points")
    return points.astype(float), normals.astype(float), told, wrong


def share_on_surfaces(points, normals, simulation, random):
    """Share of points at which a ray from in front of them ends, of those with nothing in front; and how many these are."""
    chosen = random.choice(len(points), min(N_POINTS, len(points)), replace=False)
    on, clear = 0, 0
    for point, normal in zip(points[chosen], normals[chosen]):
        front = point + IN_FRONT_M * normal
        [out, back] = (simulation.cast(start, np.array([towards]))[0] for start, towards in [(point + 1e-3 * normal, normal), (front, -normal)])
        if out > IN_FRONT_M:
            clear += 1
            on += abs(back - IN_FRONT_M) <= NEAR_M
    return on / max(clear, 1), clear


def directions():
    azimuth, ring = (a.flatten() for a in np.meshgrid(AZIMUTHS, RINGS))
    return np.stack([np.cos(ring) * np.cos(azimuth), np.cos(ring) * np.sin(azimuth), np.sin(ring)], 1)


def scans_of(out, simulation, random):
    """(place of the sensor, hits, true where an element of the cloud is hit) of scan poses of the mission."""
    told = json.loads((out / "cloud/structure.json").read_text(encoding="utf-8"))
    of_cloud = {entry["global_id"] for entry in told["elements"]}
    poses = [w for w in json.loads((out / "waypoints.json").read_text(encoding="utf-8"))["waypoints"] if w["kind"] == "scan"]
    rays = directions()
    for pose in [poses[k] for k in random.permutation(len(poses))[:N_SCANS]]:
        start = np.array(pose.get("sensor_m") or [pose["x_m"], pose["y_m"], pose["sensor_z_m"]])
        lengths, geoms = simulation.meet(start, rays)
        met = lengths < RANGE_M
        # A link is named by class and GlobalId, which may have underscores itself.
        ids = {geom: simulation.model.geom(geom).name.split(" ")[0][-22:] for geom in set(geoms[met])}
        yield start, start + rays[met] * lengths[met, None], np.array([ids[geom] in of_cloud for geom in geoms[met]])


def share_covered(scans, points, normals, spacing_m):
    """Share of hits on elements of the cloud that have a point near which looks to the sensor; and how many hits these are."""
    tree = small_gicp.KdTree(points)
    covered, n = 0, 0
    for start, hits, of_cloud in scans:
        for hit in hits[of_cloud][::4]:
            found, nearest, off_m2 = tree.nearest_neighbor_search(hit)
            n += 1
            covered += bool(found) and off_m2 <= (COVERED_SPACINGS * spacing_m) ** 2 and looks_to(points, normals, nearest, hit, start)
    return covered / max(n, 1), n


def looks_to(points, normals, nearest, hit, start):
    """True if the nearest point looks to the sensor, or lies around an edge of what was hit."""
    return (start - hit) @ normals[nearest] > 0 or abs((hit - points[nearest]) @ normals[nearest]) > 1e-3


def turned(yaw, shift):
    found = np.eye(4)
    found[:2, :2] = [[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]]
    found[:3, 3] = shift
    return found


def errors_of(scans, points, normals, random):
    """How far from where it was made each scan is put, in metres. Faces that look away from where the robot is thought to be are left
    out first, because a wall has two sides that are alike: that is what the normals are for."""
    found = []
    for start, hits, _ in scans:
        lengths = np.linalg.norm(hits - start, axis=1)
        seen = start + (hits - start) * (1 + random.normal(0, NOISE_M, len(hits)) / lengths)[:, None]
        source, _ = small_gicp.preprocess_points(seen - start, downsampling_resolution=0.1)
        angle = random.uniform(0, 2 * math.pi)
        thought = start + BEGIN_OFF_M * np.array([math.cos(angle), math.sin(angle), 0])
        towards = thought - points
        chosen = (np.einsum("ij,ij->i", towards, normals) > 0) & (np.einsum("ij,ij->i", towards, towards) < RANGE_M**2)
        if not chosen.any():
            found.append(math.inf)
            continue
        cloud, tree = small_gicp.preprocess_points(points[chosen], downsampling_resolution=0.1)
        guess = turned(random.choice([-1, 1]) * BEGIN_OFF_RAD, thought)
        for reach_m in REACHES_M:
            result = small_gicp.align(cloud, source, tree, guess, registration_type="GICP", max_correspondence_distance=reach_m, max_iterations=60)
            guess = result.T_target_source
        found.append(float(np.linalg.norm(guess[:3, 3] - start)))
    return np.array(found)


def judge(points, normals, told, scans, simulation):
    """What is wrong with a cloud: a sentence each."""
    wrong, random = [], np.random.default_rng(7)
    share, clear = share_on_surfaces(points, normals, simulation, random)
    print(f"  rays back to points: {100 * share:.2f} % of {clear} end there")
    if share < SURFACE_GOAL or clear == 0:
        wrong.append("points do not lie on the surfaces of the world, or look the wrong way")
    share, n = share_covered(scans, points, normals, told["spacing_m"])
    print(f"  surfaces that lidars see: {100 * share:.2f} % of {n} hits have points near")
    if share < COVERED_GOAL and n > 0:
        wrong.append("surfaces that lidars see have no points")
    if not scans:
        print("  no scan poses: nothing to match")
        return wrong
    errors = errors_of(scans, points, normals, random)
    within = (errors <= FOUND_M).mean()
    print(f"  small_gicp: {100 * within:.0f} % of {len(errors)} scans within {100 * FOUND_M:.0f} cm; median {np.median(errors):.4f} m, "
          f"largest {errors.max():.3f} m")
    if within < FOUND_GOAL:
        wrong.append("scans are not found on the cloud")
    return wrong


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--self-test", action="store_true", help="damage the cloud, too: each damage must be noticed")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT")
    options = parser.parse_args()
    try:
        points, normals, told, wrong = read(options.out)
        simulation = Simulation(options.out / "world")
        simulation.put({})
        scans = list(scans_of(options.out, simulation, np.random.default_rng(5)))
    except (OSError, KeyError, ValueError) as why:
        print(f"{options.out} cannot be read: {why}", file=sys.stderr)
        return 2
    print(f"{options.out}: {len(points)} points")
    if len(points) == 0:
        print("\n".join(f"FAIL {why}" for why in wrong) or "PASS: nothing to judge")
        return 1 if wrong else 0
    wrong += judge(points, normals, told, scans, simulation)
    if options.self_test:
        middle = np.median(points[:, 0])
        damages = {
            "points moved by 6 cm": (points + [0.06, 0, 0], normals),
            "normals that look inwards": (points, -normals),
            "half of it left out": (points[points[:, 0] < middle], normals[points[:, 0] < middle]),
            "a scale of 2 %": (points * 1.02, normals),
        }
        for what, (damaged, looks) in damages.items():
            print(f" with {what}:")
            if not judge(damaged, looks, told, scans, simulation):
                wrong.append(f"not noticed: {what}")
    print("\n".join(f"FAIL {why}" for why in wrong) or "PASS")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
