"""Builds all tests of the workspace and runs their programs, as many at once as there are cores: most of them wait for daemons most of
the time. Tests of the documentation come last, by cargo.

usage: scripts/run_tests.py [--jobs N]

What a program prints is printed when it has ended. The exit code is 1 if a test failed; all are run. How long each program took is in
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

# Measures what processes hold while they rest: alone, after the others.
ALONE = {"tests/soak"}
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


def run(program):
    """Runs a program in the folder of its package, as cargo does."""
    name, path, folder = program
    environment = dict(os.environ, CARGO_MANIFEST_DIR=str(folder))
    begun = time.monotonic()
    ended = subprocess.run([path], cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    return name, ended.returncode, time.monotonic() - begun, ended.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="programs at once")
    jobs = parser.parse_args().jobs
    seconds = json.loads(SECONDS.read_text()) if SECONDS.exists() else {}
    # What has never run may be long.
    ordered = sorted(programs(), key=lambda program: seconds.get(program[0], float("inf")), reverse=True)
    failed = []

    def told(ended):
        name, code, took, printed = ended
        seconds[name] = round(took, 2)
        print(f"\n     Ran {name} in {took:.1f} s")
        sys.stdout.flush()
        sys.stdout.buffer.write(printed)
        sys.stdout.flush()
        failed.extend([name] if code else [])

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        beside = [pool.submit(run, program) for program in ordered if program[0] not in ALONE]
        for ended in concurrent.futures.as_completed(beside):
            told(ended.result())
    for program in ordered:
        if program[0] in ALONE:
            told(run(program))
    SECONDS.write_text(json.dumps(seconds, indent=1, sort_keys=True))
    documented = subprocess.run(["cargo", "test", "--workspace", "--locked", "--doc"]).returncode
    if failed:
        print(f"\ntests failed in: {', '.join(sorted(failed))}", file=sys.stderr)
    sys.exit(1 if failed or documented else 0)


if __name__ == "__main__":
    main()
