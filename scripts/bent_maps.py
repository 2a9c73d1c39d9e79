"""What alignments of real SLAM maps say about where the robot is, against the true trajectory: used by bench-align and by tests.

A folder has NAME-slam.yaml (the robot's map), NAME-reference.yaml and NAME-trajectory.csv: where the robot was in its map
(slam_x_m, slam_y_m) and where that is in the reference (true_x_m, true_y_m).
"""
import csv
import json
import math
import pathlib
import subprocess
import tempfile

from alignment_pairs import lines

# Up to this deviation a pose may be used (--max-uncertainty), in metres.
USABLE_M = 0.1
# A robot is where an answer puts it within three deviations, or this.
LEAST_OFF_M = 0.15
# Of two degrees of freedom, at 95 %.
GATE = 5.991


def names(folder):
    """The maps of a folder that have a trajectory."""
    suffix = "-trajectory.csv"
    return sorted(path.name.removesuffix(suffix) for path in pathlib.Path(folder).glob(f"*{suffix}"))


def trajectory(folder, name):
    """Places in the SLAM map, each with the true place in the reference."""
    with open(pathlib.Path(folder) / f"{name}-trajectory.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    pairs = [[[float(row[f"{kind}_{axis}_m"]) for axis in "xy"] for kind in ("slam", "true")] for row in rows]
    return [pair[0] for pair in pairs], [pair[1] for pair in pairs]


def aligned(program, pairs):
    """The answers to pairs of maps, in their order."""
    with tempfile.TemporaryDirectory() as home:
        (pathlib.Path(home) / "pairs.jsonl").write_text("".join(json.dumps(pair) + "\n" for pair in pairs))
        done = subprocess.run([program, "align", "--pairs", home, "--json-lines"], stdout=subprocess.PIPE, text=True, check=True)
    return list(map(json.loads, done.stdout.splitlines()))


def answers(program, folder):
    """By name of a map: its answer, places, and true places."""
    folder = pathlib.Path(folder).resolve()
    drives = {name: trajectory(folder, name) for name in names(folder)}
    found = aligned(program, [
        {"pair": name, "reference": str(folder / f"{name}-reference.yaml"), "slam": str(folder / f"{name}-slam.yaml"), "robots": places}
        for name, (places, _) in drives.items()])
    return {answer["pair"]: (answer, *drives[answer["pair"]]) for answer in found}


def elsewhere(program, folders):
    """Answers to each map that scripts/slam-maps made with each storey of every other building of these folders."""
    maps, references = [], {}
    for folder in (pathlib.Path(folder).resolve() for folder in folders):
        for pair, truth in zip(lines(folder / "pairs.jsonl"), lines(folder / "truth.jsonl")):
            maps.append((truth["pair"], truth["building"], str(folder / pair["slam"])))
            # A log is named by its number and its storey.
            references.setdefault((truth["building"], truth["log"].split("_", 1)[1]), str(folder / pair["reference"]))
    return aligned(program, [
        {"pair": f"{name} in {storey}", "reference": reference, "slam": slam}
        for name, of, slam in maps for (building, storey), reference in references.items() if building != of])


def moved(pose, place):
    """A place moved by a pose."""
    sin, cos = math.sin(pose["yaw"]), math.cos(pose["yaw"])
    return [pose["x"] + cos * place[0] - sin * place[1], pose["y"] + sin * place[0] + cos * place[1]]


def worst_m(covariance):
    """Standard deviation in the direction that is known worst."""
    (xx, xy), (_, yy) = covariance[0][:2], covariance[1][:2]
    return math.sqrt(max(0.0, (xx + yy) / 2 + math.hypot((xx - yy) / 2, xy)))


def judged(answer, places, truths):
    """Of the places at which the pose may be used: their number, how many are beyond what was said, and how many inside the gate;
    and how far the pose of the whole map is off at all places, at most."""
    usable, beyond, inside = 0, 0, 0
    for place, truth, local in zip(places, truths, answer.get("at_robots") or [None] * len(places)):
        if local is None or worst_m(local["covariance"]) > USABLE_M:
            continue
        at = moved(local, place)
        error = [at[0] - truth[0], at[1] - truth[1]]
        (xx, xy), (_, yy) = local["covariance"][0][:2], local["covariance"][1][:2]
        nees = (yy * error[0] ** 2 - 2 * xy * error[0] * error[1] + xx * error[1] ** 2) / (xx * yy - xy * xy)
        usable += 1
        beyond += math.hypot(*error) > max(3 * worst_m(local["covariance"]), LEAST_OFF_M)
        inside += nees <= GATE
    off = max(math.dist(moved(answer, place), truth) for place, truth in zip(places, truths)) if "x" in answer else math.nan
    return {"usable": usable, "beyond": beyond, "inside": inside, "off_m": off}


def table(program, folder):
    """Prints a line for each map, and one for those that are accepted."""
    print(f"{folder}: of the scans of real maps, with the pose around the robot")
    total = {"usable": 0, "beyond": 0, "inside": 0}
    made = pathlib.Path(folder) / "truth.jsonl"
    is_unique = {truth["pair"]: truth.get("is_unique") for truth in lines(made)} if made.exists() else {}
    verdicts = {True: [], False: []}
    for name, (answer, places, truths) in answers(program, folder).items():
        of, holds = judged(answer, places, truths), answer.get("holds") or {}
        share = lambda key: f"{holds[key]:.0%}" if key in holds else "-"
        print(f"  {name}: {answer['verdict']}; one pose is off by up to {of['off_m']:.2f} m; holds for {share('share_of_walls')} of the "
              f"walls, {share('share_of_floor')} of the floor, {share('unknown_share_of_floor')} not known; usable at {of['usable']} of "
              f"{len(places)} scans, beyond what was said at {of['beyond']}, inside the gate at {of['inside']}")
        if is_unique.get(name) is not None:
            verdicts[is_unique[name]].append(answer["verdict"])
        if answer["verdict"] == "accepted":
            total = {key: total[key] + of[key] for key in total}
    for unique, of in verdicts.items():
        if of:
            fit = "one pose only" if unique else "several poses"
            print(f"  of {len(of)} maps whose walls fit the model in {fit}, accepted {of.count('accepted')}, ambiguous {of.count('ambiguous')}")
    usable = max(1, total["usable"])
    print(f"  accepted and usable: {total['usable']} scans; {1 - total['beyond'] / usable:.1%} within three deviations or "
          f"{LEAST_OFF_M} m, {total['inside'] / usable:.1%} inside the gate of 95 %")
