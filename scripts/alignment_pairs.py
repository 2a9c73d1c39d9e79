"""Pairs of maps with their true poses, as slam-pairs writes them: read, and compared with the poses of answers."""
import json
import math

# A pose is found at its place within these: metres at the middle of the SLAM map, degrees.
FOUND = (0.5, 4.0)
# Much of the walls is in no model: share of the SLAM map's.
CLUTTER = (0.45, 0.70)


def lines(path):
    return [json.loads(line) for line in path.read_text().splitlines() if line.strip()]


def errors(pose, truth):
    """(metres at the middle of the SLAM map, degrees)"""
    def moved(p):
        (x, y), (cos, sin) = truth["centre"], (math.cos(p["yaw"]), math.sin(p["yaw"]))
        return cos * x - sin * y + p["x"], sin * x + cos * y + p["y"]

    turn = (pose["yaw"] - truth["yaw"] + math.pi) % (2 * math.pi) - math.pi
    return math.dist(moved(pose), moved(truth)), abs(math.degrees(turn))


def is_within(pose, truth, limits):
    return all(e <= limit for e, limit in zip(errors(pose, truth), limits))


def is_cluttered(truth):
    return CLUTTER[0] <= truth["clutter_share"] <= CLUTTER[1]


def drives(answers, truths):
    """The looks of each drive at its growing map, in order: lists of (answer, truth)."""
    looks = {}
    for answer in answers:
        truth = truths[answer["pair"]]
        if "drive" in truth:
            looks.setdefault(truth["drive"], []).append((answer, truth))
    return [sorted(of, key=lambda look: look[1]["look"]) for of in looks.values()]
