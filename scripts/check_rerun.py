#!/usr/bin/env python3
"""Reads a recording of `groundplan convert --mcap FILE --grid-map` with rerun, and compares its maps with what rosbags reads.

    python3 scripts/check_rerun.py FILE.mcap

Needs rerun-sdk[catalog], rosbags and numpy. rerun converts the file as it does for its viewer. Grid maps must be there at the same times,
with the same numbers and in the same frames; of occupancy grids, of which rerun makes pictures, there must be one at each time. Exit
codes: 0 they are, 1 they are not, 2 the file cannot be read. Prints one JSON document with what was counted.
"""
import json
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
import rerun.server
from check_ros_messages import typestore
from rosbags.rosbag2 import Reader

GRID_MAP, GRID = "grid_map_msgs/msg/GridMap", "nav_msgs/msg/OccupancyGrid"


def read_by_rosbags(file):
    """For each topic the messages by time: of grid maps frame and numbers, of grids nothing."""
    store, found = typestore(), {GRID_MAP: {}, GRID: {}}
    with Reader(file) as reader:
        for connection, time, raw in reader.messages():
            kind = connection.msgtype
            if kind == GRID_MAP:
                message = store.deserialize_cdr(raw, kind)
                numbers = b"".join(np.asarray(layer.data, "<f4").tobytes() for layer in message.data)
                found[kind].setdefault(connection.topic, {})[time] = (message.header.frame_id, numbers)
            elif kind == GRID:
                found[kind].setdefault(connection.topic, {})[time] = None
    return found


def read_by_rerun(file, expected):
    found = {GRID_MAP: {}, GRID: {}}
    with rerun.server.Server(datasets={"recording": [str(file)]}) as server:
        dataset = server.client().get_dataset("recording")

        def column(topic, name):
            """The values of a topic that are there, with their times."""
            table = dataset.filter_contents([topic]).reader(index="message_log_time").to_pandas()
            rows = table[["message_log_time", f"{topic}:{name}"]].dropna().itertuples(index=False)
            return {time.value: value for time, value in rows}

        for topic in expected[GRID_MAP]:
            for time, [message] in column(topic, "grid_map_msgs.msg.GridMap:message").items():
                numbers = b"".join(np.asarray(layer["data"], "<f4").tobytes() for layer in message["data"])
                found[GRID_MAP].setdefault(topic, {})[time] = (message["header"]["frame_id"], numbers)
        for topic in expected[GRID]:
            found[GRID][topic] = dict.fromkeys(column(topic, "GridMap:data"))
    return found


def main():
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        sys.exit(2)
    file = pathlib.Path(sys.argv[1])
    expected = read_by_rosbags(file)
    with tempfile.TemporaryDirectory() as home:
        recording = pathlib.Path(home) / "recording.rrd"
        program = pathlib.Path(sys.executable).parent / "rerun"
        subprocess.run([program, "mcap", "convert", file, "-o", recording], check=True, stderr=subprocess.DEVNULL)
        read = read_by_rerun(recording, expected)
    faults = [topic for kind, topics in expected.items() for topic in topics if read[kind].get(topic) != topics[topic]]
    if faults or not expected[GRID_MAP]:
        print(f"FAIL rerun reads other messages of {', '.join(faults) or 'no grid map'}", file=sys.stderr)
        sys.exit(1)
    count = {kind.rsplit("/", 1)[1]: sum(map(len, topics.values())) for kind, topics in expected.items()}
    print(json.dumps(count))


if __name__ == "__main__":
    try:
        main()
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"FAIL {error}", file=sys.stderr)
        sys.exit(2)
