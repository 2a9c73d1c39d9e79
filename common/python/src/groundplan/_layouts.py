"""Layouts of headers and archives, as numpy reads them.

Written by a test of common/messages with UPDATE_GOLDEN=1 from the records there: not to be edited.
"""

from __future__ import annotations

from typing import Any

LAYOUT_VERSION: int = 1
ARCHIVE_MAGIC: int = 1380012103
SAMPLE_MAGIC: int = 1213419591
NO_TIME: int = -9223372036854775808
NO_HEIGHT: int = -2147483648
NO_SLOPE: int = 65535
NONE: int = 4294967295
WAYPOINT_KINDS: dict[int, str] = {
    1: "centre",
    2: "scan",
}
KINDS: dict[str, int] = {
    "site": 1,
    "schedule-state": 2,
    "grid": 3,
    "grids": 4,
    "mission-plan": 5,
    "slam-map": 6,
    "alignment": 7,
    "deviations": 8,
    "alignment-evidence": 9,
    "tasks": 10,
    "ground": 11,
}
INPUT_HASHES: list[tuple[str, Any]] = [
    ("site", "<u8"),
    ("schedule_state", "<u8"),
    ("grids", "<u8"),
    ("robot", "<u8"),
    ("slam_map", "<u8"),
    ("own", "<u8"),
]
SAMPLE_HEADER: list[tuple[str, Any]] = [
    ("magic", "<u4"),
    ("layout_version", "<u4"),
    ("kind", "<u4"),
    ("flags", "<u4"),
    ("epoch", "<u8"),
    ("stamp_ns", "<u8"),
    ("payload_length", "<u8"),
    ("content_hash", "<u8"),
    ("frame_epoch", "<u8"),
    ("inputs", INPUT_HASHES),
    ("reserved", ("<u8", (3,))),
]
PREAMBLE: list[tuple[str, Any]] = [
    ("magic", "<u4"),
    ("layout_version", "<u4"),
    ("kind", "<u4"),
    ("n_sections", "<u4"),
    ("length", "<u8"),
    ("content_hash", "<u8"),
    ("reserved", ("<u8", (4,))),
]
SECTION_ENTRY: list[tuple[str, Any]] = [
    ("id", "<u4"),
    ("record_len", "<u4"),
    ("offset", "<u8"),
    ("count", "<u8"),
]
GRID_HEAD: list[tuple[str, Any]] = [
    ("cell_tenths", "<i4"),
    ("first_cell", ("<i4", (2,))),
    ("width", "<u4"),
    ("height", "<u4"),
    ("map_storey", "<u4"),
    ("floor_z_tenths", "<i4"),
    ("slab_tenths", ("<i4", (2,))),
    ("floor", "<u4"),
    ("frame_epoch", "<u4"),
    ("reserved", "<u4"),
]
ROBOT_PROFILE: list[tuple[str, Any]] = [
    ("height_m", "<f8"),
    ("clearance_above_m", "<f8"),
    ("step_height_m", "<f8"),
    ("radius_m", "<f8"),
    ("max_slope_rad", "<f8"),
    ("max_cross_slope_rad", "<f8"),
    ("door_margin_m", "<f8"),
    ("edge_margin_m", "<f8"),
    ("work_margin_m", "<f8"),
    ("lidar_height_m", "<f8"),
    ("lidar_range_m", "<f8"),
    ("sensor_height_m", "<f8"),
    ("opens", "<u4"),
    ("climbs_stairs", "<u4"),
    ("stair_cost", "<u4"),
    ("reserved", "<u4"),
]
GRIDS_HEAD: list[tuple[str, Any]] = [
    ("site_hash", "<u8"),
    ("schedule_state_hash", "<u8"),
    ("plan_time_s", "<i8"),
    ("robot", ROBOT_PROFILE),
]
GRID_SLOT: list[tuple[str, Any]] = [
    ("map_storey", "<u4"),
    ("cell_tenths", "<i4"),
    ("content_hash", "<u8"),
]
SCHEDULE_STATE_HEAD: list[tuple[str, Any]] = [
    ("site_hash", "<u8"),
    ("tasks_hash", "<u8"),
    ("plan_time_s", "<i8"),
    ("plan_until_s", "<i8"),
    ("valid_from_s", "<i8"),
    ("valid_until_s", "<i8"),
    ("n_changes", "<u4"),
    ("paper", "<u4"),
]
TEXT: list[tuple[str, Any]] = [
    ("offset", "<u4"),
    ("length", "<u4"),
]
POSE_EVIDENCE: list[tuple[str, Any]] = [
    ("log_odds", "<f8"),
    ("score", "<f8"),
    ("precision", "<f8"),
    ("recall", "<f8"),
    ("free", "<f8"),
    ("seen_m", "<f8"),
    ("seen_through", "<f8"),
    ("in_walls", "<f8"),
    ("outside", "<f8"),
    ("free_in_walls", "<f8"),
    ("distinct_m", "<f8"),
]
POSE: list[tuple[str, Any]] = [
    ("map_from_slam", ("<f8", (3,))),
    ("covariance", ("<f8", (9,))),
    ("about_m", ("<f8", (2,))),
    ("evidence", POSE_EVIDENCE),
    ("map_storey", "<u4"),
    ("reserved", "<u4"),
]
ALIGNMENT_HEAD: list[tuple[str, Any]] = [
    ("site_hash", "<u8"),
    ("slam_map_hash", "<u8"),
    ("searched_map_hash", "<u8"),
    ("plan_time_s", "<i8"),
    ("pose", POSE),
    ("waiting", POSE),
    ("wrong_probability", "<f8"),
    ("scale", "<f8"),
    ("scale_deviation", "<f8"),
    ("reason", TEXT),
    ("decision", TEXT),
    ("change", TEXT),
    ("verdict", "<u4"),
    ("state", "<u4"),
    ("is_waiting", "<u4"),
    ("validity", "<u4"),
    ("first_undecided", "<u4"),
    ("reserved", "<u4"),
]
DECIDING_PLACE: list[tuple[str, Any]] = [
    ("in_slam_m", ("<f8", (2,))),
    ("way_m", "<f8"),
    ("differing_m", "<f8"),
    ("first_placed", "<u4"),
    ("n_placed", "<u4"),
    ("first_pair", "<u4"),
    ("n_pairs", "<u4"),
]
PLACED: list[tuple[str, Any]] = [
    ("in_map_m", ("<f8", (2,))),
    ("room_global_id", TEXT),
    ("room_name", TEXT),
    ("room_long_name", TEXT),
]
POSE_PAIR: list[tuple[str, Any]] = [
    ("candidates", ("<u4", (2,))),
]
HINT: list[tuple[str, Any]] = [
    ("label", TEXT),
    ("n_excluded", "<u4"),
    ("reserved", "<u4"),
]
WAYPOINT: list[tuple[str, Any]] = [
    ("position_in_map_m", ("<f8", (3,))),
    ("sensor_in_map_m", ("<f8", (3,))),
    ("up_in_map", ("<f8", (3,))),
    ("yaw_rad", "<f8"),
    ("centroid_in_map_m", ("<f8", (3,))),
    ("clearance_m", "<f8"),
    ("covers_m2", "<f8"),
    ("overlap", "<f8"),
    ("registration_overlap", "<f8"),
    ("overlap_without", "<f8"),
    ("leg_m", "<f8"),
    ("id", "<u4"),
    ("order", "<u4"),
    ("kind", "<u4"),
    ("map_storey", "<u4"),
    ("space", "<u4"),
    ("joins", "<u4"),
    ("n_faces", "<u4"),
    ("registration_order", "<u4"),
]
SITE_SECTIONS: dict[str, tuple[int, Any]] = {
    "vertices": (8, ("<i4", (3,))),
    "triangles": (9, ("<u4", (3,))),
    "points": (12, ("<i4", (2,))),
    "materials": (18, TEXT),
    "periods_s": (35, ("<u4", (2,))),
    "listed_texts": (22, TEXT),
    "strings": (2, "u1"),
}
SCHEDULE_STATE_SECTIONS: dict[str, tuple[int, Any]] = {
    "head": (1, SCHEDULE_STATE_HEAD),
    "planned": (3, "u1"),
    "effective": (4, "u1"),
    "listed_texts": (8, TEXT),
    "strings": (2, "u1"),
}
GRID_SECTIONS: dict[str, tuple[int, Any]] = {
    "head": (1, GRID_HEAD),
    "class": (2, "u1"),
    "planning": (3, "i1"),
    "localization": (4, "i1"),
    "keepout": (5, "i1"),
    "floor": (6, "u1"),
    "space": (7, "<u2"),
    "elevation": (8, "<i4"),
    "slope": (9, "<u2"),
}
GRIDS_SECTIONS: dict[str, tuple[int, Any]] = {
    "head": (1, GRIDS_HEAD),
    "slots": (2, GRID_SLOT),
    "robot_name": (3, "u1"),
    "robot_footprint_m": (6, ("<f8", (2,))),
    "safety_materials": (8, "u1"),
}
MISSION_PLAN_SECTIONS: dict[str, tuple[int, Any]] = {
    "waypoints": (3, WAYPOINT),
    "tour_points": (6, ("<f8", (2,))),
    "points": (9, ("<f8", (3,))),
    "flight_edges": (35, ("<u4", (2,))),
    "strings": (2, "u1"),
}
SLAM_MAP_SECTIONS: dict[str, tuple[int, Any]] = {
    "occupancy": (2, "i1"),
}
ALIGNMENT_SECTIONS: dict[str, tuple[int, Any]] = {
    "head": (1, ALIGNMENT_HEAD),
    "candidates": (3, POSE),
    "deciding_places": (4, DECIDING_PLACE),
    "placed": (5, PLACED),
    "pose_pairs": (6, POSE_PAIR),
    "hints": (7, HINT),
    "strings": (2, "u1"),
    "local_poses_blocks": (10, "<u4"),
    "local_poses_corners": (12, ("<f8", (2,))),
}
DEVIATIONS_SECTIONS: dict[str, tuple[int, Any]] = {
    "points": (5, ("<i4", (2,))),
    "seen": (7, "u1"),
}
ALIGNMENT_EVIDENCE_SECTIONS: dict[str, tuple[int, Any]] = {
    "known": (3, "u1"),
}
TASKS_SECTIONS: dict[str, tuple[int, Any]] = {
    "periods_s": (35, ("<u4", (2,))),
    "strings": (2, "u1"),
}
GROUND_SECTIONS: dict[str, tuple[int, Any]] = {
    "vertices": (3, ("<i4", (3,))),
}
