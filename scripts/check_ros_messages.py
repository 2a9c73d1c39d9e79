#!/usr/bin/env python3
"""Checks messages of the crate `ros` against rosbags: definitions, type hashes, field values and bytes.

usage: scripts/check_ros_messages.py FOLDER

FOLDER/messages.json is a list of objects with the name of the type in full, its definition, its hash, the value of a message as
JSON, and the file in FOLDER that holds its bytes. Needs rosbags, which has the types of Jazzy but for those of nav2_msgs, grid_map_msgs,
foxglove_msgs and std_srvs.
"""

import json
import pathlib
import sys

import numpy
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

# Types that rosbags lacks, as their packages define them.
MORE_TYPES = {
    "nav2_msgs/msg/CostmapFilterInfo": """std_msgs/Header header
uint8 type
string filter_mask_topic
float32 base
float32 multiplier
""",
    "grid_map_msgs/msg/GridMapInfo": """# Resolution of the grid [m/cell].
float64 resolution
# Lengths in x and y [m].
float64 length_x
float64 length_y
# The middle of the map.
geometry_msgs/Pose pose
""",
    "grid_map_msgs/msg/GridMap": """std_msgs/Header header
GridMapInfo info
string[] layers
string[] basic_layers
std_msgs/Float32MultiArray[] data
uint16 outer_start_index
uint16 inner_start_index
""",
    "foxglove_msgs/msg/Vector2": "float64 x\nfloat64 y\n",
    "foxglove_msgs/msg/PackedElementField": """string name
uint32 offset
uint8 UNKNOWN=0
uint8 UINT8=1
uint8 INT8=2
uint8 UINT16=3
uint8 INT16=4
uint8 UINT32=5
uint8 INT32=6
uint8 FLOAT32=7
uint8 FLOAT64=8
uint8 type
""",
    "foxglove_msgs/msg/Grid": """builtin_interfaces/Time timestamp
string frame_id
geometry_msgs/Pose pose
uint32 column_count
foxglove_msgs/Vector2 cell_size
uint32 row_stride
uint32 cell_stride
foxglove_msgs/PackedElementField[] fields
uint8[] data
""",
    "std_srvs/srv/Trigger_Request": "uint8 structure_needs_at_least_one_member\n",
    "std_srvs/srv/Trigger_Response": "bool success\nstring message\n",
}


def parsed(definition, name):
    """Types of a definition by name. rosbags takes the request of a service for a message in a folder `msg` below it."""
    types = get_types_from_msg(definition, name)
    return {key.replace("/srv/msg/", "/srv/"): value for key, value in types.items()}


def typestore():
    store = get_typestore(Stores.ROS2_JAZZY)
    for name, definition in MORE_TYPES.items():
        store.register({name: parsed(definition, name)[name]})
    return store


def difference(read, expected, place):
    """Where a message that was read is not what was written; None if it is."""
    if isinstance(expected, dict):
        for name, value in expected.items():
            found = difference(getattr(read, name), value, f"{place}.{name}")
            if found:
                return found
        return None
    if isinstance(read, numpy.ndarray):
        flat = numpy.array(expected).reshape(-1)
        # JSON has the bytes of int8[].
        flat = flat.astype(numpy.uint8).view(numpy.int8) if read.dtype == numpy.int8 else flat.astype(read.dtype)
        return None if numpy.array_equal(read, flat) else f"{place}: {read} is not {flat}"
    if isinstance(expected, list):
        if len(read) != len(expected):
            return f"{place}: {len(read)} items instead of {len(expected)}"
        pairs = enumerate(zip(read, expected))
        return next((d for k, (r, e) in pairs if (d := difference(r, e, f"{place}[{k}]"))), None)
    equal = numpy.float32(read) == numpy.float32(expected) if isinstance(expected, float) else read == expected
    return None if equal else f"{place}: {read!r} is not {expected!r}"


def faults(store, message, folder):
    name = message["type"]
    types = parsed(message["definition"], name)
    if "structure_needs_at_least_one_member" in message["value"]:
        # Its definition is empty: the member is made up by the generators of interfaces.
        types[name] = store.fielddefs[name]
    for used, fields in types.items():
        if fields != store.fielddefs[used]:
            yield f"its definition of {used} is another: {fields} instead of {store.fielddefs[used]}"
    expected = store.hash_rihs01(name)
    if message["type_hash"] != expected:
        yield f"its hash is {expected}"
    data = (folder / message["file"]).read_bytes()
    read = store.deserialize_cdr(data, name)
    found = difference(read, message["value"], name)
    if found:
        yield found
    again = bytes(store.serialize_cdr(read, name, little_endian=True))
    if again != data:
        yield f"rosbags writes {again.hex()} instead of {data.hex()}"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    folder, store = pathlib.Path(sys.argv[1]), typestore()
    messages = json.loads((folder / "messages.json").read_text(encoding="utf-8"))
    wrong = [f"{message['type']}: {fault}" for message in messages for fault in faults(store, message, folder)]
    if wrong:
        sys.exit("\n".join(wrong))
    print(f"{len(messages)} messages are those of rosbags")


if __name__ == "__main__":
    main()
