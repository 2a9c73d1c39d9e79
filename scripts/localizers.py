"""Localizers that are not ours, on a map of occupancies with scans and odometry: used by check_localization.py.

AMCL is Nav2's, as the package amcl of PyPI has it (GPL-3.0), pf-localization MRPT's program; both are particle filters, AMCL's with a
model of beams, MRPT's with a field of likelihoods around walls.
"""
import dataclasses
import gzip
import importlib.util
import math
import pathlib
import re
import struct
import subprocess
import tempfile

import numpy as np

import mrpt_slam

OCCUPIED, FREE, UNKNOWN = 100, 0, -1
# How well the first pose is known: standard deviations of x and y in metres, and of the yaw in radians.
START_OFF_M, START_OFF_RAD = 0.5, math.radians(15)


@dataclasses.dataclass
class Task:
    """What a localizer gets: it gives (x, y, yaw) in the frame of the map for each scan."""

    # Occupancies with the lowest row first, metres per cell, lower left corner.
    cells: np.ndarray
    cell: float
    origin: np.ndarray
    # (x, y, yaw), about where the first scan is.
    start: tuple
    # For each scan the pose of the odometry in a frame of its own, and the lengths of the rays; their bearings, evenly from the right
    # to the left, and the length of a ray that meets nothing.
    odometry: list
    ranges: np.ndarray
    bearings: np.ndarray
    range_m: float


def amcl_poses(task):
    """The mean of AMCL's particles after each scan; the same in each process. Nav2's settings, but the noise of the odometry."""
    import amcl

    motion = amcl.MotionParameters(0.05, 0.05, 0.05, 0.05, 0.05)
    # z_hit, z_short, z_max, z_rand, sigma_hit, lambda_short; it looks for no outliers.
    laser = amcl.LaserParameters(0.5, 0.05, 0.05, 0.5, 0.2, 0.1, 0.0, len(task.bearings))
    # 100 to 500 particles, none of them at random places.
    localizer = amcl.AMCL(100, 500, 0.0, 0.0, motion, laser, "differential")
    localizer.set_map(amcl.create_occupancy_grid_from_list(task.cells.tolist(), task.cell, *map(float, task.origin)))
    # It belongs to the map, and is anywhere if nothing says where it is.
    localizer.set_laser_pose(amcl.Vector3D(0.0, 0.0, 0.0))
    variance = amcl.create_diagonal_covariance(START_OFF_M**2, START_OFF_M**2, START_OFF_RAD**2)
    localizer.set_initial_pose(amcl.Vector3D(*task.start), variance)
    poses = []
    for odometry, ranges in zip(task.odometry, task.ranges):
        scan = amcl.create_laser_scan_from_list(np.stack([ranges, task.bearings], 1).tolist(), task.range_m)
        localizer.update(scan, amcl.Vector3D(*odometry))
        mean = localizer.get_pose_mean()
        poses.append((mean.x, mean.y, mean.theta))
    return poses


PF_LOCALIZATION = """
[LocalizationExperiment]
particles_count = 3000
logOutput_dir = {home}/out
map_file = {home}/map.gridmap.gz
rawlog_file = {home}/drive.rawlog
3DSceneFrequency = -1
SHOW_PROGRESS_3D_REAL_TIME = false
init_PDF_mode = 1
init_PDF_min_x = {low[0]}
init_PDF_max_x = {high[0]}
init_PDF_min_y = {low[1]}
init_PDF_max_y = {high[1]}
init_PDF_min_yaw_deg = {low[2]}
init_PDF_max_yaw_deg = {high[2]}

[PF_options]
PF_algorithm = 0
resamplingMethod = 0
adaptiveSampleSize = true
sampleSize = 1
BETA = 0.5
powFactor = 1

[KLD_options]
KLD_binSize_PHI_deg = 5
KLD_binSize_XY = 0.1
KLD_delta = 0.02
KLD_epsilon = 0.02
KLD_minSampleSize = 300
KLD_maxSampleSize = 3000
KLD_minSamplesPerBin = 0

[MetricMap]
occupancyGrid_count = 1
pointsMap_count = 0

[MetricMap_occupancyGrid_00_creationOpts]
resolution = {cell}
disableSaveAs3DObject = 0

[MetricMap_occupancyGrid_00_likelihoodOpts]
likelihoodMethod = 4
LF_decimation = 1
LF_stdHit = 0.2
LF_maxCorrsDistance = 0.5
LF_zHit = 0.9
LF_zRandom = 0.1
LF_maxRange = {range_m}
LF_alternateAverageMethod = 0
enableLikelihoodCache = true
"""
ESTIMATED = re.compile(r"PDF estimation: \(([-+.\de]+),([-+.\de]+),([-+.\de]+)deg\)")


def mrpt_poses(task):
    """The mean of the particles of pf-localization after each scan but the first, which it does not use; at random."""
    with tempfile.TemporaryDirectory() as name:
        home = pathlib.Path(name)
        write_gridmap(home / "map.gridmap.gz", task)
        field_rad = float(task.bearings[-1] - task.bearings[0])
        scans = zip(task.ranges, task.odometry)
        messages = [(field_rad, task.range_m, ranges.tolist(), list(odometry)) for ranges, odometry in scans]
        mrpt_slam.write_rawlog(home / "drive.rawlog", messages)
        x, y, yaw = task.start
        middle = np.array([x, y, math.degrees(yaw)])
        width = np.array([START_OFF_M, START_OFF_M, math.degrees(START_OFF_RAD)])
        options = PF_LOCALIZATION.format(home=home, low=middle - width, high=middle + width, cell=task.cell, range_m=task.range_m)
        (home / "options.ini").write_text(options)
        # After an error it asks for a key.
        command = ["pf-localization", home / "options.ini"]
        done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    poses = [(float(x), float(y), math.radians(float(yaw))) for x, y, yaw in ESTIMATED.findall(done.stdout)]
    if done.returncode != 0 or len(poses) != len(task.ranges):
        end = "\n".join(done.stdout.splitlines()[-15:])
        raise ValueError(f"pf-localization ended with code {done.returncode} and {len(poses)} poses of {len(task.ranges)}:\n{end}")
    return poses


def write_gridmap(path, task):
    """A map as MRPT had it in its first version, which all later ones read: of each cell how probably it is free, of 255."""
    height, width = task.cells.shape
    (left, low), cell = task.origin, task.cell
    free = np.select([task.cells == OCCUPIED, task.cells == FREE], [0, 255], 127).astype(np.uint8)
    limits = struct.pack("<2I5f", width, height, left, left + width * cell, low, low + height * cell, cell)
    with gzip.open(path, "wb", compresslevel=1) as file:
        file.write(mrpt_slam.thing("mrpt::maps::COccupancyGridMap2D", 0, limits + free.tobytes()))


LOCALIZERS = {"amcl": amcl_poses, "mrpt": mrpt_poses}


def is_available(localizer):
    return mrpt_slam.is_installed() if localizer == "mrpt" else importlib.util.find_spec("amcl") is not None
