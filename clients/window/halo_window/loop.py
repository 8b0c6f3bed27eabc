"""The main loop of a client: each frame at once, a picture 60 times a second.

Rule: two threads. One receives, the other has the window: some systems stop it while the user
drags the window, and frames must neither wait nor be lost then. The second starts no thread of
its own and ends the first.
"""

from __future__ import annotations

import math
import signal
import sys
import threading
import time
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

from halo_client import Receiver, Silence
from halo_protocol import Event, TouchFrame

if TYPE_CHECKING:
    from halo_window.stage import Stage

PICTURES_HZ = 60.0
POLL_S = 0.1
"""Longest wait for a datagram, so that the thread can end."""
MOST_WAITING = 4096
"""Events that wait for a picture: a minute of a dragged window; then the oldest are lost."""
LINGER_S = 2.0
"""How long picture and sound go on after the end of a recorded stream."""


def listen(
    name: str,
    receiver: Receiver,
    stage: Stage | None,
    on_frame: Callable[[TouchFrame, float], None],
    draw: Callable[[float, str], None],
    *,
    at_once: bool = False,
) -> None:
    """Run until the window is closed or a recorded stream is over.

    `on_frame(frame, now_s)` gets each frame: in the receiving thread if `at_once`, for sound, else
    before the next picture, in the window's thread; `draw(now_s, note)` draws each picture, where
    `note` is empty or says that no frames come. Ctrl-C and SIGTERM raise `KeyboardInterrupt`;
    raises `ClientError` for a broken recorded stream.
    """
    # Started in a shell's background, a program inherits that Ctrl-C is ignored.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    silence = Silence(receiver.url, time.monotonic())
    end_s = math.inf
    with _Reader(receiver, on_frame if at_once else None) as reader:
        while (stage is None or stage.open) and (now_s := time.monotonic()) < end_s:
            events = reader.drained()
            if not at_once:
                for event in events:
                    if isinstance(event, TouchFrame):
                        on_frame(event, now_s)
            news = silence.notice(events, now_s)
            if news and not reader.ended:
                print(f"{name}: {news}", file=sys.stderr, flush=True)
            if reader.ended:
                end_s = min(end_s, now_s + LINGER_S)
            draw(now_s, "waiting for frames ..." if silence.waiting and not reader.ended else "")
            time.sleep(max(now_s + 1 / PICTURES_HZ - time.monotonic(), 0.0))


class _Reader:
    """The receiving thread; a context manager."""

    def __init__(
        self, receiver: Receiver, on_frame: Callable[[TouchFrame, float], None] | None
    ) -> None:
        self._receiver, self._on_frame = receiver, on_frame
        self._events: deque[Event] = deque(maxlen=MOST_WAITING)
        self._stopped = threading.Event()
        self._error: BaseException | None = None
        self.ended = False
        """Whether a recorded stream is over and all its events were returned."""
        self._thread = threading.Thread(target=self._run, name="receiver", daemon=True)

    def drained(self) -> list[Event]:
        """Return what has arrived since the last call. Raises what ended the thread."""
        over = not self._thread.is_alive()
        events = []
        while self._events:
            events.append(self._events.popleft())
        if self._error is not None and not events:
            raise self._error
        self.ended = over and not events
        return events

    def _run(self) -> None:
        try:
            while not self._stopped.is_set() and not self._receiver.ended:
                events = self._receiver.poll(POLL_S)
                for event in events:
                    if self._on_frame is not None and isinstance(event, TouchFrame):
                        self._on_frame(event, time.monotonic())
                self._events.extend(events)
        except Exception as error:  # raised again in the window's thread
            self._error = error

    def __enter__(self) -> _Reader:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stopped.set()
        self._thread.join(2.0)
