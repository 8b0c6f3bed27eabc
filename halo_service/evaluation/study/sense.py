"""All methods over the same frames in one pass, as `halo replay` would run each of them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import tee
from typing import Any

from halo_service.evaluation.study.recording import StoredRecording
from halo_service.evaluation.study.simulate import Tracker
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.runtime.method import Method
from halo_service.runtime.pace import paced_by_depth
from halo_service.runtime.replay import replay
from halo_service.sensing import SensingSettings
from halo_service.sources import EndOfSource, Source
from halo_service.values import BadFrame, Frame, SourceKind, TouchFrame, Tracked
from halo_service.virtual.camera import factory


class FrameSequence:
    """A `Source` of frames that are there already."""

    kind: SourceKind = "recording"

    def __init__(self, captures: Iterable[Frame | BadFrame], camera: Camera | None = None) -> None:
        """`camera`: that of the frames; None: the virtual one."""
        self.camera = camera or factory()
        self._captures = iter(captures)

    def read(self, timeout_s: float) -> Frame | BadFrame:
        """Return the next capture."""
        del timeout_s  # it never has to wait
        capture = next(self._captures, None)
        if capture is None:
            raise EndOfSource
        return capture

    def close(self) -> None:
        """Nothing to release."""


class CachedHands:
    """A hand tracker that returns the hands of a stored recording."""

    def __init__(self, recording: StoredRecording, whole_image: bool = False) -> None:
        self._hands = {
            each.time_us: Tracked(each.time_us, each.image_hands if whole_image else each.hands)
            for each in recording.frames
        }

    def __call__(self, frame: Frame) -> Tracked:
        """Return the hands in one of the recording's frames."""
        return self._hands[frame.time_us]


class SharedTracker:
    """A hand tracker for several callers that ask for the same frame; it runs once per frame."""

    def __init__(self, track: Tracker) -> None:
        self._track = track
        self._last: tuple[Frame, Tracked] | None = None

    def __call__(self, frame: Frame) -> Tracked:
        """Return the hands in this frame."""
        if self._last is None or self._last[0] is not frame:
            self._last = frame, self._track(frame)
        return self._last[1]


def captures_of(source: Source) -> Iterator[Frame | BadFrame]:
    """Yield all captures of a source until it ends."""
    while True:
        try:
            capture = source.read(1.0)
        except EndOfSource:
            return
        if capture is not None:
            yield capture


def sense_all(
    captures: Iterable[Frame | BadFrame],
    camera: Camera,
    track: Tracker,
    methods: Sequence[Method[Any]],
    profiles: Mapping[str, Profile],
    settings: SensingSettings,
    track_image: Tracker | None = None,
    hands: int = 2,
) -> dict[str, tuple[TouchFrame, ...]]:
    """Return what each method publishes, by its name; the tracker is as late as it is live.

    `track_image`: for methods with a tracker of the whole image; None: as for the others.
    `hands`: how many the tracker finds at most.

    Every frame goes to all methods before the next is read, so each is decoded once.
    """

    def tracker_of(method: Method[Any]) -> Tracker:
        if method.whole_image and track_image is not None:
            return track_image
        return paced_by_depth(track, profiles[method.name], hands) if method.paced else track

    runs = [
        replay(
            FrameSequence(copy, camera),
            tracker_of(method),
            method,
            method.start(profiles[method.name], settings),
        )
        for method, copy in zip(methods, tee(captures, len(methods)), strict=True)
    ]
    published = list(zip(*runs, strict=True))
    return {
        method.name: tuple(each[index] for each in published)
        for index, method in enumerate(methods)
    }
