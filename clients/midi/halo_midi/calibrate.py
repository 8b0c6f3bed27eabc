"""The strike speeds of one musician, for the velocity curve.

Rule: `curve` is pure; `measured` reads a receiver.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from halo_client import Receiver, waiting
from halo_protocol import UNKNOWN_STRIKE

STRIKES = 20
"""Half of them soft, half hard."""
END = 10
"""A soft end is slower than all but one in ten strikes, the loud one faster."""
NARROWEST_MM_S = 50.0
"""Least distance of both ends, so that noise does not decide the velocity."""


def curve(strikes_mm_s: Sequence[float]) -> tuple[float, float]:
    """Return the speeds of the softest and the loudest note, mm/s."""
    ordered = sorted(strikes_mm_s)
    margin = len(ordered) // END
    soft, loud = ordered[margin], ordered[-1 - margin]
    return soft, max(loud, soft + NARROWEST_MM_S)


def measured(receiver: Receiver, say: Callable[[str], None]) -> tuple[float, float]:
    """Ask for strikes with `say`, and return their curve."""
    say(f"tap {STRIKES} times: {STRIKES // 2} as soft as you ever play, {STRIKES // 2} as hard")
    strikes: list[float] = []
    for frame in receiver.frames(timeout_s=2.0):
        if frame is None:
            say(waiting(receiver.url))
            continue
        for down in frame.downs:
            if down.strike_mm_s != UNKNOWN_STRIKE and len(strikes) < STRIKES:
                strikes.append(down.strike_mm_s)
                say(f"{len(strikes)} of {STRIKES}: {down.strike_mm_s:.0f} mm/s")
        if len(strikes) == STRIKES:
            break
    if not strikes:
        return 0.0, NARROWEST_MM_S
    return curve(strikes)
