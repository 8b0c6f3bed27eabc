"""Each stage by itself."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from halo_service.geometry.surface import Surface, line_of_sight_deg
from halo_service.profile import Background, Correction, Profile, TouchStates
from halo_service.sensing.background import Drift, excess_depth, follow_drift
from halo_service.sensing.contact import CONTACT_LEVEL, Evidence, contact_probability, evidence
from halo_service.sensing.correction import leveled_top
from halo_service.sensing.debounce import Debounce, debounce
from halo_service.sensing.detector import Detector, detect
from halo_service.sensing.extraction import FREE_PX, LEAST_FREE_PX, extract
from halo_service.sensing.hover import hover_height, own_height
from halo_service.sensing.pressure import force, read_force, touch_force, touch_pressure
from halo_service.sensing.segmentation import segment
from halo_service.sensing.settings import SensingSettings
from halo_service.sensing.states import interpolate, span
from halo_service.values import Finger, Fingertip, Side, Signal

SETTINGS = SensingSettings()
NAN = math.nan
FRAME_US = 33_333


def tip_at(x: float, y: float, top_mm: float = 14.0) -> Fingertip:
    return Fingertip(
        Side.RIGHT, Finger.INDEX, (x, y), (x, y + 25), (0, 0), (0, 0, 500), top_mm, 45, 0, 1
    )


NOISE = (1e6, 0.1, 0.1, 0.1)
"""The sum is too noisy to count."""


def read(total: float, dent_mm: float) -> tuple[float, ...]:
    return total, dent_mm, 0.6 * dent_mm, 0.3 * dent_mm


def signal(dent_mm: float, total: float = 0.0) -> Signal:
    return Signal(total, total, read(total, dent_mm))


def own(seen: Signal, tip: Fingertip, by_place_mm: float = 1.0) -> Signal:
    """The same with the finger's own depth, at the place of the calibration."""
    return replace(seen, top_mm=leveled_top(tip, None).height_mm, top_deviation_mm=by_place_mm)


@pytest.fixture
def dented(profile: Profile) -> TouchStates:
    """The drawn states with all their readings: the sum, and three depths of the same halo."""
    assert profile.touch is not None
    dents = {"hover": 5.0, "subtle": 10.0, "touch": 11.0, "pressure": 15.0}
    states = profile.touch
    held = {
        name: replace(
            getattr(states, name), readings=read(getattr(states, name).signal, dent), noise=NOISE
        )
        for name, dent in dents.items()
    }
    return replace(states, **held)


@pytest.mark.parametrize(
    ("depth_mm", "valid", "expected"),
    [(512, True, 12.0), (490, True, -10.0), (0, True, 0.0), (512, False, 0.0), (500, True, 0.0)],
)
def test_excess_is_depth_less_background_and_nothing_where_nothing_was_measured(
    depth_mm: int, valid: bool, expected: float
) -> None:
    background = Background(
        np.full((2, 2), 500.0, np.float32), np.ones((2, 2), np.float32), np.full((2, 2), valid)
    )
    excess = excess_depth(np.full((2, 2), depth_mm, np.uint16), background)
    assert excess.dtype == np.float32
    assert np.all(excess == expected)


@pytest.mark.parametrize(
    ("excess_mm", "halo", "hand"),
    [(8.5, True, False), (8.0, False, False), (0.0, False, False), (-4.5, False, True)],
)
def test_segmentation_separates_halo_from_hand(excess_mm: float, halo: bool, hand: bool) -> None:
    segmentation = segment(np.full((1, 1), excess_mm, np.float32), SETTINGS, 8.0)
    assert (bool(segmentation.halo[0, 0]), bool(segmentation.hand[0, 0])) == (halo, hand)


@pytest.mark.parametrize(
    ("x", "y", "share"),
    [
        (320, 288, 1.0),
        (0, 0, 1.0),
        (639, 575, 1.0),
        (-12, 50, 60 / LEAST_FREE_PX),
        (-100, 50, 0.0),
    ],
    ids=["inside", "top left corner", "bottom right corner", "almost outside", "outside"],
)
def test_what_is_left_of_a_patch_is_scaled_to_all_of_it(x: float, y: float, share: float) -> None:
    segmentation = segment(np.full((576, 640), 10.0, np.float32), SETTINGS, 8.0)
    total = extract(segmentation, tip_at(x, y))
    assert total == pytest.approx(share * 10.0 * FREE_PX)


@pytest.mark.parametrize("hidden", [slice(0, 0), slice(278, 283), slice(288, 298)])
def test_what_a_hand_hides_of_a_halo_is_compensated(hidden: slice) -> None:
    excess = np.full((576, 640), 10.0, np.float32)
    excess[hidden] = -30.0
    total = extract(segment(excess, SETTINGS, 8.0), tip_at(320, 288))
    assert total == pytest.approx(10.0 * FREE_PX)


@pytest.mark.parametrize("yaw_deg", [0.0, 30.0, 90.0, -135.0])
def test_the_patch_lies_across_the_finger_wherever_it_points(yaw_deg: float) -> None:
    rows, columns = np.mgrid[:576, :640] + 0.5  # a pixel reaches from its number to the next
    yaw = np.radians(yaw_deg)
    along = (columns - 320) * np.sin(yaw) - (rows - 288) * np.cos(yaw)
    across = (columns - 320) * np.cos(yaw) + (rows - 288) * np.sin(yaw)
    dent = (along > -10) & (along <= 10) & (across >= -15) & (across < 15)
    segmentation = segment(np.where(dent, 10.0, 0.0).astype(np.float32), SETTINGS, 8.0)
    joint = (320.0 - 25.0 * np.sin(yaw), 288.0 + 25.0 * np.cos(yaw))
    tip = replace(tip_at(320, 288), distal_px=joint)
    assert extract(segmentation, tip) == pytest.approx(10.0 * FREE_PX, rel=0.07)


def test_pixels_under_the_threshold_are_not_summed() -> None:
    excess = np.full((576, 640), 7.9, np.float32)
    excess[288, 320] = 12.0
    total = extract(segment(excess, SETTINGS, 8.0), tip_at(320, 288))
    assert total == pytest.approx(12.0 * FREE_PX / 600)


def test_interpolation_is_the_papers_equation() -> None:
    assert interpolate(15.0, 10.0, 20.0, 1.0, 3.0) == 2.0
    assert interpolate(25.0, 10.0, 20.0, 1.0, 3.0) == 4.0


@pytest.mark.parametrize("share", [0.0, 0.5, 1.0, 1.5])
def test_the_level_is_0_at_subtle_and_1_at_touch(
    profile: Profile, dented: TouchStates, share: float
) -> None:
    assert profile.touch is not None
    total = 1500.0 + share * 500.0
    depth_mm = 10.0 + share

    def level(read: Signal, states: TouchStates) -> float:
        return evidence(read, tip_at(320, 288), states).level

    assert level(signal(depth_mm), dented) == pytest.approx(share)
    flat = replace(signal(depth_mm * 0.8), at_pitch=0.8)
    assert level(flat, dented) == pytest.approx(share)
    one_hidden = replace(signal(depth_mm), readings=(0.0, NAN, 0.6 * depth_mm, NAN))
    assert level(one_hidden, dented) == pytest.approx(share)
    all_hidden = replace(signal(NAN, total), readings=(total, NAN, NAN, NAN))
    assert level(all_hidden, dented) == pytest.approx(share)
    older = profile.touch  # calibrated before there were several readings
    assert level(signal(3.0, total), older) == pytest.approx(share)


def test_a_reading_weighs_what_it_is_worth_between_the_two_states(dented: TouchStates) -> None:
    """The first depth saturates with force, the second varies over the sweep."""
    touch = replace(dented.touch, readings=(2000.0, 11.0, 6.6, 3.3))
    press = replace(dented.pressure, readings=(3000.0, 11.05, 9.0, 4.5))
    now = replace(signal(11.0), deviations=(0.01, 0.01, 0.2, 0.01))
    weights = span(now, touch, press).weights
    assert sum(weights) == pytest.approx(1.0)
    assert weights[1] == 0.0
    assert weights[3] > 10.0 * weights[2] > 0.0


@pytest.mark.parametrize("level", [-1.0, 0.0, 1.0, 2.0])
def test_a_probability_is_surer_the_surer_the_level_is(dented: TouchStates, level: float) -> None:
    tip = tip_at(320, 288, NAN)  # its own depth is not measured
    steady = replace(signal(10.0 + level), deviations=(0.02,) * 4)
    vague = replace(steady, deviations=(0.2,) * 4)
    sure, unsure = (contact_probability(evidence(s, tip, dented), 0.0) for s in (steady, vague))
    assert (sure > 0.5) is (level > CONTACT_LEVEL)
    assert min(sure, 1.0 - sure) < min(unsure, 1.0 - unsure)


def test_a_rise_makes_a_touch_more_probable_and_a_fall_less() -> None:
    seen = Evidence(0.5, 0.3)
    falling, still, rising = (contact_probability(seen, rise) for rise in (-0.6, 0.0, 0.6))
    assert falling < still < rising


def test_the_surface_stops_a_finger_at_once_and_a_hovering_one_stops_slowly() -> None:
    """The halo of a touch may read too weak at its place; how it stopped shows the contact."""
    tap = levels(-2.9, -2.6, -2.2, -0.4, 0.2, 0.2, 0.2, 0.2)
    approach = levels(-1.2, -0.8, -0.4, -0.1, 0.1, 0.2, 0.2, 0.2)
    assert [each.touching for each in tap] == [*[False] * 5, *[True] * 3]
    assert not any(each.touching for each in approach)


def test_a_finger_leaves_the_surface_by_rising() -> None:
    """Its halo fades for some frames while it is as low as it was; then it rises."""
    fading = [(-2.0, 30.0), (1.0, 3.0), (1.0, 3.2), (-0.2, 3.1), (-0.2, 2.9), (0.4, 3.0)]
    detector = None
    touching = []
    for n, (level, height_mm) in enumerate([*fading, (-0.2, 9.0), (-2.0, 14.0)]):
        seen = Evidence(level, 0.5, height_mm, 3.0)
        detector = detect(detector, seen, n * FRAME_US, 0.0, SETTINGS)
        touching.append(detector.touching)
    assert touching == [False, *[True] * 5, False, False]
    assert detector is not None
    assert math.isnan(detector.lowest_mm)


def test_no_evidence_decides_alone() -> None:
    """A misread frame may show any level and any depth; neither makes or rules out a touch."""
    high = Evidence(0.5 + 1.0, 0.3, 30.0, 3.0)
    assert 0.5 < contact_probability(Evidence(1.5, 0.3), 0.0) < 1.0
    assert contact_probability(high, 0.0) < contact_probability(Evidence(1.5, 0.3), 0.0)
    assert contact_probability(Evidence(99.0, 0.3, 30.0, 3.0), 0.0) > 0.5
    assert contact_probability(Evidence(-99.0, 0.3, 0.0, 3.0), 0.0) < 0.5


def levels(
    *values: float, speed_mm_s: float = 0.0, deviation: float = 0.3, came_in: bool = False
) -> list[Detector]:
    """Feed levels to a detector, one a frame."""
    detector, all_of_them = None, []
    for n, level in enumerate(values):
        seen = Evidence(level, deviation)
        detector = detect(detector, seen, n * FRAME_US, speed_mm_s, SETTINGS, came_in)
        all_of_them.append(detector)
    return all_of_them


@pytest.mark.parametrize(
    ("values", "touching"),
    [
        ((-1.0, -1.0, 1.0, 1.0), [False, False, True, True]),
        ((-1.0, -0.5, 0.0, 0.15), [False, False, False, False]),
        ((0.0, 0.0, 1.0, 0.25, -0.05), [False, False, True, True, False]),
        ((-1.0, -1.0, 1.0, 1.0, -0.2, 0.2, 1.0), [False] * 2 + [True] * 2 + [False, True, True]),
        ((-1.0, -1.0, 1.0, 1.0, -0.3, -0.2, -0.2), [False] * 2 + [True] * 2 + [False] * 3),
        ((1.0, 1.0, 1.0, -1.0, -1.0, 1.0), [*[False] * 5, True]),
        ((2.1, 2.1, 2.6, 1.9, *[-1.0] * 30, 1.0), [*[False] * 34, True]),
        ((*[0.1] * 60, 0.3, 0.1), [False] * 62),
        ((*[0.2] * 60, 0.6), [*[False] * 60, True]),
        (tuple(0.044 * n - 1.0 for n in range(45)), [*[False] * 31, *[True] * 14]),
    ],
    ids=[
        "a tap",
        "an approach",
        "hysteresis",
        "a misread frame in a touch",
        "an end that the next frame confirms",
        "found while it rests",
        "found pressing, then pressed harder",
        "a flicker while it hovers close by",
        "a touch of a finger that hovered close by",
        "a soft landing",
    ],
)
def test_the_detector(values: tuple[float, ...], touching: list[bool]) -> None:
    assert [detector.touching for detector in levels(*values)] == touching


def test_a_finger_that_slides_in_over_the_edge_touches_at_once() -> None:
    """It may come from the surface of another camera, where it came down."""
    pressing = levels(1.0, 1.0, 1.0, -1.0, came_in=True)
    assert [each.touching for each in pressing] == [False, True, True, False]
    assert not any(each.touching for each in levels(0.1, 0.1, 0.1, came_in=True))


def test_a_touch_begins_and_ends_at_the_probabilities_of_the_settings() -> None:
    feed = [0.02 * n - 1.0 for n in range(101)]
    seen = levels(*feed, *reversed(feed))
    down = next(n for n, each in enumerate(seen) if each.touching)
    up = next(n for n, each in enumerate(seen) if n > down and not each.touching)
    assert seen[down - 1].probability < SETTINGS.down_level <= seen[down].probability
    assert seen[up].probability < SETTINGS.up_level <= seen[up - 1].probability


def test_a_finger_in_fast_flight_does_not_touch() -> None:
    assert not levels(-1.0, -1.0, 1.0, speed_mm_s=2000.0)[-1].touching


def test_long_hovering_close_by_does_not_hide_the_next_touch() -> None:
    assert levels(*[0.3] * 200, 1.0)[-1].touching


def test_the_moment_of_contact_lies_between_the_frames() -> None:
    down = levels(-1.0, 0.1, 1.0)[-1]
    assert down.ago_us == pytest.approx(FRAME_US * (1.0 - CONTACT_LEVEL) / 0.9, abs=1)


@pytest.mark.parametrize(
    ("touches", "counts", "touching"),
    [
        ([1, 1, 0, 0], [1, 1, 1, 1], [1, 1, 1, 0]),
        ([1, 0, 1, 0, 0], [1, 1, 1, 1, 1], [1, 1, 1, 1, 0]),
        ([1, 0, 0, 1], [1, 1, 1, 2], [1, 1, 0, 1]),
        ([0, 0, 0], [0, 0, 0], [0, 0, 0]),
    ],
)
def test_debounce_accepts_an_up_when_a_second_frame_agrees(
    touches: list[int], counts: list[int], touching: list[int]
) -> None:
    state, seen = Debounce(), []
    for n, raw in enumerate(touches):
        state = debounce(state, bool(raw), 0, n * FRAME_US)
        seen.append(state.contact)
    assert [contact.count for contact in seen] == counts
    assert [int(contact.touching) for contact in seen] == touching


def test_a_delayed_up_has_the_time_of_its_first_frame() -> None:
    state = Debounce()
    for n, touching in enumerate([True, False, False]):
        state = debounce(state, touching, 10_000 if n == 1 else 0, n * FRAME_US)
    assert state.contact.ago_us == FRAME_US + 10_000


@pytest.mark.parametrize(
    ("dent_mm", "top_mm", "height_mm"),
    [
        (5.0, 24.0, 10.0),
        (10.0, 15.0, 1.0),
        (11.0, 14.0, 0.0),
        (99.0, 14.0, 0.0),
        (5.0, 99.0, 10.0),
        (0.0, 44.0, 30.0),
        (-0.2, 44.0, 30.0),
        (NAN, 44.0, 30.0),
        (NAN, 10.0, 0.0),
        (NAN, NAN, 21.0),
    ],
    ids=[
        "hover",
        "subtle",
        "touch",
        "never negative",
        "the halo is surer than the depth",
        "above the halo its own depth",
        "noise is no halo",
        "the halo is hidden",
        "hidden and low",
        "nothing is measured",
    ],
)
def test_hover(dented: TouchStates, dent_mm: float, top_mm: float, height_mm: float) -> None:
    tip = tip_at(320, 288, top_mm)
    read_mm = hover_height(signal(dent_mm), tip, dented)[0]
    assert read_mm >= 0.0
    assert read_mm == pytest.approx(height_mm, abs=1.0 if height_mm > 21.0 else 0.5)


def test_no_halo_at_the_calibrated_hover_height_divides_by_nothing(dented: TouchStates) -> None:
    """As on a dark cloth, where the halo first shows nearer to the surface."""
    faint = replace(dented, hover=replace(dented.hover, readings=(0.0,) * 4))
    tip = tip_at(320, 288, 25.0)
    heights = [hover_height(signal(dent_mm), tip, faint)[0] for dent_mm in (0.0, 3.0, 9.0)]
    assert heights == sorted(heights, reverse=True)
    assert heights[0] == pytest.approx(11.0, abs=2.0)  # by its own depth: 25 mm less 14


def test_hover_falls_without_a_jump_from_above_the_halo_to_the_surface(
    dented: TouchStates,
) -> None:
    # The finger's own depth is 3 mm off, as it may be; the halo fades in below the onset.
    dents = [0.0] * 10 + [0.02 * n for n in range(551)]
    own = [35.0 + 3.0 - n for n in range(10)] + [24.0] * 551
    tips = [tip_at(320, 288, 14.0 + mm) for mm in own]
    heights = [hover_height(signal(d), t, dented)[0] for d, t in zip(dents, tips, strict=True)]
    falls = -np.diff(heights)
    assert np.all(falls >= -1e-9)
    assert falls.max() <= 5.0
    assert heights[-1] < 0.7


@pytest.fixture
def topped(dented: TouchStates) -> TouchStates:
    """With the upper side's own depth, which skin and halo lower: 11 mm over a way of 9 mm."""
    hover = replace(dented.hover, top_mm=20.0, top_noise_mm=0.7)
    return replace(dented, hover=hover, subtle=replace(dented.subtle, top_mm=9.0, top_noise_mm=0.7))


@pytest.mark.parametrize(("dent_mm", "top_mm", "height_mm"), [(5.0, 20.0, 10.0), (10.0, 9.0, 1.0)])
def test_both_estimates_of_a_height_agree_in_the_held_states(
    topped: TouchStates, dent_mm: float, top_mm: float, height_mm: float
) -> None:
    tip = tip_at(320, 288, top_mm)
    seen = own(signal(dent_mm), tip)
    assert hover_height(seen, tip, topped)[0] == pytest.approx(height_mm, abs=0.3)


def test_the_estimate_with_the_smaller_variance_counts_more(topped: TouchStates) -> None:
    tip = tip_at(320, 288, 25.0)  # 15 mm by its own depth, 10 by a steady halo
    seen = own(signal(5.0), tip)
    unsure = own(signal(5.0), tip, 5.0)
    steady = hover_height(seen, tip, topped)[0]
    noisy = replace(
        topped,
        hover=replace(topped.hover, noise=(1e6, 2.0, 1.2, 0.6)),
        subtle=replace(topped.subtle, noise=(1e6, 2.0, 1.2, 0.6)),
    )
    assert 10.0 < hover_height(unsure, tip, topped)[0] < steady < 12.0
    assert 12.0 < hover_height(seen, tip, noisy)[0] < 15.0


def test_two_estimates_of_a_height_are_surer_than_each(topped: TouchStates) -> None:
    tip = tip_at(320, 288, 20.0)
    _, both_mm = hover_height(own(signal(5.0), tip), tip, topped)
    _, halo_mm = hover_height(signal(5.0), tip_at(320, 288, NAN), topped)
    _, own_mm = hover_height(own(signal(NAN), tip), tip, topped)
    assert 0.0 < both_mm < min(halo_mm, own_mm)
    assert hover_height(signal(NAN), tip_at(320, 288, NAN), topped) == (21.0, math.inf)


def test_above_the_halo_the_own_depth_counts_alone(topped: TouchStates) -> None:
    tip = tip_at(320, 288, 45.0)
    assert hover_height(own(signal(0.0), tip), tip, topped)[0] == pytest.approx(35.0, abs=0.1)


def test_a_halo_too_strong_for_its_place_does_not_hide_a_finger_that_is_clearly_higher(
    topped: TouchStates,
) -> None:
    """7 mm by its own depth, to 1.5 mm; a halo as in subtle, give or take half of hover's."""
    tip = tip_at(320, 288, 16.4)
    halo = replace(own(signal(10.0), tip), deviations=(0.3,) * 4)
    assert hover_height(halo, tip, topped)[0] > 3.5


def test_a_finger_that_the_camera_looks_along_is_read_lower_by_how_oblique_it_is(
    topped: TouchStates,
) -> None:
    """At 30 degrees the place behind the end lies farther back on the finger, 7 mm higher."""
    plain, along = tip_at(320, 288, 25.0), replace(tip_at(320, 288, 32.32), seen_deg=30.0)
    plain_mm, plain_deviation_mm = own_height(own(signal(5.0), plain), plain, topped)
    along_mm, along_deviation_mm = own_height(own(signal(5.0), along), along, topped)
    assert plain_mm == pytest.approx(15.0)
    assert along_mm == pytest.approx(plain_mm, abs=0.01)
    assert along_deviation_mm > 1.5 * plain_deviation_mm


@pytest.mark.parametrize("seen_deg", [179.9, 180.0, 0.0, NAN])
def test_an_angle_that_cannot_be_makes_no_height(topped: TouchStates, seen_deg: float) -> None:
    tip = replace(tip_at(320, 288, 25.0), seen_deg=seen_deg)
    height_mm, deviation_mm = own_height(own(signal(5.0), tip), tip, topped)
    assert abs(height_mm) < 100.0
    assert deviation_mm > 4.0


def test_a_hover_state_above_the_usual_onset_reads_its_own_height(dented: TouchStates) -> None:
    high = replace(dented, hover=replace(dented.hover, height_mm=25.0))
    tip = tip_at(320, 288, NAN)
    assert hover_height(signal(5.0), tip, high)[0] == pytest.approx(25.0, abs=1.0)


def test_an_upper_side_is_leveled_by_the_grid_at_its_place() -> None:
    """2 mm higher for each 15 mm to the right, 1 mm for each 15 mm towards the user."""
    x_mm, y_mm = np.arange(4.0, dtype=np.float32) * 15.0, np.arange(3.0, dtype=np.float32) * 15.0
    higher_mm = 2.0 * np.arange(4.0)[:, None] + np.arange(3.0)[None, :]
    grid = np.stack([higher_mm, np.full((4, 3), 1.5)]).astype(np.float32)
    four = np.ones((4, 3, 2, 2), np.float32)
    two = np.array([15.0, 75.0], np.float32)
    correction = Correction(x_mm, y_mm, two, two, four, np.empty((0, 9)), "", tops_mm=grid)
    top = leveled_top(replace(tip_at(320, 288, 20.0), pad_mm=(45.0, 15.0)), correction)
    assert top.height_mm == pytest.approx(20.0 - 6.0 - 1.0)
    assert top.deviation_mm == pytest.approx(1.5)
    assert leveled_top(tip_at(320, 288, NAN), correction).deviation_mm == pytest.approx(1.5)


def test_states_held_at_another_angle_say_the_same_height(topped: TouchStates) -> None:
    tip = tip_at(320, 288, 25.0)
    held = [
        replace(state, top_mm=state.top_mm + 7.32, seen_deg=30.0)
        for state in (topped.hover, topped.subtle)
        if state.top_mm is not None
    ]
    oblique = replace(topped, hover=held[0], subtle=held[1])
    seen = own(signal(5.0), tip)
    expected = own_height(seen, tip, topped)[0]
    assert own_height(seen, tip, oblique)[0] == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize(
    ("changes", "above"),
    [
        ({"top_mm": 30.0}, True),
        ({"top_mm": 12.0}, False),
        ({"top_mm": NAN}, False),
        ({"top_mm": 55.0, "seen_deg": 15.0}, False),
    ],
    ids=["high", "low", "unmeasured", "the camera looks along it"],
)
def test_a_finger_that_its_own_depth_shows_above_does_not_touch(
    topped: TouchStates, changes: dict[str, float], above: bool
) -> None:
    """Beyond where the finger was swept, a halo may read as strong as a touch's."""
    tip = replace(tip_at(320, 288), **changes)  # type: ignore[arg-type]
    halo = own(replace(signal(11.0), deviations=(0.05,) * 4), tip)
    assert (contact_probability(evidence(halo, tip, topped), 0.0) < 0.5) is above


@pytest.mark.parametrize(
    ("tilt_deg", "pitch_deg", "seen_deg"), [(0, 45, 45), (0, 75, 15), (20, 45, 25), (-20, 45, 65)]
)
def test_the_angle_between_a_finger_and_the_line_of_sight(
    tilt_deg: float, pitch_deg: float, seen_deg: float
) -> None:
    """A camera that is tilted towards the far edge looks along a finger that points there."""
    tilt = math.radians(tilt_deg)
    pose = np.eye(4)
    pose[1:3, 1:3] = [[math.cos(tilt), -math.sin(tilt)], [math.sin(tilt), math.cos(tilt)]]
    surface = Surface("table", 300.0, 200.0, np.linalg.inv(pose))
    ahead = (0.0, 0.0, 500.0)
    assert line_of_sight_deg(ahead, pitch_deg, 0.0, surface) == pytest.approx(seen_deg)


def test_states_without_a_dent_leave_the_height_to_the_depth(profile: Profile) -> None:
    assert profile.touch is not None
    assert hover_height(signal(7.0, 900.0), tip_at(320, 288, 20.0), profile.touch)[0] == 6.0


@pytest.mark.parametrize(
    ("total", "pressure", "grams"),
    [
        (2000.0, 0.02, 25.0),
        (1800.0, 0.02, 25.0),
        (-9e9, 0.02, 25.0),
        (2500.0, 0.4054, 95.9),
        (3000.0, 1.0, 200.0),
        (4000.0, 2.6594, 490.4),
    ],
)
def test_pressure_and_force(
    profile: Profile, dented: TouchStates, total: float, pressure: float, grams: float
) -> None:
    assert profile.touch is not None
    by_sum = touch_pressure(Signal(total, total, (total, NAN, NAN, NAN)), dented)
    by_dent, _ = read_force(signal(11.0 + (total - 2000.0) / 250.0), dented)
    assert by_sum == pytest.approx(pressure, abs=0.001)
    assert max(by_dent, 25.0) == pytest.approx(grams, abs=0.1)
    older = touch_pressure(signal(3.0, total), profile.touch)
    assert older == pytest.approx(by_sum, rel=0.005)  # no noise is known there, so it is steady
    assert force(by_sum, profile.touch) == pytest.approx(grams, abs=0.1)


@pytest.mark.parametrize(
    ("dent_mm", "grams"), [(11.0, 25.0), (15.0, 200.0), (16.0, 292.5), (17.0, 400.0), (18.0, 519.7)]
)
def test_a_hard_press_fixes_the_far_end_of_the_force(
    dented: TouchStates, dent_mm: float, grams: float
) -> None:
    readings = read(3500.0, 17.0)
    hard = replace(dented.pressure, force_g=400.0, readings=readings, noise=NOISE)
    states = replace(dented, hard=hard)
    assert read_force(signal(dent_mm), states)[0] == pytest.approx(grams, abs=1.0)


def test_a_force_is_as_sure_as_the_readings_are(dented: TouchStates) -> None:
    vague = replace(signal(15.0), deviations=(0.2,) * 4)
    steady = replace(signal(15.0), deviations=(0.02,) * 4)
    assert touch_force(vague, dented)[1] > 2.0 * touch_force(steady, dented)[1] > 0.0


def test_an_unsure_force_is_held_nearer_to_the_medium_press(dented: TouchStates) -> None:
    vague, steady = (
        touch_force(replace(signal(17.0), deviations=(each,) * 4), dented)[0]
        for each in (0.2, 0.01)
    )
    assert 200.0 < vague < steady - 30.0
    assert steady == pytest.approx(read_force(signal(17.0), dented)[0], rel=0.05)


def test_pressure_grows_with_the_halo(dented: TouchStates) -> None:
    pressures = [touch_pressure(signal(11.2 + 0.1 * n), dented) for n in range(80)]
    assert np.all(np.diff(pressures) > 0.0)


def test_the_drift_of_a_device_that_warms_up_is_followed_past_hand_and_halo() -> None:
    background = Background(
        np.full((576, 640), 500.0, np.float32),
        np.ones((576, 640), np.float32),
        np.ones((576, 640), bool),
    )
    drift = Drift()
    for n in range(0, 30 * 60, 10):
        depth = np.full((576, 640), 506, np.uint16)
        depth[200:400, 200:400] = 450  # a hand that rests
        depth[100:200, 200:400] = 516  # and its halo
        depth[:, ::32] = 0  # what measures nothing says nothing
        drift = follow_drift(drift, depth, background, n * FRAME_US)
    assert drift.offset_mm == pytest.approx(6.0, abs=0.1)
