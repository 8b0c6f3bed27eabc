"""What is said of the results: whose they are, and how the table is to be read."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape

import pytest

from halo_service.evaluation.methods import METHODS
from halo_service.evaluation.metrics.result import Result, Subject
from halo_service.evaluation.report.goals import VIRTUAL
from halo_service.evaluation.report.page import INTRODUCTION, RECORDED, page
from halo_service.evaluation.report.summary import note, told
from halo_service.evaluation.report.table import as_text
from halo_service.evaluation.study.judge import recording_judged
from halo_service.evaluation.study.sense import Played
from halo_service.profile import Profile
from halo_service.sensing import SensingSettings
from halo_service.values import Frame, Tracked

DESK, USER = Subject("desk"), Subject("201-wood", 201, "wood", "straight")


def of(subject: Subject, *methods: str, asked: bool = False) -> list[Result]:
    """Results of nothing, by each method."""
    return [Result(subject, "recording", each, None, asked=asked) for each in methods]


CASES = {
    "a study": (of(USER, "ours", "paper"), "virtual users 201 on wood", None),
    "with truth": (of(DESK, "ours"), "recording desk, judged by its truth", "its truth."),
    "by its script": (
        of(DESK, "ours", asked=True),
        "recording desk, judged by what was asked for",
        "what was asked for, with people's own errors in it.",
    ),
}


@pytest.mark.parametrize("results, head, ends", CASES.values(), ids=CASES.keys())
def test_whose_figures_they_are_stands_above_and_below_the_table(
    results: Sequence[Result], head: str, ends: str | None
) -> None:
    heading, table, *_ = told(results, "1.2.3", as_text)
    assert head in heading
    words = " ".join(table.split())
    assert words.endswith(VIRTUAL if ends is None else f"of one recording, judged by {ends}")
    assert ("virtual" in heading + words) is (ends is None)


@pytest.mark.parametrize(
    "results, lead", [(of(USER, "ours"), INTRODUCTION), (of(DESK, "ours"), RECORDED)]
)
def test_the_page_says_it_too(results: Sequence[Result], lead: str) -> None:
    text = page(results, {})
    assert escape(lead) in text
    assert escape(note(results)) in text
    assert ("virtual" in text) is (lead == INTRODUCTION)


def test_a_method_that_was_not_calibrated_with_its_own_signal_is_marked(
    profile: Profile, draw: Callable[..., Frame], see: Callable[..., Tracked]
) -> None:
    frames = [draw(time_us=n * 33_333) for n in range(3)]
    target = {"step": "target", "from_s": 0.0, "to_s": 0.1, "target_mm": [150.0, 100.0]}
    results = recording_judged(
        Played(frames, profile.camera),
        "desk",
        lambda frame: see(time_us=frame.time_us),
        tuple(METHODS.values()),
        profile,
        SensingSettings(),
        None,
        [target],
    )
    assert [(each.method, each.asked, bool(each.remark)) for each in results] == [
        ("ours", True, False),
        ("paper", True, True),
        ("direct", True, False),
        ("wilson", True, False),
    ]
    assert "'paper' was not calibrated with its own signal" in note(results)
