"""Events out of an input: the loop between a socket and a picture.

Rule: here alone is a clock read. What bytes mean is `halo_protocol`'s; how they come is an
`Input`'s. Bad datagrams are counted, told once a sender, and never raised.
"""

from __future__ import annotations

import logging
import math
import re
import time
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol, Self, overload

from halo_client.errors import EndOfStream
from halo_client.known import Known
from halo_protocol import VERSION, Assembler, Event, Lost, ProtocolError, TouchFrame

_LOG = logging.getLogger("halo_client")
_TICK_S = 0.25
"""How often silence is looked for while nothing comes."""
_SENDERS = 256
"""Senders of bad datagrams that are told; a forger of addresses cannot fill the log."""
_MAJOR = int(VERSION.partition(".")[0])
_ADDRESS = re.compile(rb"/halo/(\d{1,4})/")


class Input(Protocol):
    """What brings datagrams."""

    url: str

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        """The next datagram and who sent it, or None after so many seconds.

        `EndOfStream` where nothing will ever come again.
        """

    def close(self) -> None:
        """Let go of what was opened. May be called twice."""


@dataclass(slots=True)
class Losses:
    """What did not arrive, or not as it should, since the receiver was opened."""

    missed: int = 0
    """Frames that the counter says were sent, and that never came."""
    incomplete: int = 0
    """Frames of which a part was lost."""
    dropped: int = 0
    """Parts that came late or twice."""
    bad: int = 0
    """Datagrams that were no protocol."""
    foreign: int = 0
    """Datagrams of another major version of the protocol."""


class Receiver:
    """Frames and reports from one source. A context manager; it belongs to one thread."""

    def __init__(self, source: Input) -> None:
        self._source = source
        self._assembler = Assembler()
        self._warned: set[str] = set()
        self.losses = Losses()
        self.ended = False
        """Whether a recorded stream is over; its open touches were ended then."""
        self.known = Known()
        """The latest scene, homography, pose and health of each service's surface."""

    @property
    def url(self) -> str:
        """Where this receiver hears."""
        return self._source.url

    def poll(self, timeout_s: float) -> list[Event]:
        """The events of the next datagram, or none after so many seconds.

        Each is a `TouchFrame`, a `Report` (scene, homography, pose, health) or a `Lost`. Call
        it at least a few times a second: it also finds out who has gone silent.
        """
        try:
            received = self._source.receive(timeout_s)
        except EndOfStream:
            received, self.ended = None, True
        now_s = math.inf if self.ended else time.monotonic()
        events = self._read(*received, now_s) if received else self._assembler.expire(now_s)
        for event in events:
            self._remember(event)
        self.losses.dropped = self._assembler.dropped
        return events

    @overload
    def frames(self, timeout_s: None = None) -> Iterator[TouchFrame]: ...
    @overload
    def frames(self, timeout_s: float) -> Iterator[TouchFrame | None]: ...
    def frames(self, timeout_s: float | None = None) -> Iterator[TouchFrame | None]:
        """Each frame as it is there; with a timeout, None whenever none came for so long.

        It ends with a recorded stream, and never else.
        """
        quiet_since_s = time.monotonic()
        while not self.ended:
            frames = [e for e in self.poll(self._patience(timeout_s)) if isinstance(e, TouchFrame)]
            yield from frames
            now_s = time.monotonic()
            if frames:
                quiet_since_s = now_s
            elif timeout_s is not None and now_s - quiet_since_s >= timeout_s:
                quiet_since_s = now_s
                yield None

    def close(self) -> None:
        """Let go of the source. May be called twice."""
        self._source.close()

    @staticmethod
    def _patience(timeout_s: float | None) -> float:
        return _TICK_S if timeout_s is None else min(timeout_s, _TICK_S)

    def _read(self, datagram: bytes, sender: str, now_s: float) -> list[Event]:
        try:
            events = self._assembler.receive_data(datagram, now_s)
            if not events:
                self._look_for_another_major(datagram)
            return events
        except ProtocolError as error:
            self.losses.bad += 1
            if sender not in self._warned and len(self._warned) < _SENDERS:
                self._warned.add(sender)
                _LOG.warning("skipping bad datagrams from %s: %s", sender, error)
            return self._assembler.expire(now_s)

    def _look_for_another_major(self, datagram: bytes) -> None:
        found = _ADDRESS.search(datagram)
        if found is None or int(found[1]) == _MAJOR:
            return
        self.losses.foreign += 1
        if self.losses.foreign == 1:
            _LOG.warning(
                "a service at %s speaks protocol %d, and this program speaks %d: "
                "use versions of both that belong together",
                self.url,
                int(found[1]),
                _MAJOR,
            )

    def _remember(self, event: Event) -> None:
        if isinstance(event, TouchFrame):
            self.losses.missed += event.missed
            self.losses.incomplete += not event.complete
        elif isinstance(event, Lost):
            self.known.forget(event)
        else:
            self.known.learn(event)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
