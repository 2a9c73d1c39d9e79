"""The rule by which maps may be used: that of `common/site-view`, whose table of cases the tests of this package check.

No bus and no clock inside: times are arguments, monotonic ones in nanoseconds since the machine's boot.
"""

from __future__ import annotations

import datetime
from dataclasses import dataclass

from ._map_limits import FOLLOWER, FRESH_TOLERANCE_NS, GRIDS_LATE_NS, MISSED_HEARTBEATS, SCHEDULE_REPORTERS, SILENT_AFTER_NS, WATCHED

INCOMPLETE = "grids, index and schedule state have not come together yet"
EXPIRED = "the plan time is past the validity of the schedule state, and no newer schedule state has come"


@dataclass(frozen=True)
class MapVerdict:
    """How a robot may use its maps."""

    word: str
    """`current`: use them; `overtaken`: a newer schedule state is here and its grids are on their way, use them but do not enter
    what that state blocks; `hold`: they are late, stand still; `no_map`."""
    reason: str | None = None
    """Why there is no map; None with another word."""

    @property
    def may_drive(self) -> bool:
        """True with `current` and `overtaken`."""
        return self.word in ("current", "overtaken")


def newest_schedule_report(reported_ns: dict[str, int], now_ns: int) -> str | None:
    """Which daemon tells when the next schedule state is due, from when each one last reported: a report of another is from before the
    configuration changed. What is later than now was written before the machine was started anew, and does not count."""
    newest: str | None = None
    for daemon in SCHEDULE_REPORTERS:
        at_ns = reported_ns.get(daemon)
        if at_ns is not None and at_ns <= now_ns and (newest is None or reported_ns[newest] <= at_ns):
            newest = daemon
    return newest


class MapRule:
    """Heartbeats, schedule states, indices and times go in, a verdict comes out."""

    def __init__(self) -> None:
        self._heard: dict[str, int] = {}
        self._is_following = False
        self._state: tuple[int, int] | None = None
        self._newer: tuple[int, int] | None = None
        self._index: tuple[int, int] | None = None
        self._has_grids = False
        self._drawn: int | None = None
        self._unmatched_since: int | None = None
        self._due_ms: int | None = None
        self._distrust: str | None = None

    def joined(self, now_ns: int) -> None:
        """A generation of the bus was joined: samples come again, heartbeats count from now."""
        self._heard = dict.fromkeys(WATCHED, now_ns)
        self._state = self._index = None
        self._match_newest(now_ns)

    def insert_heartbeat(self, at_ns: int, daemon: str) -> None:
        """A daemon was heard at this time. What follows a server publishes the maps in the place of all watched ones; others than
        these count for nothing."""
        self._is_following = self._is_following or daemon == FOLLOWER
        for watched, heard in self._heard.items():
            if daemon in (watched, FOLLOWER):
                self._heard[watched] = max(heard, at_ns)

    def insert_schedule_state(self, now_ns: int, content_hash: int, site_hash: int) -> None:
        """A schedule state has come. One that says the same as the last one is not newer."""
        self._state = (content_hash, site_hash)
        if self._newer is None or self._newer[0] != content_hash:
            self._newer = (content_hash, now_ns)
        self._match_newest(now_ns)

    def insert_index(self, now_ns: int, schedule_state_hash: int, site_hash: int, has_grids: bool) -> None:
        """An index of grids has come; `has_grids` is True if the grids that it names are there."""
        self._index, self._has_grids = (schedule_state_hash, site_hash), has_grids
        self._match_newest(now_ns)

    def set_grids(self, now_ns: int, has_grids: bool) -> None:
        """The grids that the newest index names are there, or one of them is not."""
        if self._index is not None:
            self._has_grids = has_grids
        self._match_newest(now_ns)

    def set_next_state(self, due_ms: int | None, distrust: str | None) -> None:
        """When the next schedule state is due, in milliseconds since 1970 in UTC, and why nothing tells it."""
        self._due_ms, self._distrust = due_ms, distrust

    def verdict(self, now_ns: int, utc_ms: int) -> MapVerdict:
        """What a consumer may do; `utc_ms` is the machine's clock, in milliseconds since 1970 in UTC."""
        for daemon, heard in self._heard.items():
            if now_ns - heard >= SILENT_AFTER_NS:
                silent = FOLLOWER if self._is_following else daemon
                return MapVerdict("no_map", f"{silent} has missed {MISSED_HEARTBEATS} heartbeats")
        if self._distrust is not None:
            return MapVerdict("no_map", self._distrust)
        if self._due_ms is not None and (utc_ms - self._due_ms) * 1_000_000 >= FRESH_TOLERANCE_NS:
            return MapVerdict("no_map", f"{EXPIRED}: the next one was due at {_utc_text(self._due_ms)}")
        if self._state is None or self._drawn is None:
            return MapVerdict("no_map", INCOMPLETE)
        if self._unmatched_since is None:
            return MapVerdict("current")
        late_ns = self._unmatched_since + FRESH_TOLERANCE_NS
        if self._newer is not None and self._newer[0] != self._drawn:
            late_ns = min(late_ns, self._newer[1] + GRIDS_LATE_NS)
        return MapVerdict("overtaken" if now_ns < late_ns else "hold")

    def _match_newest(self, now_ns: int) -> None:
        if self._state is not None and self._state == self._index and self._has_grids:
            self._drawn, self._unmatched_since = self._state[0], None
        elif self._unmatched_since is None:
            self._unmatched_since = now_ns


def _utc_text(utc_ms: int) -> str:
    due = datetime.datetime(1970, 1, 1) + datetime.timedelta(milliseconds=utc_ms)
    fraction = f".{utc_ms % 1000:03}".rstrip("0") if utc_ms % 1000 else ""
    return f"{due:%Y-%m-%dT%H:%M:%S}{fraction}Z"
