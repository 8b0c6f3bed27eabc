"""Which frames the hand model gets, on drawn depth images."""

from collections.abc import Callable

import numpy as np
import pytest

from halo_service.hand_tracking.paced_tracker import PacedTracker
from halo_service.values import Frame, Hand, Side, Tracked

SHAPE, SURFACE_MM, FRAME_US = (576, 640), 500, 33_333
BACKGROUND = np.full(SHAPE, SURFACE_MM, np.float32)
INFRARED = np.full(SHAPE, 900, np.uint16)
Hands = Callable[[int], tuple[Hand, ...]]


def hand(x: float, y: float, confidence: float = 0.95) -> Hand:
    """Return a hand of 80 by 100 px around a place."""
    grid = np.stack(np.meshgrid(np.linspace(-40, 40, 3), np.linspace(-50, 50, 7)), axis=-1)
    return Hand(Side.RIGHT, grid.reshape(-1, 2) + np.array((x, y)), confidence)


def frame(number: int, *blobs: tuple[int, int]) -> Frame:
    """Draw blobs of 80 by 100 px, 60 mm above the surface."""
    depth = np.full(SHAPE, SURFACE_MM, np.uint16)
    for x, y in blobs:
        depth[y - 50 : y + 50, x - 40 : x + 40] = SURFACE_MM - 60
    return Frame(FRAME_US * number, depth, INFRARED)


def looked(frames: list[Frame], hands: Hands, max_hands: int = 2) -> list[bool]:
    """Return for each frame whether the model got it, and check what was returned."""
    looks: list[int] = []

    def look(each: Frame) -> Tracked:
        looks.append(each.time_us)
        return Tracked(each.time_us, hands(each.time_us // FRAME_US))

    tracker = PacedTracker(look, BACKGROUND, BACKGROUND > 0, 500.0, max_hands)
    for each in frames:
        tracked = tracker.detect(each)
        if tracked.hands:
            assert tracked.time_us == looks[-1]  # hands carry the time of their own frame
    return [each.time_us in looks for each in frames]


def every_fourth(looks: list[bool]) -> bool:
    """Return whether the last dozen frames hold three looks, each four frames apart."""
    numbers = [number for number, look in enumerate(looks[-12:]) if look]
    return len(numbers) == 3 and set(np.diff(numbers)) == {4}


def test_a_hand_that_depth_confirms_is_looked_at_in_every_fourth_frame() -> None:
    looks = looked([frame(n, (300, 300)) for n in range(30)], lambda n: (hand(300, 300),))
    assert all(looks[:3]) and every_fourth(looks)


def test_two_hands_that_touch_each_other_are_looked_at_as_rarely() -> None:
    """The sensing follows each finger; looks at every frame lost as many touches (`looks.py`)."""
    pair = hand(300, 300), hand(390, 300)
    looks = looked([frame(n, (300, 300), (390, 300)) for n in range(30)], lambda n: pair)
    assert every_fourth(looks)


def test_the_model_rests_over_an_empty_table() -> None:
    assert not any(looked([frame(n) for n in range(10)], lambda n: ()))


@pytest.mark.parametrize(
    "hands",
    [
        pytest.param(lambda n: (), id="none is found"),
        pytest.param(lambda n: (hand(300, 300, 0.6),), id="the model is unsure"),
        pytest.param(lambda n: (hand(300 + 40 * (n % 2), 300),), id="it jumps"),
    ],
)
def test_every_frame_is_looked_at_while_hands_are_unsure(hands: Hands) -> None:
    frames = [frame(n, (300, 300), (390, 300)) for n in range(20)]
    assert all(looked(frames, hands))


def test_a_hand_that_comes_in_is_looked_at_in_its_first_frame() -> None:
    frames = [frame(n, (150, 300)) for n in range(18)]
    frames += [frame(n, (150, 300), (500, 300)) for n in range(18, 45)]
    found = (hand(150, 300), hand(500, 300))
    looks = looked(frames, lambda n: found[: 1 + (n >= 18)])
    assert not all(looks[:18])
    assert all(looks[18:21]) and every_fourth(looks)


def test_what_belongs_to_no_hand_is_searched_for_a_second_then_it_is_an_object() -> None:
    frames = [frame(n, (150, 300), (500, 300)) for n in range(60)]
    looks = looked(frames, lambda n: (hand(150, 300),))
    assert all(looks[:30]) and every_fourth(looks)
    assert every_fourth(looked(frames[:20], lambda n: (hand(150, 300),), max_hands=1))


def test_a_hand_that_moves_on_is_looked_at_where_it_is() -> None:
    frames = [frame(n, (150, 300)) for n in range(18)]
    frames += [frame(n, (150 + 40 * (n - 17), 300)) for n in range(18, 24)]
    looks = looked(frames, lambda n: (hand(150 + 40 * max(n - 17, 0), 300),))
    assert not all(looks[:18]) and all(looks[18:])


def test_a_gap_in_time_or_a_step_back_is_looked_at() -> None:
    numbers = [*range(12), 40, 13]
    looks = looked([frame(n, (300, 300)) for n in numbers], lambda n: (hand(300, 300),))
    assert all(looks[-2:])
