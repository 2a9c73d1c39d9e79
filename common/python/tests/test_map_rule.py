"""The rule by which maps may be used says what that of the daemons' own consumers says."""

from __future__ import annotations

import json
import pathlib
import tempfile
import unittest
from typing import Any

from groundplan import MapRule, board
from groundplan._map_limits import SCHEDULE_REPORTERS
from groundplan.map_rule import newest_schedule_report

TABLE = pathlib.Path(__file__).resolve().parents[2] / "site-view/tests/map_verdicts.json"
BEGAN_NS = 1_000_000_000_000


def tell(rule: MapRule, now_ns: int, event: list[Any]) -> None:
    word, *told = event
    if word == "joined":
        rule.joined(now_ns)
    elif word == "heartbeat":
        rule.insert_heartbeat(now_ns, *told)
    elif word == "state":
        rule.insert_schedule_state(now_ns, *told)
    elif word == "index":
        rule.insert_index(now_ns, *told)
    elif word == "grids":
        rule.set_grids(now_ns, *told)
    elif word == "due":
        rule.set_next_state(told[0], None)
    elif word == "distrust":
        rule.set_next_state(None, told[0])
    elif word == "stands":
        rule.set_next_state(None, None)
    elif word != "wait":
        raise ValueError(word)


class Rule(unittest.TestCase):
    def test_every_case_of_the_table_has_its_verdict(self) -> None:
        table = json.loads(TABLE.read_text())
        self.assertGreater(len(table["cases"]), 40)
        for name, steps in table["cases"].items():
            rule = MapRule()
            for ms, event, word, reason in steps:
                now_ns = BEGAN_NS + ms * 1_000_000
                tell(rule, now_ns, event)
                said = rule.verdict(now_ns, ms)
                self.assertEqual((said.word, said.reason), (word, reason), f"{name}, after {event} at {ms} ms")
                self.assertEqual(said.may_drive, word in ("current", "overtaken"))


    def test_the_newest_report_tells_when_the_next_schedule_state_is_due(self) -> None:
        table = json.loads(TABLE.read_text())["schedule_reports"]
        self.assertGreater(len(table), 20)
        for *reported_ms, reporter in table:
            reported = zip(SCHEDULE_REPORTERS, reported_ms)
            reported_ns = {daemon: ms * 1_000_000 for daemon, ms in reported if ms is not None}
            self.assertEqual(newest_schedule_report(reported_ns, 100_000_000), reporter, reported_ms)


class Board(unittest.TestCase):
    def test_a_report_tells_when_its_daemon_was_heard_and_a_damaged_one_nothing(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder)
            self.assertIsNone(board.report(root, "rasterize"))
            (root / "board").mkdir()
            file = root / "board/rasterize.json"
            for text in ["{", "[]", "{}", '{"stamp_ns": null}', json.dumps({"stamp_ns": board.monotonic_ns() + 10**12})]:
                file.write_text(text)
                self.assertIsNone(board.report(root, "rasterize"), text)
            file.write_text('{"stamp_ns": 5, "facts": {"next_update_ms": 7}}')
            self.assertEqual(board.report(root, "rasterize"), board.Report(5, {"next_update_ms": 7}))


if __name__ == "__main__":
    unittest.main()
