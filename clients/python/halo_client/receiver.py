"""Turns the datagrams of an input into events.

Rule: only this module reads a clock. `halo_protocol` decodes; an `Input` brings datagrams. Bad
datagrams are counted, logged once per sender, and never raised.
"""

from __future__ import annotations

import logging
import math
import re
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol, Self, overload, runtime_checkable

from halo_client.errors import EndOfStream
from halo_client.follow import FIRST, Follow, Follower
from halo_client.known_services import KnownServices
from halo_client.touches import Began, Callbacks, Ended, Moved
from halo_protocol import (
    VERSION,
    Assembler,
    Collision,
    Event,
    Lost,
    ProtocolError,
    Report,
    TouchFrame,
)

_LOG = logging.getLogger("halo_client")
_TICK_S = 0.25
"""How often lost services are detected while nothing arrives."""
_SENDERS = 256
"""Senders of bad datagrams that are logged; forged addresses cannot fill the log."""
_MAJOR = int(VERSION.partition(".")[0])
_ADDRESS = re.compile(rb"/halo/(\d{1,4})/")


class Input(Protocol):
    """A source of datagrams."""

    url: str

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        """The next datagram and its sender, or None after the timeout.

        `EndOfStream` when the input has ended for good.
        """

    def close(self) -> None:
        """Close the input. May be called twice."""


@runtime_checkable
class NodeWatch(Protocol):
    """An `Input` that knows which nodes have left."""

    left: frozenset[str]
    """Nodes that were there and are not; their touches end after half a second of silence."""


@dataclass(slots=True)
class Losses:
    """Losses and errors since the receiver was opened."""

    missed: int = 0
    """Frames that were sent (by the frame counter) and never arrived."""
    incomplete: int = 0
    """Frames with a lost part."""
    dropped: int = 0
    """Parts that arrived late or twice."""
    bad: int = 0
    """Datagrams that could not be decoded."""
    foreign: int = 0
    """Datagrams of another major version of the protocol."""
    collisions: int = 0
    """Pairs of running services with the same node name."""


class Receiver:
    """Frames and reports from one source. A context manager; it belongs to one thread."""

    def __init__(self, source: Input, follow: Follow = FIRST) -> None:
        self._source = source
        self._watch = source if isinstance(source, NodeWatch) else None
        self._follower = Follower(follow)
        self._assembler = Assembler()
        self._warned: set[str] = set()
        self._callbacks = Callbacks()
        self.losses = Losses()
        self.ended = False
        """Whether a recorded stream is over; its open touches were ended."""
        self.services = KnownServices()
        """The latest scene, homography, pose and health of each surface."""

    @property
    def url(self) -> str:
        """The source of this receiver."""
        return self._source.url

    def poll(self, timeout_s: float) -> list[Event]:
        """The events of the next datagram, or none after the timeout.

        Each is a `TouchFrame`, a `Report` (scene, homography, pose, health) or a `Lost`. Call
        it at least a few times a second: it also detects lost services.
        """
        try:
            received = self._source.receive(timeout_s)
        except EndOfStream:
            received, self.ended = None, True
        if self._watch is not None:
            self._assembler.left = self._watch.left
        now_s = math.inf if self.ended else time.monotonic()
        events = self._read(*received, now_s) if received else self._assembler.expire(now_s)
        for event in events:
            self._remember(event)
        self.losses.dropped = self._assembler.dropped
        followed = [event for each in events for event in self._followed(each)]
        self._callbacks.call(followed)
        return followed

    def on_down(self, function: Callable[[Began], object]) -> None:
        """Call a function with each touch that begins, during `poll`, `frames` or `run`."""
        self._callbacks.down.append(function)

    def on_move(self, function: Callable[[Moved], object]) -> None:
        """Call a function in each frame with each touch that goes on."""
        self._callbacks.move.append(function)

    def on_up(self, function: Callable[[Ended], object]) -> None:
        """Call a function with each touch that ends, also if its service is lost."""
        self._callbacks.up.append(function)

    def run(self, seconds: float = math.inf) -> None:
        """Call the functions until the time is over or a recorded stream ends."""
        until_s = time.monotonic() + seconds
        while not self.ended and (left_s := until_s - time.monotonic()) > 0:
            self.poll(min(left_s, _TICK_S))

    @overload
    def frames(self, timeout_s: None = None) -> Iterator[TouchFrame]: ...
    @overload
    def frames(self, timeout_s: float) -> Iterator[TouchFrame | None]: ...
    def frames(self, timeout_s: float | None = None) -> Iterator[TouchFrame | None]:
        """Yield each frame when it arrives; with a timeout, None after each wait without one.

        It ends only with a recorded stream.
        """
        quiet_since_s = time.monotonic()
        while not self.ended:
            frames = [
                e for e in self.poll(self._poll_timeout(timeout_s)) if isinstance(e, TouchFrame)
            ]
            yield from frames
            now_s = time.monotonic()
            if frames:
                quiet_since_s = now_s
            elif timeout_s is not None and now_s - quiet_since_s >= timeout_s:
                quiet_since_s = now_s
                yield None

    def close(self) -> None:
        """Close the source. May be called twice."""
        self._source.close()

    @staticmethod
    def _poll_timeout(timeout_s: float | None) -> float:
        return _TICK_S if timeout_s is None else min(timeout_s, _TICK_S)

    @property
    def following(self) -> tuple[str, str, str] | None:
        """Node, surface and session that are followed now; None before the first frame."""
        return self._follower.current

    def _followed(self, event: Event) -> list[Event]:
        """The event, if it is of the service that is followed, and what it ends."""
        ended: list[Event] = []
        if isinstance(event, TouchFrame) and (old := self._follower.replaces(event)):
            ended = self._assembler.close(*old)
            for each in ended:
                self._remember(each)
            self._follower.retire(old)
        others = len(self._follower.ignored)
        accepted = self._follower.accepts(event)
        if len(self._follower.ignored) > others and isinstance(event, TouchFrame):
            self._warn_of_another(event)
        return [*ended, event] if accepted else ended

    def _warn_of_another(self, frame: TouchFrame) -> None:
        _LOG.warning(
            "%s also receives '%s' on surface '%s', which is ignored; name the one to follow with "
            "?node=%s&surface=%s, or receive all with ?follow=all",
            self.url,
            frame.node,
            frame.surface,
            frame.node,
            frame.surface,
        )

    def _read(self, datagram: bytes, sender: str, now_s: float) -> list[Event]:
        try:
            events = self._assembler.receive_data(datagram, now_s)
            self._count_other_major(datagram)
            return events
        except ProtocolError as error:
            self.losses.bad += 1
            if sender not in self._warned and len(self._warned) < _SENDERS:
                self._warned.add(sender)
                _LOG.warning("skipping bad datagrams from %s: %s", sender, error)
            return self._assembler.expire(now_s)

    def _count_other_major(self, datagram: bytes) -> None:
        found = _ADDRESS.search(datagram)
        if found is None or int(found[1]) == _MAJOR:
            return
        self.losses.foreign += 1
        if self.losses.foreign == 1:
            _LOG.warning(
                "a service at %s speaks protocol %d, and this program speaks %d: "
                "install matching versions of both",
                self.url,
                int(found[1]),
                _MAJOR,
            )

    def _remember(self, event: Event) -> None:
        if isinstance(event, Collision):
            self.losses.collisions += 1
            _LOG.warning(
                "two running services are called '%s' (sessions %s and %s): give one of them "
                "another name with `halo serve --node`",
                event.node,
                *event.sessions,
            )
        elif isinstance(event, TouchFrame):
            self.losses.missed += event.missed
            self.losses.incomplete += not event.complete
        elif isinstance(event, Lost):
            self.services.forget(event)
        elif isinstance(event, Report) and not self._follower.is_clone(event):
            self.services.update(event)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
