#!/usr/bin/env python3
"""Reads the grid of a storey from the running daemons, in place: iceoryx2 gives the memory, numpy looks at it.

usage: scripts/python_subscriber.py [--root /run/groundplan] [--prefix gp010_] [--storey 0] [--follow]

Prints a JSON document for each sample. Needs Python 3.9 or later and `pip install iceoryx2==0.10.0 numpy`; iceoryx2 must be
of the version that groundplan uses, because the formats of one version do not open those of another.
"""

import argparse
import ctypes
import fcntl
import json
import pathlib

import iceoryx2 as iox2
import numpy as np

# Numbers of the wake-up events of a daemon.
DATA, LATE_JOINER = 0, 1
# Layers of a grid. planning and localization: 0 free, 100 occupied, -1 unknown. keepout: 100 must not enter, -1 elsewhere.
SECTIONS = {2: ("class", np.uint8), 3: ("planning", np.int8), 4: ("localization", np.int8),
            5: ("keepout", np.int8), 6: ("floor", np.uint8), 7: ("space", np.uint16)}


class Block(ctypes.Structure):
    """Samples are made of these."""
    _fields_ = [("bytes", ctypes.c_uint8 * 64)]

    @staticmethod
    def type_name():
        return "groundplan.block64.v1"


class Header(ctypes.Structure):
    """What travels beside a sample: messages/src/sample_header.rs."""
    _fields_ = [("magic", ctypes.c_uint32), ("layout_version", ctypes.c_uint32), ("kind", ctypes.c_uint32),
                ("flags", ctypes.c_uint32), ("epoch", ctypes.c_uint64), ("stamp_ns", ctypes.c_uint64),
                ("payload_length", ctypes.c_uint64), ("content_hash", ctypes.c_uint64),
                ("frame_epoch", ctypes.c_uint64), ("inputs", ctypes.c_uint64 * 6), ("reserved", ctypes.c_uint64 * 3)]

    @staticmethod
    def type_name():
        return "groundplan.sample_header.v1"


def current_generation(root):
    """The bus is created anew under another number when it was damaged."""
    lines = (root / "generation").read_text().splitlines()
    return int(dict(line.split("=", 1) for line in lines)["generation"])


def join(root, prefix, generation):
    """A node in a generation, and the lock of a member: the files of the generation stay while it is held."""
    life = open(root / f"{generation}.lock", "a")
    fcntl.flock(life, fcntl.LOCK_SH)
    config = iox2.config.default()
    config.global_cfg.prefix = iox2.FileName.new(f"{prefix}{generation}_")
    config.global_cfg.root_path = iox2.Path.new(str(root / str(generation)))
    builder = iox2.NodeBuilder.new().config(config).signal_handling_mode(iox2.SignalHandlingMode.HandleTerminationRequests)
    return builder.create(iox2.ServiceType.Ipc), life


def layers(archive):
    """The layers of a `grid` archive by name, as arrays over its memory; row 0 is the lowest."""
    preamble = archive[:64].view(np.uint32)
    table = archive[64:64 + 24 * int(preamble[3])].view(
        np.dtype([("id", "<u4"), ("record_len", "<u4"), ("offset", "<u8"), ("count", "<u8")]))
    found, head = {}, None
    for entry in table:
        at, count = int(entry["offset"]), int(entry["count"])
        data = archive[at:at + count * int(entry["record_len"])]
        if entry["id"] == 1:
            head = data.view(np.int32)
        elif int(entry["id"]) in SECTIONS:
            name, kind = SECTIONS[int(entry["id"])]
            found[name] = data.view(kind)
    cell_tenths, first_column, first_row, width, height = (int(v) for v in head[:5])
    grid = {name: layer.reshape(height, width) for name, layer in found.items()}
    return grid, cell_tenths / 10_000, (first_column * cell_tenths / 10_000, first_row * cell_tenths / 10_000)


def describe(sample):
    header = ctypes.cast(sample.user_header_ptr, ctypes.POINTER(Header)).contents
    archive = np.frombuffer(sample.payload().as_memory_view(), np.uint8)[:header.payload_length]
    # The memory is mapped for reading only: writing would end this process.
    archive.flags.writeable = False
    grid, resolution_m, origin_m = layers(archive)
    planning = grid["planning"]
    return {"epoch": header.epoch, "content_hash": f"{header.content_hash:016x}", "shape": planning.shape,
            "resolution_m": resolution_m, "origin_m": origin_m, "free": int((planning == 0).sum()),
            "occupied": int((planning == 100).sum()), "keepout": int((grid["keepout"] == 100).sum())}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path("/run/groundplan"))
    parser.add_argument("--prefix", default="gp010_")
    parser.add_argument("--storey", type=int, default=0)
    parser.add_argument("--follow", action="store_true")
    options = parser.parse_args()

    iox2.set_log_level(iox2.LogLevel.Error)
    generation = current_generation(options.root)
    node, _life = join(options.root, options.prefix, generation)
    event_service = node.service_builder(iox2.ServiceName.new("event/rasterize")).event().open()
    listener = event_service.listener_builder().create()
    topic = node.service_builder(iox2.ServiceName.new(f"grid/{options.storey:02}"))
    # ctypes has no alignment of 64 bytes, so it is set here.
    service = topic.publish_subscribe(iox2.Slice[Block]).user_header(Header)
    subscriber = service.payload_alignment(iox2.Alignment.new(64)).open().subscriber_builder().create()
    # The producer delivers its last sample when this event wakes it.
    event_service.notifier_builder().create().notify_with_custom_event_id(iox2.EventId.new(LATE_JOINER))
    while True:
        sample = subscriber.receive()
        if sample is not None:
            print(json.dumps(describe(sample)), flush=True)
            sample.delete()
            if not options.follow:
                return
            continue
        listener.timed_wait(iox2.Duration.from_secs(1))
        if current_generation(options.root) != generation:
            raise SystemExit("the bus was created anew: start again")


main()
