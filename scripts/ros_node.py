#!/usr/bin/env python3
"""A node of ROS 2 itself (rclpy on Fast DDS): prints what the graph tells it, as `ros2 topic info -v` and `ros2 node info` do.

usage: ros_node.py [--domain N] [--node /groundplan/ros_bridge]

One JSON line a second:
number     of the line
endpoints  by topic, the nodes of its publishers and subscriptions, each with its message type and "typed" or "untyped": whether
           the publisher says the hash of its type
of_node    what the node has by its name: topics that it publishes and subscribes to, its services
Needs ros-kilted-rclpy, ros-kilted-rmw-fastrtps-cpp and ros-kilted-rmw-implementation (scripts/python-env).
"""

import argparse
import json
import os
import sys
import time

import rclpy
from rclpy.node import Node

# Not by the environment of the caller: the daemon is judged by this one.
MIDDLEWARE = "rmw_fastrtps_cpp"


def ends(infos: list) -> list:
    """Sorted, so that a list that says the same is the same."""
    typed = {True: "typed", False: "untyped"}
    return sorted(
        [f"{info.node_namespace.rstrip('/')}/{info.node_name}", info.topic_type, typed[info.topic_type_hash.version > 0]]
        for info in infos
    )


def by_name(node: Node, name: str) -> dict:
    namespace, _, base = name.rpartition("/")
    asked = {
        "publishers": node.get_publisher_names_and_types_by_node,
        "subscriptions": node.get_subscriber_names_and_types_by_node,
        "services": node.get_service_names_and_types_by_node,
    }
    try:
        return {what: dict(sorted(ask(base, namespace or "/"))) for what, ask in asked.items()}
    except rclpy.node.NodeNameNonExistentError:
        return {}


def graph(node: Node, of: str) -> dict:
    topics = sorted(name for name, _ in node.get_topic_names_and_types())
    return {
        "endpoints": {
            topic: {
                "publishers": ends(node.get_publishers_info_by_topic(topic)),
                "subscriptions": ends(node.get_subscriptions_info_by_topic(topic)),
            }
            for topic in topics
        },
        "of_node": by_name(node, of),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--domain", type=int, default=0)
    parser.add_argument("--node", default="/groundplan/ros_bridge")
    arguments = parser.parse_args()
    os.environ["RMW_IMPLEMENTATION"] = MIDDLEWARE
    rclpy.init(domain_id=arguments.domain)
    node = rclpy.create_node("looker")
    number = 0
    while rclpy.ok():
        begun = time.monotonic()
        while time.monotonic() < begun + 1:
            rclpy.spin_once(node, timeout_sec=0.2)
        print(json.dumps({"topic": "graph", "number": number, **graph(node, arguments.node)}), flush=True)
        number += 1


if __name__ == "__main__":
    try:
        main()
    except (KeyboardInterrupt, BrokenPipeError):
        sys.exit(0)
