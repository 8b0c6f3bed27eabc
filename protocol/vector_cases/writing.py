"""Messages that are written and read back: frames and reports."""

from __future__ import annotations

from dataclasses import replace

from halo_protocol import Health, Homography, Pose, Scene
from vector_cases.build import (
    UNIX_S,
    FrameCase,
    ReportCase,
    down,
    hands,
    header,
    pointer,
    touching,
    up,
)

_LONG = "a-name-of-thirty-two-characters_"
_LONG_SESSION = "session-of-thirty-two-characters"

FRAMES = [
    FrameCase("empty", "No finger: sent when the last one leaves, and as keep-alive.", header(0)),
    FrameCase("hovering", "One finger in the air.", header(1), [pointer()]),
    FrameCase(
        "touch-begins",
        "The first frame of a touch has its right position and the down.",
        header(1),
        [touching()],
        [down()],
    ),
    FrameCase(
        "touch-ends",
        "Two frames later: the down for the third time, the up for the first.",
        header(1),
        [pointer(contacts=1)],
        [down(ago_ms=79.0)],
        [up()],
    ),
    FrameCase(
        "last-finger-left",
        "An up without a pointer: the finger left the view while it touched.",
        header(0),
        ups=[up()],
    ),
    FrameCase("ten-fingers", "Two hands in two datagrams of 1232 bytes.", header(10), hands(10)),
    FrameCase(
        "ten-fingers-in-one",
        "Two hands in one datagram, with a larger limit.",
        header(10),
        hands(10),
        max_bytes=1432,
    ),
    FrameCase(
        "timetagged",
        "The option for clients that schedule: the timetag is the frame's time.",
        header(1),
        [pointer()],
        timetagged=True,
    ),
    FrameCase("split", "Twelve fingers in two datagrams.", header(12), hands(12)),
    FrameCase(
        "split-with-events",
        "Events go before pointers, hence into the first datagram.",
        header(10),
        [touching(100 + i, i) for i in range(10)],
        [down(100 + i, slot=i) for i in range(10)],
    ),
    FrameCase(
        "long-names",
        "Names of 32 characters leave room for fewer pointers.",
        header(10, node=_LONG, session=_LONG_SESSION),
        hands(10),
        surface=_LONG,
    ),
    FrameCase("largest", "64 fingers, the most there can be.", header(64), hands(64)),
    FrameCase(
        "counter-at-its-end",
        "The largest frame number and session time; the next is 0.",
        header(0, frame=2**24 - 1, session_ms=2**24 - 1),
    ),
    FrameCase(
        "replay",
        "A recording's own time, counted from 0.",
        header(0, session="replay-3f2a", frame=0, time_s=0, time_frac_us=463_945, session_ms=463),
    ),
    FrameCase(
        "off-the-surface",
        "u and v are not clamped; numbers that no float32 holds exactly are rounded.",
        header(1),
        [pointer(u=-0.1, v=1.05, x_mm=-30.3, y_mm=210.1, pressure=0.0, confidence=0.333)],
    ),
    FrameCase(
        "pressed",
        "More than the calibrated press, with its force known.",
        header(1, time_frac_us=123_457),
        [touching(pressure=1.75, force_g=312.5, contacts=41)],
    ),
]

SCENE = Scene(
    "desk", "s1", "1.0.0", 300.0, 200.0, 2, 3, 0, 30.0, 4257, 0, UNIX_S - 86_400, "0.1.0", "1.9.0"
)
_MATRIX_3X3 = (6.5, 0.125, -40.0, -0.0625, 6.25, 12.5, 0.0009765625, -0.00048828125, 1.0)
_MATRIX_3X4 = (1.0, 0.0, 0.0, -150.0, 0.0, 0.75, -0.5, -100.0, 0.0, 0.5, 0.75, 520.0)

REPORTS = [
    ReportCase("scene-camera", "A calibrated camera.", SCENE),
    ReportCase(
        "scene-virtual",
        "The virtual camera, without a control port; another service has the same name.",
        replace(SCENE, source=2, calibration=1, revision=0, control_port=0, collision=1),
    ),
    ReportCase(
        "scene-recording",
        "A recording without a profile; the bundle carries a time.",
        replace(SCENE, source=1, calibration=0, calibrated_s=0),
        time_us=UNIX_S * 1_000_000 + 250_000,
    ),
    ReportCase(
        "homography", "A projector is known.", Homography("desk", "s1", 3, 1920, 1080, _MATRIX_3X3)
    ),
    ReportCase(
        "pose", "Camera and marker are known.", Pose("desk", "s1", 3, _MATRIX_3X4, _MATRIX_3X4, 1)
    ),
    ReportCase(
        "pose-without-anchor",
        "The camera alone is known: `anchored` is 0.",
        Pose("desk", "s1", 3, _MATRIX_3X4, (0.0,) * 12, 0),
    ),
    ReportCase(
        "health",
        "All is well.",
        replace(
            Health("desk", "s1", 29.75, 3.5, 2, 1, 3, 1, 33.25),
            time_s=UNIX_S,
            time_frac_us=250_000,
        ),
    ),
    ReportCase(
        "health-clock-set",
        "The host's clock was set back by 30 s; the time in frames follows slowly.",
        Health("desk", "s1", 29.75, 3.5, 0, 0, 3, 1, 33.25, 1, -29_984.5),
    ),
    ReportCase(
        "health-camera-tilted",
        "The camera was tilted after the calibration.",
        Health("desk", "s1", 29.75, 3.5, 0, 0, 3, 1, 33.25, 0, 0.0, 3),
    ),
    ReportCase(
        "health-router-gone-disk-full",
        "A router of `[zenoh] connect` is away and two profiles could not be written.",
        Health("desk", "s1", 29.75, 3.5, 0, 0, 3, 1, 33.25, 0, 0.0, 1, 1, 2, 412),
    ),
    ReportCase(
        "health-busy",
        "The machine is busy: the hand model gets five images a second and frames are left out.",
        Health("desk", "s1", 24.5, 21.25, 57, 0, 3, 1, 180.5, 0, 0.0, 1, 0, 0, 412, 3, 4.75),
    ),
    ReportCase(
        "health-canvas",
        "A canvas merges two nodes; the clock of one is 5 s behind.",
        replace(
            Health("hall", "s1", 30.0, 0.25, 2, 0, 3, 1, 33.25),
            nodes=2,
            clock_offset_ms=5000.5,
            clock_deviation_ms=0.25,
        ),
    ),
    ReportCase(
        "health-camera-lost",
        "The camera is unplugged; latencies are unknown.",
        Health("desk", "s1", 0.0, -1.0, 2, 40, 0, 2, -1.0),
    ),
]
