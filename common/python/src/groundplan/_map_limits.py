"""Limits of the rule by which maps may be used.

Written by a test of common/site-view with UPDATE_GOLDEN=1 from those there: not to be edited.
"""

from __future__ import annotations

WATCHED: tuple[str, ...] = ("schedule-eval", "rasterize")
"""Daemons without which maps grow old unnoticed."""
FOLLOWER: str = "site-follow"
"""Publishes the maps in the place of these on a robot that follows a server."""
SCHEDULE_REPORTERS: tuple[str, ...] = ("schedule-eval", "site-follow")
"""Daemons that report when the next schedule state is due."""
MISSED_HEARTBEATS: int = 3
"""A daemon that has missed so many is silent."""
SILENT_AFTER_NS: int = 3000000000
"""Age of the last heartbeat of a daemon that is silent."""
GRIDS_LATE_NS: int = 1000000000
"""After this time without its grids a newer schedule state stops the robot."""
FRESH_TOLERANCE_NS: int = 3000000000
"""After this time maps of which something else is unknown are not used."""
