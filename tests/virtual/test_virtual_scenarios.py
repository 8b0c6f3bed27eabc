"""The scenarios: what happens in them is what they are for, and the truth is true of it."""

import itertools
from pathlib import Path

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.values import Finger, Side
from halo_service.virtual import truth
from halo_service.virtual.camera import factory
from halo_service.virtual.room import draw_room
from halo_service.virtual.scenarios import (
    ENDING,
    SCENARIOS,
    awkward,
    start_scenario,
    threshold,
    typing,
)
from halo_service.virtual.scenarios import labels as label_scenario
from halo_service.virtual.scenarios.study import FORCES_G, HEIGHTS_MM, targets
from halo_service.virtual.sim_url import parse_sim_url
from halo_type.phrases import PHRASES
from tests.kind_sensor import KIND_ROOM, KIND_URL

FINGER_FIELDS = "hand finger camera_mm height_mm touching force_g pitch_deg yaw_deg"
LABELS = "7,touchdown,100,100,1000000\n7,touchend,0,0,1000060\n8,touchdown,500,300,1000500\r\r\n"


def run(name, seconds, step_s=1 / 30):
    """Every snapshot, and the touches."""
    request = parse_sim_url(name + ("&" if "?" in name else "?") + KIND_URL)
    scenario = start_scenario(request.scenario, request.room)
    snapshots = [(t, scenario.at(t)) for t in np.arange(0.0, seconds, step_s)]
    return scenario, snapshots, scenario.ended_contacts(1e9)


def name_of(scenario, tmp_path):
    if scenario != "labels":
        return f"sim:{scenario}"
    (tmp_path / "labels.txt").write_text(LABELS)
    return f"sim:labels?labels={tmp_path / 'labels.txt'}"


@pytest.mark.parametrize("scenario", SCENARIOS)
def test_touches_and_pressing_fingers_agree(scenario, tmp_path):
    _, snapshots, contacts = run(name_of(scenario, tmp_path), 12.0, 0.05)
    pressed = {}
    for t, snapshot in snapshots:
        for hand, finger in itertools.product(snapshot.hands, Finger):
            if hand.force_g[finger] > 0.0:
                pressed.setdefault((hand.side, finger), []).append(t)
                assert hand.pad(finger)[2] >= -1e-6
            else:
                assert hand.pad(finger)[2] <= 1e-6
    for (side, finger), times in pressed.items():
        mine = [c for c in contacts if (c.side, c.finger) == (side, finger)]
        for t in times:
            assert any(c.from_s - 1e-6 <= t <= c.to_s + 1e-6 for c in mine)
    for contact in contacts:
        assert contact.to_s > contact.from_s
        assert contact.peak_force_g > 0.0
        assert contact.strike_mm_s > 0.0


@pytest.mark.parametrize("scenario", [s for s in SCENARIOS if s not in ("idle", "hand")])
def test_no_skin_goes_through_the_table(scenario, tmp_path):
    _, snapshots, _ = run(name_of(scenario, tmp_path), 30.0, 0.25)
    for _, snapshot in snapshots:
        for hand in snapshot.hands:
            in_view = hand.vertices[hand.vertices[:, 1] < 330.0]
            assert in_view[:, 2].max(initial=-1.0) < 3.0  # a pressed pad is flat: 2.6 mm


def test_the_demo_hovers_touches_and_presses_within_five_seconds():
    for seed in range(6):
        _, snapshots, contacts = run(f"sim:demo?seed={seed}", 5.0, 1 / 15)
        heights = [-snapshot.hands[0].pad(Finger.INDEX)[2] for _, snapshot in snapshots]
        assert any(4.0 < h < 15.0 for h in heights)
        assert len(contacts) >= 2
        assert max(max(snapshot.hands[0].force_g) for _, snapshot in snapshots) > 100.0


def test_an_idle_room_is_empty_and_so_is_a_hand_without_messages():
    for name in ("sim:idle", "sim:hand"):
        _, snapshots, contacts = run(name, 2.0)
        assert contacts == []
        assert all(snapshot.hands == () for _, snapshot in snapshots)


def test_pointing_visits_the_sixteen_targets_once_a_second():
    _, _, contacts = run("sim:pointing?seed=2", 56.0, 0.1)
    grid = targets()
    assert (min(grid), max(grid)) == ((75.0, 25.0), (225.0, 175.0))
    regular, swift = contacts[:16], contacts[16:32]
    for part, low, high in ((regular, 0.3, 0.6), (swift, 0.1, 0.3)):
        assert sorted(c.target_mm for c in part) == sorted(grid)
        assert all(low <= c.to_s - c.from_s <= high for c in part)
    misses = [np.hypot(c.x_mm - c.target_mm[0], c.y_mm - c.target_mm[1]) for c in contacts]
    assert max(misses) < 12.0
    assert np.median(np.diff([c.from_s for c in contacts])) == pytest.approx(1.4, abs=0.2)


@pytest.mark.parametrize(
    "scenario, field, levels",
    [("hover", "height_mm", HEIGHTS_MM), ("pressure", "force_g", FORCES_G)],
)
def test_the_study_holds_each_level_twice(scenario, field, levels):
    running, snapshots, _ = run(f"sim:{scenario}?seed=3", 60.0, 0.1)
    assert running.finished
    assert sorted(s.fields[field] for s in running.steps) == sorted(2 * list(levels))
    for step in running.steps:
        within = [snapshot.hands[0] for t, snapshot in snapshots if step.from_s <= t <= step.to_s]
        if scenario == "hover":
            values = [-hand.pad(Finger.INDEX)[2] for hand in within]
        else:
            values = [hand.force_g[Finger.INDEX] for hand in within]
        assert np.mean(values) == pytest.approx(step.fields[field], rel=0.06)


@pytest.mark.parametrize(
    ("scenario", "hard"), [("calibration", []), ("calibration-hard", ["hard"])]
)
def test_calibration_follows_the_script_that_it_reports(scenario, hard):
    running, snapshots, _ = run(f"sim:{scenario}?seed=4", 48.0, 0.1)
    assert running.finished
    names = [step.name for step in running.steps]
    assert names == ["background", "hover", "subtle", "touch", "pressure", *hard, "sweep"]
    assert all(a.to_s <= b.from_s for a, b in itertools.pairwise(running.steps))
    room = parse_sim_url(f"sim:calibration?seed=4&{KIND_URL}").room
    for step in running.steps:
        within = [snapshot for t, snapshot in snapshots if step.from_s <= t < step.to_s]
        hands = [snapshot.hands[0] for snapshot in within]
        pads = np.array([hand.pad(Finger.INDEX) for hand in hands])
        if step.name == "background":
            assert len(within) >= 25
            assert pads[:, 1].min() > 0.5 * room.camera_height_mm  # out of view
        if step.name in ("hover", "subtle"):
            assert np.mean(-pads[:, 2]) == pytest.approx(step.fields["height_mm"], abs=0.4)
        if step.name in ("touch", "pressure", "hard"):
            forces = [hand.force_g[Finger.INDEX] for hand in hands]
            assert np.mean(forces) == pytest.approx(step.fields["force_g"], rel=0.05)
        if step.name == "sweep":
            assert all(len(snapshot.things) == 1 for snapshot in within)  # the wedge
            assert np.ptp(pads[:, 0]) > 240.0
            assert np.ptp(pads[:, 1]) > 140.0
            pitches = [hand.pitch_yaw(Finger.INDEX)[0] for hand in hands]
            assert np.mean(pitches) == pytest.approx(45.0, abs=1.5)


def test_typed_keys_spell_phrases_and_mostly_lie_inside():
    _, snapshots, contacts = run("sim:typing?seed=2", 50.0, 0.2)
    text = "".join(c.key for c in contacts)
    assert any(phrase in text for phrase in PHRASES)
    layout = typing.keys()
    inside = [layout[c.key].inside(c.x_mm, c.y_mm) for c in contacts]
    assert np.mean(np.array(inside) > 0.0) > 0.98
    assert {c.side for c in contacts} == {Side.LEFT, Side.RIGHT}
    gaps = np.diff([c.from_s for c in contacts])
    assert np.median(gaps) == pytest.approx(0.45, abs=0.08)
    tips = [[h.pad(Finger.INDEX)[0] for h in snapshot.hands] for _, snapshot in snapshots[25:]]
    assert min(right - left for left, right in tips) > 5.0  # hands do not cross


def test_a_finger_has_time_for_two_keys_in_quick_succession():
    """Of this user, the same finger strikes two keys in the shortest time, the first one held."""
    _, _, contacts = run("sim:typing-fast?seed=203", 34.0, 0.5)
    assert len(contacts) > 30
    for style in (typing.ACCURATE, typing.BALANCED, typing.FAST):
        assert style.hold_s < style.longest_hold_s <= 0.15


def test_typing_styles_trade_speed_for_aim():
    pace, scatter = {}, {}
    for name in ("typing-accurate", "typing", "typing-fast"):
        _, _, contacts = run(f"sim:{name}?seed=2", 40.0, 2.0)
        pace[name] = np.median(np.diff([c.from_s for c in contacts]))
        aims = [np.subtract((c.x_mm, c.y_mm), c.target_mm) for c in contacts]
        scatter[name] = np.std(aims)
    assert sorted(pace, key=pace.get) == ["typing-fast", "typing", "typing-accurate"]
    assert sorted(scatter, key=scatter.get) == ["typing-accurate", "typing", "typing-fast"]


def test_re_taps_rise_by_what_their_step_says():
    running, _, contacts = run("sim:threshold?seed=2", 50.0, 0.4)
    assert running.finished
    lifts = sorted(step.fields["lift_mm"] for step in running.steps)
    assert lifts == sorted(threshold.LIFTS_MM * threshold.ROUNDS)
    assert len(contacts) == len(lifts) + threshold.ROUNDS
    for step in running.steps:
        assert sum(step.from_s <= c.from_s <= step.to_s for c in contacts) == 1
    running, snapshots, _ = run("sim:threshold?seed=2", 8.0, 0.02)
    assert len(running.steps) >= len(threshold.LIFTS_MM)
    for step in running.steps:
        within = [snapshot.hands[0] for t, snapshot in snapshots if step.from_s <= t <= step.to_s]
        risen = max(-hand.pad(Finger.INDEX)[2] for hand in within)
        assert risen == pytest.approx(step.fields["lift_mm"], abs=0.5)


def test_awkward_touches_are_as_their_steps_say_and_each_follows_a_feint():
    running, snapshots, contacts = run("sim:awkward?seed=2", 60.0)
    assert running.finished
    edge = (150.0, 100.0)  # half the surface's size: as far as its edges are from its middle
    for step in running.steps:
        (touch,) = (c for c in contacts if step.from_s <= c.from_s <= step.to_s)
        before = [s.hands[0] for t, s in snapshots if step.from_s + 0.6 <= t < touch.from_s - 0.2]
        assert min(-hand.pad(Finger.INDEX)[2] for hand in before) == pytest.approx(4.0, abs=0.8)
        if step.name == "angle":
            hand = next(s.hands[0] for t, s in snapshots if t >= touch.from_s)
            pitch, _ = hand.pitch_yaw(Finger.INDEX)
            assert pitch == pytest.approx(step.fields["pitch_deg"], abs=4.0)
        else:
            off = np.abs((touch.x_mm - edge[0], touch.y_mm - edge[1])) - edge
            assert max(off) == pytest.approx(step.fields["beyond_mm"], abs=2.0)
    reported = [(step.name, *step.fields.values()) for step in running.steps]
    expected = [("angle", each) for each in awkward.PITCHES_DEG]
    expected += [("edge", each) for each in awkward.BEYOND_MM]
    assert sorted(reported) == sorted(expected * awkward.ROUNDS)


def test_ten_fingers_all_touch():
    _, _, contacts = run("sim:ten-fingers?seed=2", 20.0, 0.1)
    assert {(c.side, c.finger) for c in contacts} == set(
        itertools.product((Side.LEFT, Side.RIGHT), Finger)
    )


def test_one_hand_drums_while_the_other_hovers():
    room = draw_room(3, **KIND_ROOM)
    _, snapshots, contacts = run("sim:drumming?seed=3", 20.0, 0.1)
    assert {c.side for c in contacts} == {room.dominant}
    assert len(contacts) > 15
    idle = [h for _, snapshot in snapshots for h in snapshot.hands if h.side is not room.dominant]
    heights = [-hand.pad(Finger.INDEX)[2] for hand in idle[70:]]
    assert min(heights) > 0.0
    assert np.ptp(heights) > 30.0


def test_palms_and_fists_of_chaos_touch_nothing():
    room = draw_room(5, **KIND_ROOM)
    _, snapshots, contacts = run("sim:chaos?seed=5", 40.0, 0.1)
    assert {c.side for c in contacts} == {room.dominant}
    assert any(snapshot.things for _, snapshot in snapshots)
    lowest = [
        hand.vertices[:, 2].max()
        for _, snapshot in snapshots
        for hand in snapshot.hands
        if hand.side is not room.dominant
    ]
    assert max(lowest) > -1.0  # they do lie on the table


def test_a_label_files_touches_begin_and_end_when_they_did(tmp_path):
    name = name_of("labels", tmp_path)
    _, _, contacts = run(name, 8.0)
    assert [round(c.to_s - c.from_s, 3) for c in contacts] == [0.06, label_scenario.LEAST_S]
    assert contacts[1].from_s - contacts[0].from_s == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize(
    "person, playable",
    [("07_1_3", 1.0), ("05_1_1", 1.0), ("06_2", 1.0), ("05_3_2", 1.0), ("06_5", 0.6)],
)
def test_touches_of_real_people_can_be_replayed(company_data, person, playable):
    path = company_data / "touch_labels" / f"{person}.txt"
    touches = label_scenario.read(path)
    assert len(touches) > 30
    _, _, contacts = run(f"sim:labels?labels={path}", 40.0, 0.2)
    reported = [label for label in touches if label.to_s < 39.0]
    # The last file is of many fingers at once, and only two play here.
    assert len(contacts) >= playable * len(reported)
    starts = {round(label.from_s, 6) for label in touches}
    assert {round(c.from_s, 6) for c in contacts} <= starts
    for contact in contacts:
        assert 25.0 <= contact.x_mm <= 275.0
        assert 25.0 <= contact.y_mm <= 175.0


@pytest.mark.parametrize(
    "text, sentence",
    [("", "holds no touches"), ("a,b\n", "holds no touches"), (None, "cannot be read")],
)
def test_a_label_file_without_touches_is_rejected(tmp_path, text, sentence):
    path = tmp_path / "labels.txt"
    if text is not None:
        path.write_text(text)
    with pytest.raises(UserError, match=sentence):
        label_scenario.read(Path(path))
    with pytest.raises(UserError, match="needs a file"):
        start_scenario("labels", draw_room(1, **KIND_ROOM))


def test_a_controlled_finger_follows_its_messages():
    scenario = start_scenario("hand", draw_room(2, **KIND_ROOM))
    scenario.send((2, 1, 80.0, 60.0, 12.0, 0.0))
    (hand,) = scenario.at(0.1).hands
    assert hand.pad(Finger.INDEX) == pytest.approx([80.0, 60.0, -12.0])
    scenario.send((1, 1, 200.0, 60.0, 5.0, 90.0))
    left = next(h for h in scenario.at(0.2).hands if h.side is Side.LEFT)
    assert left.force_g[Finger.INDEX] == 90.0
    assert left.pad(Finger.INDEX)[2] > 0.0
    scenario.send((2, 1, 0.0, 0.0, -1.0, 0.0))
    assert [h.side for h in scenario.at(0.3).hands] == [Side.LEFT]


@pytest.mark.parametrize(
    "message",
    [None, "index", (), (2, 1, 0, 0, 0), (0, 1, 0, 0, 0, 0), (3, 1, 0, 0, 0, 0), (2, 9, 0, 0, 0, 0),
     (2, 1, float("nan"), 0, 0, 0), (2, 1, 1e9, 0, 0, 0), (2, 1, 0, 0, 0, -5), (2, 1, 0, 0, 0, 1e9),
     (2, 1, "x", 0, 0, 0)],
)  # fmt: skip
def test_an_invalid_message_moves_no_finger(message):
    scenario = start_scenario("hand", draw_room(2, **KIND_ROOM))
    with pytest.raises(UserError):
        scenario.send(message)
    assert scenario.at(0.1).hands == ()


def test_endings_are_what_the_table_says(tmp_path):
    for scenario in SCENARIOS:
        running, _, _ = run(name_of(scenario, tmp_path), 60.0, 1.75)  # the last look is at 59.5 s
        assert running.finished == (scenario in ENDING), scenario


def test_a_line_of_truth_has_the_documented_fields():
    room = draw_room(1, **KIND_ROOM)
    scenario = start_scenario("demo", room)
    surface = room.surface()
    for t in np.arange(0.0, 6.0, 1 / 30):
        snapshot = scenario.at(t)
        line = truth.frame_line(7, factory(), surface, snapshot.hands)
        for finger in line["fingers"]:
            assert " ".join(finger) == FINGER_FIELDS
            on_surface = surface.from_camera(np.array([finger["camera_mm"]]))[0]
            assert -on_surface[2] == pytest.approx(finger["height_mm"], abs=0.01)
            assert finger["touching"] == (finger["force_g"] > 0.0)
            assert not finger["touching"] or finger["height_mm"] == 0.0
    (first, *_) = scenario.ended_contacts(6.0)
    line = truth.contact_line(first, surface, lambda s: 500_000 + round(s * 1e6))["contact"]
    assert line["from_us"] == 500_000 + round(first.from_s * 1e6)
    assert {"hand", "finger", "to_us", "camera_mm", "strike_mm_s", "peak_force_g"} <= set(line)
