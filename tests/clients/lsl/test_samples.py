"""Frames become regular samples and contacts, and the streams say what they are."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Any

import pytest

from halo_lsl.bridge import Bridge
from halo_lsl.clock import Arrival, Clock, Kind
from halo_lsl.samples import Regular, contact_samples, pointer_values
from halo_lsl.streams import (
    CONTACTS,
    FINGER,
    MARKERS,
    POINTERS,
    STREAMS,
    Setup,
    Stream,
    description,
    source_id,
)
from halo_protocol import Event, Health, Lost, Report, Scene, TouchFrame
from tests.clients.recordings import recorded

SIZE_MM = (300.0, 200.0)


def as_is(time_s: float) -> float:
    return time_s


def test_each_slot_has_its_channels_and_nan_while_it_is_empty(wire: Any) -> None:
    finger = replace(wire.finger(id=7, at=(30.0, 50.0), pressure=0.5), slot=2)
    values = pointer_values(wire.frame(0, [finger]))
    labels = [channel.label for channel in POINTERS.channels]
    row = dict(zip(labels, values, strict=True))
    assert row["fingers"] == 1
    assert (row["f2_id"], row["f2_x"], row["f2_y"], row["f2_touch"]) == (7, 30.0, 50.0, 1.0)
    assert math.isnan(row["f2_force"]), "an unknown force is no -1"
    assert sum(map(math.isnan, values)) == 9 * len(FINGER) + 1


@pytest.mark.parametrize(
    ("times", "count"),
    [
        ([0.0, 1 / 30, 2 / 30], 3), ([0.0, 0.034, 0.065, 0.101], 4), ([0.0, 0.1], 4),
        ([0.0, 0.0], 1), ([0.1, 0.0], 1), ([0.0, 2.9], 88), ([0.0, 3.5], 2),
    ],
)  # fmt: skip
def test_pointers_are_regular_and_gaps_are_nan(wire: Any, times: list[float], count: int) -> None:
    regular, frame = Regular(30.0), wire.frame(0, [wire.finger()])
    samples = [each for time_s in times for each in regular.samples(frame, time_s)]
    assert len(samples) == count
    steps = [b.time_s - a.time_s for a, b in itertools.pairwise(samples)]
    assert all(0.5 / 30 <= step <= 1.5 / 30 for step in steps) or times == [0.0, 3.5]
    known = [each for each in samples if not math.isnan(each.values[0])]
    assert {each.time_s for each in known} <= set(times)


def test_a_touch_is_a_contact_at_its_own_time_and_a_marker(wire: Any) -> None:
    frame = wire.frame(0, [wire.finger(pressure=0.5)], downs=(wire.down(),))
    ((sample, marker),) = contact_samples(frame, SIZE_MM, as_is)
    assert sample.time_s == marker.time_s == frame.time_us / 1e6 - 0.012
    labels = [channel.label for channel in CONTACTS.channels]
    row = dict(zip(labels, sample.values, strict=True))
    assert (row["touch"], row["x"], row["y"], row["strike"]) == (1.0, 150.0, 100.0, 200.0)
    assert marker.text == "down/right/index"


def test_a_finger_that_has_left_is_unknown(wire: Any) -> None:
    frame = wire.frame(0, downs=(wire.down(strike_mm_s=-1.0),), ups=(wire.up(),))
    (down, _), (up, marker) = contact_samples(frame, SIZE_MM, as_is)
    assert math.isnan(down.values[-1]) and math.isnan(up.values[-1])
    assert marker.text == "up/unknown/unknown"


class Log:
    """What was sent."""

    def __init__(self) -> None:
        self.setups: list[Setup] = []
        self.sent: list[tuple[Stream, Any, float]] = []

    def create(self, setup: Setup) -> Log:
        self.setups.append(setup)
        return self

    def push(self, stream: Stream, values: Any, time_s: float) -> None:
        self.sent.append((stream, values, time_s))

    def texts(self) -> list[str]:
        return [values[0] for stream, values, _ in self.sent if stream is MARKERS]


def scene(revision: int = 1) -> Report:
    size = (300.0, 200.0)
    return Report(
        "table",
        Scene("desk", "s1", "1.0.0", *size, 2, revision, 2, 30.0, calibrated_s=86_400),
    )


def health() -> Report:
    return Report("table", Health("desk", "s1", 30.0, 3.0, 0, 0, 3, 1))


def bridged(events: list[Event]) -> Log:
    log = Log()
    bridge = Bridge(Clock(Kind.ARRIVAL), log.create)
    for number, event in enumerate(events):
        at_s = event.time_us / 1e6 if isinstance(event, TouchFrame) else number / 30
        bridge.process(event, Arrival(at_s + 0.02, at_s))
    return log


def test_the_streams_are_created_once_and_describe_the_service(wire: Any) -> None:
    frames = [wire.frame(n, [wire.finger()]) for n in range(40)]
    (setup,) = bridged([frames[0], scene(), health(), *frames[1:], scene()]).setups
    tree = description(POINTERS, setup)
    assert tree["acquisition"]["source"] == "virtual"
    calibration = tree["acquisition"]["calibration"]
    assert calibration.pop("age_s") == f"{setup.created_s - 86_400:.0f}"
    assert calibration == {"state": "complete", "revision": "1", "date": "1970-01-02T00:00:00Z"}
    assert tree["acquisition"]["surface_size"]["width"] == "300"
    assert tree["synchronization"]["can_drop_samples"] == "true"
    channels = tree["channels"]["channel"]
    assert len(channels) == len(POINTERS.channels) == 1 + 10 * len(FINGER)
    assert channels[5] == {"label": "f0_x", "unit": "millimeters", "type": "PositionX"}
    assert len({each["label"] for each in channels}) == len(channels)
    assert len({source_id(stream, setup) for stream in STREAMS}) == 3


def test_without_a_scene_the_streams_come_a_little_later(wire: Any) -> None:
    frames = [wire.frame(n, [wire.finger()]) for n in range(60)]
    assert bridged(frames[:40]).setups == []
    (setup,) = bridged(frames).setups
    assert description(MARKERS, setup)["acquisition"]["source"] == "unknown"


def test_what_happens_to_the_service_is_a_marker(wire: Any) -> None:
    frames = [wire.frame(n, [wire.finger()]) for n in range(20)]
    restarted = [replace(wire.frame(n, []), session="s2") for n in range(20, 25)]
    log = bridged([scene(), health(), *frames, scene(2), Lost("table", "desk", "s1"), *restarted])
    assert log.texts() == [
        "service/session/s1", "calibration/revision/2", "service/lost/desk", "service/session/s2",
    ]  # fmt: skip


def test_a_recorded_drummer_gives_every_contact_once_and_regular_samples() -> None:
    frames = list(recorded("drumming"))
    log = bridged([scene(), health(), *frames])
    downs = [values for stream, values, _ in log.sent if stream is CONTACTS and values[0] == 1.0]
    assert len(downs) == sum(len(frame.downs) for frame in frames)
    times = [at for stream, _, at in log.sent if stream is POINTERS]
    steps_ms = [1e3 * (b - a) for a, b in itertools.pairwise(times)]
    assert min(steps_ms) > 30.0 and max(steps_ms) < 37.0
