"""Headers and archives: what they must begin with, and their sections as arrays in place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from . import _layouts

Bytes = npt.NDArray[np.uint8]


class LayoutError(ValueError):
    """Bytes that are no archive of the wanted kind and of this layout version."""


def record(layout: Any) -> np.dtype[Any]:
    """The type of a record; its fields lie without room between them."""
    kind: np.dtype[Any] = np.dtype(layout)
    return kind


@dataclass(frozen=True)
class Header:
    """What travels beside a sample."""

    epoch: int
    """Counts the samples of a topic; never falls."""
    stamp_ns: int
    """Monotonic time of publication, of this machine's boot."""
    payload_length: int
    """Bytes of the archive."""
    content_hash: int
    """Hash of the archive's content."""
    frame_epoch: int
    """Counts the changes of the map frame."""
    site_hash: int
    """Content hash of the site that it was made from; 0 for none."""
    schedule_state_hash: int
    """Content hash of the schedule state that it was made from; 0 for none."""

    @staticmethod
    def of(bytes_: Bytes, topic_kind: str) -> Header:
        """Checks and reads a header.

        Raises LayoutError for another layout version or another kind of archive.
        """
        fields = bytes_.view(record(_layouts.SAMPLE_HEADER))[0]
        _check("the sample", fields, _layouts.SAMPLE_MAGIC, topic_kind)
        return Header(
            epoch=int(fields["epoch"]),
            stamp_ns=int(fields["stamp_ns"]),
            payload_length=int(fields["payload_length"]),
            content_hash=int(fields["content_hash"]),
            frame_epoch=int(fields["frame_epoch"]),
            site_hash=int(fields["inputs"]["site"]),
            schedule_state_hash=int(fields["inputs"]["schedule_state"]),
        )


class Archive:
    """Sections of an archive by name, read in place.

    Preamble, lengths and bounds are checked; the hash over the content is taken on trust, as it was written by a daemon.
    """

    def __init__(self, memory: Bytes, kind: str, sections: dict[str, tuple[int, Any]]) -> None:
        preamble_type, entry_type = record(_layouts.PREAMBLE), record(_layouts.SECTION_ENTRY)
        if len(memory) < preamble_type.itemsize:
            raise LayoutError(f"the archive is cut off: {len(memory)} bytes")
        preamble = memory[: preamble_type.itemsize].view(preamble_type)[0]
        _check("the archive", preamble, _layouts.ARCHIVE_MAGIC, kind)
        table_end = preamble_type.itemsize + int(preamble["n_sections"]) * entry_type.itemsize
        if not table_end <= int(preamble["length"]) <= len(memory):
            raise LayoutError(f"the archive is cut off: {len(memory)} bytes of {preamble['length']}")
        self.content_hash = int(preamble["content_hash"])
        self._memory = memory[: int(preamble["length"])]
        table = self._memory[preamble_type.itemsize : table_end].view(entry_type)
        self._entries = {int(entry["id"]): entry for entry in table}
        self._sections = sections

    def section(self, name: str) -> npt.NDArray[Any]:
        """Records of a section.

        Raises LayoutError if it is missing, out of bounds or of other records.
        """
        number, layout = self._sections[name]
        entry = self._entries.get(number)
        if entry is None:
            raise LayoutError(f"the archive has no section {name}")
        kind = record(layout)
        start, length = int(entry["offset"]), int(entry["count"]) * kind.itemsize
        if int(entry["record_len"]) != kind.itemsize or start + length > len(self._memory):
            raise LayoutError(f"section {name} of the archive is damaged")
        return self._memory[start : start + length].view(kind)

    def optional_section(self, name: str) -> npt.NDArray[Any] | None:
        """Records of a section that not every archive has; None without it.

        Raises LayoutError if it is out of bounds or of other records.
        """
        return self.section(name) if self._sections[name][0] in self._entries else None

    def head(self) -> Any:
        """The only record of the section `head`."""
        records = self.section("head")
        if len(records) != 1:
            raise LayoutError("the archive has not one head")
        return records[0]


def _check(what: str, fields: Any, magic: int, kind: str) -> None:
    if int(fields["magic"]) != magic:
        raise LayoutError(f"{what} is none of groundplan")
    if int(fields["layout_version"]) != _layouts.LAYOUT_VERSION:
        raise LayoutError(
            f"{what} has layout version {fields['layout_version']}, this package reads {_layouts.LAYOUT_VERSION}: "
            "install the package of the daemons' version"
        )
    if int(fields["kind"]) != _layouts.KINDS[kind]:
        raise LayoutError(f"{what} is of kind {fields['kind']}, not {kind}")
