"""The main loop of a client: each frame at once, a picture 60 times a second.

Rule: one thread. Between pictures it waits in the receiver, so that a frame waits no longer than
the drawing of one picture.
"""

from __future__ import annotations

import math
import signal
import sys
import time
from collections.abc import Callable, Iterator

from halo_client import Receiver, Silence
from halo_protocol import Event, TouchFrame
from halo_window.stage import Stage

PICTURES_HZ = 60.0
AT_ONCE = 32
"""Most datagrams read before the next picture, so that a flood cannot stop the pictures."""
LINGER_S = 2.0
"""How long picture and sound go on after the end of a recorded stream."""


def listen(
    name: str,
    receiver: Receiver,
    stage: Stage | None,
    on_frame: Callable[[TouchFrame, float], None],
    draw: Callable[[float, str], None],
) -> None:
    """Run until the window is closed or a recorded stream is over.

    `on_frame(frame, now_s)` gets each frame; `draw(now_s, note)` draws each picture, where `note`
    is empty or says that no frames come. Ctrl-C and SIGTERM raise `KeyboardInterrupt`;
    raises `ClientError` for a broken recorded stream.
    """
    # Started in a shell's background, a program inherits that Ctrl-C is ignored.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    due_s = time.monotonic()
    silence = Silence(receiver.url, due_s)
    end_s = math.inf
    while (stage is None or stage.open) and time.monotonic() < end_s:
        events = []
        for event in _events(receiver, due_s):
            events.append(event)
            if isinstance(event, TouchFrame):
                on_frame(event, time.monotonic())
        now_s = time.monotonic()
        news = silence.notice(events, now_s)
        if news and not receiver.ended:
            print(f"{name}: {news}", file=sys.stderr, flush=True)
        if receiver.ended:
            end_s = min(end_s, now_s + LINGER_S)
        draw(now_s, "waiting for frames ..." if silence.waiting and not receiver.ended else "")
        due_s = max(due_s + 1 / PICTURES_HZ, now_s)


def _events(receiver: Receiver, until_s: float) -> Iterator[Event]:
    """Yield events until a time; those that already wait, even if the time has passed."""
    for _ in range(AT_ONCE):
        left_s = max(0.0, until_s - time.monotonic())
        if receiver.ended:
            time.sleep(left_s)
            return
        events = receiver.poll(left_s)
        yield from events
        if not events and time.monotonic() >= until_s:
            return
