"""The loop of a guest: a frame is handed on the moment it comes, a picture 60 times a second.

Rule: one thread. While no picture is due it waits in the receiver, so that a frame never waits
for longer than a picture takes to draw.
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
"""Datagrams read before the next picture, so that a flood of them cannot stop the pictures."""
LINGER_S = 2.0
"""What a recorded stream leaves behind is seen and heard for so long."""


def listen(
    name: str,
    receiver: Receiver,
    stage: Stage | None,
    take: Callable[[TouchFrame, float], None],
    draw: Callable[[float, str], None],
) -> None:
    """Run until the window is closed or a recorded stream is over.

    `take(frame, now_s)` gets each frame, `draw(now_s, note)` is called for each picture; the note
    says that nobody plays, or nothing. Ctrl-C and SIGTERM raise `KeyboardInterrupt`;
    `ClientError` where a recorded stream is broken.
    """
    # Started in a shell's background, a program inherits that Ctrl-C is ignored.
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, signal.default_int_handler)
    due_s = time.monotonic()
    silence = Silence(receiver.url, due_s)
    end_s = math.inf
    while (stage is None or stage.open) and time.monotonic() < end_s:
        heard = []
        for event in _events(receiver, due_s):
            heard.append(event)
            if isinstance(event, TouchFrame):
                take(event, time.monotonic())
        now_s = time.monotonic()
        news = silence.notice(heard, now_s)
        if news and not receiver.ended:
            print(f"{name}: {news}", file=sys.stderr, flush=True)
        if receiver.ended:
            end_s = min(end_s, now_s + LINGER_S)
        draw(now_s, "waiting for frames ..." if silence.waiting and not receiver.ended else "")
        due_s = max(due_s + 1 / PICTURES_HZ, now_s)


def _events(receiver: Receiver, until_s: float) -> Iterator[Event]:
    """What comes until a time; what waits already, even if it has passed."""
    for _ in range(AT_ONCE):
        left_s = max(0.0, until_s - time.monotonic())
        if receiver.ended:
            time.sleep(left_s)
            return
        events = receiver.poll(left_s)
        yield from events
        if not events and time.monotonic() >= until_s:
            return
