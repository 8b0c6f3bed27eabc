"""Two hands drag over the seam of two cameras: what their nodes really reported, merged.

`streams/` has 4.2 s of `benchmarks/installation.py --seed 11`: frames of two virtual cameras that
went through the hand tracker and the sensing, with the clocks of their devices.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.merging.sensed import merged
from benchmarks.merging.sensed_score import Score, score
from halo_service.virtual.installation.truth import canvas_truth, layout_text
from halo_service.virtual.sim_url import parse_sim_url

STREAMS = [Path(__file__).parent / "streams" / f"camera-{number}.jsonl" for number in (1, 2)]
REQUEST = parse_sim_url("sim:crossing,cameras=2,seed=11")
FROM_S, SECONDS = 34.7, 4.0


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> Score:
    layout = tmp_path_factory.mktemp("canvas") / "table.toml"
    layout.write_text(layout_text(REQUEST))
    frames, downs = merged(layout, STREAMS, REQUEST)
    return score(list(canvas_truth(REQUEST, SECONDS, FROM_S)), frames, downs, REQUEST)


def test_each_touch_is_one_touch_of_the_canvas(result: Score) -> None:
    assert (result.touches, result.touching) == (2, 4)
    assert (result.lost, result.lost_by_all) == (0, 0), result.wrong
    assert (result.again, result.again_by_canvas, result.wrong_downs) == (0, 0, 0), result.wrong


def test_each_finger_has_one_id_on_both_sides_of_the_seam(result: Score) -> None:
    assert result.crossings >= 4
    assert (result.unseen, result.changed) == (0, 0), result.wrong


def test_a_finger_does_not_jump_at_the_seam(result: Score) -> None:
    figures = dict(result.rows())
    median, most, _ = map(float, figures["seam error, mm: median, 95 %, 99 %"].split())
    assert median < 4.0
    assert most < 6.0
