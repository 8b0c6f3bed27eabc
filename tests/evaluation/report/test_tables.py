"""Tables and page: who falls short is told so, and so is what nobody measured."""

import xml.etree.ElementTree as ElementTree
from csv import DictReader
from dataclasses import replace
from html.parser import HTMLParser
from io import StringIO

import numpy as np
import pytest

from halo_service.evaluation.metrics.behaviour import Conduct
from halo_service.evaluation.metrics.confidence import Sureness
from halo_service.evaluation.metrics.keystrokes import Keys, Phrase
from halo_service.evaluation.metrics.levels import Jump, Trial
from halo_service.evaluation.metrics.result import Result, Subject
from halo_service.evaluation.metrics.retaps import Retap
from halo_service.evaluation.metrics.scores import score
from halo_service.evaluation.metrics.scripted import score_asked
from halo_service.evaluation.metrics.speeds import Speed
from halo_service.evaluation.metrics.touches import pooled
from halo_service.evaluation.report.breakdown import breakdown
from halo_service.evaluation.report.brief import brief
from halo_service.evaluation.report.csv_rows import figures, write
from halo_service.evaluation.report.goals import GOALS, NOT_MEASURED, PASS, SHORT, goal_table
from halo_service.evaluation.report.page import page
from halo_service.evaluation.report.table import Table, as_markdown, as_text
from halo_type.metrics import Typed
from tests.evaluation.small_world import (
    SURFACE,
    at,
    contact,
    down,
    finger,
    pointer,
    told_frames,
    truth_frames,
    up,
)

SUBJECT = Subject("201-wood", 201, "wood", "straight")
FACTS = {"command": "halo evaluate", "users": "201 & 202"}


def taps(count=6, missed=(), doubled=(), off_mm=1.0, early=()):
    """Scores of so many touches of targets, told 1 mm off in their first frame or one early."""
    lines, events, fingers = [], {}, {}
    for k in range(count):
        begin = 12 * k + 5
        aim = [80.0 + 20.0 * (k % 3), 60.0 + 40.0 * (k // 3)]
        lines.append(contact(begin - 0.5, begin + 5, *aim, target_mm=aim))
        fingers |= {frame: [finger(*aim)] for frame in range(begin, begin + 6)}
        if k not in missed:
            told = begin - (k in early)
            events[told] = [down(x_mm=aim[0] + off_mm, y_mm=aim[1], strike_mm_s=180.0)]
            events[begin + 6] = [up()]
        if k in doubled:
            events[begin + 3] = [down(x_mm=aim[0], y_mm=aim[1])]
    frames = 12 * count + 10
    return score(told_frames(frames, events), [*truth_frames(frames, fingers), *lines], (), SURFACE)


def empty(**more):
    """Scores of a take in which nobody touched."""
    return replace(score(told_frames(5), truth_frames(5), (), SURFACE), **more)


def feinted(ghost=None, missed=False):
    """Scores of a flat feint, told with the confidence `ghost`, and of the touch after it."""
    downs = ({} if ghost is None else {5: [down()]}) | ({} if missed else {12: [down(x_mm=103.0)]})
    told = told_frames(30, downs, {5: [pointer(confidence=1.0 if ghost is None else ghost)]})
    script = [{"step": "angle", "pitch_deg": 8.0, "from_s": 0.0, "to_s": 1.0}]
    return score(told, [*truth_frames(30), contact(11.5, 15)], script, SURFACE)


def result(scores, task="pointing", method="ours", subject=SUBJECT, refused="", asked=False):
    return Result(subject, task, method, scores, refused, asked=asked)


def held(error, kind="hover", unseen=0.0):
    return empty(trials=(Trial(kind, 10.0, error, -error, 10.0 - error, unseen),))


def retapped(told):
    return empty(retaps=tuple(Retap(lift, k < n) for lift, n in told.items() for k in range(100)))


def line_of(figure, results):
    table = goal_table(results)
    return next(row for row in table.rows if row[0].startswith(figure))[3]


CASES = {
    "every touch told": ("touch:", [result(taps())], PASS),
    "one missed": ("touch:", [result(taps(missed=[2]))], SHORT),
    "none missed": ("missed", [result(taps())], PASS),
    "one doubled of a few": ("missed", [result(taps(doubled=[1]))], SHORT),
    "no touch at all": ("touch:", [result(empty())], NOT_MEASURED),
    "near": ("spatial error of hits", [result(taps(off_mm=2.9))], PASS),
    "far": ("spatial error of hits", [result(taps(off_mm=3.1))], SHORT),
    "in the first frame": ("contact", [result(taps())], PASS),
    "hover within": ("hover error", [result(held(0.9), "hover")], PASS),
    "hover beyond": ("hover error", [result(held(1.1), "hover")], SHORT),
    "hover told too rarely": ("hover error", [result(held(0.1, unseen=0.1), "hover")], SHORT),
    "noise is judged apart": ("hover error", [result(held(9.0), "hover-noise2")], NOT_MEASURED),
    "pressure within": ("pressure error", [result(held(7.0, "pressure"), "pressure")], PASS),
    "re-taps of 2 mm": ("touch point", [result(retapped({2.0: 99}), "threshold")], PASS),
    "re-taps of 3 mm": ("touch point", [result(retapped({2.0: 98, 3.0: 100}), "threshold")], SHORT),
    "no re-tap told": ("touch point", [result(retapped({6.0: 0}), "threshold")], SHORT),
    "a key in 100": ("keys", [result(empty(keys=Keys(100, 1)), "typing")], PASS),
    "two keys in 100": ("keys", [result(empty(keys=Keys(100, 2)), "typing-fast")], SHORT),
    "right, but two in 100 missed": (
        "keys",
        [result(empty(keys=Keys(100, 0, missed=2)), "typing")],
        SHORT,
    ),
    "right, but two in 100 doubled": (
        "keys",
        [result(empty(keys=Keys(100, 0, doubled=2)), "typing")],
        SHORT,
    ),
    "one missed, another doubled": (
        "keys",
        [result(empty(keys=Keys(100, 1, 1, 1)), "typing")],
        PASS,
    ),
    "nobody says how hard": (
        "pressure error",
        [result(held(np.nan, "pressure", unseen=1.0), "pressure")],
        NOT_MEASURED,
    ),
    "a feint told surely": ("hard to see", [result(feinted(0.9), "awkward")], SHORT),
    "a feint told in doubt": ("hard to see", [result(feinted(0.5), "awkward")], PASS),
    "no feint told": ("hard to see", [result(feinted(), "awkward")], PASS),
    "nothing told that is hard to see": (
        "hard to see",
        [result(feinted(missed=True), "awkward")],
        NOT_MEASURED,
    ),
    "a palm told surely": (
        "hard to see",
        [result(feinted(), "awkward"), result(empty(sureness=Sureness(5, 0, 1)), "chaos")],
        SHORT,
    ),
    "told wrongly where it is easy": (
        "hard to see",
        [result(empty(sureness=Sureness(5, 0, 1)), "ten-fingers")],
        NOT_MEASURED,
    ),
    "a recording of feints": ("hard to see", [result(feinted(0.9), "recording")], SHORT),
    "a stuck touch": ("touches that stick", [result(empty(conduct=Conduct(1)))], SHORT),
    "real taps": ("real people", [result(taps(), "labels-05_1")], PASS),
    "everybody calibrated": ("tables that could not", [result(taps())], PASS),
    "somebody refused": ("tables that could not", [result(None, refused="too far")], SHORT),
}


@pytest.mark.parametrize("figure, results, word", CASES.values(), ids=CASES.keys())
def test_each_goal_says_whether_it_is_met(figure, results, word):
    assert line_of(figure, results).endswith(word)


def test_the_worst_family_is_named_though_the_mean_would_pass():
    fine, poor = replace(SUBJECT, family="sigmoid"), replace(SUBJECT, family="straight")
    results = [result(held(0.2), "hover", subject=fine)] * 9
    results.append(result(held(4.0), "hover-noise2", subject=poor))
    told = line_of("hover error, worst", results)
    assert told == f"4.00 mm (straight, doubled noise), {SHORT}"


def test_a_family_for_which_nothing_is_told_is_not_the_best():
    fine, poor = replace(SUBJECT, family="sigmoid"), replace(SUBJECT, family="straight")
    results = [
        result(held(0.5), "hover", subject=fine),
        result(held(np.nan, unseen=1.0), "hover-noise2", subject=poor),
    ]
    told = line_of("hover error, worst", results)
    assert told == f"0.50 mm (sigmoid), 100 % unseen (straight, doubled noise), {SHORT}"
    assert line_of("hover error, worst", results[:1]) == f"0.50 mm (sigmoid), {PASS}"
    assert line_of("hover error, worst", results[1:]) == NOT_MEASURED


def test_downs_before_their_contact_are_told_and_make_nothing_faster():
    told = line_of("contact", [result(taps(early=(0, 1, 2, 3)))])
    assert told == f"0 ms (p95 17), +0 frames, 67 % told before contact, {PASS}"


def test_place_by_what_was_asked_for_meets_no_goal():
    script = [{"step": "target", "from_s": 0.5, "to_s": 1.5, "target_mm": [100.0, 100.0]}]
    scores = score_asked(told_frames(60, {20: [down(x_mm=104.0)]}), script, SURFACE)
    results = [result(scores, asked=True)]
    assert line_of("spatial error of hits", results) == "4.0 ± 0.0 mm from the target"


def test_tracker_thread_what_was_told_wrongly_stands_what_was_missed_and_how_much_else_is_doubted():
    results = [
        result(feinted(0.9), "awkward"),
        result(feinted(0.5, missed=True), "awkward"),
        result(empty(sureness=Sureness(3, 1)), "chaos"),
        result(empty(sureness=Sureness(199, 1))),
    ]
    assert line_of("hard to see", results) == f"1 / 1 of 7, 1 of 2 missed, {SHORT}"
    assert line_of("right touches told surely", results) == "99.5 / 80.0 %"
    assert line_of("right touches told surely", results[:1]) == "- / 100.0 %"
    assert line_of("right touches told surely", [result(empty())]) == NOT_MEASURED


def test_a_low_finger_without_a_pointer_is_told_of_every_task_but_of_who_tells_touches_alone():
    results = [
        result(empty(conduct=Conduct(pointers=90, unseen=10, fingers=100, aloft=80))),
        result(empty(conduct=Conduct(pointers=10, unseen=90, fingers=100)), "chaos"),
    ]
    assert line_of("low fingers that play", results) == "50.0 %"
    assert line_of("low fingers that play", results[1:]) == NOT_MEASURED
    silent = result(empty(conduct=Conduct(unseen=100, fingers=100)))
    assert line_of("low fingers that play", [silent]) == "100.0 %"
    nobody = result(empty(conduct=Conduct(pointers=5, aloft=5)))
    assert line_of("low fingers that play", [nobody]) == NOT_MEASURED


def test_a_session_without_truth_tells_nothing_of_sureness():
    script = [{"step": "target", "from_s": 0.5, "to_s": 1.5, "target_mm": [100.0, 100.0]}]
    scores = score_asked(told_frames(60, {20: [down(x_mm=115.0)]}), script, SURFACE)
    assert len(scores.touches.hits) == 1
    assert scores.sureness == Sureness()
    assert "wrong_surely" not in dict(figures(scores))


def test_what_is_hard_to_see_is_told_by_how_hard_it_is():
    results = [
        result(feinted(0.9), "awkward"),
        result(feinted(0.5, missed=True), "awkward"),
        result(feinted(), "awkward", "paper"),
    ]
    tables = {table.title: table.rows for table in breakdown(results)}
    assert tables["Touches that are hard to see"] == (
        ("pitch, 8°", "ours", "2", "1", "1", "1", "1", "3.0 ± 0.0"),
        ("pitch, 8°", "paper", "1", "1", "0", "0", "0", "3.0 ± 0.0"),
    )
    assert "Touches that are hard to see" not in {t.title for t in breakdown([result(taps())])}
    rows = dict(figures(feinted(0.5)))
    assert {name: rows[name] for name in rows if name.startswith("angle")} == {
        "angle_told_share_at_8_deg": 1.0,
        "angle_wrong_surely_at_8_deg": 0,
        "angle_wrong_unsurely_at_8_deg": 1,
        "angle_off_mm_at_8_deg": pytest.approx(3.0),
    }
    assert (rows["wrong_surely"], rows["wrong_unsurely"], rows["right_surely_share"]) == (0, 1, 1.0)


def test_table_line_page_and_rows_tell_one_and_the_same_median():
    early = taps(early=(0, 1, 2, 3))
    assert line_of("contact", [result(early)]).startswith("0 ms")
    assert "| 0 frames, 0 ms late |" in next(brief([result(early)]))
    assert "ours, median 0 ms" in page((result(early),), FACTS)
    assert dict(figures(early))["down_ms_median"] == 0.0


def test_the_rows_say_how_many_downs_came_before_their_contact():
    rows = dict(figures(taps(early=(0, 1, 2, 3))))
    assert rows["down_before_contact_share"] == pytest.approx(2 / 3)
    assert rows["down_ms_median"] == 0.0
    assert dict(figures(empty()))["down_before_contact_share"] is None


ALL = replace(
    taps(early=(0, 1, 2, 3)),
    touches=pooled([taps(off_mm=off_mm).touches for off_mm in (1.0, 3.0)]),
    strikes=tuple(
        Speed(told, true, 0.0) for told, true in enumerate((10.0, 20.0, 30.0, 50.0, 40.0))
    ),
    velocities=tuple(Speed(told, float(told), 0.0) for told in range(60, 65)),
    trials=tuple(Trial("hover", level, 1.0, -level, 0.0, 0.0) for level in (1.0, 3.0)),
    jumps=(Jump(10.0, 0.0), Jump(10.0, 4.0)),
    retaps=tuple(Retap(lift, told) for lift, told in ((1.0, False), (2.0, True))),
    phrases=(Phrase("table", Typed(20.0, 3, 1, 0), Typed(20.0, 4, 1, 0)),),
)
"""Two places, 1 and 3 mm from where they were; and something of all else that has a row."""
ROWS = {
    "spatial_ellipse_long_mm": 2.0 * np.sqrt(5.991 * 12.0 / 11.0),
    "spatial_ellipse_short_mm": 0.0,
    "spatial_as_the_paper_mm": 1.0,
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
def test_what_the_tables_tell_is_in_the_rows_too(name, value):
    assert dict(figures(ALL))[name] == pytest.approx(value, abs=1e-9)


@pytest.mark.parametrize("name", ["spatial_as_the_paper_mm", "spatial_ellipse_long_mm"])
def test_a_take_without_a_hit_has_no_row_of_place(name):
    assert name not in dict(figures(empty()))


def test_rows_hold_numbers_alone():
    out = StringIO()
    write([result(ALL), result(empty()), result(taps(count=1))], "1.2.3", out)
    rows = list(DictReader(out.getvalue().splitlines()))
    assert {"least_lift_mm", "down_ms_p95"} <= {row["figure"] for row in rows}
    assert np.isfinite([float(row["value"]) for row in rows]).all()


@pytest.mark.parametrize("touches, word", [(1888, SHORT), (1920, PASS)])
def test_doubled_touches_are_allowed_as_often_as_the_goal_says(touches, word):
    """Two of 3840, so one of 1920 and none of fewer."""
    one, none = taps(count=32, doubled=[3]), taps(count=32)
    results = [result(one)] + [result(none)] * (touches // 32 - 1)
    assert line_of("missed", results).endswith(word)


def test_every_method_has_a_column_of_its_own_results():
    results = [result(taps()), result(taps(missed=[0]), method="paper")]
    table = goal_table(results)
    assert table.head == ("figure", "paper", "goal", "ours", "paper")
    (row,) = [row for row in table.rows if row[0].startswith("touch:")]
    assert (row[3].endswith(PASS), row[4].endswith(SHORT)) == (True, True)


def test_no_results_are_no_figures():
    assert goal_table(()).rows[0] == (GOALS[0].figure, GOALS[0].paper, GOALS[0].goal)
    assert breakdown(()) == ()


def test_a_breakdown_has_a_row_a_material_and_method_and_the_refused_with_their_sentence():
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


def test_places_are_told_by_mean_median_and_percentile():
    (table,) = (t for t in breakdown([result(ALL)]) if t.title == "Touches by material")
    told = dict(zip(table.head, table.rows[0], strict=True))
    assert (told["off by, mm"], told["median p95, mm"]) == ("2.0 ± 1.0", "2.0 3.0")


def test_levels_are_told_one_by_one_with_their_bias_and_by_noise():
    results = [result(held(0.5), "hover"), result(held(0.7), "hover-noise2")]
    table = next(t for t in breakdown(results) if t.title == "Hover and pressure by level")
    assert table.rows == (("hover, 10 mm", "ours", "0.50 ± 0.00", "-0.50", "0.70 ± 0.00", "-0.70"),)


TABLE = Table("Title", ("what", "a|b"), (("one", "1"), ("longer", "22")), "Read so.")


def test_text_stands_in_columns():
    assert as_text(TABLE).splitlines() == [
        "Title", "", "what    a|b", "------  ---", "one     1", "longer  22", "", "Read so.",
    ]  # fmt: skip


def test_markdown_keeps_its_columns_whatever_is_in_them():
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


def test_the_page_is_complete_in_itself_and_whole():
    reader = Reader()
    text = page(tuple(everything()), FACTS)
    reader.feed(text)
    assert (reader.loads, reader.open) == ([], [])
    assert "<script" not in text
    assert "url(" not in text
    assert "201 & 202" in reader.words
    assert any("too <b>far</b> & low" in words for words in reader.words)


def test_every_drawing_is_sound_and_says_what_it_shows():
    text = page(tuple(everything()), FACTS)
    drawings = ["<svg" + part.split("</svg>")[0] + "</svg>" for part in text.split("<svg")[1:]]
    # A map of the one material, two clouds, the bars, two families of hover and one of pressure,
    # two histograms and the re-taps.
    assert len(drawings) == 1 + 2 + 1 + 2 + 1 + 2 + 1
    for drawing in drawings:
        root = ElementTree.fromstring(drawing)
        assert root.get("aria-label")
        assert "nan" not in drawing


def test_the_same_results_give_the_same_page():
    assert page(tuple(everything()), FACTS) == page(tuple(everything()), FACTS)


def test_a_page_of_nothing_is_still_a_page():
    assert page((), {}).endswith("</html>\n")
