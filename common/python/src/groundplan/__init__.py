"""Reads the maps of running groundplan daemons in shared memory, in place.

`Bus` joins the daemons, `Subscriber` reads a topic, `SiteReader` gives schedule state, index and grids that belong together,
and the verdict whether a robot may use them.
A view of shared memory keeps its sample: what a program looks at is neither given back nor written.
"""

from .archive import Archive, Header, LayoutError
from .bus import Bus, BusFull, BusGone, Sample, Subscriber
from .grid import Grid, GridIndex, GridSlot, ScheduleState
from .map_rule import MapRule, MapVerdict
from .mission_plan import MissionPlan, Waypoint
from .site import SiteReader, SiteSet

__all__ = [
    "Archive",
    "Bus",
    "BusFull",
    "BusGone",
    "Grid",
    "GridIndex",
    "GridSlot",
    "Header",
    "LayoutError",
    "MapRule",
    "MapVerdict",
    "MissionPlan",
    "Sample",
    "ScheduleState",
    "SiteReader",
    "SiteSet",
    "Subscriber",
    "Waypoint",
]
