"""The frame counter.

Rule: all modular arithmetic is here. No clock is read: Unix time is an argument.
A counter seeded from time in steps of 10 ms stays ahead of whatever was sent before the
restart as long as the source makes at most 100 frames a second.
"""

MODULUS = 2**31
"""An OSC int is a signed 32-bit number; the counter uses its non-negative half."""
WINDOW = 2**30
"""Half of it: a number less than this ahead is newer, any other is older."""
STEP_US = 10_000


def first_frame(unix_time_us: int) -> int:
    """The number to start a live session with."""
    return unix_time_us // STEP_US % MODULUS


def next_frame(frame: int) -> int:
    """The number after `frame`."""
    return (frame + 1) % MODULUS


def ahead(a: int, b: int) -> int:
    """How many frames `a` is ahead of `b`, 0 to 2^31 - 1."""
    return (a - b) % MODULUS


def is_newer(a: int, b: int) -> bool:
    """Whether `a` was sent after `b`."""
    return 0 < ahead(a, b) < WINDOW
