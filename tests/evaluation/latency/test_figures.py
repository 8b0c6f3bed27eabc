"""From rows to figures, on rows with known numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace

import numpy as np
import pytest

from halo_service.app.benchmarking.table import lines, tables
from halo_service.evaluation.latency.blocks import Arrangement, Block, Spent
from halo_service.evaluation.latency.figures import Case, case_of, goals
from halo_service.evaluation.latency.listener import Received
from halo_service.evaluation.latency.raw_frames import RawFrame
from halo_service.evaluation.latency.simulate import LatencyRecording, TrueContact
from halo_service.evaluation.latency.stopwatch import Row
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.values import TouchEvent

FRAME_US = 33_333
MS = 1_000_000


def down(x_mm: float = 150.0, y_mm: float = 100.0) -> TouchEvent:
    return TouchEvent("down", 1, 0, x_mm, y_mm, 0.0, 0.0, 1)


def block(arrangement: Arrangement, ms: Sequence[float], *downs_at: int) -> Block:
    """Frames that took so long, the given ones with a down."""
    rows = tuple(
        Row(
            n * FRAME_US,
            {"wait": round(0.25 * each * MS), "send": round(0.75 * each * MS)},
            (down(),) if n in downs_at else (),
        )
        for n, each in enumerate(ms)
    )
    spent = Spent(2.0 * len(ms), 1.0 * len(ms), 0.5 * len(ms))
    ages = (33.0, 35.0) if arrangement == "ours" else ()
    return Block(
        arrangement,
        rows,
        len(ms),
        0,
        spent,
        Received(9, len(ms) + 1),
        extra_packets=1,
        hands_ms=ages,
    )


def case(profile: Profile, camera: Camera, *blocks: Block, contacts: Sequence[int] = ()) -> Case:
    """`contacts`: when they begin, us; all in the middle of the surface."""
    middle = profile.surface.to_camera(np.array([[150.0, 100.0, 0.0]]))[0].tolist()
    true = tuple(TrueContact(us, us + 100_000, tuple(middle)) for us in contacts)
    recording = LatencyRecording("sim:x", "virtual", camera, (RawFrame(0, b"", b"", None),), true)
    return case_of(recording, 1, blocks, profile.surface)


def test_stages_percentiles_and_work_are_summed_over_all_blocks(
    profile: Profile, camera: Camera
) -> None:
    summed = case(
        profile,
        camera,
        block("ours", [2.0, 4.0]),
        block("sequential", [40.0, 40.0, 40.0]),
        block("ours", [4.0, 6.0]),
    )
    ours = summed.ours
    assert (ours.frames, ours.received, ours.dropped) == (4, 4, 0)
    assert (ours.latency.median, ours.latency.largest) == pytest.approx((4.0, 6.0))
    assert ours.stages["wait"].median + ours.stages["send"].median == pytest.approx(4.0)
    assert (ours.cpu_a_frame, ours.path_cpu_a_frame) == pytest.approx((2.0, 1.0))
    assert ours.core_wait_a_frame == pytest.approx(0.5)
    assert ours.hands is not None
    assert ours.hands.median == pytest.approx(34.0)
    assert summed.sequential.hands is None
    assert summed.ratio == pytest.approx(10.0)
    assert summed.contacts is None


@pytest.mark.parametrize(
    ("begins_us", "downs_at", "delay_ms", "early"),
    [
        pytest.param(70_000, (3,), 99.999 - 70.0 + 4.0, 0, id="in the frame after the contact"),
        pytest.param(105_000, (3,), 0.0, 1, id="predicted by a few milliseconds"),
        pytest.param(200_000, (3,), None, 0, id="long before the contact"),
        pytest.param(10_000, (9,), None, 0, id="long after it"),
        pytest.param(70_000, (), None, 0, id="never"),
    ],
)
def test_contact_to_down_is_the_frame_s_age_and_what_it_took(
    profile: Profile,
    camera: Camera,
    begins_us: int,
    downs_at: tuple[int, ...],
    delay_ms: float | None,
    early: int,
) -> None:
    summed = case(
        profile,
        camera,
        block("ours", [4.0] * 12, *downs_at),
        block("sequential", [40.0] * 12),
        contacts=[begins_us],
    )
    contacts = summed.contacts
    if delay_ms is None:
        assert contacts is None
    else:
        assert contacts is not None
        assert (contacts.true, contacts.reported, contacts.early) == (1, 1, early)
        assert contacts.median_ms == pytest.approx(delay_ms)
        assert contacts.median_frames == pytest.approx(delay_ms / (1000 / 30))


def test_an_early_down_counts_as_0_ms_and_hides_no_late_one(
    profile: Profile, camera: Camera
) -> None:
    summed = case(
        profile,
        camera,
        block("ours", [4.0] * 12, 3, 9),
        block("sequential", [40.0] * 12),
        contacts=[140_000, 290_000],  # 36 ms after the one message, 14 ms before the other
    )
    contacts = summed.contacts
    assert contacts is not None
    assert contacts.early == 1
    assert contacts.median_ms == pytest.approx((0.0 + 9 * FRAME_US / 1e3 + 4.0 - 290.0) / 2)
    assert "2 of 2 reported, 1 before contact" in "\n".join(lines(summed))


def test_one_down_belongs_to_one_contact(profile: Profile, camera: Camera) -> None:
    summed = case(
        profile,
        camera,
        block("ours", [4.0] * 6, 3),
        block("sequential", [40.0] * 6),
        contacts=[80_000, 90_000],
    )
    assert summed.contacts is not None
    assert (summed.contacts.true, summed.contacts.reported) == (2, 1)


@pytest.mark.parametrize(
    ("ours_ms", "sequential_ms", "passed"),
    [
        (3.0, 40.0, [True, True, True, True]),
        (5.5, 40.0, [False, True, True, True]),
        (4.0, 15.0, [True, True, False, True]),
        (14.0, 80.0, [False, False, True, True]),
    ],
)
def test_each_goal_passes_or_fails(
    profile: Profile,
    camera: Camera,
    ours_ms: float,
    sequential_ms: float,
    passed: list[bool],
) -> None:
    summed = case(
        profile,
        camera,
        block("ours", [ours_ms] * 6, 3),
        block("sequential", [sequential_ms] * 6, 4),
        contacts=[90_000],
    )
    assert [goal.passed for goal in goals(summed)] == passed
    text = "\n".join(lines(summed))
    assert "waited" not in text  # 0.5 ms per frame are negligible
    assert text.count("pass") == sum(passed)
    assert text.count("  fail") == len(passed) - sum(passed)


def test_a_late_down_fails(profile: Profile, camera: Camera) -> None:
    summed = case(
        profile,
        camera,
        block("ours", [4.0] * 6, 4),
        block("sequential", [40.0] * 6),
        contacts=[90_000],
    )
    assert [goal.passed for goal in goals(summed)] == [True, True, True, False]


def test_a_case_is_plain_enough_for_json(profile: Profile, camera: Camera) -> None:
    fields = asdict(case(profile, camera, block("ours", [3.0]), block("sequential", [40.0])))
    assert set(fields) == {"source", "hands", "ours", "sequential", "contacts"}
    for each in (fields["ours"], fields["sequential"]):
        assert set(each) == {
            "frames", "dropped", "received", "datagrams", "latency", "stages", "cpu_a_frame",
            "path_cpu_a_frame", "core_wait_a_frame", "hands",
        }  # fmt: skip
        assert set(each["latency"]) == {"median", "p95", "p99", "largest"}


def test_a_disturbed_run_has_a_note(profile: Profile, camera: Camera) -> None:
    ours = block("ours", [9.0] * 6)
    disturbed = replace(ours, spent=replace(ours.spent, core_wait_ms=6 * 4.2))
    text = "\n".join(lines(case(profile, camera, disturbed, block("sequential", [40.0] * 6))))
    assert "waited 4.2 ms for a free core" in text


def test_the_table_names_each_stage_of_either_once(profile: Profile, camera: Camera) -> None:
    stages = {"wait": MS, "sense": 2 * MS, "encode": MS, "send": MS}
    rows = (Row(0, stages, ()),)
    ours = replace(block("ours", [1.0]), rows=rows)
    other = {"wait": MS, "decode": MS, "hands": 20 * MS, "encode": MS, "send": MS}
    sequential = replace(block("sequential", [1.0]), rows=(Row(0, other, ()),))
    summed = case(profile, camera, ours, sequential)
    names = [line.split()[0] for line in lines(summed) if line.startswith("  ")]
    first = names.index("wait")
    assert names[first : first + 6] == ["wait", "decode", "hands", "sense", "encode", "send"]
    assert [name.strip() for name, *_ in tables(summed)[0].rows][1:7] == names[first : first + 6]
