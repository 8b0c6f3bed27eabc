"""The words around the tables: who was measured, and how to read them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from html import escape

import pytest

from halo_service.evaluation.methods import METHODS
from halo_service.evaluation.metrics.result import Result, Subject
from halo_service.evaluation.report.goals import VIRTUAL
from halo_service.evaluation.report.page import INTRODUCTION, RECORDED, page
from halo_service.evaluation.report.summary import heading, note, results_file, tables
from halo_service.evaluation.report.table import as_text
from halo_service.evaluation.study.judge import judge_recording
from halo_service.evaluation.study.sense import FrameSequence
from halo_service.profile import Profile
from halo_service.sensing import SensingSettings
from halo_service.values import Frame, Tracked

DESK, USER = Subject("desk"), Subject("201-wood", 201, "wood", "straight")


def of(subject: Subject, *methods: str, by_script: bool = False) -> list[Result]:
    """Results of nothing, by each method."""
    return [Result(subject, "recording", each, None, by_script=by_script) for each in methods]


CASES = {
    "a study": (of(USER, "ours", "paper"), "virtual users 201 on wood", None),
    "with truth": (of(DESK, "ours"), "recording desk, compared with its truth", "its truth."),
    "by its script": (
        of(DESK, "ours", by_script=True),
        "recording desk, compared with its script",
        "its script, so with people's own errors.",
    ),
}


@pytest.mark.parametrize("results, head, ends", CASES.values(), ids=CASES.keys())
def test_the_words_above_and_below_the_table_say_who_was_measured(
    results: Sequence[Result], head: str, ends: str | None
) -> None:
    above = "\n".join(heading(results, "1.2.3"))
    assert head in above
    words = " ".join(as_text(tables(results)[0]).split())
    assert words.endswith(VIRTUAL if ends is None else f"of one recording, compared with {ends}")
    assert ("virtual" in above + words) is (ends is None)


@pytest.mark.parametrize(
    "results, lead", [(of(USER, "ours"), INTRODUCTION), (of(DESK, "ours"), RECORDED)]
)
def test_the_page_has_the_same_words(results: Sequence[Result], lead: str) -> None:
    text = page(results, {})
    assert escape(lead) in text
    assert escape(note(results)) in text
    assert ("virtual" in text) is (lead == INTRODUCTION)


def test_a_method_without_its_own_calibration_has_a_remark(
    profile: Profile, draw: Callable[..., Frame], see: Callable[..., Tracked]
) -> None:
    frames = [draw(time_us=n * 33_333) for n in range(3)]
    target = {"step": "target", "from_s": 0.0, "to_s": 0.1, "target_mm": [150.0, 100.0]}
    results = judge_recording(
        FrameSequence(frames, profile.camera),
        "desk",
        lambda frame: see(time_us=frame.time_us),
        tuple(METHODS.values()),
        profile,
        SensingSettings(),
        None,
        [target],
    )
    assert [(each.method, each.by_script, bool(each.remark)) for each in results] == [
        ("ours", True, False),
        ("paper", True, True),
        ("direct", True, False),
        ("wilson", True, False),
    ]
    assert "'paper' was not calibrated with its own signal" in note(results)


def test_a_results_file_begins_with_what_it_is_of() -> None:
    facts = {"date": "2026-11-28", "commit": "abc", "command": "halo evaluate"}
    lines = results_file(of(USER, "ours"), facts).splitlines()
    assert lines[0] == "# Evaluation results"
    assert lines[2:5] == ["- date: 2026-11-28", "- commit: abc", "- command: halo evaluate"]
    assert "### The paper's figures and ours" in lines
