#!/usr/bin/env python3
"""A peer of ros-bridge in the ROS 2 graph, with CycloneDDS and without ROS: prints what the bridge publishes.

usage: ros_peer.py [--domain N] [--namespace /groundplan] [--for SECONDS] [--publish-slam-map FILE.yaml --topic /map]
                   [--robot-at X,Y,YAW;..] [--clock SECONDS] [--plan X,Y,X,Y] [--nav2] [--call SERVICE] [--set NAME=VALUE] [--raw]
                   [--participants N] [--lease SECONDS]

Each message is one JSON line: topic, frame, and what a person wants to know of it.
--publish-slam-map  it is the robot: it publishes a map of a map server as SLAM would, latched, once a second
--robot-at          it is the robot: its pose in its map on /tf; of several, the next one for each line of standard input, and the last one stays
--clock             it is a simulator: it publishes /clock from this time on
--plan              it is a planner: the shortest way over map and mask, as Nav2's costmap applies them
--nav2              it is Nav2: it answers the calls by which it is stopped, loaded and resumed
--raw               it measures: grids are counted in bytes and not read, and it looks every millisecond
--lease             how long it is taken for alive without a sign of it, 10 s by default
--participants      so many participants, as a robot with many nodes has: it prints when all of them hear the bridge
--call, --set       it calls next_change, align or confirm, or sets a parameter, once, and prints the answer
"""

import argparse
import array as values
import collections
import hashlib
import json
import math
import os
import pathlib
import select
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import InstanceState, Policy, Qos, SampleState, ViewState
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int8, int32, int64, sequence, uint8, uint16, uint32, uint64
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.sub import DataReader, Subscriber, ddspy_take
from cyclonedds.topic import Topic
from cyclonedds.util import duration
from slam_drive import read_pgm


@dataclass
class Time(IdlStruct, typename="builtin_interfaces::msg::dds_::Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs::msg::dds_::Header_"):
    stamp: Time
    frame_id: str


@dataclass
class Point(IdlStruct, typename="geometry_msgs::msg::dds_::Point_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Quaternion(IdlStruct, typename="geometry_msgs::msg::dds_::Quaternion_"):
    x: float64
    y: float64
    z: float64
    w: float64


@dataclass
class Pose(IdlStruct, typename="geometry_msgs::msg::dds_::Pose_"):
    position: Point
    orientation: Quaternion


@dataclass
class MapMetaData(IdlStruct, typename="nav_msgs::msg::dds_::MapMetaData_"):
    map_load_time: Time
    resolution: float32
    width: uint32
    height: uint32
    origin: Pose


@dataclass
class OccupancyGrid(IdlStruct, typename="nav_msgs::msg::dds_::OccupancyGrid_"):
    header: Header
    info: MapMetaData
    data: sequence[uint8]


@dataclass
class GridMapInfo(IdlStruct, typename="grid_map_msgs::msg::dds_::GridMapInfo_"):
    resolution: float64
    length_x: float64
    length_y: float64
    pose: Pose


@dataclass
class MultiArrayDimension(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayDimension_"):
    label: str
    size: uint32
    stride: uint32


@dataclass
class MultiArrayLayout(IdlStruct, typename="std_msgs::msg::dds_::MultiArrayLayout_"):
    dim: sequence[MultiArrayDimension]
    data_offset: uint32


@dataclass
class Float32MultiArray(IdlStruct, typename="std_msgs::msg::dds_::Float32MultiArray_"):
    layout: MultiArrayLayout
    data: sequence[float32]


@dataclass
class GridMap(IdlStruct, typename="grid_map_msgs::msg::dds_::GridMap_"):
    header: Header
    info: GridMapInfo
    layers: sequence[str]
    basic_layers: sequence[str]
    data: sequence[Float32MultiArray]
    outer_start_index: uint16
    inner_start_index: uint16


@dataclass
class CostmapFilterInfo(IdlStruct, typename="nav2_msgs::msg::dds_::CostmapFilterInfo_"):
    header: Header
    type: uint8
    filter_mask_topic: str
    base: float32
    multiplier: float32


@dataclass
class String(IdlStruct, typename="std_msgs::msg::dds_::String_"):
    data: str


@dataclass
class KeyValue(IdlStruct, typename="diagnostic_msgs::msg::dds_::KeyValue_"):
    key: str
    value: str


@dataclass
class DiagnosticStatus(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticStatus_"):
    level: uint8
    name: str
    message: str
    hardware_id: str
    values: sequence[KeyValue]


@dataclass
class DiagnosticArray(IdlStruct, typename="diagnostic_msgs::msg::dds_::DiagnosticArray_"):
    header: Header
    status: sequence[DiagnosticStatus]


@dataclass
class Vector3(IdlStruct, typename="geometry_msgs::msg::dds_::Vector3_"):
    x: float64
    y: float64
    z: float64


@dataclass
class Transform(IdlStruct, typename="geometry_msgs::msg::dds_::Transform_"):
    translation: Vector3
    rotation: Quaternion


@dataclass
class TransformStamped(IdlStruct, typename="geometry_msgs::msg::dds_::TransformStamped_"):
    header: Header
    child_frame_id: str
    transform: Transform


@dataclass
class TFMessage(IdlStruct, typename="tf2_msgs::msg::dds_::TFMessage_"):
    transforms: sequence[TransformStamped]


@dataclass
class Clock(IdlStruct, typename="rosgraph_msgs::msg::dds_::Clock_"):
    clock: Time


@dataclass
class TriggerRequest(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Request_"):
    client: uint64
    number: int64
    nothing: uint8


@dataclass
class TriggerResponse(IdlStruct, typename="std_srvs::srv::dds_::Trigger_Response_"):
    client: uint64
    number: int64
    success: bool
    message: str


@dataclass
class ParameterValue(IdlStruct, typename="rcl_interfaces::msg::dds_::ParameterValue_"):
    type: uint8
    bool_value: bool
    integer_value: int64
    double_value: float64
    string_value: str
    byte_array_value: sequence[uint8]
    bool_array_value: sequence[bool]
    integer_array_value: sequence[int64]
    double_array_value: sequence[float64]
    string_array_value: sequence[str]


@dataclass
class Parameter(IdlStruct, typename="rcl_interfaces::msg::dds_::Parameter_"):
    name: str
    value: ParameterValue


@dataclass
class SetParametersRequest(IdlStruct, typename="rcl_interfaces::srv::dds_::SetParameters_Request_"):
    client: uint64
    number: int64
    parameters: sequence[Parameter]


@dataclass
class SetParametersResult(IdlStruct, typename="rcl_interfaces::msg::dds_::SetParametersResult_"):
    successful: bool
    reason: str


@dataclass
class SetParametersResponse(IdlStruct, typename="rcl_interfaces::srv::dds_::SetParameters_Response_"):
    client: uint64
    number: int64
    results: sequence[SetParametersResult]


@dataclass
class GoalInfo(IdlStruct, typename="action_msgs::msg::dds_::GoalInfo_"):
    goal_id: array[uint8, 16]
    stamp: Time


@dataclass
class CancelGoalRequest(IdlStruct, typename="action_msgs::srv::dds_::CancelGoal_Request_"):
    client: uint64
    number: int64
    goal_info: GoalInfo


@dataclass
class CancelGoalResponse(IdlStruct, typename="action_msgs::srv::dds_::CancelGoal_Response_"):
    client: uint64
    number: int64
    return_code: int8
    goals_canceling: sequence[GoalInfo]


@dataclass
class ClearRequest(IdlStruct, typename="nav2_msgs::srv::dds_::ClearEntireCostmap_Request_"):
    client: uint64
    number: int64
    nothing: uint8


@dataclass
class ClearResponse(IdlStruct, typename="nav2_msgs::srv::dds_::ClearEntireCostmap_Response_"):
    client: uint64
    number: int64
    nothing: uint8


@dataclass
class SetRouteGraphRequest(IdlStruct, typename="nav2_msgs::srv::dds_::SetRouteGraph_Request_"):
    client: uint64
    number: int64
    graph_filepath: str


@dataclass
class SetRouteGraphResponse(IdlStruct, typename="nav2_msgs::srv::dds_::SetRouteGraph_Response_"):
    client: uint64
    number: int64
    success: bool


LATCHED = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.TransientLocal, Policy.History.KeepLast(1)
)
ANY = SampleState.Any | ViewState.Any | InstanceState.Any
BEST_EFFORT = Qos(Policy.Reliability.BestEffort, Policy.Durability.Volatile, Policy.History.KeepLast(1))
VOLATILE = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.Volatile, Policy.History.KeepLast(1))


def of_grid(grid: OccupancyGrid) -> dict:
    cells = bytes(grid.data)
    return {
        "size": [grid.info.width, grid.info.height],
        "resolution_m": round(grid.info.resolution, 7),
        "origin_m": [grid.info.origin.position.x, grid.info.origin.position.y],
        "free": cells.count(0),
        "occupied": cells.count(100),
        "unknown": cells.count(255),
        "sha256": hashlib.sha256(cells).hexdigest(),
    }


def of_grid_map(grid_map: GridMap) -> dict:
    return {
        "layers": grid_map.layers,
        "resolution_m": grid_map.info.resolution,
        "middle_m": [grid_map.info.pose.position.x, grid_map.info.pose.position.y],
        "cells": [len(layer.data) for layer in grid_map.data],
        "sha256": hashlib.sha256(b"".join(values.array("f", layer.data).tobytes() for layer in grid_map.data)).hexdigest(),
    }


def of_info(info: CostmapFilterInfo) -> dict:
    return {"type": info.type, "mask": info.filter_mask_topic, "base": info.base, "multiplier": info.multiplier}


def of_diagnostics(array_: DiagnosticArray) -> dict:
    return {"levels": {status.name: status.level for status in array_.status}}


def of_transforms(message: TFMessage) -> dict:
    def of(t: TransformStamped) -> dict:
        q = t.transform.rotation
        return {
            "parent": t.header.frame_id,
            "child": t.child_frame_id,
            "x_m": t.transform.translation.x,
            "y_m": t.transform.translation.y,
            "yaw_rad": 2 * math.atan2(q.z, q.w),
        }

    return {"transforms": [of(t) for t in message.transforms]}


def read_map(path: pathlib.Path) -> OccupancyGrid:
    """A map of the map server, by its trinary rule."""
    words = dict(line.split(":", 1) for line in path.read_text().splitlines() if ":" in line)
    width, height, pixels = read_pgm(path.parent / words["image"].strip())
    rule = [100 if (255 - p) / 255 > 0.65 else 0 if (255 - p) / 255 < 0.196 else 255 for p in range(256)]
    cells = list(pixels.translate(bytes(rule)))
    x, y, yaw = json.loads(words["origin"])
    orientation = Quaternion(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    origin = Pose(Point(x, y, 0.0), orientation)
    info = MapMetaData(Time(0, 0), float(words["resolution"]), width, height, origin)
    return OccupancyGrid(Header(Time(0, 0), "map"), info, cells)


def length_of_way(planning: OccupancyGrid, mask: OccupancyGrid, ends: list) -> float | None:
    """Metres of the shortest way over free cells, in steps to four neighbours; None if there is none."""
    width, height, side = planning.info.width, planning.info.height, planning.info.resolution
    origin = planning.info.origin.position
    # Nav2: an unknown cell of the map is lethal with the parameters of the project, one of the mask says nothing.
    free = [cell == 0 and kept != 100 for cell, kept in zip(bytes(planning.data), bytes(mask.data))]
    start, goal = (
        int((y - origin.y) // side) * width + int((x - origin.x) // side) for x, y in (ends[:2], ends[2:])
    )
    steps, queue = {start: 0}, collections.deque([start] if free[start] else [])
    while queue and goal not in steps:
        cell = queue.popleft()
        row, column = divmod(cell, width)
        for at, inside in (
            (cell - 1, column > 0),
            (cell + 1, column + 1 < width),
            (cell - width, row > 0),
            (cell + width, row + 1 < height),
        ):
            if inside and free[at] and at not in steps:
                steps[at] = steps[cell] + 1
                queue.append(at)
    return round(steps[goal] * side, 2) if goal in steps and free[goal] else None


class Peer:
    """The participant, its readers, and what it does of itself."""

    def __init__(self, arguments: argparse.Namespace) -> None:
        self.arguments = arguments
        if arguments.lease is not None:
            discovery = f"<LeaseDuration>{arguments.lease}s</LeaseDuration><SPDPInterval>1s</SPDPInterval>"
            # What the library reads when the first participant of a domain is made.
            os.environ["CYCLONEDDS_URI"] = f"<CycloneDDS><Domain><Discovery>{discovery}</Discovery></Domain></CycloneDDS>"
        # The last one does all the rest.
        self.participants = [DomainParticipant(arguments.domain)]
        while len(self.participants) < arguments.participants:
            # The programs of a robot do not begin in one moment. Each announces itself from its beginning on, every few seconds; the
            # bridge's library takes no more than eight announcements that come at once.
            time.sleep(0.25)
            self.participants.append(DomainParticipant(arguments.domain))
        self.participant = self.participants[-1]
        self.subscriber, self.publisher = Subscriber(self.participant), Publisher(self.participant)
        self.own = arguments.namespace.rstrip("/")
        self.readers = [
            (name, self.reader(f"rt{name}", kind, qos), shown)
            for name, kind, qos, shown in [
                (f"{self.own}/map", OccupancyGrid, LATCHED, of_grid),
                (f"{self.own}/localization_map", OccupancyGrid, LATCHED, of_grid),
                (f"{self.own}/keepout_mask", OccupancyGrid, LATCHED, of_grid),
                (f"{self.own}/keepout_info", CostmapFilterInfo, LATCHED, of_info),
                (f"{self.own}/speed_mask", OccupancyGrid, LATCHED, of_grid),
                (f"{self.own}/speed_info", CostmapFilterInfo, LATCHED, of_info),
                (f"{self.own}/grid_map", GridMap, LATCHED, of_grid_map),
                (f"{self.own}/changed", String, LATCHED, lambda message: json.loads(message.data)),
                (f"{self.own}/heartbeat", String, VOLATILE, lambda message: json.loads(message.data)),
                (f"{self.own}/route_graph", String, LATCHED, lambda message: {"file": message.data}),
                ("/tf_static", TFMessage, LATCHED, of_transforms),
                ("/diagnostics", DiagnosticArray, VOLATILE, of_diagnostics),
            ]
        ]
        self.listeners = [self.heartbeats_of(participant) for participant in self.participants]
        self.deaf = set(range(len(self.listeners)))
        self.services = []
        self.grids = {}
        self.calls = []

    def reader(self, name: str, kind: type, qos: Qos) -> DataReader:
        return DataReader(self.subscriber, Topic(self.participant, name, kind), qos=qos)

    def heartbeats_of(self, participant: DomainParticipant) -> DataReader:
        return DataReader(Subscriber(participant), Topic(participant, f"rt{self.own}/heartbeat", String), qos=VOLATILE)

    def writer(self, name: str, kind: type, qos: Qos) -> DataWriter:
        return DataWriter(self.publisher, Topic(self.participant, name, kind), qos=qos)

    def serve(self, name: str, request: type, response: type, answer: list) -> None:
        """Answers calls of a service with these fields behind its header."""
        reader = self.reader(f"rq{name}Request", request, VOLATILE)
        writer = self.writer(f"rr{name}Reply", response, VOLATILE)
        self.services.append((name, reader, lambda asked: writer.write(response(asked.client, asked.number, *answer))))

    def call(self, name: str, request: type, response: type, fields: list) -> None:
        """Calls a service once, when there is one that can answer."""
        writer = self.writer(f"rq{name}Request", request, VOLATILE)
        reader = self.reader(f"rr{name}Reply", response, VOLATILE)
        self.calls.append([name, writer, reader, request(0x67726F756E64, 1, *fields), time.monotonic() + 1])

    def hear(self) -> None:
        hear = {number for number in self.deaf if self.listeners[number].take(1)}
        self.deaf -= hear
        if hear and not self.deaf:
            self.print({"topic": "participants", "hear": len(self.participants)})

    def spin(self) -> None:
        self.hear()
        # Requests are taken first and answered last: what was sent before one is printed before it. What follows its answer comes later.
        requests = [(name, asked, answer) for name, reader, answer in self.services for asked in reader.take(10)]
        for name, reader, shown in self.readers:
            if self.arguments.raw and shown is of_grid:
                for content, info in ddspy_take(reader._ref, ANY, 10):
                    if info.valid_data:
                        self.print({"topic": name, "bytes": len(content)})
                continue
            for message in reader.take(10):
                if message.sample_info.valid_data:
                    frame = message.header.frame_id if hasattr(message, "header") else None
                    self.print({"topic": name, "frame": frame, **shown(message)})
                    if isinstance(message, OccupancyGrid):
                        self.grids[name] = message
                        self.plan()
        for name, asked, answer in requests:
            if asked.sample_info.valid_data:
                path = {"file": asked.graph_filepath} if hasattr(asked, "graph_filepath") else {}
                self.print({"topic": name, "called": True, **path})
                answer(asked)
        for call in self.calls:
            name, writer, reader, request, due = call
            # A service that has just been found may not have found its caller yet.
            if request and time.monotonic() >= due and writer.get_matched_subscriptions() and reader.get_matched_publications():
                writer.write(request)
                call[3] = None
            for answer in reader.take(10):
                if answer.sample_info.valid_data and answer.number == 1:
                    results = getattr(answer, "results", None)
                    first = results[0] if results else answer
                    words = {"success": first.successful, "message": first.reason} if results else vars(answer)
                    self.print({"topic": name, "success": words["success"], "message": words["message"]})

    def plan(self) -> None:
        planning, mask = (self.grids.get(f"{self.own}/{name}") for name in ("map", "keepout_mask"))
        if self.arguments.plan and planning and mask and len(planning.data) == len(mask.data):
            self.print({"topic": "plan", "length_m": length_of_way(planning, mask, self.arguments.plan)})

    @staticmethod
    def print(document: dict) -> None:
        print(json.dumps({**document, "at_s": round(time.time(), 4)}), flush=True)


def numbers(text: str) -> list:
    return [float(number) for number in text.split(",")]


def poses(text: str) -> list:
    return [numbers(pose) for pose in text.split(";")]


def value_of(text: str) -> ParameterValue:
    integer = int(text) if text.lstrip("-").isdigit() else None
    kind, words = (4, text) if integer is None else (2, "")
    return ParameterValue(kind, False, integer or 0, 0.0, words, [], [], [], [], [])


def n_lines() -> int | None:
    """Lines that have come on standard input since the last call; `None` at its end."""
    if not select.select([sys.stdin], [], [], 0)[0]:
        return 0
    text = os.read(sys.stdin.fileno(), 4096)
    return text.count(b"\n") if text else None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--domain", type=int, default=0)
    parser.add_argument("--namespace", default="/groundplan")
    parser.add_argument("--for", dest="seconds", type=float, default=math.inf)
    parser.add_argument("--publish-slam-map", type=pathlib.Path)
    parser.add_argument("--topic", default="/map")
    parser.add_argument("--robot-at", type=poses)
    parser.add_argument("--clock", type=float)
    parser.add_argument("--plan", type=numbers)
    parser.add_argument("--nav2", action="store_true")
    parser.add_argument("--raw", action="store_true")
    parser.add_argument("--participants", type=int, default=1)
    parser.add_argument("--lease", type=int)
    parser.add_argument("--call", action="append", default=[])
    parser.add_argument("--set", action="append", default=[])
    arguments = parser.parse_args()
    peer = Peer(arguments)
    if arguments.nav2:
        for action in ("navigate_to_pose", "navigate_through_poses", "follow_waypoints"):
            name = f"/{action}/_action/cancel_goal"
            peer.serve(name, CancelGoalRequest, CancelGoalResponse, [0, []])
        for costmap in ("global_costmap", "local_costmap"):
            peer.serve(f"/{costmap}/clear_entirely_{costmap}", ClearRequest, ClearResponse, [0])
        peer.serve("/route_server/set_route_graph", SetRouteGraphRequest, SetRouteGraphResponse, [True])
    for name in arguments.call:
        peer.call(f"{peer.own}/{name}", TriggerRequest, TriggerResponse, [0])
    for name, _, value in (text.partition("=") for text in arguments.set):
        parameters = [Parameter(name, value_of(value))]
        peer.call(f"{peer.own}/ros_bridge/set_parameters", SetParametersRequest, SetParametersResponse, [parameters])
    slam_map = slam_map_writer = tf_writer = clock_writer = None
    if arguments.publish_slam_map:
        slam_map = read_map(arguments.publish_slam_map)
        slam_map_writer = peer.writer(f"rt{arguments.topic}", OccupancyGrid, LATCHED)
    if arguments.robot_at:
        tf_writer = peer.writer("rt/tf", TFMessage, VOLATILE)
    if arguments.clock is not None:
        clock_writer = peer.writer("rt/clock", Clock, BEST_EFFORT)
    begun = time.monotonic()
    map_due = tf_due = clock_due = begun
    n_driven = 0
    while (now := time.monotonic()) - begun < arguments.seconds:
        if slam_map_writer and now >= map_due:
            slam_map_writer.write(slam_map)
            map_due = now + 1
        if tf_writer and now >= tf_due:
            n_driven += n_lines() or 0
            x, y, yaw = arguments.robot_at[min(n_driven, len(arguments.robot_at) - 1)]
            rotation = Quaternion(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
            transform = Transform(Vector3(x, y, 0.0), rotation)
            tf_writer.write(TFMessage([TransformStamped(Header(Time(0, 0), "map"), "base_link", transform)]))
            tf_due = now + 0.1
        if clock_writer and now >= clock_due:
            seconds = arguments.clock + now - begun
            clock_writer.write(Clock(Time(int(seconds), int(seconds % 1 * 1e9))))
            clock_due = now + 0.05
        peer.spin()
        time.sleep(0.001 if arguments.raw else 0.01)


if __name__ == "__main__":
    try:
        main()
    except (KeyboardInterrupt, BrokenPipeError):
        sys.exit(0)
