"""A thread that follows one surface of a node: what bridge and canvas have in common."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from itertools import pairwise

from halo_client import ClientError, Follow, Input, Receiver, Silence, ZenohSource
from halo_client.errors import EndOfStream
from halo_client.receiver import NodeWatch
from halo_client.zenoh_input import ZenohInput
from halo_protocol import ANY, Event, Lost, TouchFrame
from halo_service.errors import UserError
from halo_service.runtime.error_log import ErrorLog

log = logging.getLogger(__name__)

TICK_S = 0.1
"""How often lost nodes, new clients and the end are noticed while nothing arrives."""


class Following:
    """Receives until it is closed; the end of a node's touches is then reported, too."""

    def __init__(
        self,
        source: Input,
        follow: Follow,
        handle: Callable[[list[Event]], None],
        command: str,
        read: Callable[[bytes], None] = lambda datagram: None,
    ) -> None:
        """`handle`: gets the events of each turn, also none, in this thread; `command`: for the
        log; `read`: gets each datagram before the receiver has it."""
        self._input = _Tap(source, read)
        self.receiver = Receiver(self._input, follow)
        self._handle = handle
        self._command = command
        self._errors = ErrorLog()
        named = [each for each in (follow.node, follow.surface) if each != ANY]
        self.name = "/".join(named) or "any node"
        """Of node and surface, as far as it is clear which they are."""
        self._thread = threading.Thread(
            target=self._run, name=f"{command} {self.name}", daemon=True
        )

    def start(self) -> None:
        """Begin to receive."""
        self._thread.start()

    def close(self) -> None:
        """End, handle what the end ends, and close."""
        self._input.ended.set()
        self._thread.join()
        self.receiver.close()

    @property
    def losses(self) -> str:
        """What was lost so far, apart from whole frames, as part of a sentence."""
        losses = self.receiver.losses
        return (
            f"{losses.incomplete} incomplete, {losses.dropped} late or twice, "
            f"{losses.bad} bad datagrams"
        )

    def _run(self) -> None:
        silence = Silence(f"{self.receiver.url} of {self.name}", time.monotonic())
        while not self.receiver.ended:
            with self._errors.guard(f"{self._command} {self.name}"):
                events = self.receiver.poll(TICK_S)
                self._handle(events)
                if self.receiver.following is not None:
                    self.name = "/".join(self.receiver.following[:2])
                said = silence.notice(events, time.monotonic())
                if said and not self.receiver.ended:
                    log.info("%s", said)


def opened(source: ZenohSource, follow: Follow, command: str) -> ZenohInput:
    """Subscribe to one surface; `command`: for the error. Raises `UserError`."""
    try:
        return ZenohInput(replace(source, follow=follow))
    except ClientError as error:
        raise UserError(f"{command}: {error}") from error


def received_events(events: Iterable[Event]) -> Iterator[Event]:
    """Yield the events of a turn without the frame that a receiver adds where a node is lost.

    It has no pointers, and the time of the last frame that was sent.
    """
    for event, following in pairwise([*events, None]):
        if event is not None and not (
            isinstance(event, TouchFrame) and isinstance(following, Lost)
        ):
            yield event


class _Tap:
    """An input. Each datagram is read before the receiver has it; `ended` ends it for good."""

    def __init__(self, source: Input, read: Callable[[bytes], None]) -> None:
        self._source = source
        self._read = read
        self.url = source.url
        self.ended = threading.Event()

    @property
    def left(self) -> frozenset[str]:
        """As of the source; none where it does not know."""
        return self._source.left if isinstance(self._source, NodeWatch) else frozenset()

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        if self.ended.is_set():
            raise EndOfStream
        received = self._source.receive(timeout_s)
        if received is not None:
            self._read(received[0])
        return received

    def close(self) -> None:
        self._source.close()
