#!/usr/bin/env python3
"""Reads the grid of a storey from the running daemons, in place: iceoryx2 gives the memory, numpy looks at it.

usage: scripts/python_subscriber.py [--root /run/groundplan] [--prefix gp010_] [--storey 0] [--follow]

Prints a JSON document for each sample. Needs the package in common/python: `pip install ./common/python`.
"""

import argparse
import json
import pathlib

import groundplan
import numpy as np
import numpy.typing as npt


def bounds(layer: "npt.NDArray[np.float64] | None") -> "list[float] | None":
    """Lowest and highest value; None of a level storey, and where there is no ground."""
    return None if layer is None or np.isnan(layer).all() else [float(np.nanmin(layer)), float(np.nanmax(layer))]


def describe(sample: groundplan.Sample) -> "dict[str, object]":
    grid = groundplan.Grid(sample.memory)
    return {"epoch": sample.header.epoch, "content_hash": f"{grid.content_hash:016x}", "shape": grid.planning.shape,
            "resolution_m": grid.resolution_m, "origin_m": grid.origin_m, "free": int((grid.planning == 0).sum()),
            "occupied": int((grid.planning == 100).sum()), "keepout": int((grid.keepout == 100).sum()),
            "elevation_m": bounds(grid.elevation), "slope_rad": bounds(grid.slope)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--root", type=pathlib.Path, default=pathlib.Path("/run/groundplan"))
    parser.add_argument("--prefix", default="gp010_")
    parser.add_argument("--storey", type=int, default=0)
    parser.add_argument("--follow", action="store_true")
    options = parser.parse_args()
    with groundplan.Bus(options.root, options.prefix) as bus:
        topic = groundplan.Subscriber(bus, f"grid/{options.storey:02}")
        print(json.dumps(describe(topic.wait(30))), flush=True)
        while options.follow:
            sample = topic.receive()
            if sample is None:
                topic.sleep(0.5)
            else:
                print(json.dumps(describe(sample)), flush=True)


main()
