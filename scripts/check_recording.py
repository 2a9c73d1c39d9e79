#!/usr/bin/env python3
"""Checks a recording of `groundplan convert --date all -o OUT --mcap FILE` against the maps in OUT, or the end of one of
`groundplan record FILE` against `groundplan export OUT`.

usage: scripts/check_recording.py FILE OUT

Every topic has a message at every change instant, every grid is what Nav2's map_server reads from the PGM and YAML of its date,
markers begin with the deletion of those of before, limits of speed (where they are recorded) are those of speed.pgm or none, frames of storeys lie at their floors, and the sources are those of the
manifest. Needs mcap, mcap-ros2-support and numpy; shares no code with what wrote either. Prints one JSON document with what was
counted.
"""

import collections
import datetime
import json
import pathlib
import sys

import numpy
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

MARKERS = {"rooms", "waypoints", "route"}
GRIDS = {"map": "planning", "localization_map": "localization", "keepout_mask": "keepout"}
TYPES = {
    **{name: "nav_msgs/msg/OccupancyGrid" for name in GRIDS},
    **{name: "visualization_msgs/msg/MarkerArray" for name in MARKERS},
    "keepout_info": "nav2_msgs/msg/CostmapFilterInfo",
}
DELETEALL = 3


def load(path):
    return json.loads(path.read_text(encoding="utf-8"))


def nanoseconds(plan_time):
    """Civil time at the site as if it were UTC."""
    at = datetime.datetime.fromisoformat(plan_time).replace(tzinfo=datetime.timezone.utc)
    return int(at.timestamp()) * 1_000_000_000


def map_server(folder, name):
    """Cells and origin as Nav2's map_server makes them of a map in trinary mode, both thresholds inside."""
    lines = (folder / f"{name}.yaml").read_text(encoding="utf-8").splitlines()
    facts = dict(line.split(": ", 1) for line in lines)
    assert (facts["mode"], facts["negate"]) == ("trinary", "0"), facts
    magic, size, depth, pixels = (folder / facts["image"]).read_bytes().split(b"\n", 3)
    assert (magic, depth) == (b"P5", b"255"), (magic, depth)
    width, height = map(int, size.split())
    pixels = numpy.frombuffer(pixels, numpy.uint8).reshape(height, width)[::-1]
    occupied = (255.0 - pixels) / 255.0
    cells = numpy.full(pixels.shape, -1, numpy.int8)
    cells[occupied <= float(facts["free_thresh"])] = 0
    cells[occupied >= float(facts["occupied_thresh"])] = 100
    return cells, json.loads(facts["origin"]), float(facts["resolution"])


def speed_steps(folder):
    """Steps of the mask of speeds as Nav2's map_server reads them in the mode scale, 0 without a limit; None without the file."""
    path = folder / "speed.yaml"
    if not path.exists():
        return None
    facts = dict(line.split(": ", 1) for line in path.read_text(encoding="utf-8").splitlines())
    assert (facts["mode"], facts["negate"]) == ("scale", "0"), facts
    _, size, _, pixels = (folder / facts["image"]).read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    shares = (255.0 - numpy.frombuffer(pixels, numpy.uint8).reshape(height, width)[::-1]) / 255.0
    low, high = float(facts["free_thresh"]), float(facts["occupied_thresh"])
    return numpy.rint(numpy.clip((shares - low) / (high - low), 0.0, 1.0) * 100.0).astype(numpy.int8)


def check_speeds(recording, prefix, folders):
    """The limits of speed of a storey, if they are recorded; how many cells have one."""
    masks, n_limited = recording.messages.get(f"{prefix}/speed_mask"), 0
    if masks is None:
        return 0
    infos = recording.messages[f"{prefix}/speed_info"]
    assert sorted(masks) == sorted(infos) == sorted(folders), prefix
    for at, mask in masks.items():
        found = numpy.array(mask.data, numpy.int8).reshape(mask.info.height, mask.info.width)
        expected = speed_steps(folders[at])
        expected = numpy.zeros_like(found) if expected is None else expected
        n_wrong = numpy.count_nonzero(found != expected)
        assert n_wrong == 0, f"{prefix}/speed_mask at {at}: {n_wrong} cells differ"
        info = infos[at]
        assert (info.type, info.filter_mask_topic, info.base) == (2, f"{prefix}/speed_mask", 0.0), prefix
        filter_file = folders[at] / "speed_filter.yaml"
        if filter_file.exists():
            (step,) = (line.split(": ")[1] for line in filter_file.read_text(encoding="utf-8").splitlines() if "multiplier" in line)
            assert info.multiplier == numpy.float32(step), (info.multiplier, step)
        n_limited += int(numpy.count_nonzero(found))
    return n_limited


class Recording:
    """Messages of a file by topic and instant."""

    def __init__(self, path):
        with path.open("rb") as stream:
            reader = make_reader(stream, decoder_factories=[DecoderFactory()])
            self.profile, self.summary = reader.get_header().profile, reader.get_summary()
            self.metadata = [(record.name, record.metadata) for record in reader.iter_metadata()]
            self.types, self.messages = {}, collections.defaultdict(dict)
            for schema, channel, message, decoded in reader.iter_decoded_messages():
                assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr"), (schema, channel)
                assert message.log_time == message.publish_time, message.log_time
                self.types[channel.topic] = schema.name
                self.messages[channel.topic][message.log_time] = decoded
        counts = self.summary.statistics.channel_message_counts
        counts = {self.summary.channels[channel].topic: n for channel, n in counts.items()}
        assert counts == {topic: len(messages) for topic, messages in self.messages.items()}, counts


def stamp_ns(header):
    return header.stamp.sec * 1_000_000_000 + header.stamp.nanosec


def check_sources(recording, manifest):
    models = [facts for name, facts in recording.metadata if name == "model"]
    expected = [{key: source[key] for key in ("file", "schema", "sha256")} for source in manifest["sources"]]
    assert models == expected, (models, expected)
    whole = [facts for name, facts in recording.metadata if name == "groundplan"]
    assert len(whole) == 1 and float(whole[0]["resolution_m"]) == manifest["resolution_m"], whole
    return int(whole[0].get("change_instants", 1))


def check_grid(grid, folder, name, place):
    cells, origin, resolution_m = map_server(folder, name)
    info = grid.info
    assert (info.height, info.width) == cells.shape, place
    assert numpy.float32(resolution_m) == numpy.float32(info.resolution), place
    position, turn = info.origin.position, info.origin.orientation
    assert [position.x, position.y, 0.0] == origin and position.z == 0.0, place
    assert (turn.x, turn.y, turn.z, turn.w) == (0.0, 0.0, 0.0, 1.0), place
    data = numpy.array(grid.data, numpy.int8).reshape(cells.shape)
    assert numpy.array_equal(data, cells), f"{place}: {numpy.count_nonzero(data != cells)} cells differ"


def check_frames(recording, storeys, frames):
    if len(storeys) == 1:
        assert "/tf_static" not in recording.messages
        return
    (static,) = recording.messages["/tf_static"].values()
    found = {t.child_frame_id: (t.header.frame_id, t.transform.translation.z) for t in static.transforms}
    expected = {frame: ("map", storey["floor_z_m"]) for frame, storey in zip(frames, storeys)}
    assert found == expected, (found, expected)


def check_messages(recording, prefix, frame, instants, folders):
    """Every message of a storey; returns how many cells were compared and markers seen."""
    n_cells, n_markers = 0, 0
    for name, kind in TYPES.items():
        topic = f"{prefix}/{name}"
        messages = recording.messages[topic]
        assert recording.types[topic] == kind, (topic, recording.types[topic])
        assert sorted(messages) == instants, f"{topic}: {len(messages)} messages at {len(instants)} change instants"
        for at, message in messages.items():
            place = f"{topic} at {at}"
            headers = [marker.header for marker in message.markers] if name in MARKERS else [message.header]
            assert all((stamp_ns(h), h.frame_id) == (at, frame) for h in headers), place
            if name in GRIDS:
                check_grid(message, folders[at], GRIDS[name], place)
                n_cells += len(message.data)
            elif name in MARKERS:
                actions = [marker.action for marker in message.markers]
                assert actions == [DELETEALL] + [0] * (len(actions) - 1), place
                names = [(marker.ns, marker.id) for marker in message.markers]
                assert len(names) == len(set(names)), place
                n_markers += len(names) - 1
            else:
                info = (message.type, message.filter_mask_topic, message.base, message.multiplier)
                assert info == (0, f"{prefix}/keepout_mask", 0.0, 1.0), place
    return n_cells, n_markers


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    recording, out = Recording(pathlib.Path(sys.argv[1])), pathlib.Path(sys.argv[2])
    assert recording.profile == "ros2", recording.profile
    manifest = load(out / "manifest.json")
    if "dates" in manifest:
        dates = {nanoseconds(date["plan_time"]): date for date in manifest["dates"]}
    else:
        # Of a running site only the last maps can be exported afterwards.
        (end,) = {max(messages) for topic, messages in recording.messages.items() if topic != "/tf_static"}
        dates = {end: {"directory": "."}}
        sets = {len(messages) for topic, messages in recording.messages.items() if topic != "/tf_static"}
        assert len(sets) == 1, sets
        for topic, messages in recording.messages.items():
            if topic != "/tf_static":
                recording.messages[topic] = {end: messages[end]}
    manifests = {at: load(out / date["directory"] / "manifest.json") for at, date in dates.items()}
    instants = sorted(dates)
    last = manifests[instants[-1]]
    assert check_sources(recording, last) == len(instants)
    storeys = last["storeys"]
    names = [pathlib.PurePath(storey["directory"]).name.replace("-", "_") for storey in storeys]
    single = len(storeys) == 1
    frames = ["map"] if single else [f"storey_{name}" for name in names]
    check_frames(recording, storeys, frames)
    cells, markers, limited = 0, 0, 0
    for k, frame in enumerate(frames):
        folders = {at: out / dates[at]["directory"] / manifests[at]["storeys"][k]["directory"] for at in instants}
        prefix = "/groundplan" if single else f"/groundplan/{frame}"
        n_cells, n_markers = check_messages(recording, prefix, frame, instants, folders)
        cells, markers = cells + n_cells, markers + n_markers
        limited += check_speeds(recording, prefix, folders)
    topics = {topic: len(messages) for topic, messages in sorted(recording.messages.items())}
    json.dump({"change_instants": len(instants), "topics": topics, "cells": cells, "markers": markers,
               "limited_cells": limited}, sys.stdout)


main()
