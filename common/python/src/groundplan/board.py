"""The status board: what the daemons report about themselves, in files beside the bus."""

from __future__ import annotations

import json
import pathlib
import time
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Report:
    """The last report of a daemon."""

    stamp_ns: int
    """When it was heard, in monotonic time since the machine's boot."""
    facts: dict[str, Any]
    """Facts of its service."""


def monotonic_ns() -> int:
    """Monotonic time since the machine's boot, as the daemons have it."""
    return time.clock_gettime_ns(time.CLOCK_MONOTONIC)


def report(bus_root: pathlib.Path, daemon: str, robot: str | None = None) -> Report | None:
    """The last report of a daemon, of a robot with a name if it is one of a robot, also of one that is dead or hangs; None if there
    is none that can be read."""
    folder = bus_root / "board"
    daemon = daemon if robot is None else f"{daemon}@{robot}"
    try:
        said = json.loads((folder / f"{daemon}.json").read_text())
        stamp_ns, facts = int(said["stamp_ns"]), said.get("facts") or {}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    try:
        # It is touched also where the file system has no room for a report.
        touched_ns = (folder / f"{daemon}.lock").stat().st_mtime_ns
    except OSError:
        touched_ns = 0
    now_ns = monotonic_ns()
    if touched_ns <= now_ns:
        stamp_ns = max(stamp_ns, touched_ns)
    # One of the future was written before the machine was started anew.
    return Report(stamp_ns, facts) if stamp_ns <= now_ns and isinstance(facts, dict) else None
