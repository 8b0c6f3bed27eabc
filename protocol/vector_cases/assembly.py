"""Sequences of datagrams, for the assembler."""

from __future__ import annotations

from collections.abc import Sequence

from halo_protocol import Down, Pointer, Up, encode, encode_frame
from vector_cases.build import (
    COUNTER,
    TABLE,
    AssemblyCase,
    Step,
    down,
    elements,
    hands,
    header,
    now,
    pointer,
    touching,
    up,
)
from vector_cases.writing import SCENE


def _frame(
    number: int,
    pointers: Sequence[Pointer] = (),
    events: Sequence[Down | Up] = (),
    node: str = "desk",
    session: str = "s1",
    surface: str = TABLE,
) -> list[bytes]:
    """The datagrams of the frame that many after the first, at 25 frames a second."""
    time_us = number * 40_000
    return encode_frame(
        surface,
        header(
            len(pointers),
            node=node,
            session=session,
            frame=(COUNTER + number) % 2**24,
            time_s=1_700_000_000 + time_us // 1_000_000,
            time_frac_us=time_us % 1_000_000,
            session_ms=time_us // 1000 % 2**24,
        ),
        pointers,
        [event for event in events if isinstance(event, Down)],
        [event for event in events if isinstance(event, Up)],
    )


def _steps(*frames: list[bytes]) -> list[Step]:
    """Datagrams as they come, 10 ms apart."""
    datagrams = [datagram for frame in frames for datagram in frame]
    return [Step(i / 100, datagram) for i, datagram in enumerate(datagrams)]


# The tapping finger is in the second part, its down in the first.
_TAPPING = [*hands(12)[:-1], touching(111, 11)]
_SPLIT_1 = _frame(1, _TAPPING, [down(111, slot=11)])
_SPLIT_2 = _frame(2, _TAPPING, [down(111, slot=11, ago_ms=52.5)])
_OTHERS = [touching(200 + i, i) for i in range(12)]
_LONG_TOUCHED = [touching(100 + i, i, contacts=3) for i in range(12)]
_TOUCH = touching(contacts=3)
_PART = elements(_frame(1, [pointer()])[0])
_MANY_UPS = [up(200 + i, slot=i) for i in range(40)]

ASSEMBLIES = [
    AssemblyCase(
        "one-by-one",
        "Frames as they arrive; the fourth is lost and counted as missed.",
        _steps(_frame(1), _frame(2, [pointer()]), _frame(3, [pointer()]), _frame(5)),
    ),
    AssemblyCase(
        "repeated-down-is-one-hit",
        "A down is sent with three frames and reported with the first.",
        _steps(
            _frame(1, [pointer()]),
            *(_frame(i, [touching()], [down(ago_ms=40.0 * i - 70)]) for i in (2, 3, 4)),
            _frame(5, [pointer(contacts=1)], [up()]),
            _frame(6, [pointer(contacts=1)], [up(ago_ms=44.0)]),
        ),
    ),
    AssemblyCase(
        "first-copy-lost",
        "Frame 2 is lost: its down is reported with frame 3.",
        _steps(_frame(1, [pointer()]), _frame(3, [touching()], [down(ago_ms=50.0)])),
    ),
    AssemblyCase(
        "all-copies-lost",
        "The contacts of the pointer show the hit: a down with strike -1 is inferred.",
        _steps(_frame(1, [pointer()]), _frame(5, [touching()])),
    ),
    AssemblyCase(
        "whole-touch-lost",
        "Down and up are inferred; if two touches were lost, the number shows it.",
        _steps(_frame(1, [pointer()]), _frame(9, [pointer(contacts=2)])),
    ),
    AssemblyCase(
        "up-lost",
        "A pointer that hovers again has ended its touch, even without an up.",
        _steps(
            _frame(1, [pointer()]),
            _frame(2, [touching()], [down()]),
            _frame(6, [pointer(contacts=1)]),
        ),
    ),
    AssemblyCase(
        "finger-gone-in-touch",
        "A pointer that is no longer alive has ended its touch, too.",
        _steps(_frame(1, [pointer()]), _frame(2, [touching()], [down()]), _frame(6)),
    ),
    AssemblyCase(
        "up-without-its-down",
        "The finger touched and left between two frames: the down is inferred from the up.",
        _steps(_frame(1), _frame(5, events=[up(ago_ms=20.0)])),
    ),
    AssemblyCase(
        "up-of-an-earlier-touch",
        "After a later touch was reported, an earlier one is over.",
        _steps(
            _frame(1, [pointer()]),
            _frame(2, [touching(contacts=3)], [down(contacts=3)]),
            _frame(3, [touching(contacts=3)], [up(contacts=2)]),
        ),
    ),
    AssemblyCase(
        "quick-double-tap",
        "Two touches in one frame, in order.",
        _steps(
            _frame(1, [pointer()]),
            _frame(2, [touching(contacts=2)], [down(), up(), down(contacts=2)]),
        ),
    ),
    AssemblyCase(
        "late-joiner",
        "A client that joins during a touch gets no earlier hit, but gets the end of the touch.",
        _steps(
            _frame(1, [_TOUCH]), _frame(2, [_TOUCH]), _frame(3, [pointer(contacts=3)], [up(7, 3)])
        ),
    ),
    AssemblyCase(
        "late-joiner-of-a-part",
        "The same if a part of the first frame was lost.",
        _steps(_frame(1, _LONG_TOUCHED)[1:], _frame(2, _LONG_TOUCHED)),
    ),
    AssemblyCase(
        "late-joiner-after-a-touch",
        "A repeated up of an earlier touch is not reported.",
        _steps(_frame(1, [pointer(contacts=3)], [up(7, 3)]), _frame(2, [pointer(contacts=3)])),
    ),
    AssemblyCase(
        "late-joiner-just-in-time",
        "A down that is still repeated is a hit.",
        _steps(_frame(1, [_TOUCH], [down(contacts=3)]), _frame(2, [_TOUCH], [down(contacts=3)])),
    ),
    AssemblyCase(
        "late-joiner-of-late-copies",
        "Copies of a touch that was over 200 ms before the client's first frame are not reported; "
        "those of a later touch are.",
        _steps(
            _frame(1, events=[down(7, contacts=3, ago_ms=404.5), up(7, 3, ago_ms=304.5)]),
            _frame(2, events=[down(8, contacts=1, ago_ms=340.5), up(8, 1, ago_ms=244.5)]),
            _frame(8, events=[down(9, contacts=1, ago_ms=404.5), up(9, 1, ago_ms=304.5)]),
        ),
    ),
    AssemblyCase("split", "Reported when both parts have arrived.", _steps(_SPLIT_1)),
    AssemblyCase("split-backwards", "In any order.", _steps(_SPLIT_1[::-1])),
    AssemblyCase(
        "split-and-part-lost",
        "The newer frame ends the wait: fingers of the lost part stay where they were, and nothing "
        "is inferred that the newer frame contains.",
        _steps(_frame(0, hands(12)), _SPLIT_1[1:], _SPLIT_2),
    ),
    AssemblyCase(
        "split-and-never-whole",
        "A part of the first frame is lost: its fingers are unknown.",
        _steps(_SPLIT_1[:1], _frame(2, hands(1))),
    ),
    AssemblyCase(
        "parts-of-different-frames",
        "One number, two frames: a part that contradicts the first one is dropped.",
        _steps(_SPLIT_1[:1], _frame(1, _OTHERS)[1:], _SPLIT_1[1:]),
    ),
    AssemblyCase(
        "more-events-than-fit",
        "Late events of a frame that was already reported come in an event of their own.",
        _steps(_frame(1), _frame(2, events=_MANY_UPS)),
    ),
    AssemblyCase(
        "old-and-twice",
        "A frame that is not newer is dropped.",
        _steps(_frame(5), _frame(5), _frame(4), _frame(6)),
    ),
    AssemblyCase(
        "counter-wraps",
        "0 is newer than 2^24 - 1.",
        _steps(_frame(2**24 - 1 - COUNTER), _frame(2**24 - COUNTER)),
    ),
    AssemblyCase(
        "restart",
        "A new session starts with a smaller number; the old finger ends soon after.",
        [
            *_steps(_frame(5, [touching()], [down()])),
            Step(0.4, _frame(1, session="s2")[0]),
            Step(0.6, _frame(2, session="s2")[0]),
        ],
    ),
    AssemblyCase(
        "two-sessions-of-one-node",
        "Two running services with one name: a collision, reported once. Both stay separate.",
        [
            Step(0.0, _frame(1)[0]),
            Step(0.3, _frame(1, [pointer()], session="s2")[0]),
            Step(0.7, _frame(2, [pointer()], session="s2")[0]),
            Step(1.0, _frame(2)[0]),
            Step(1.1, _frame(3, [pointer()], session="s2")[0]),
            Step(2.0, _frame(3)[0]),
        ],
    ),
    AssemblyCase(
        "one-collision-while-another-service-is-lost",
        "A lost service with the same session name does not repeat the collision.",
        [
            Step(0.0, _frame(1)[0]),
            Step(0.1, _frame(1, node="wall")[0]),
            Step(0.3, _frame(1, session="s2")[0]),
            Step(1.0, _frame(2)[0]),
            Step(3.0, _frame(2, session="s2")[0]),
            Step(3.2, _frame(3)[0]),
        ],
    ),
    AssemblyCase(
        "two-services",
        "Neither deletes the other's pointers.",
        _steps(
            _frame(1, [pointer()]), _frame(9, [pointer(8)], node="wall"), _frame(2, [pointer()])
        ),
    ),
    AssemblyCase(
        "two-surfaces-in-one-datagram",
        "Each has its own frame.",
        _steps([now(*elements(_frame(1, [pointer()])[0]), *elements(_frame(1, surface="w")[0]))]),
    ),
    AssemblyCase(
        "silence",
        "After three seconds of silence a service is lost, and its touches end.",
        [
            *_steps(_frame(1, [pointer()]), _frame(2, [touching()], [down()])),
            Step(3.0),
            Step(3.02),
            Step(4.0),
        ],
    ),
    AssemblyCase(
        "back-after-silence",
        "Like a late joiner: no earlier hits.",
        [
            *_steps(_frame(1, [touching()], [down()])),
            Step(5.0, _frame(9, [touching(contacts=5)])[0]),
        ],
    ),
    AssemblyCase(
        "reports-pass",
        "A scene is reported each time.",
        [Step(0.0, encode(TABLE, SCENE)), Step(0.5, encode(TABLE, SCENE))],
    ),
    AssemblyCase(
        "parts-that-are-none",
        "Each is refused whole, and the frame after them is reported as usual.",
        _steps(
            [now(*_PART[1:])],  # no header
            [now(*_PART[:-1])],  # no alive list
            [now(_PART[0], *_PART)],  # two headers
            [now(*_PART[:-1], *_PART[1:])],  # a pointer twice
            [now(_PART[0], _PART[-1], *_PART[1:])],  # a pointer behind the alive list
            [now(_PART[0], *elements(_frame(1)[0])[1:])],  # count 1, none alive
            [now(*_PART[:2], *elements(_frame(1, [pointer(8)])[0])[2:])],  # another is alive
            _frame(1, [pointer()]),
        ),
    ),
]
