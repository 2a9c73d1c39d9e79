#!/usr/bin/env python3
"""A client of the Foxglove server of ros-bridge: prints the channels that it advertises and what comes of them.

usage: foxglove_peer.py [--url ws://127.0.0.1:8765] [--topic TOPIC].. [--world] [--deaf]

The first JSON line has the topic "serverInfo" and the name of the server; then there is one line for each advertised channel with
schema and encodings, and one for each message with what a person wants to know of it, decoded with the schema that was
advertised. --topic subscribes to these alone. --world gets the models of entities by their URLs. --deaf subscribes to all and reads nothing from then on.
It ends with the server. Needs numpy, websockets, mcap-ros2-support and mcap-protobuf-support.
"""

import argparse
import base64
import hashlib
import json
import struct
import sys
import time

import numpy
from google.protobuf.json_format import MessageToDict
from mcap.records import Schema
from mcap_protobuf.decoder import DecoderFactory as ProtobufDecoder
from mcap_ros2.decoder import DecoderFactory as RosDecoder
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect

SUBPROTOCOL = "foxglove.sdk.v1"
MESSAGE_DATA = 1
ASSET = 4


def grid(message):
    cells = numpy.asarray(message.data, numpy.int8)
    return {"frame": message.header.frame_id, "resolution_m": round(message.info.resolution, 6),
            "size": [message.info.width, message.info.height], "sha256": hashlib.sha256(cells.tobytes()).hexdigest()}


def elevation(message):
    """The sum is that of the same numbers in a map of grid_map: layer by layer, from the largest x and y."""
    cells = numpy.frombuffer(bytes(message.data), "<f4").reshape(-1, len(message.fields))
    return {"frame": message.frame_id, "fields": [field.name for field in message.fields], "cells": len(cells),
            "sha256": hashlib.sha256(numpy.ascontiguousarray(cells[::-1].T).tobytes()).hexdigest()}


def markers(message):
    return {"namespaces": sorted({marker.ns for marker in message.markers if marker.ns}), "markers": len(message.markers)}


def entities(message):
    rooms = [{fact["key"]: fact.get("value", "") for fact in entity.get("metadata", [])}
             for entity in MessageToDict(message).get("entities", []) if "metadata" in entity]
    models = [model for entity in MessageToDict(message).get("entities", []) for model in entity.get("models", [])]
    return {"rooms": rooms, "models": [{"url": model["url"], "z_m": model["pose"]["position"].get("z", 0.0)}
                                       for model in models]}


def pose(message):
    position = message.pose.pose.position
    return {"frame": message.header.frame_id, "position_m": [position.x, position.y],
            "covariance": list(message.pose.covariance)}


SHOWN = {
    "nav_msgs/msg/OccupancyGrid": grid,
    "nav2_msgs/msg/CostmapFilterInfo": lambda message: {"mask": message.filter_mask_topic, "type": message.type},
    "visualization_msgs/msg/MarkerArray": markers,
    "foxglove_msgs/msg/Grid": elevation,
    "foxglove.SceneUpdate": entities,
    "std_msgs/msg/String": lambda message: json.loads(message.data),
    "geometry_msgs/msg/PoseWithCovarianceStamped": pose,
    "tf2_msgs/msg/TFMessage": lambda message: {
        "frames": [[each.header.frame_id, each.child_frame_id] for each in message.transforms]},
    "diagnostic_msgs/msg/DiagnosticArray": lambda message: {"n_status": len(message.status)},
}


def tell(topic, **facts):
    print(json.dumps({"topic": topic, **facts}), flush=True)


class Channel:
    """A channel as it was advertised."""

    def __init__(self, advertised):
        self.id, self.topic, self.encoding = advertised["id"], advertised["topic"], advertised["encoding"]
        self.schema_name, self.schema_encoding = advertised["schemaName"], advertised["schemaEncoding"]
        text = advertised["schema"]
        # Schemas that are no text are sent as text.
        data = base64.b64decode(text) if self.schema_encoding == "protobuf" else text.encode()
        schema = Schema(self.id + 1, data, self.schema_encoding, self.schema_name)
        factories = [RosDecoder(), ProtobufDecoder()]
        decoders = (factory.decoder_for(self.encoding, schema) for factory in factories)
        self.decode = next(decoder for decoder in decoders if decoder)

    def tell(self):
        tell("advertised " + self.topic, schema=self.schema_name, schema_encoding=self.schema_encoding,
             encoding=self.encoding)


def tell_asset(frame):
    number, failed, length = struct.unpack_from("<IBI", frame, 1)
    error, content = frame[10:10 + length].decode(), frame[10 + length:]
    facts = {"error": error} if failed else {"bytes": len(content), "sha256": hashlib.sha256(content).hexdigest()}
    tell(f"asset {number}", **facts)


def follow(socket, wanted, world, deaf):
    """Subscribes to channels by their number and shows their messages."""
    channels = {}
    n_assets = 0
    for frame in socket:
        if isinstance(frame, bytes):
            if frame[0] == MESSAGE_DATA:
                number, log_time_ns = struct.unpack_from("<IQ", frame, 1)
                channel = channels[number]
                shown = SHOWN[channel.schema_name](channel.decode(frame[13:]))
                tell(channel.topic, log_time_ns=log_time_ns, **shown)
                for model in shown.get("models", []) if world else []:
                    n_assets += 1
                    socket.send(json.dumps({"op": "fetchAsset", "requestId": n_assets, "uri": model["url"]}))
            elif frame[0] == ASSET:
                tell_asset(frame)
            continue
        message = json.loads(frame)
        if message["op"] == "serverInfo":
            tell("serverInfo", name=message["name"], subprotocol=socket.subprotocol)
        elif message["op"] == "advertise":
            advertised = [Channel(each) for each in message["channels"]]
            for channel in advertised:
                channels[channel.id] = channel
                channel.tell()
            ids = [c.id for c in advertised if not wanted or c.topic in wanted]
            socket.send(json.dumps({"op": "subscribe", "subscriptions": [{"id": n, "channelId": n} for n in ids]}))
            if deaf:
                tell("deaf")
                while True:
                    time.sleep(3600)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--url", default="ws://127.0.0.1:8765", help="the server (default %(default)s)")
    parser.add_argument("--topic", action="append", default=[], help="only these topics")
    parser.add_argument("--world", action="store_true", help="get the models of entities by their URLs")
    parser.add_argument("--deaf", action="store_true", help="read nothing once subscribed")
    arguments = parser.parse_args()
    # A queue of one frame: a client that does not take it stops the sender.
    queue = 1 if arguments.deaf else 64
    with connect(arguments.url, subprotocols=[SUBPROTOCOL], max_size=None, max_queue=queue) as socket:
        follow(socket, set(arguments.topic), arguments.world, arguments.deaf)


if __name__ == "__main__":
    try:
        main()
    except (KeyboardInterrupt, BrokenPipeError, ConnectionClosed):
        sys.exit(0)
