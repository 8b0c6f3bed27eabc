"""The frame counter.

Rule: all modular arithmetic is here. No clock is read: Unix time is an argument. Every number is
below 2^24, so that clients that have only float32 numbers hold it exactly.
"""

MODULUS = 2**24
"""Counters use 0 to 2^24 - 1: a float32 has a mantissa of 24 bits."""
WINDOW = MODULUS // 2
"""Half of it: a number less than this ahead is newer, any other is older."""
STEP_US = 10_000


def first_frame(unix_time_us: int) -> int:
    """The number to start a live session with: Unix time in steps of 10 ms."""
    return unix_time_us // STEP_US % MODULUS


def next_frame(frame: int) -> int:
    """The number after `frame`."""
    return (frame + 1) % MODULUS


def ahead(a: int, b: int) -> int:
    """How many frames `a` is ahead of `b`, 0 to 2^24 - 1."""
    return (a - b) % MODULUS


def is_newer(a: int, b: int) -> bool:
    """Whether `a` was sent after `b`, within one session."""
    return 0 < ahead(a, b) < WINDOW


def session_ms(time_us: int, start_us: int) -> int:
    """Milliseconds since the start of a session, modulo 2^24 (4 h 39 min)."""
    return (time_us - start_us) // 1000 % MODULUS
