"""Schedule state, index and grids that belong together."""

from __future__ import annotations

import datetime
import time
from dataclasses import dataclass

from .bus import Bus, Subscriber
from .grid import Grid, GridIndex, ScheduleState


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
    named: list[Grid] = []
    for slot, grid in zip(index.slots, grids):
        if grid is None or grid.content_hash != slot.content_hash:
            return None
        named.append(grid)
    return SiteSet(state, index, named) if len(named) == len(index.slots) else None


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

    def current(self) -> SiteSet | None:
        """The newest set of samples that belong together; None before there was one."""
        state, index = self._state_topic.receive(), self._index_topic.receive()
        if state is not None:
            self._state = ScheduleState(state.memory)
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
        found = set_of(self._state, self._index, self._grids)
        if found is not None:
            self._current = found
        return self._current

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
