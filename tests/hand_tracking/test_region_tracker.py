"""The real hand model on the regions that depth proposes."""

import json
import math
from collections.abc import Iterator
from concurrent.futures import Future
from contextlib import closing

import numpy as np
import pytest

from halo_service.hand_tracking.model import hand_model
from halo_service.hand_tracking.region_tracker import RegionTracker
from halo_service.sources.recording import Recording
from halo_service.values import Frame, Side
from halo_service.virtual import offline
from halo_service.virtual.camera import factory
from halo_service.virtual.sim_url import parse_sim_url

FRAMES = 12


class Looks:
    """A model's stand-in that counts its calls, and finds nothing."""

    def __init__(self) -> None:
        self.count = 0

    def find(self, picture, time_us):
        """Count, and find nothing."""
        from halo_service.values import Tracked

        self.count += 1
        return Tracked(time_us, ())


def empty_surface(url: str) -> np.ndarray:
    """Return the mean depth of the same room without anybody."""
    frames = [each.depth for each, _ in offline.frames(parse_sim_url(url), 0.5) if each is not None]
    return np.mean(frames, axis=0).astype(np.float32)


def scene(scenario: str, options: str) -> tuple[RegionTracker, list[tuple[Frame, list[dict]]]]:
    """Return a tracker for a room, and some frames of a scenario with its fingers' truth."""
    background = empty_surface(f"sim:idle?{options}")
    lens = factory().depth
    tracker = RegionTracker(hand_model(None), background, background > 0, lens.fx, 2)
    frames = []
    for frame, lines in offline.frames(parse_sim_url(f"sim:{scenario}?{options}"), 6.0):
        fingers = [f for line in lines for f in line.get("fingers", ()) if f["finger"] == "index"]
        if frame is not None and fingers:
            frames.append((frame, fingers))
        if len(frames) == 3 * FRAMES:
            break
    return tracker, frames


@pytest.fixture
def one_hand() -> Iterator[tuple[RegionTracker, list[tuple[Frame, list[dict]]]]]:
    tracker, frames = scene("demo", "seed=1")
    yield tracker, frames
    tracker.close()


def test_a_hand_is_found_where_it_is(one_hand) -> None:
    tracker, frames = one_hand
    lens, found = factory().depth, []
    for frame, fingers in frames:
        hands = tracker.detect(frame).hands
        tip = lens.project(np.array([fingers[0]["camera_mm"]]))[0]
        found += [math.dist(hand.landmarks_px[8], tip) for hand in hands]
        assert len(hands) <= 1
    assert len(found) > 0.7 * len(frames)
    assert np.median(found) < 15.0


def test_two_hands_are_two() -> None:
    tracker, frames = scene("drumming", "seed=2")
    counts = [len(tracker.detect(frame).hands) for frame, _ in frames]
    tracker.close()
    assert counts[-1] == 2 and max(counts) == 2


def test_the_model_rests_over_an_empty_table_and_before_a_thing_that_is_no_hand() -> None:
    background = np.full((576, 640), 500.0, np.float32)
    tracker = RegionTracker(hand_model(None), background, background > 0, 505.0, 2)
    models = [Looks(), Looks()]
    for slot, model in zip(tracker._slots, models, strict=True):
        slot.model.result().close()
        slot.model = Future()
        slot.model.set_result(model)
    empty, ir = np.full((576, 640), 500, np.uint16), np.full((576, 640), 900, np.uint16)
    mug = empty.copy()
    mug[250:330, 300:380] = 410
    for n in range(10):
        tracker.detect(Frame(33_000 * n, empty, ir))
    assert sum(model.count for model in models) == 0
    for n in range(10, 40):
        tracker.detect(Frame(33_000 * n, mug, ir))
    assert 3 <= sum(model.count for model in models) <= 5  # a second, looked at every 0.3 s


def test_a_bright_hand_that_the_images_edge_cuts_is_found_in_every_frame(company_data) -> None:
    """On frames of another virtual sensor, in which the model finds no hand in the whole image."""
    recording = company_data / "hand_at_edge.mkv"
    with closing(Recording(recording, realtime=False, loop=False)) as source:
        frames = [source.read(1.0) for _ in range(65)]
    background = np.median([frame.depth for frame in frames[:20]], axis=0).astype(np.float32)
    lens = source.camera.depth
    tracker = RegionTracker(hand_model(None), background, background > 0, lens.fx, 2)
    lines = (company_data / "hand_at_edge.truth.jsonl").read_text().splitlines()
    truth = [json.loads(line)["fingers"] for line in lines]
    off_px, sides = [], []
    for frame, fingers in zip(frames[20:], truth[20:], strict=True):
        hands = tracker.detect(frame).hands
        assert len(hands) == 1
        sides.append(hands[0].side)
        tip = lens.project(np.array([fingers[0]["camera_mm"]]))[0]
        off_px.append(math.dist(hands[0].landmarks_px[8], tip))
    tracker.close()
    assert np.median(off_px) < 6.0 and max(off_px) < 15.0
    assert sides.count(Side.RIGHT) > len(sides) / 2  # the tracks take the majority
