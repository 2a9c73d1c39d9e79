#!/usr/bin/env python3
"""A peer of ros-bridge in the ROS 2 graph, with CycloneDDS and without ROS: prints what the bridge publishes.

usage: ros_peer.py [--domain N] [--namespace /groundplan] [--for SECONDS] [--publish-slam-map FILE.yaml --topic /map]

Each message is one JSON line: topic, frame, and what a person wants to know of it. With --publish-slam-map it is the
robot: it publishes a map of a map server as SLAM would, latched, once a second.
"""

import argparse
import hashlib
import json
import math
import pathlib
import sys
import time
from dataclasses import dataclass

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import array, float32, float64, int32, sequence, uint8, uint32
from cyclonedds.pub import DataWriter, Publisher
from cyclonedds.sub import DataReader, Subscriber
from cyclonedds.topic import Topic
from cyclonedds.util import duration


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


LATCHED = Qos(
    Policy.Reliability.Reliable(duration(seconds=1)), Policy.Durability.TransientLocal, Policy.History.KeepLast(1)
)
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
    magic, width, height, most, cells = (path.parent / words["image"].strip()).read_bytes().split(maxsplit=4)
    assert magic == b"P5" and most == b"255"
    width, height = int(width), int(height)
    rule = [100 if (255 - p) / 255 > 0.65 else 0 if (255 - p) / 255 < 0.196 else 255 for p in range(256)]
    rows = [cells[k * width : (k + 1) * width].translate(bytes(rule)) for k in reversed(range(height))]
    x, y, yaw = json.loads(words["origin"])
    orientation = Quaternion(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2))
    origin = Pose(Point(x, y, 0.0), orientation)
    info = MapMetaData(Time(0, 0), float(words["resolution"]), width, height, origin)
    return OccupancyGrid(Header(Time(0, 0), "map"), info, list(b"".join(rows)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--domain", type=int, default=0)
    parser.add_argument("--namespace", default="/groundplan")
    parser.add_argument("--for", dest="seconds", type=float, default=math.inf)
    parser.add_argument("--publish-slam-map", type=pathlib.Path)
    parser.add_argument("--topic", default="/map")
    arguments = parser.parse_args()
    participant = DomainParticipant(arguments.domain)
    subscriber, publisher = Subscriber(participant), Publisher(participant)
    own = arguments.namespace.rstrip("/")
    wanted = [
        (f"{own}/map", OccupancyGrid, LATCHED, of_grid),
        (f"{own}/localization_map", OccupancyGrid, LATCHED, of_grid),
        (f"{own}/keepout_mask", OccupancyGrid, LATCHED, of_grid),
        (f"{own}/keepout_info", CostmapFilterInfo, LATCHED, of_info),
        (f"{own}/changed", String, LATCHED, lambda message: json.loads(message.data)),
        ("/tf_static", TFMessage, LATCHED, of_transforms),
        ("/diagnostics", DiagnosticArray, VOLATILE, of_diagnostics),
    ]
    readers = []
    for name, kind, qos, shown in wanted:
        topic = Topic(participant, f"rt{name}", kind)
        readers.append((name, DataReader(subscriber, topic, qos=qos), shown))
    writer = slam_map = None
    if arguments.publish_slam_map:
        slam_map = read_map(arguments.publish_slam_map)
        writer = DataWriter(publisher, Topic(participant, f"rt{arguments.topic}", OccupancyGrid), qos=LATCHED)
    begun = published = time.monotonic()
    published -= 10
    while time.monotonic() - begun < arguments.seconds:
        if writer and time.monotonic() - published >= 1:
            writer.write(slam_map)
            published = time.monotonic()
        for name, reader, shown in readers:
            for message in reader.take(10):
                if not message.sample_info.valid_data:
                    continue
                frame = message.header.frame_id if hasattr(message, "header") else None
                print(json.dumps({"topic": name, "frame": frame, **shown(message)}), flush=True)
        time.sleep(0.02)


if __name__ == "__main__":
    try:
        main()
    except (KeyboardInterrupt, BrokenPipeError):
        sys.exit(0)
