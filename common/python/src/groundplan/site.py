"""Schedule state, index and grids that belong together, and whether a robot may use them."""

from __future__ import annotations

import datetime
import time
from dataclasses import dataclass

from . import board
from ._map_limits import FOLLOWER, WATCHED
from .bus import OF_ROBOT, Bus, BusGone, Subscriber
from .grid import Grid, GridIndex, ScheduleState
from .map_rule import MapRule, MapVerdict, newest_schedule_report


@dataclass(frozen=True)
class SiteSet:
    """Schedule state, index and grids that belong together: their hashes name each other."""

    state: ScheduleState
    index: GridIndex
    grids: list[Grid]
    """In the order of the index."""

    @property
    def plan_time(self) -> datetime.datetime | None:
        """Civil time at the site; None if everything is built regardless of dates."""
        return self.state.plan_time

    @property
    def valid_until(self) -> datetime.datetime | None:
        """Plan time of the next change, after which these maps are not to be used; None if there is none."""
        return self.state.valid_until


def set_of(state: ScheduleState | None, index: GridIndex | None, grids: list[Grid | None]) -> SiteSet | None:
    """The set of the newest samples; None while they do not match, because some are on their way."""
    if state is None or index is None:
        return None
    if (index.site_hash, index.schedule_state_hash) != (state.site_hash, state.content_hash):
        return None
    named = named_grids(index, grids)
    return None if named is None else SiteSet(state, index, named)


def named_grids(index: GridIndex, grids: list[Grid | None]) -> list[Grid] | None:
    """The grids that an index names; None while one of them is on its way."""
    named: list[Grid] = []
    for slot, grid in zip(index.slots, grids):
        if grid is None or grid.content_hash != slot.content_hash:
            return None
        named.append(grid)
    return named if len(named) == len(index.slots) else None


class SiteReader:
    """The newest set of a site. Two dates are never mixed: while samples do not match, the set of before stays."""

    def __init__(self, bus: Bus) -> None:
        self._bus = bus
        self._index_topic = Subscriber(bus, "grids")
        self._state_topic = Subscriber(bus, "schedule-state")
        self._grid_topics: list[Subscriber] = []
        self._state: ScheduleState | None = None
        self._index: GridIndex | None = None
        self._grids: list[Grid | None] = []
        self._current: SiteSet | None = None
        self._rule = MapRule()
        self._generation = 0

    def current(self) -> SiteSet | None:
        """The newest set of samples that belong together; None before there was one."""
        state, index = self._state_topic.receive(), self._index_topic.receive()
        now_ns = board.monotonic_ns()
        if self._bus.generation != self._generation:
            # As in a new reader: there is no map until schedule state, index and grids have come again.
            self._rule, self._generation = MapRule(), self._bus.generation
            self._rule.joined(now_ns)
        if state is not None:
            self._state = ScheduleState(state.memory)
            self._rule.insert_schedule_state(now_ns, self._state.content_hash, self._state.site_hash)
        if index is not None:
            self._index = GridIndex(index.memory)
            wanted = len(self._index.slots)
            del self._grid_topics[wanted:], self._grids[wanted:]
            for slot in range(len(self._grid_topics), wanted):
                self._grid_topics.append(Subscriber(self._bus, f"grid/{slot:02}"))
                self._grids.append(None)
        for slot, topic in enumerate(self._grid_topics):
            sample = topic.receive()
            if sample is not None:
                self._grids[slot] = Grid(sample.memory)
        if self._index is not None:
            has_grids = named_grids(self._index, self._grids) is not None
            if index is not None:
                self._rule.insert_index(now_ns, self._index.schedule_state_hash, self._index.site_hash, has_grids)
            self._rule.set_grids(now_ns, has_grids)
        found = set_of(self._state, self._index, self._grids)
        if found is not None:
            self._current = found
        return self._current

    def verdict(self) -> MapVerdict:
        """Whether a robot may use the current set, by the rule of the daemons' own consumers: to be asked before each use.

        Takes what has come. Without a bus there is no map.
        """
        try:
            self.current()
        except BusGone as gone:
            return MapVerdict("no_map", str(gone))
        reports: dict[str, board.Report] = {}
        for daemon in (*WATCHED, FOLLOWER):
            report = board.report(self._bus.root, daemon, self._bus.robot if daemon in OF_ROBOT else None)
            if report is not None:
                reports[daemon] = report
                self._rule.insert_heartbeat(report.stamp_ns, daemon)
        now_ns = board.monotonic_ns()
        reporter = newest_schedule_report({daemon: report.stamp_ns for daemon, report in reports.items()}, now_ns)
        if reporter is not None:
            facts = reports[reporter].facts
            self._rule.set_next_state(facts.get("next_update_ms"), facts.get("clock_distrust"))
        return self._rule.verdict(now_ns, time.time_ns() // 1_000_000)

    def wait(self, timeout_s: float) -> SiteSet:
        """As `current`, but waits for a first set.

        Raises TimeoutError without one.
        """
        deadline = time.monotonic() + timeout_s
        while True:
            found = self.current()
            if found is not None:
                return found
            left = deadline - time.monotonic()
            if left <= 0:
                raise TimeoutError(f"no maps within {timeout_s} s; see `groundplan status`")
            self._index_topic.sleep(left)
