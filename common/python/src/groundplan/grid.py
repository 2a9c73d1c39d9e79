"""Views of the archives `grid`, `grids` and `schedule-state`."""

from __future__ import annotations

import datetime
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _layouts
from .archive import Archive, Bytes, LayoutError

TENTHS_PER_M = 10_000
MRAD_PER_RAD = 1_000
EPOCH = datetime.datetime(1970, 1, 1)


def plan_time(seconds: int) -> datetime.datetime | None:
    """Civil time at the site; None for no such time."""
    return None if seconds == _layouts.NO_TIME else EPOCH + datetime.timedelta(seconds=seconds)


class Grid:
    """Layers of one map storey; row 0 is the lowest, column 0 the leftmost, yaw is 0."""

    def __init__(self, memory: Bytes) -> None:
        archive = Archive(memory, "grid", _layouts.GRID_SECTIONS)
        head = archive.head()
        cell = int(head["cell_tenths"])
        self._shape = (int(head["height"]), int(head["width"]))
        self.content_hash = archive.content_hash
        self.storey = int(head["map_storey"])
        """Index of the map storey."""
        self.resolution_m = cell / TENTHS_PER_M
        """Side of a cell."""
        self.origin_m = (int(head["first_cell"][0]) * cell / TENTHS_PER_M, int(head["first_cell"][1]) * cell / TENTHS_PER_M)
        """Lower left corner in the frame `map`."""
        self.floor_z_m = int(head["floor_z_tenths"]) / TENTHS_PER_M
        """Height of the floor in the frame `map`."""
        self.slab_m = (int(head["slab_tenths"][0]) / TENTHS_PER_M, int(head["slab_tenths"][1]) / TENTHS_PER_M)
        """Heights above the floor between which elements are obstacles."""
        self.classes: npt.NDArray[np.uint8] = self._layer(archive, "class")
        """What a cell shows: the numbers of `classes.png`."""
        self.planning: npt.NDArray[np.int8] = self._layer(archive, "planning")
        """0 free, 100 occupied, -1 unknown."""
        self.localization: npt.NDArray[np.int8] = self._layer(archive, "localization")
        """0 free, 100 occupied, -1 unknown."""
        self.keepout: npt.NDArray[np.int8] = self._layer(archive, "keepout")
        """100 where a robot must not enter, -1 elsewhere."""
        self.floor: npt.NDArray[np.uint8] = self._layer(archive, "floor")
        """0 none, 1 built, 2 assumed."""
        self.space: npt.NDArray[np.uint16] = self._layer(archive, "space")
        """Index of the space plus 1; 0 for none."""
        self._heights = archive.optional_section("elevation")
        self._slopes = archive.optional_section("slope")
        if (self._heights is None) != (self._slopes is None):
            raise LayoutError("the grid has heights without slopes, or slopes without heights")
        if self._heights is not None and self._slopes is not None:
            self._heights, self._slopes = self._layer(archive, "elevation"), self._layer(archive, "slope")

    @property
    def elevation(self) -> npt.NDArray[np.float64] | None:
        """Height of the ground in the middle of each cell in the frame `map`, in metres; NaN where there is none.

        None on a level storey: its floor lies at `floor_z_m`, in the cells in which `floor` is not 0. A copy, made at each call.
        """
        if self._heights is None:
            return None
        return np.where(self._heights == _layouts.NO_HEIGHT, np.nan, self._heights / TENTHS_PER_M)

    @property
    def slope(self) -> npt.NDArray[np.float64] | None:
        """Slope of the ground in each cell, in radians; NaN where there is none.

        None on a level storey. A copy, made at each call.
        """
        if self._slopes is None:
            return None
        return np.where(self._slopes == _layouts.NO_SLOPE, np.nan, self._slopes / MRAD_PER_RAD)

    def _layer(self, archive: Archive, name: str) -> npt.NDArray[Any]:
        layer = archive.section(name)
        if len(layer) != self._shape[0] * self._shape[1]:
            raise LayoutError(f"layer {name} has {len(layer)} cells, the grid has {self._shape[0]} x {self._shape[1]}")
        return layer.reshape(self._shape)

    def cell_at(self, x_m: float, y_m: float) -> tuple[int, int] | None:
        """Row and column of the cell at a point of the frame `map`; None outside."""
        column = int(np.floor((x_m - self.origin_m[0]) / self.resolution_m))
        row = int(np.floor((y_m - self.origin_m[1]) / self.resolution_m))
        inside = 0 <= row < self._shape[0] and 0 <= column < self._shape[1]
        return (row, column) if inside else None


@dataclass(frozen=True)
class GridSlot:
    """A grid that an index names."""

    storey: int
    """Index of the map storey."""
    resolution_m: float
    """Side of a cell."""
    content_hash: int
    """Hash of the grid's content."""


class GridIndex:
    """Index of a set of grids that belong together."""

    def __init__(self, memory: Bytes) -> None:
        archive = Archive(memory, "grids", _layouts.GRIDS_SECTIONS)
        head = archive.head()
        self.content_hash = archive.content_hash
        self.site_hash = int(head["site_hash"])
        """Content hash of the site."""
        self.schedule_state_hash = int(head["schedule_state_hash"])
        """Content hash of the schedule state."""
        self.plan_time = plan_time(int(head["plan_time_s"]))
        """Civil time at the site; None if everything is built regardless of dates."""
        self.robot_name = archive.section("robot_name").tobytes().decode()
        """Name of the robot profile."""
        self.robot = {name: head["robot"][name].item() for name in head["robot"].dtype.names}
        """Robot profile that the maps are for, by the keys of its file."""
        slots = archive.section("slots")
        self.slots = [
            GridSlot(int(s["map_storey"]), int(s["cell_tenths"]) / TENTHS_PER_M, int(s["content_hash"])) for s in slots
        ]
        """The grids, in the order of their topics `grid/00` .."""


class ScheduleState:
    """Plan time and validity of the states of elements and spaces."""

    def __init__(self, memory: Bytes) -> None:
        archive = Archive(memory, "schedule-state", _layouts.SCHEDULE_STATE_SECTIONS)
        head = archive.head()
        self.content_hash = archive.content_hash
        self.site_hash = int(head["site_hash"])
        """Content hash of the site."""
        self.plan_time = plan_time(int(head["plan_time_s"]))
        """Civil time at the site; None if everything is built regardless of dates."""
        self.valid_until = plan_time(int(head["valid_until_s"]))
        """The next change; None if there is none."""
