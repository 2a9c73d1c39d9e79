"""Archives and sets without daemons: what is refused, and which samples belong together."""

from __future__ import annotations

import unittest
from typing import Any

import numpy as np

from groundplan import Archive, Grid, GridIndex, Header, LayoutError, MissionPlan, ScheduleState, _layouts
from groundplan.site import set_of


def archive(of: str, sections: list[tuple[int, Any]], content_hash: int = 7, **preamble: int) -> Any:
    """Bytes of an archive of records by section number."""
    parts, entries, end = [], [], 64 + 24 * len(sections)
    for number, records in sections:
        start = (end + 63) // 64 * 64
        parts.append(b"\0" * (start - end) + records.tobytes())
        entries.append((number, records.dtype.itemsize, start, len(records)))
        end = start + records.nbytes
    fields = {"magic": _layouts.ARCHIVE_MAGIC, "layout_version": _layouts.LAYOUT_VERSION, "kind": _layouts.KINDS[of],
              "n_sections": len(sections), "length": end, "content_hash": content_hash, **preamble}
    head = np.zeros(1, _layouts.PREAMBLE)
    for name, value in fields.items():
        head[name] = value
    table = np.array(entries, _layouts.SECTION_ENTRY)
    return np.frombuffer(head.tobytes() + table.tobytes() + b"".join(parts), np.uint8)


HEIGHTS = ("elevation", "slope")


def grid(width: int = 3, height: int = 2, n_cells: int = 6, heights: tuple[str, ...] = (), **preamble: int) -> Any:
    head = np.zeros(1, _layouts.GRID_HEAD)
    head["cell_tenths"], head["width"], head["height"], head["first_cell"] = 500, width, height, (-20, 10)
    sections = {name: (number, np.zeros(n_cells, kind)) for name, (number, kind) in _layouts.GRID_SECTIONS.items() if name != "head"}
    sections["planning"][1][:6] = [0, 100, -1, 0, 0, 100]
    sections["elevation"][1][:6] = [-12_345, _layouts.NO_HEIGHT, 0, 1, 20_000, _layouts.NO_HEIGHT]
    sections["slope"][1][:6] = [100, _layouts.NO_SLOPE, 0, 1, 785, _layouts.NO_SLOPE]
    layers = [section for name, section in sections.items() if name not in HEIGHTS or name in heights]
    return archive("grid", [(_layouts.GRID_SECTIONS["head"][0], head), *layers], **preamble)


def state(site_hash: int, content_hash: int) -> ScheduleState:
    head = np.zeros(1, _layouts.SCHEDULE_STATE_HEAD)
    head["site_hash"], head["plan_time_s"], head["valid_until_s"] = site_hash, 86_400, _layouts.NO_TIME
    return ScheduleState(archive("schedule-state", [(_layouts.SCHEDULE_STATE_SECTIONS["head"][0], head)], content_hash))


def index(site_hash: int, state_hash: int, grids: list[int]) -> GridIndex:
    head, slots = np.zeros(1, _layouts.GRIDS_HEAD), np.zeros(len(grids), _layouts.GRID_SLOT)
    head["site_hash"], head["schedule_state_hash"], slots["content_hash"] = site_hash, state_hash, grids
    numbers = {name: number for name, (number, _) in _layouts.GRIDS_SECTIONS.items()}
    name = np.frombuffer(b"default", np.uint8)
    return GridIndex(archive("grids", [(numbers["head"], head), (numbers["slots"], slots), (numbers["robot_name"], name)]))


class Archives(unittest.TestCase):
    def test_a_grid_is_viewed_in_place(self) -> None:
        memory = grid()
        seen = Grid(memory)
        self.assertEqual(seen.planning.tolist(), [[0, 100, -1], [0, 0, 100]])
        self.assertTrue(np.shares_memory(seen.planning, memory))
        self.assertEqual((seen.resolution_m, seen.origin_m), (0.05, (-1.0, 0.5)))
        self.assertEqual((seen.cell_at(-0.97, 0.56), seen.cell_at(-1.01, 0.56), seen.cell_at(-0.84, 0.5)), ((1, 0), None, None))

    def test_heights_are_metres_and_slopes_radians_and_a_level_storey_has_none(self) -> None:
        level = Grid(grid())
        self.assertEqual((level.elevation, level.slope), (None, None))
        memory = grid(heights=HEIGHTS)
        seen = Grid(memory)
        assert seen.elevation is not None and seen.slope is not None
        np.testing.assert_array_equal(seen.elevation, [[-1.2345, np.nan, 0.0], [0.0001, 2.0, np.nan]])
        np.testing.assert_array_equal(seen.slope, [[0.1, np.nan, 0.0], [0.001, 0.785, np.nan]])
        self.assertFalse(np.shares_memory(seen.elevation, memory))
        for one in HEIGHTS:
            with self.assertRaisesRegex(LayoutError, "without"):
                Grid(grid(heights=(one,)))
        with self.assertRaises(LayoutError):
            Grid(grid(n_cells=7, heights=HEIGHTS))

    def test_a_waypoint_on_a_slope_is_turned_by_its_yaw_and_stands_along_the_normal(self) -> None:
        records = np.zeros(2, _layouts.WAYPOINT)
        number_of = {name: number for number, name in _layouts.WAYPOINT_KINDS.items()}
        records["kind"] = number_of["centre"], number_of["scan"]
        records["space"], records["up_in_map"] = (3, _layouts.NONE), [(0, 0, 1), (-0.6, 0, 0.8)]
        records["yaw_rad"], records["sensor_in_map_m"][1] = (1.0, np.pi / 2), (-0.6, 0, 0.8)
        level, sloped = MissionPlan(archive("mission-plan", [(_layouts.MISSION_PLAN_SECTIONS["waypoints"][0], records)])).waypoints
        self.assertEqual((level.kind, level.space, sloped.kind, sloped.space), ("centre", 3, "scan", None))
        self.assertEqual((sloped.sensor_m, sloped.up), ((-0.6, 0.0, 0.8), (-0.6, 0.0, 0.8)))
        np.testing.assert_allclose(level.quaternion, [0, 0, np.sin(0.5), np.cos(0.5)], atol=1e-15)
        x, y, z, w = sloped.quaternion
        # The third and first column of its matrix: the normal, and across the slope ahead.
        np.testing.assert_allclose([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], sloped.up, atol=1e-12)
        np.testing.assert_allclose([1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)], [0, 1, 0], atol=1e-12)

    def test_another_layout_version_is_refused_with_both(self) -> None:
        with self.assertRaisesRegex(LayoutError, f"version 99, this package reads {_layouts.LAYOUT_VERSION}"):
            Grid(grid(layout_version=99))
        header = np.zeros(1, _layouts.SAMPLE_HEADER)
        header["magic"], header["layout_version"] = _layouts.SAMPLE_MAGIC, 99
        with self.assertRaisesRegex(LayoutError, "version 99"):
            Header.of(np.frombuffer(header.tobytes(), np.uint8), "grid")

    def test_a_waypoint_of_an_unknown_kind_is_refused(self) -> None:
        records = np.zeros(1, _layouts.WAYPOINT)
        records["kind"] = max(_layouts.WAYPOINT_KINDS) + 1
        with self.assertRaisesRegex(LayoutError, "of the kind"):
            MissionPlan(archive("mission-plan", [(_layouts.MISSION_PLAN_SECTIONS["waypoints"][0], records)]))

    def test_what_is_no_whole_archive_of_the_kind_is_refused(self) -> None:
        for memory in [grid(magic=1), grid(kind=1), grid(length=1 << 40), grid(n_sections=1000), grid()[:40], grid(n_cells=7)]:
            with self.assertRaises(LayoutError):
                Grid(memory)

    def test_a_section_that_is_missing_or_of_other_records_is_refused(self) -> None:
        for sections in [{"head": (99, "u1")}, {"head": (_layouts.GRID_SECTIONS["head"][0], "u1")}]:
            with self.assertRaises(LayoutError):
                Archive(grid(), "grid", sections).section("head")


class Sets(unittest.TestCase):
    def test_only_samples_that_name_each_other_are_a_set(self) -> None:
        cut = Grid(grid(content_hash=5))
        found = set_of(state(1, 2), index(1, 2, [5]), [cut])
        assert found is not None and found.plan_time is not None
        self.assertEqual((found.grids, found.plan_time.day, found.valid_until), ([cut], 2, None))
        for strange in [(state(9, 2), index(1, 2, [5]), [cut]), (state(1, 9), index(1, 2, [5]), [cut]),
                        (state(1, 2), index(1, 2, [6]), [cut]), (state(1, 2), index(1, 2, [5, 5]), [cut]),
                        (state(1, 2), index(1, 2, [5]), [None]), (None, index(1, 2, [5]), [cut])]:
            self.assertIsNone(set_of(*strange))  # type: ignore[arg-type]


if __name__ == "__main__":
    unittest.main()
