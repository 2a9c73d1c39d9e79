"""View of the archive `mission-plan`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from . import _layouts
from .archive import Archive, Bytes, LayoutError

Vector = tuple[float, float, float]


@dataclass(frozen=True)
class Waypoint:
    """A pose to drive to."""

    id: int
    """Number in the mission plan."""
    order: int
    """Place in the tour, from 0 over all storeys."""
    kind: str
    """One of `_layouts.WAYPOINT_KINDS`: `centre` or `scan`."""
    storey: int
    """Index of the map storey."""
    space: int | None
    """Index of the space in the site; None outside of spaces."""
    position_m: Vector
    """On the floor, in the frame `map`."""
    sensor_m: Vector
    """Place of the sensor in the frame `map`: above the position along `up`."""
    up: Vector
    """Normal of the ground on which the robot stands, a unit vector in the frame `map`."""
    yaw_rad: float
    """Heading: the angle in plan of where the robot looks, whatever the slope."""

    @property
    def quaternion(self) -> tuple[float, float, float, float]:
        """Orientation (x, y, z, w) of the robot in the frame `map`: turned by its yaw, then pitched and rolled until its Z axis is `up`."""
        ahead = math.cos(self.yaw_rad) * self.up[0] + math.sin(self.yaw_rad) * self.up[1]
        left = math.cos(self.yaw_rad) * self.up[1] - math.sin(self.yaw_rad) * self.up[0]
        pitch, roll = math.atan2(ahead, self.up[2]) / 2, math.atan2(-left, math.hypot(ahead, self.up[2])) / 2
        (sr, cr), (sp, cp), (sy, cy) = ((math.sin(a), math.cos(a)) for a in (roll, pitch, self.yaw_rad / 2))
        return (
            sr * cp * cy - cr * sp * sy,
            cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy,
            cr * cp * cy + sr * sp * sy,
        )


class MissionPlan:
    """Waypoints of a robot."""

    def __init__(self, memory: Bytes) -> None:
        archive = Archive(memory, "mission-plan", _layouts.MISSION_PLAN_SECTIONS)
        self.content_hash = archive.content_hash
        self.waypoints = [_waypoint(record) for record in archive.section("waypoints")]
        """In the order of their ids."""


def _waypoint(record: Any) -> Waypoint:
    def vector(name: str) -> Vector:
        x, y, z = (float(value) for value in record[name])
        return x, y, z

    kind = int(record["kind"])
    if kind not in _layouts.WAYPOINT_KINDS:
        raise LayoutError(f"a waypoint is of the kind {kind}, which this package does not know")
    space = int(record["space"])
    return Waypoint(
        id=int(record["id"]),
        order=int(record["order"]),
        kind=_layouts.WAYPOINT_KINDS[kind],
        storey=int(record["map_storey"]),
        space=None if space == _layouts.NONE else space,
        position_m=vector("position_in_map_m"),
        sensor_m=vector("sensor_in_map_m"),
        up=vector("up_in_map"),
        yaw_rad=float(record["yaw_rad"]),
    )
