"""Tables, lines, CSV and page: a missed goal says so, and so does a figure not measured."""

import xml.etree.ElementTree as ElementTree
from csv import DictReader
from dataclasses import replace
from html.parser import HTMLParser
from io import StringIO

import numpy as np
import pytest

from halo_service.evaluation.metrics.behaviour import Behaviour
from halo_service.evaluation.metrics.confidence import Confidence
from halo_service.evaluation.metrics.keystrokes import Keys, Phrase
from halo_service.evaluation.metrics.levels import Jump, Trial
from halo_service.evaluation.metrics.pool import pool
from halo_service.evaluation.metrics.result import Result, Subject
from halo_service.evaluation.metrics.retaps import Retap
from halo_service.evaluation.metrics.scores import score
from halo_service.evaluation.metrics.scripted import score_script
from halo_service.evaluation.metrics.speeds import Speed
from halo_service.evaluation.metrics.touches import Touches
from halo_service.evaluation.report.breakdown import breakdown, reliability_table
from halo_service.evaluation.report.csv_file import write
from halo_service.evaluation.report.figures import FIGURES, figures
from halo_service.evaluation.report.goals import FAIL, GOALS, NOT_MEASURED, PASS, goal_table
from halo_service.evaluation.report.page import page
from halo_service.evaluation.report.summary import brief
from halo_service.evaluation.report.table import Table, as_markdown, as_text
from halo_type.metrics import Typed
from tests.evaluation.small_world import (
    SURFACE,
    at,
    contact,
    down,
    finger,
    pointer,
    published_frames,
    truth_frames,
    up,
)

SUBJECT = Subject("201-wood", 201, "wood", "straight")
FACTS = {"command": "halo evaluate", "users": "201 & 202"}


def taps(count=6, missed=(), doubled=(), off_mm=1.0, early=()):
    """Scores of touches of targets, reported 1 mm off in their first frame or one early."""
    lines, events, fingers = [], {}, {}
    for k in range(count):
        begin = 12 * k + 5
        aim = [80.0 + 20.0 * (k % 3), 60.0 + 40.0 * (k // 3 % 4)]
        lines.append(contact(begin - 0.5, begin + 5, *aim, target_mm=aim))
        fingers |= {frame: [finger(*aim)] for frame in range(begin, begin + 6)}
        if k not in missed:
            reported = begin - (k in early)
            events[reported] = [down(x_mm=aim[0] + off_mm, y_mm=aim[1], strike_mm_s=180.0)]
            events[begin + 6] = [up()]
        if k in doubled:
            events[begin + 3] = [down(x_mm=aim[0], y_mm=aim[1])]
    frames = 12 * count + 10
    return score(
        published_frames(frames, events), [*truth_frames(frames, fingers), *lines], (), SURFACE
    )


def empty(**more):
    """Scores of a recording without touches."""
    return replace(score(published_frames(5), truth_frames(5), (), SURFACE), **more)


def feinted(ghost=None, missed=False):
    """Scores of a flat feint, reported with the confidence `ghost`, and of the touch after it."""
    downs = ({} if ghost is None else {5: [down()]}) | ({} if missed else {12: [down(x_mm=103.0)]})
    frames = published_frames(30, downs, {5: [pointer(confidence=1.0 if ghost is None else ghost)]})
    script = [{"step": "angle", "pitch_deg": 8.0, "from_s": 0.0, "to_s": 1.0}]
    return score(frames, [*truth_frames(30), contact(11.5, 15)], script, SURFACE)


def result(scores, task="pointing", method="ours", subject=SUBJECT, refused="", by_script=False):
    return Result(subject, task, method, scores, refused, by_script=by_script)


def held(error, kind="hover", no_reading=0.0):
    return empty(trials=(Trial(kind, 10.0, error, -error, 10.0 - error, no_reading),))


def retapped(reported):
    return empty(
        retaps=tuple(Retap(lift, k < n) for lift, n in reported.items() for k in range(100))
    )


def line_of(figure, results):
    table = goal_table(results)
    return next(row for row in table.rows if row[0].startswith(figure))[3]


CASES = {
    "every touch reported": ("touch:", [result(taps())], PASS),
    "one missed": ("touch:", [result(taps(missed=[2]))], FAIL),
    "none missed": ("missed", [result(taps())], PASS),
    "one doubled of a few": ("missed", [result(taps(doubled=[1]))], FAIL),
    "no touch at all": ("touch:", [result(empty())], NOT_MEASURED),
    "near": ("spatial error of hits", [result(taps(off_mm=2.9))], PASS),
    "far": ("spatial error of hits", [result(taps(off_mm=3.1))], FAIL),
    "in the first frame": ("contact", [result(taps())], PASS),
    "hover within": ("hover error", [result(held(0.9), "hover")], PASS),
    "hover beyond": ("hover error", [result(held(1.1), "hover")], FAIL),
    "hover read too rarely": (
        "hover error",
        [result(held(0.1, no_reading=0.1), "hover")],
        FAIL,
    ),
    "doubled noise is separate": ("hover error", [result(held(9.0), "hover-noise2")], NOT_MEASURED),
    "pressure within": ("pressure error", [result(held(7.0, "pressure"), "pressure")], PASS),
    "re-taps of 2 mm": ("touch point", [result(retapped({2.0: 99}), "threshold")], PASS),
    "re-taps of 3 mm": ("touch point", [result(retapped({2.0: 98, 3.0: 100}), "threshold")], FAIL),
    "no re-tap reported": ("touch point", [result(retapped({6.0: 0}), "threshold")], FAIL),
    "a key in 100": ("keys", [result(empty(keys=Keys(100, 1)), "typing")], PASS),
    "two keys in 100": ("keys", [result(empty(keys=Keys(100, 2)), "typing-fast")], FAIL),
    "right, but two in 100 missed": (
        "keys",
        [result(empty(keys=Keys(100, 0, missed=2)), "typing")],
        FAIL,
    ),
    "right, but two in 100 doubled": (
        "keys",
        [result(empty(keys=Keys(100, 0, doubled=2)), "typing")],
        FAIL,
    ),
    "one missed, another doubled": (
        "keys",
        [result(empty(keys=Keys(100, 1, 1, 1)), "typing")],
        PASS,
    ),
    "no force reported": (
        "pressure error",
        [result(held(np.nan, "pressure", no_reading=1.0), "pressure")],
        NOT_MEASURED,
    ),
    "a feint with high confidence": ("difficult to see", [result(feinted(0.9), "awkward")], FAIL),
    "a feint with low confidence": ("difficult to see", [result(feinted(0.5), "awkward")], PASS),
    "no feint reported": ("difficult to see", [result(feinted(), "awkward")], PASS),
    "nothing difficult reported": (
        "difficult to see",
        [result(feinted(missed=True), "awkward")],
        NOT_MEASURED,
    ),
    "a palm with high confidence": (
        "difficult to see",
        [result(feinted(), "awkward"), result(empty(confidence=Confidence(5, 0, 1)), "chaos")],
        FAIL,
    ),
    "wrong where it is easy": (
        "difficult to see",
        [result(empty(confidence=Confidence(5, 0, 1)), "ten-fingers")],
        NOT_MEASURED,
    ),
    "a recording of feints": ("difficult to see", [result(feinted(0.9), "recording")], FAIL),
    "a stuck touch": ("stuck touches", [result(empty(behaviour=Behaviour(1)))], FAIL),
    "real taps": ("real people", [result(taps(), "labels-05_1")], PASS),
    "everybody calibrated": ("tables that could not", [result(taps())], PASS),
    "somebody refused": ("tables that could not", [result(None, refused="too far")], FAIL),
}


@pytest.mark.parametrize("figure, results, word", CASES.values(), ids=CASES.keys())
def test_each_goal_passes_or_fails(figure, results, word):
    assert line_of(figure, results).endswith(word)


def test_the_worst_family_is_named_though_the_mean_would_pass():
    fine, poor = replace(SUBJECT, family="sigmoid"), replace(SUBJECT, family="straight")
    results = [result(held(0.2), "hover", subject=fine)] * 9
    results.append(result(held(4.0), "hover-noise2", subject=poor))
    worst = line_of("hover error, worst", results)
    silent = "0 % without reading (sigmoid)"
    assert worst == f"4.00 mm (straight, doubled noise), {silent}, {FAIL}"


def test_a_family_without_a_reading_is_not_the_best():
    fine, poor = replace(SUBJECT, family="sigmoid"), replace(SUBJECT, family="straight")
    results = [
        result(held(0.5), "hover", subject=fine),
        result(held(np.nan, no_reading=1.0), "hover-noise2", subject=poor),
    ]
    worst = line_of("hover error, worst", results)
    silent = "100 % without reading (straight, doubled noise)"
    assert worst == f"0.50 mm (sigmoid), {silent}, {FAIL}"
    assert line_of("hover error, worst", results[:1]) == (
        f"0.50 mm (sigmoid), 0 % without reading (sigmoid), {PASS}"
    )
    assert line_of("hover error, worst", results[1:]) == NOT_MEASURED


def test_early_downs_are_reported_and_count_as_0_ms():
    line = line_of("contact", [result(taps(early=(0, 1, 2, 3)))])
    assert line == f"0 ms (p95 17), +0 frames, 67 % before contact, {PASS}"


def test_place_by_a_script_meets_no_goal():
    script = [{"step": "target", "from_s": 0.5, "to_s": 1.5, "target_mm": [100.0, 100.0]}]
    scores = score_script(published_frames(60, {20: [down(x_mm=104.0)]}), script, SURFACE)
    results = [result(scores, by_script=True)]
    assert line_of("spatial error of hits", results) == "4.0 ± 0.0 mm from the target"


def test_wrong_touches_are_shown_with_the_missed_and_the_right_ones():
    results = [
        result(feinted(0.9), "awkward"),
        result(feinted(0.5, missed=True), "awkward"),
        result(empty(confidence=Confidence(3, 1)), "chaos"),
        result(empty(confidence=Confidence(199, 1))),
    ]
    assert line_of("difficult to see", results) == f"1 / 1 of 7, 1 of 2 missed, {FAIL}"
    right = "right touches with high confidence"
    assert line_of(f"{right}: pointing", results) == "99.5 %"
    assert line_of(f"{right}: difficult", results) == "80.0 %"
    assert line_of(f"{right}: pointing", results[:1]) == NOT_MEASURED
    assert line_of(f"{right}: difficult", results[:1]) == "100.0 %"
    assert line_of(f"{right}: difficult", [result(empty())]) == NOT_MEASURED


def test_low_fingers_without_a_pointer_count_in_every_task_but_not_for_touch_only_methods():
    results = [
        result(
            empty(behaviour=Behaviour(pointers=90, without_pointer=10, fingers=100, hovering=80))
        ),
        result(empty(behaviour=Behaviour(pointers=10, without_pointer=90, fingers=100)), "chaos"),
    ]
    assert line_of("active low fingers", results) == "50.0 %"
    assert line_of("active low fingers", results[1:]) == NOT_MEASURED
    silent = result(empty(behaviour=Behaviour(without_pointer=100, fingers=100)))
    assert line_of("active low fingers", [silent]) == "100.0 %"
    hovering = result(empty(behaviour=Behaviour(pointers=5, hovering=5)))
    assert line_of("active low fingers", [hovering]) == NOT_MEASURED


def test_a_session_without_truth_has_no_confidence_figures():
    script = [{"step": "target", "from_s": 0.5, "to_s": 1.5, "target_mm": [100.0, 100.0]}]
    scores = score_script(published_frames(60, {20: [down(x_mm=115.0)]}), script, SURFACE)
    assert len(scores.touches.hits) == 1
    assert scores.confidence == Confidence()
    assert np.isnan(dict(figures(scores))["wrong_high_confidence"])


def test_difficult_touches_are_broken_down_by_difficulty():
    results = [
        result(feinted(0.9), "awkward"),
        result(feinted(0.5, missed=True), "awkward"),
        result(feinted(), "awkward", "paper"),
    ]
    tables = {table.title: table.rows for table in breakdown(results)}
    assert tables["Touches that are difficult to see"] == (
        ("pitch, 8°", "ours", "2", "1", "1", "1", "3.0 ± 0.0"),
        ("pitch, 8°", "paper", "1", "0", "0", "0", "3.0 ± 0.0"),
    )
    assert "Touches that are difficult to see" not in {t.title for t in breakdown([result(taps())])}
    rows = dict(figures(feinted(0.5)))
    assert {name: rows[name] for name in rows if name.startswith("angle")} == {
        "angle_recall_at_8_deg": 1.0,
        "angle_wrong_high_confidence_at_8_deg": 0,
        "angle_wrong_low_confidence_at_8_deg": 1,
        "angle_spatial_mean_mm_at_8_deg": pytest.approx(3.0),
    }
    names = "wrong_high_confidence", "wrong_low_confidence", "right_high_confidence_share"
    assert tuple(rows[name] for name in names) == (0, 1, 1.0)


def test_table_line_page_and_csv_show_the_same_median():
    early = taps(early=(0, 1, 2, 3))
    assert line_of("contact", [result(early)]).startswith("0 ms")
    assert "| 0 frames, 0 ms late |" in next(brief([result(early)]))
    assert "ours, median 0 ms" in page((result(early),), FACTS)
    assert dict(figures(early))["down_ms_median"] == 0.0


def test_the_share_of_early_downs_is_a_figure():
    rows = dict(figures(taps(early=(0, 1, 2, 3))))
    assert rows["down_before_contact_share"] == pytest.approx(2 / 3)
    assert rows["down_ms_median"] == 0.0
    assert np.isnan(dict(figures(empty()))["down_before_contact_share"])


ALL = replace(
    taps(early=(0, 1, 2, 3)),
    touches=pool(Touches, [taps(off_mm=off_mm).touches for off_mm in (1.0, 3.0)]),
    strikes=tuple(
        Speed(speed, true, 0.0) for speed, true in enumerate((10.0, 20.0, 30.0, 50.0, 40.0))
    ),
    velocities=tuple(Speed(speed, float(speed), 0.0) for speed in range(60, 65)),
    trials=tuple(Trial("hover", level, 1.0, -level, 0.0, 0.0) for level in (1.0, 3.0)),
    jumps=(Jump(10.0, 0.0), Jump(10.0, 4.0)),
    retaps=tuple(Retap(lift, reported) for lift, reported in ((1.0, False), (2.0, True))),
    phrases=(Phrase("table", Typed(20.0, 3, 1, 0), Typed(20.0, 4, 1, 0)),),
)
"""Two places, 1 and 3 mm from the true ones; and something for each other figure."""
ROWS = {
    "spatial_ellipse_long_mm": 2.0 * np.sqrt(5.991 * 12.0 / 11.0),
    "spatial_ellipse_short_mm": 0.0,
    "spatial_paper_method_mm": 1.0,
    "spatial_common_offset_mm": 2.0,
    "down_ms_p95": (at(5) - at(4.5)) / 1e3,
    "strike_rank_correlation": 0.9,
    "velocity_rank_correlation": 1.0,
    "hover_bias_mm_at_3_mm": -3.0,
    "hover_jump_largest_mm": 4.0,
    "least_lift_mm": 2.0,
    "awpm": 15.0,
    "perfect_awpm": 16.0,
    "perfect_uncorrected_share": 0.2,
}


@pytest.mark.parametrize("name, value", ROWS.items(), ids=ROWS.keys())
def test_what_the_tables_show_is_a_figure(name, value):
    assert dict(figures(ALL))[name] == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize("name", ["spatial_paper_method_mm", "spatial_ellipse_long_mm"])
def test_a_recording_without_a_hit_has_no_place(name):
    assert np.isnan(dict(figures(empty()))[name])


def test_csv_values_are_numbers():
    out = StringIO()
    write([result(ALL), result(empty()), result(taps(count=1))], "1.2.3", out)
    rows = list(DictReader(out.getvalue().splitlines()))
    assert {"least_lift_mm", "down_ms_p95"} <= {row["figure"] for row in rows}
    assert np.isfinite([float(row["value"]) for row in rows]).all()


@pytest.mark.parametrize("touches, word", [(1888, FAIL), (1920, PASS)])
def test_few_doubled_touches_are_allowed(touches, word):
    """Two of 3840, so one of 1920 and none of fewer."""
    one, none = taps(count=32, doubled=[3]), taps(count=32)
    results = [result(one)] + [result(none)] * (touches // 32 - 1)
    assert line_of("missed", results).endswith(word)


def test_every_figure_has_its_own_name():
    assert len({figure.name for figure in FIGURES}) == len(FIGURES)


def test_every_method_has_a_column_of_its_own_results():
    results = [result(taps()), result(taps(missed=[0]), method="paper")]
    table = goal_table(results)
    assert table.head == ("figure", "paper", "goal", "ours", "paper")
    (row,) = [row for row in table.rows if row[0].startswith("touch:")]
    assert (row[3].endswith(PASS), row[4].endswith(FAIL)) == (True, True)


def test_without_results_there_are_no_figures():
    assert goal_table(()).rows[0] == (GOALS[0].figure, GOALS[0].paper, GOALS[0].goal)
    assert breakdown(()) == ()


def test_a_breakdown_has_rows_by_material_and_method_and_the_refused_with_their_reason():
    foam = replace(SUBJECT, name="202-foam", material="foam")
    results = [
        result(taps()),
        result(taps(doubled=[1]), method="paper"),
        result(None, subject=foam, refused="the states overlap: press harder"),
    ]
    tables = {table.title: table.rows for table in breakdown(results)}
    touches = tables["Touches by material"]
    assert [row[:3] for row in touches] == [("wood", "ours", "6"), ("wood", "paper", "6")]
    assert [row[7] for row in touches] == ["0", "1"]
    refused = ("202-foam", "ours", "the states overlap: press harder")
    assert tables["Could not be calibrated"] == (refused,)


def test_a_breakdown_has_a_row_for_each_property_of_the_user_and_the_camera():
    facts = {"halo": "odd", "curl": 0.0, "mode": "WFOV_2X2BINNED", "device": "kinect"}
    near = replace(SUBJECT, skin_offset_mm=6.0, height_mm=350.0, **facts)
    far = replace(SUBJECT, skin_offset_mm=12.0, height_mm=1000.0, **(facts | {"halo": "bell"}))
    results = [result(taps(6), subject=near), result(taps(4, missed=(1,)), subject=far)]
    (table,) = (t for t in breakdown(results) if t.title == "By property of user and camera")
    rows = {row[0]: row[2:5] for row in table.rows}
    assert rows["halo: odd"] == ("6", "100.00", "0")
    assert rows["halo: bell"][2] == "1"
    assert rows["curl: below 0.2"][0] == rows["depth mode: WFOV_2X2BINNED"][0] == "10"
    assert list(rows).index("skin offset, mm: below 7") < list(rows).index(
        "skin offset, mm: from 11"
    )
    assert {"camera height, mm: below 450", "camera height, mm: from 800"} <= set(rows)
    unknown = breakdown([result(taps(6), subject=Subject("desk"))])
    assert all(t.title != "By property of user and camera" for t in unknown)


def test_places_have_mean_median_and_percentile():
    (table,) = (t for t in breakdown([result(ALL)]) if t.title == "Touches by material")
    row = dict(zip(table.head, table.rows[0], strict=True))
    assert (row["error, mm"], row["median p95, mm"]) == ("2.0 ± 1.0", "2.0 3.0")


def test_levels_have_an_error_and_a_bias_at_each_noise():
    results = [result(held(0.5), "hover"), result(held(0.7), "hover-noise2")]
    table = next(t for t in breakdown(results) if t.title == "Hover by level")
    assert table.rows == (("hover, 10 mm", "ours", "0.50 ± 0.00", "0.70 ± 0.00", "-0.50", "-0.70"),)


TABLE = Table("Title", ("what", "a|b"), (("one", "1"), ("longer", "22")), "Read so.")


def test_text_is_aligned_in_columns():
    assert as_text(TABLE).splitlines() == [
        "Title", "", "what    a|b", "------  ---", "one     1", "longer  22", "", "Read so.",
    ]  # fmt: skip


def test_markdown_escapes_the_column_separator():
    assert as_markdown(TABLE).splitlines()[2:6] == [
        "| what | a\\|b |", "| --- | --- |", "| one | 1 |", "| longer | 22 |",
    ]  # fmt: skip


class Reader(HTMLParser):
    """Collects what a page would load, and whether every tag is closed."""

    def __init__(self):
        super().__init__()
        self.loads, self.open, self.words = [], [], []

    def handle_starttag(self, tag, attributes):
        self.handle_startendtag(tag, attributes)
        if tag != "meta":
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.loads += [value for name, value in attributes if name in ("src", "href", "data")]

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


def everything():
    foam = Subject("202-foam", 202, "foam", "sigmoid")
    for method in ("ours", "paper"):
        yield result(taps(), method=method)
        yield result(held(0.5), "hover", method)
        yield result(held(0.7), "hover-noise2", method, foam)
        yield result(held(5.0, "pressure"), "pressure", method, foam)
        yield result(retapped({1.0: 50, 2.0: 100}), "threshold", method)
    yield result(None, method="ours", subject=foam, refused="too <b>far</b> & low")


def test_the_reliability_table_shows_the_share_of_right_touches_by_confidence():
    table = reliability_table([result(feinted(0.5), "awkward"), result(taps())])
    cells = dict(table.rows)
    assert table.head == ("confidence", "ours")
    assert cells == {"0.5 to 0.6": "0% of 1", "0.9 to 1": "100% of 7"}


def test_the_page_loads_nothing_and_closes_every_tag():
    reader = Reader()
    text = page(tuple(everything()), FACTS)
    reader.feed(text)
    assert (reader.loads, reader.open) == ([], [])
    assert "<script" not in text
    assert "url(" not in text
    assert "201 & 202" in reader.words
    assert any("too <b>far</b> & low" in words for words in reader.words)


def test_every_drawing_is_valid_and_has_a_description():
    text = page(tuple(everything()), FACTS)
    drawings = ["<svg" + part.split("</svg>")[0] + "</svg>" for part in text.split("<svg")[1:]]
    # A map of the one material, two clouds, the bars, two families of hover and one of pressure,
    # two histograms, the reliability and the re-taps.
    assert len(drawings) == 1 + 2 + 1 + 2 + 1 + 2 + 1 + 1
    for drawing in drawings:
        root = ElementTree.fromstring(drawing)
        assert root.get("aria-label")
        assert "nan" not in drawing


def test_the_same_results_give_the_same_page():
    assert page(tuple(everything()), FACTS) == page(tuple(everything()), FACTS)


def test_a_page_without_results_is_still_a_page():
    assert page((), {}).endswith("</html>\n")
