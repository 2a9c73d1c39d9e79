#!/usr/bin/env python3
"""A node of a robot on ROS 2 itself (rclpy on Fast DDS): takes the latched grids of a bridge, and asks for what it is told to.

usage: ros_consumer.py [--domain N] [--export OUT --storey N] [ACTION..]

Each ACTION is done once, in order, and its answer is a JSON line whose topic is the action:
list                  names of the parameters
get NAME              the value of a parameter
set NAME=VALUE        sets it, and says whether that was done and why not; `set-atomically NAME=VALUE` by the other service for it
call SERVICE          calls a service of std_srvs/Trigger in the namespace
Each grid that comes is a JSON line too: its topic, frame and number of cells; with --export how many cells differ from the file of
the exported maps, read as Nav2's map server does, or -1 if size, resolution or origin do.
Needs ros-kilted-rclpy, -rmw-fastrtps-cpp, -rmw-implementation, -nav-msgs and -std-srvs (scripts/python-env).
"""

import argparse
import json
import os
import pathlib
import sys

import rclpy
from nav_msgs.msg import OccupancyGrid
from rclpy.node import Node
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from ros_node import MIDDLEWARE
from slam_drive import read_pgm
from std_srvs.srv import Trigger

NAMESPACE, BRIDGE = "/groundplan", "/groundplan/ros_bridge"
LAYERS = {"map": "planning", "localization_map": "localization", "keepout_mask": "keepout"}
LATCHED = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE, durability=DurabilityPolicy.TRANSIENT_LOCAL)
# Far beyond what any answer needs.
DEADLINE_S = 120.0


def say(topic: str, **words: object) -> None:
    print(json.dumps({"topic": topic, **words}), flush=True)


def occupancy(pixel: int) -> int:
    """What Nav2's map server publishes of a pixel, by the thresholds of the files."""
    share = (255 - pixel) / 255
    return 100 if share > 0.65 else 0 if share < 0.196 else -1


OCCUPANCIES = [occupancy(pixel) for pixel in range(256)]


class ExportedStorey:
    """The files of a storey in a folder that `groundplan export` wrote."""

    def __init__(self, folder: pathlib.Path, storey: int) -> None:
        self.manifest = json.loads((folder / "manifest.json").read_text())
        self.entry = self.manifest["storeys"][storey]
        self.folder = folder / self.entry["directory"]

    def n_differing(self, grid: OccupancyGrid, layer: str) -> int:
        width, height, pixels = read_pgm(self.folder / f"{layer}.pgm")
        info, at = grid.info, grid.info.origin.position
        places = zip((at.x, at.y, info.resolution), (*self.entry["origin_m"], self.manifest["resolution_m"]))
        if (info.width, info.height) != (width, height) or any(abs(a - b) > 1e-6 for a, b in places):
            return -1
        return sum(cell != OCCUPANCIES[pixel] for cell, pixel in zip(grid.data, pixels))


def listen(node: Node, exported: ExportedStorey | None) -> None:
    for topic, layer in LAYERS.items():
        name = f"{NAMESPACE}/{topic}"

        def take(grid: OccupancyGrid, name: str = name, layer: str = layer) -> None:
            differing = exported.n_differing(grid, layer) if exported else None
            say(name, frame=grid.header.frame_id, cells=len(grid.data), differing=differing)

        node.create_subscription(OccupancyGrid, name, take, LATCHED)


class Asker:
    """Does the actions, with the clients that rclpy has."""

    def __init__(self, node: Node) -> None:
        self.node = node
        self.parameters = AsyncParameterClient(node, BRIDGE)

    def answer(self, future) -> object:
        rclpy.spin_until_future_complete(self.node, future, timeout_sec=DEADLINE_S)
        return future.result()

    def do(self, action: str) -> dict:
        what, _, of = action.partition(" ")
        if what == "call":
            return self.call(of)
        if not self.parameters.wait_for_services(timeout_sec=DEADLINE_S):
            return {"answer": None}
        if what == "list":
            return {"answer": list(self.answer(self.parameters.list_parameters()).result.names)}
        if what == "get":
            values = self.answer(self.parameters.get_parameters([of])).values
            return {"answer": parameter_value_to_python(values[0])}
        name, _, value = of.partition("=")
        parameters = [Parameter(name, value=int(value) if value.lstrip("-").isdigit() else value)]
        if what == "set-atomically":
            result = self.answer(self.parameters.set_parameters_atomically(parameters)).result
        else:
            result = self.answer(self.parameters.set_parameters(parameters)).results[0]
        return {"answer": result.successful, "reason": result.reason}

    def call(self, service: str) -> dict:
        client = self.node.create_client(Trigger, f"{NAMESPACE}/{service}")
        if not client.wait_for_service(timeout_sec=DEADLINE_S):
            return {"answer": None}
        response = self.answer(client.call_async(Trigger.Request()))
        return {"answer": response.success, "reason": response.message}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--domain", type=int, default=0)
    parser.add_argument("--export", type=pathlib.Path)
    parser.add_argument("--storey", type=int, default=0)
    parser.add_argument("actions", metavar="ACTION", nargs="*")
    arguments = parser.parse_args()
    os.environ["RMW_IMPLEMENTATION"] = MIDDLEWARE
    rclpy.init(domain_id=arguments.domain)
    node = rclpy.create_node("consumer")
    listen(node, ExportedStorey(arguments.export, arguments.storey) if arguments.export else None)
    asker = Asker(node)
    for action in arguments.actions:
        say(action, **asker.do(action))
    while rclpy.ok():
        rclpy.spin_once(node, timeout_sec=0.2)


if __name__ == "__main__":
    try:
        main()
    except (KeyboardInterrupt, BrokenPipeError):
        sys.exit(0)
