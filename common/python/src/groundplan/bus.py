"""The bus of the daemons: joining it, and subscribers of its latched topics."""

from __future__ import annotations

import ctypes
import fcntl
import pathlib
import re
import threading
import time
import weakref
from dataclasses import dataclass
from typing import IO, Any

import iceoryx2 as iox2
import numpy as np

from . import _layouts
from .archive import Bytes, Header

LIBRARY = "iceoryx2-0.10.0"
DEFAULT_ROOT = pathlib.Path("/run/groundplan")
DEFAULT_PREFIX = "gp010_"
# Wakes the producer, which then delivers its last sample.
LATE_JOINER = 1
PRODUCERS = {
    "site": "ifc-ingest",
    "tasks": "schedule-eval",
    "schedule-state": "schedule-eval",
    "grid": "rasterize",
    "grids": "rasterize",
    "mission-plan": "waypoint-gen",
    "alignment": "slam-align",
    "deviations": "slam-align",
}
# What each robot of a site with named ones has of its own; the rest is the site's.
OF_ROBOT = frozenset({"rasterize", "waypoint-gen", "slam-align"})
ROBOT_NAME = re.compile(r"[a-z0-9-]{1,32}")
# Places of every topic and event service that are kept for daemons and commands, as in common/bus/src/limits.rs.
KEPT_PLACES = 12
HEADER_BYTES = np.dtype(_layouts.SAMPLE_HEADER).itemsize


class BusGone(ConnectionError):
    """There is no bus here, or not one of this version."""


class BusFull(ConnectionError):
    """A topic has as many readers as programs like this one can be: the other places are kept for daemons and commands."""


class _Block(ctypes.Structure):
    """Payloads are made of these."""

    _fields_ = [("bytes", ctypes.c_uint8 * 64)]

    @staticmethod
    def type_name() -> str:
        return "groundplan.block64.v1"


class _Header(ctypes.Structure):
    """User header of samples; `Header.of` reads it."""

    _fields_ = [("words", ctypes.c_uint64 * (HEADER_BYTES // 8))]

    @staticmethod
    def type_name() -> str:
        return "groundplan.sample_header.v1"


@dataclass(frozen=True)
class Sample:
    """The newest sample of a topic."""

    header: Header
    memory: Bytes
    """Its archive in shared memory, for reading. The sample is released when this and all views of it are gone."""


class _Events:
    """What a producer wakes this program with: one listener, for all subscribers of its topics and from any thread."""

    def __init__(self, node: Any, name: str) -> None:
        try:
            service = node.service_builder(iox2.ServiceName.new(name)).event().open()
            self._listener = service.listener_builder().create()
            self._notifier = service.notifier_builder().create()
        except (iox2.EventOpenError, iox2.ListenerCreateError, iox2.NotifierCreateError) as error:
            raise _refusal(name, error) from error
        _leave_kept_places(name, service.dynamic_config.number_of_listeners, service.static_config.max_listeners)
        self._woken = threading.Condition()
        self._is_waited_on = False
        self._n_wakes = 0

    def announce_late_joiner(self) -> None:
        """Wakes the producer, which then delivers its last samples."""
        self._notifier.notify_with_custom_event_id(iox2.EventId.new(LATE_JOINER))

    def wait(self, seconds: float) -> None:
        """Waits until the producer wakes, at most so long: one thread for all that wait."""
        with self._woken:
            if self._is_waited_on:
                n_wakes = self._n_wakes
                self._woken.wait_for(lambda: self._n_wakes != n_wakes, seconds)
                return
            self._is_waited_on = True
        try:
            self._listener.timed_wait(iox2.Duration.from_millis(max(1, int(seconds * 1000))))
        finally:
            with self._woken:
                self._is_waited_on = False
                self._n_wakes += 1
                self._woken.notify_all()


def _refusal(what: str, error: Exception) -> ConnectionError:
    """What an error of the bus library means."""
    if "Exceeds" in str(error):
        return BusFull(f"{what} of the bus has as many participants as it can have: stop one of the programs that read it")
    if "DoesNotExist" in str(error):
        return BusGone(f"the bus has no {what}: of a site with named robots say which, as in Bus(robot=\"lift\"); see `groundplan status`")
    return BusGone(f"{what} of the bus cannot be opened ({error}); see `groundplan status`")


def _leave_kept_places(what: str, taken: int, most: int) -> None:
    """Raises BusFull if this program took one of the places that are kept."""
    if taken > most - KEPT_PLACES:
        raise BusFull(
            f"{what} of the bus has {taken - 1} participants, and the other {KEPT_PLACES} places are kept for daemons and commands: "
            "stop one of the programs that read it"
        )


class Bus:
    """Membership in the bus of running daemons, for as long as it is open."""

    def __init__(
        self, root: str | pathlib.Path = DEFAULT_ROOT, prefix: str = DEFAULT_PREFIX, robot: str | None = None
    ) -> None:
        """`root` and `prefix` are those of `[bus]` in site.toml. `robot` is the name of the robot whose maps are meant, on a site
        with `[[robots]]`; what is the site's is that of all.

        Raises BusGone if there is no bus, or one of another version of groundplan or iceoryx2; ValueError for what is no name.
        """
        if robot is not None and ROBOT_NAME.fullmatch(robot) is None:
            raise ValueError(f"{robot!r} is no name of a robot: 1 to 32 characters of a-z, 0-9 and -")
        self.robot = robot
        """The robot whose maps are meant; None for one without a name."""
        self._root, self._prefix = pathlib.Path(root), prefix
        self._lock: IO[str] | None = None
        self.generation = 0
        """Counts how often the bus was created."""
        self.node: Any = None
        self._events: dict[str, _Events] = {}
        iox2.set_log_level(iox2.LogLevel.Error)
        self.join()

    def __enter__(self) -> Bus:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leaves the bus."""
        self._events = {}
        self.node = None
        if self._lock is not None:
            self._lock.close()
            self._lock = None

    def current_generation(self) -> int:
        """Generation of the bus that there is now.

        Raises BusGone if there is none of this version.
        """
        path = self._root / "generation"
        try:
            lines = path.read_text().splitlines()
        except OSError as error:
            raise BusGone(f"no bus in {self._root}: {error.strerror}; start the site (groundplan up)") from error
        said = dict(line.split("=", 1) for line in lines if "=" in line)
        if said.get("library") != LIBRARY or said.get("layout") != str(_layouts.LAYOUT_VERSION):
            raise BusGone(
                f"the bus in {self._root} is of {said.get('library')}, layout {said.get('layout')}; this package reads "
                f"{LIBRARY}, layout {_layouts.LAYOUT_VERSION}"
            )
        return int(said["generation"])

    def join(self) -> None:
        """Joins the bus that there is now, if it is another one. Subscribers do it by themselves."""
        generation = self.current_generation()
        if generation == self.generation:
            return
        self.close()
        # Files of a generation stay while a member holds its lock.
        self._lock = open(self._root / f"{generation}.lock", "a")
        fcntl.flock(self._lock, fcntl.LOCK_SH)
        config = iox2.config.default()
        config.global_cfg.prefix = iox2.FileName.new(f"{self._prefix}{generation}_")
        config.global_cfg.root_path = iox2.Path.new(str(self._root / str(generation)))
        builder = iox2.NodeBuilder.new().config(config)
        signals = iox2.SignalHandlingMode.HandleTerminationRequests
        self.node = builder.signal_handling_mode(signals).create(iox2.ServiceType.Ipc)
        self.generation = generation

    @property
    def root(self) -> pathlib.Path:
        """The folder of the bus."""
        return self._root

    def service_of(self, producer: str, name: str) -> str:
        """The name of a service of a daemon on the bus: below the robot whose it is, if that has a name."""
        return f"robots/{self.robot}/{name}" if self.robot is not None and producer in OF_ROBOT else name

    def events(self, producer: str) -> _Events:
        """What a producer wakes this program with, opened once.

        Raises BusFull if there is no place left for it.
        """
        if producer not in self._events:
            self._events[producer] = _Events(self.node, self.service_of(producer, f"event/{producer}"))
        return self._events[producer]


class Subscriber:
    """Reads a latched topic: the last sample at once, then every newer one that it is in time for."""

    def __init__(self, bus: Bus, topic: str) -> None:
        """`topic`: `site`, `tasks`, `schedule-state`, `grid/00` .., `grids`, `mission-plan`, `alignment` or `deviations`.

        Raises KeyError for another name, BusFull if there is no place left for it.
        """
        self.topic = topic
        self._kind = topic.split("/", 1)[0]
        self._producer = PRODUCERS[self._kind]
        self._bus = bus
        self._generation = 0
        self._subscriber: Any = None
        self._events: _Events | None = None
        self._open()

    def _open(self) -> None:
        self._subscriber = self._events = None
        self._bus.join()
        node = self._bus.node
        events = self._bus.events(self._producer)
        name = self._bus.service_of(self._producer, self.topic)
        topic = node.service_builder(iox2.ServiceName.new(name)).publish_subscribe(iox2.Slice[_Block])
        # ctypes has no alignment of 64 bytes, so it is set here.
        try:
            service = topic.user_header(_Header).payload_alignment(iox2.Alignment.new(64)).open()
            subscriber = service.subscriber_builder().create()
        except (iox2.PublishSubscribeOpenError, iox2.SubscriberCreateError) as error:
            raise _refusal(name, error) from error
        _leave_kept_places(self.topic, service.dynamic_config.number_of_subscribers, service.static_config.max_subscribers)
        self._subscriber, self._events, self._generation = subscriber, events, self._bus.generation
        events.announce_late_joiner()

    def receive(self) -> Sample | None:
        """The newest sample that was not received yet; None without one.

        Raises LayoutError for a sample that this package does not read, BusGone if the site is down.
        """
        if self._bus.current_generation() != self._generation:
            self._open()
        newest = None
        while True:
            sample = self._subscriber.receive()
            if sample is None:
                break
            if newest is not None:
                newest.delete()
            newest = sample
        return None if newest is None else self._checked(newest)

    def wait(self, timeout_s: float) -> Sample:
        """As `receive`, but waits for a sample.

        Raises TimeoutError without one.
        """
        deadline = time.monotonic() + timeout_s
        while True:
            sample = self.receive()
            if sample is not None:
                return sample
            left = deadline - time.monotonic()
            if left <= 0:
                raise TimeoutError(f"no sample of {self.topic} within {timeout_s} s; see `groundplan status`")
            self.sleep(left)

    def sleep(self, seconds: float) -> None:
        """Sleeps until the producer wakes this subscriber, at most so long, and at most half a second."""
        assert self._events is not None
        self._events.wait(min(seconds, 0.5))

    def _checked(self, sample: Any) -> Sample:
        try:
            words = ctypes.cast(sample.user_header_ptr, ctypes.POINTER(_Header)).contents
            header = Header.of(np.frombuffer(bytes(words), np.uint8), self._kind)
            memory = np.frombuffer(sample.payload().as_memory_view(), np.uint8)
        except BaseException:
            sample.delete()
            raise
        # Views of this array keep it alive, and it keeps the sample: memory that is looked at is not given back.
        weakref.finalize(memory, sample.delete)
        # It is mapped for reading only: writing would end this process.
        memory.flags.writeable = False
        return Sample(header, memory[: header.payload_length])
