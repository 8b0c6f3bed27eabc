"""The two pages: every figure with its unit and its good range, verdicts that follow from them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from halo_calibration.steps.camera import CameraReport
from halo_service.app.first_light.report import (
    Account,
    Row,
    placement_rows,
    report_page,
    touch_rows,
    verdicts,
)
from halo_service.evaluation.metrics.result import Result, Subject
from halo_service.evaluation.metrics.scripted import score_script
from halo_service.evaluation.report.select import RECORDING
from halo_service.profile import Profile
from tests.evaluation.small_world import SURFACE, down, published_frames

GOOD = CameraReport(550.0, 5.0, 0.99, 1500.0, 0.0, "good", (), ())
SCRIPT = [
    {"step": "target", "from_s": 0.0, "to_s": 0.5, "target_mm": [100.0, 100.0]},
    {"step": "target", "from_s": 0.6, "to_s": 0.9, "target_mm": [150.0, 100.0]},
]


def results(count: int = 60, downs: int = 2) -> tuple[Result, ...]:
    """A session of two touches, so many of which were reported, each 2 mm off."""
    events = {10: [down(1, 102.0, 100.0)], 20: [down(2, 152.0, 100.0)]}
    events = dict(list(events.items())[:downs])
    frames = published_frames(count, events, {})
    scores = score_script(frames, SCRIPT, SURFACE)
    return (Result(Subject("first-light"), RECORDING, "ours", scores, by_script=True),)


@pytest.fixture
def account(profile: Profile) -> Account:
    return Account({"date": "today"}, GOOD, profile, results(), files={"a.mkv": "send <it>"})


ROWS = {
    "in range": (Row("x", 5.0, "mm", 1.0, 9.0), True, ("x", "5 mm", "1 to 9 mm")),
    "too much": (Row("x", 5.25, "mm", most=5.0, digits=1), False, ("x", "5.2 mm", "up to 5.0 mm")),
    "too little": (Row("x", 5.0, "%", 95.0), False, ("x", "5 %", "95 % or more")),
    "a count": (Row("x", 0.0, "", most=0), True, ("x", "0", "up to 0")),
    "unknown": (Row("x", math.nan, "mm", most=1.0), None, ("x", "not measured", "up to 1 mm")),
}


@pytest.mark.parametrize(("row", "good", "cells"), ROWS.values(), ids=ROWS)
def test_a_figure_has_its_unit_and_its_good_range(row, good, cells) -> None:
    assert (row.good, row.cells) == (good, cells)


def test_all_rows_have_a_good_range_and_a_remedy(account: Account) -> None:
    for row in (*placement_rows(account), *touch_rows(account)):
        assert math.isfinite(row.least) or math.isfinite(row.most), row.what
        assert row.remedy, row.what


def test_the_verdicts_follow_from_the_figures(account: Account) -> None:
    found = dict(verdicts(account))
    assert found["Touch"] == "works"
    assert found["Hover"] == found["Pressure"] == "not measured"
    missed = replace(account, results=results(downs=1))
    assert dict(verdicts(missed))["Touch"] == "partly: touches reported, of those requested"
    (share,) = [row for row in touch_rows(missed) if row.what.startswith("touches reported, of")]
    assert share.value == pytest.approx(50.0)
    far = replace(account, camera=replace(GOOD, height_mm=1300.0), lost_share=0.2)
    assert "camera above the table, frames lost" in dict(verdicts(far))["Camera and table"]


def test_the_page_is_complete_in_itself_and_escapes_what_it_shows(account: Account) -> None:
    page = report_page(replace(account, missed=("Touch <b>.",), coins=True))
    assert page.count("class='sheet'") == 2
    assert "send &lt;it&gt;" in page
    assert "<b>." not in page
    assert "not felt or not held still: 1, the first is: Touch &lt;b&gt;." in page
    assert "25 mm beyond the coins" in page
    for outside in ("http://", "https://", "<script"):
        assert outside not in page.replace("http://www.w3.org/2000/svg", "")


def test_a_rehearsal_says_that_it_is_one(account: Account) -> None:
    assert "camera, the hand and the table were virtual" in report_page(
        replace(account, virtual=True)
    )
    assert "your own errors are in every figure" in report_page(account)


def test_nothing_to_do_is_said_too(account: Account) -> None:
    good = replace(account, profile=replace(account.profile))
    noise = np.median(good.profile.background.noise_mm[good.profile.background.valid])
    assert noise < 2.0
    assert "Nothing: all that was measured is in its good range." in report_page(good)
