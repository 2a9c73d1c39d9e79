"""Builds all tests of the workspace and runs their programs, as many at once as there are cores: most of them wait for daemons most of
the time. Tests of the documentation come last, by cargo.

usage: scripts/run_tests.py [--jobs N] [--quick]

--quick leaves out what needs daemons, the ROS 2 graph or a SLAM program, and documentation: unit and property tests of all crates, and
the stages on the demo building. What a program prints is printed when it has ended. The exit code is 1 if a test failed; all are run. How long each program took is in
target/test-seconds.json: those that take long begin first.
"""

import argparse
import concurrent.futures
import json
import os
import pathlib
import subprocess
import sys
import time

# What reads a site's bus, on that of a robot that follows a server: it must not notice. Names of tests, by program.
FOLLOWING = {
    "tests/python": ["python_sees_the_grids_and_sets_that_the_client_sees", "readers_do_not_keep_the_operator_out"],
    "tests/recording": ["a_running_site_is_recorded_as_its_maps_change"],
    "tests/watch": ["the_link_follows_the_maps_and_a_program_runs_for_each", "a_watch_deletes_and_replaces_nothing_that_it_did_not_write"],
    "tests/foxglove": ["the_building_comes_under_its_url_as_an_export_writes_it", "the_pose_of_a_slam_map_comes_with_its_covariance"],
    "tests/deleted_bus": ["maps_come_back_after_segments_or_folder_of_the_bus_were_deleted"],
    "tests/ros": ["a_bridge_that_was_stopped_and_goes_on_is_heard_again", "a_slam_map_from_the_graph_is_aligned_and_the_transform_comes_back"],
    "tests/ros_node": ["every_topic_and_service_of_the_bridge_is_its_nodes_for_early_and_late_nodes"],
}
# Measures what processes hold while they rest: alone, after the others.
ALONE = {"tests/soak"}
# Of the end-to-end tests those that --quick runs: the stages, each by commands that end.
STAGES = {f"tests/{name}" for name in (
    "bad_input", "demo_building", "doors", "floors", "footprints", "ground", "link", "model_check", "output_folder", "safety", "schedule",
    "tidy", "waypoints", "world")}
SECONDS = pathlib.Path("target/test-seconds.json")


def programs():
    """The programs of the tests, as (name, path, folder of the package), built with the features of the whole workspace."""
    command = ["cargo", "test", "--workspace", "--locked", "--no-run", "--message-format=json-render-diagnostics"]
    built = subprocess.run(command, stdout=subprocess.PIPE, text=True)
    if built.returncode:
        sys.exit(built.returncode)
    found = []
    for line in built.stdout.splitlines():
        message = json.loads(line)
        if message.get("executable") and message["profile"]["test"]:
            folder = pathlib.Path(message["manifest_path"]).parent
            found.append((f"{folder.name}/{message['target']['name']}", message["executable"], folder))
    return found


def on_followers(found):
    """The tests of FOLLOWING, as programs with their tests and an environment."""
    by_name = {name: (path, folder) for name, path, folder in found}
    return [(f"{name} on a follower", *by_name[name], tests) for name, tests in FOLLOWING.items()]


def run(program):
    """Runs a program in the folder of its package, as cargo does; of tests on followers those alone."""
    name, path, folder, *of_followers = program
    environment = dict(os.environ, CARGO_MANIFEST_DIR=str(folder))
    tests = []
    if of_followers:
        # What a test asks for by its whole name is run, or there is none of this name.
        environment["GROUNDPLAN_TESTS_FOLLOW"] = "1"
        tests = ["--exact", *of_followers[0]]
        listed = subprocess.run([path, "--list", *tests], cwd=folder, env=environment, stdout=subprocess.PIPE, text=True).stdout
        if missing := [test for test in of_followers[0] if f"{test}: test" not in listed]:
            return name, 1, 0.0, f"there are no tests {', '.join(missing)}\n".encode()
    begun = time.monotonic()
    ended = subprocess.run([path, *tests], cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return name, ended.returncode, time.monotonic() - begun, ended.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="programs at once")
    parser.add_argument("--quick", action="store_true", help="without daemons")
    options = parser.parse_args()
    seconds = json.loads(SECONDS.read_text()) if SECONDS.exists() else {}
    # What has never run may be long.
    found = programs()
    if options.quick:
        if unknown := STAGES - {name for name, *_ in found}:
            sys.exit(f"there are no tests {', '.join(sorted(unknown))}")
        found = [program for program in found if not program[0].startswith("tests/") or program[0] in STAGES]
    else:
        found += on_followers(found)
    ordered = sorted(found, key=lambda program: seconds.get(program[0], float("inf")), reverse=True)
    failed = []

    def told(ended):
        name, code, took, printed = ended
        seconds[name] = round(took, 2)
        print(f"\n     Ran {name} in {took:.1f} s")
        sys.stdout.flush()
        sys.stdout.buffer.write(printed)
        sys.stdout.flush()
        failed.extend([name] if code else [])

    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        beside = [pool.submit(run, program) for program in ordered if program[0] not in ALONE]
        for ended in concurrent.futures.as_completed(beside):
            told(ended.result())
    for program in ordered:
        if program[0] in ALONE:
            told(run(program))
    SECONDS.write_text(json.dumps(seconds, indent=1, sort_keys=True))
    documented = 0 if options.quick else subprocess.run(["cargo", "test", "--workspace", "--locked", "--doc"]).returncode
    if failed:
        print(f"\ntests failed in: {', '.join(sorted(failed))}", file=sys.stderr)
    sys.exit(1 if failed or documented else 0)


if __name__ == "__main__":
    main()
