"""Maps of MRPT's programs for SLAM, icp-slam and rbpf-slam, of logs in the format of CARMEN: used by slam-maps, and by localizers.py.

A log has messages ROBOTLASER1 (others are left out): scans with the pose of the odometry. It is written as a rawlog of actions and
sensory frames, which both programs read; carmen2rawlog of MRPT 2.5 gives all messages the same time and no actions. A map is read from
the picture that the programs leave, the path from their text files: one pose for each scan, metres and radians in the frame of the map.
"""
import gzip
import math
import os
import pathlib
import shutil
import struct
import subprocess
import sys

# Side of a cell of the maps, in metres.
CELL_M = 0.05
# Scans enter the map this far apart.
INSERTED_M, INSERTED_DEG = 0.4, 25
N_PARTICLES = 15
# What map servers read: occupied, unknown, free.
OCCUPIED, UNKNOWN, FREE = 0, 205, 254
# Of 255: the free probability of a cell that nothing is known of is 127; one hit or pass moves it farther than this.
UNDECIDED = 12
# Ticks of 100 ns from 1601 to the first scan, which is in 2026.
FIRST_TICK = 134_000_000_000_000_000

MAPS = f"""
gasGrid_count = 0
landmarksMap_count = 0
beaconMap_count = 0
occupancyGrid_count = 1
pointsMap_count = 1

[MappingApplication_occupancyGrid_00_creationOpts]
resolution = {CELL_M}

[MappingApplication_occupancyGrid_00_insertOpts]
mapAltitude = 0
useMapAltitude = 0
maxDistanceInsertion = 30
maxOccupancyUpdateCertainty = 0.65
considerInvalidRangesAsFreeSpace = 0
wideningBeamsWithDistance = 0

[MappingApplication_occupancyGrid_00_likelihoodOpts]
likelihoodMethod = 4
LF_decimation = 5
LF_stdHit = 0.15
LF_maxCorrsDistance = 0.3
LF_zHit = 0.95
LF_zRandom = 0.05
LF_maxRange = 30
LF_alternateAverageMethod = 0
enableLikelihoodCache = 1

[MappingApplication_pointsMap_00_insertOpts]
minDistBetweenLaserPoints = 0.05
fuseWithExisting = 0
isPlanarMap = 1
"""

APPLICATION = """
[MappingApplication]
rawlog_offset = 0
logOutput_dir = {out}
LOG_FREQUENCY = 0
SAVE_3D_SCENE = 0
SAVE_POSE_LOG = 0
SAVE_MAP_IMAGES = 0
CAMERA_3DSCENE_FOLLOWS_ROBOT = 0
verbosity = ERROR
"""

# After the demonstrations that come with MRPT: icp-slam_demo_classic.ini.
ICP_SLAM = APPLICATION + f"""
SHOW_PROGRESS_3D_REAL_TIME = 0
SHOW_LASER_SCANS_3D = 0
localizationLinDistance = 0.1
localizationAngDistance = 3
insertionLinDistance = {INSERTED_M}
insertionAngDistance = {INSERTED_DEG}
minICPgoodnessToAccept = 0.4
matchAgainstTheGrid = 0
likelihoodMapSelection = -1
{MAPS}
[ICP]
ICP_algorithm = icpClassic
maxIterations = 80
minAbsStep_trans = 1e-6
minAbsStep_rot = 1e-6
thresholdDist = 0.3
thresholdAng_DEG = 5
ALFA = 0.8
smallestThresholdDist = 0.05
onlyClosestCorrespondences = 1
onlyUniqueRobust = 1
corresponding_points_decimation = 3
"""

# After gridmapping_RBPF_ICPbased_intel.ini: each particle is moved by scan matching against its own map.
RBPF_SLAM = APPLICATION + f"""
SHOW_PROGRESS_IN_WINDOW = 0
GENERATE_LOG_JOINT_H = 0
GENERATE_LOG_INFO = 0
RANDOM_SEED = {{seed}}
insertionLinDistance = {INSERTED_M}
insertionAngDistance_deg = {INSERTED_DEG}
localizeLinDistance = 0
localizeAngDistance_deg = 0
PF_algorithm = 2
adaptiveSampleSize = 0
resamplingMethod = 0
sampleSize = {N_PARTICLES}
BETA = 0.5
pfOptimalProposal_mapSelection = 3
ICPGlobalAlign_MinQuality = 0.5
likelihoodMapSelection = 0
ICP_algorithm = 1
maxIterations = 60
thresholdDist = 0.5
thresholdAng_DEG = 5
ALFA = 0.5
smallestThresholdDist = 0.05
onlyClosestCorrespondences = 1
{MAPS}
"""

# By name of the program: its configuration, which scans it takes (each, or at this distance and angle from the one before), the
# begin of the names of its maps, the file of its path, how many poses that has before the first scan, and the columns of x, y, yaw.
PROGRAMS = {
    "icp-slam": (ICP_SLAM, (0.0, 0.0), "_finalmaps_.txt", "log_estimated_path.txt", 0, (1, 2, 3)),
    "rbpf-slam": (RBPF_SLAM, (0.2, 8.0), "finalMap", "most_likely_path.txt", 1, (0, 1, 2)),
}


def is_installed():
    """True if MRPT's programs are there, or could be installed."""
    programs = [*PROGRAMS, "pf-localization"]
    is_there = lambda: all(shutil.which(program) for program in programs)
    if not is_there() and os.geteuid() == 0 and shutil.which("apt-get"):
        environment = {**os.environ, "DEBIAN_FRONTEND": "noninteractive"}
        subprocess.run(["apt-get", "update", "-q"], env=environment, stdout=sys.stderr)
        subprocess.run(["apt-get", "install", "-y", "-q", "--no-install-recommends", "mrpt-apps"], env=environment, stdout=sys.stderr)
    return is_there()


def scans(log):
    """Messages of a log, in order: (field of view in radians, largest range in metres, ranges from the right to the left, odometry)."""
    found = []
    for line in pathlib.Path(log).read_text().splitlines():
        words = line.split()
        if not words or words[0] != "ROBOTLASER1":
            continue
        n = int(words[8])
        pose = words[9 + n + 1 + int(words[9 + n]) + 3:][:3]
        found.append((float(words[3]), float(words[5]), [float(word) for word in words[9:9 + n]], [float(word) for word in pose]))
    return found


def thing(name, version, body):
    """An object as MRPT writes it: its class, its version, its fields, and an end."""
    return bytes([len(name) | 0x80]) + name.encode() + bytes([version]) + body + b"\x88"


def pose_2d(x, y, yaw):
    return thing("mrpt::poses::CPose2D", 1, struct.pack("<3d", x, y, yaw))


def movement(step, tick):
    """A motion by odometry, in the frame of the pose before it."""
    gaussian = struct.pack("<I6f", 0, 0.05, 0.01, 0.02, 0.05, 0.01, math.radians(0.3))
    thrun = struct.pack("<I6f", 300, 0.05, 0.05, 0.05, 0.05, 0.001, 0.001)
    body = struct.pack("<i", 0) + pose_2d(*step) + gaussian + thrun + b"\0\0" + struct.pack("<Q", tick)
    return thing("mrpt::obs::CActionRobotMovement2D", 7, body)


def range_scan(field_rad, max_range_m, ranges, tick):
    """A scan of a lidar in the middle of the robot."""
    mounted = thing("mrpt::poses::CPose3D", 3, struct.pack("<12d", 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1))
    label = b"LASER"
    body = struct.pack("<f?f", field_rad, True, max_range_m) + mounted + struct.pack(f"<I{len(ranges)}f", len(ranges), *ranges)
    body += bytes(0 < r < max_range_m for r in ranges) + struct.pack("<fQfI", 0.01, tick, 0, len(label)) + label
    return thing("mrpt::obs::CObservation2DRangeScan", 7, body + struct.pack("<d?", 0, False))


def between(before, after):
    """The motion from a pose to the next, in the frame of the first."""
    dx, dy = after[0] - before[0], after[1] - before[1]
    sin, cos = math.sin(before[2]), math.cos(before[2])
    turn = (after[2] - before[2] + math.pi) % (2 * math.pi) - math.pi
    return [cos * dx + sin * dy, cos * dy - sin * dx, turn]


def taken(program, messages):
    """Numbers of the scans that a program gets, by the odometry."""
    least_m, least_deg = PROGRAMS[program][1]
    numbers = [0]
    for number, message in enumerate(messages):
        dx, dy, turn = between(messages[numbers[-1]][3], message[3])
        if number and (math.hypot(dx, dy) >= least_m or abs(turn) >= math.radians(least_deg)):
            numbers.append(number)
    return numbers


def write_rawlog(path, messages):
    """Scans of a log as pairs of an action and a sensory frame, four in a second."""
    before = messages[0][3]
    with gzip.open(path, "wb", compresslevel=1) as file:
        for number, (field_rad, max_range_m, ranges, pose) in enumerate(messages):
            tick = FIRST_TICK + 2_500_000 * number
            one = struct.pack("<I", 1)
            file.write(thing("mrpt::obs::CActionCollection", 0, one + movement(between(before, pose), tick)))
            file.write(thing("mrpt::obs::CSensoryFrame", 2, one + range_scan(field_rad, max_range_m, ranges, tick)))
            before = pose


def mapped(program, messages, folder, seed):
    """Runs a program on the scans of a log in a folder: (numbers of the scans that it got, their poses, pixels and corner of the map).
    Fails with the end of the program's output."""
    numbers = taken(program, messages)
    write_rawlog(folder / "drive.rawlog", [messages[number] for number in numbers])
    run(program, folder, seed)
    poses = path_of(program, folder)
    if len(poses) != len(numbers):
        raise RuntimeError(f"{program} has {len(poses)} poses of {len(numbers)} scans")
    return numbers, poses, *map_of(program, folder)


def run(program, folder, seed):
    (folder / "options.ini").write_text(PROGRAMS[program][0].format(out=folder / "out", seed=seed))
    command = [program, folder / "options.ini", folder / "drive.rawlog"]
    with open(folder / "output.txt", "w") as output:
        # After an error the programs ask for a key.
        done = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT)
    if done.returncode != 0:
        end = "\n".join((folder / "output.txt").read_text(errors="replace").splitlines()[-15:])
        raise RuntimeError(f"{program} failed with code {done.returncode}:\n{end}")


def path_of(program, folder):
    """The pose of each scan that the program got, in the frame of the map: (x, y, yaw)."""
    *_, name, n_before, columns = PROGRAMS[program]
    rows = [line.split() for line in (folder / "out" / name).read_text().splitlines() if not line.startswith("%")]
    return [tuple(float(row[k]) for k in columns) for row in rows[n_before:]]


def map_of(program, folder):
    """(pixels as a map server reads them, an array of bytes with the first row at the top; (x, y) of the lower left corner), without the
    unknown border."""
    import numpy
    import PIL.Image

    begin = PROGRAMS[program][2]
    picture, = (folder / "out").glob(f"{begin}*COccupancyGridMap2D_00.png")
    limits = picture.with_name(f"{picture.stem}_limits.txt").read_text().splitlines()[-1].split()
    x_min, x_max, y_min, _ = map(float, limits)
    free = numpy.asarray(PIL.Image.open(picture).convert("L")).astype(int)
    height, width = free.shape
    if abs((x_max - x_min) / width - CELL_M) > 1e-6:
        raise RuntimeError(f"{picture} has cells of {(x_max - x_min) / width} m")
    pixels = numpy.full(free.shape, UNKNOWN, numpy.uint8)
    pixels[free > 127 + UNDECIDED] = FREE
    pixels[free < 127 - UNDECIDED] = OCCUPIED
    rows, columns = (numpy.flatnonzero((pixels != UNKNOWN).any(axis)) for axis in (1, 0))
    if not len(rows):
        raise RuntimeError(f"{picture} is of an unknown place")
    top, bottom, left, right = rows[0], rows[-1] + 1, columns[0], columns[-1] + 1
    corner = (float(x_min + left * CELL_M), float(y_min + (height - bottom) * CELL_M))
    return pixels[top:bottom, left:right], corner
