"""All methods over the same frames in one pass, as `halo replay` would run each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import tee
from typing import Any

from halo_service.evaluation.study.recording import Kept
from halo_service.geometry.camera import Camera
from halo_service.profile import Profile
from halo_service.runtime.method import Method
from halo_service.runtime.replay import replay
from halo_service.sensing import SensingSettings
from halo_service.sources import EndOfSource, Source
from halo_service.values import BadFrame, Frame, SourceKind, TouchFrame, Tracked
from halo_service.virtual.camera import factory

Look = Callable[[Frame], Tracked]


class Played:
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
        """There is nothing to let go."""


class Remembered:
    """A hand tracker that says again what it saw when the take was made."""

    def __init__(self, kept: Kept) -> None:
        self._seen = {each.time_us: Tracked(each.time_us, each.hands) for each in kept.captures}

    def __call__(self, frame: Frame) -> Tracked:
        """Return the hands in one of the take's frames."""
        return self._seen[frame.time_us]


class Once:
    """A hand tracker that is asked by several for the same frame, and looks once."""

    def __init__(self, look: Look) -> None:
        self._look = look
        self._last: tuple[Frame, Tracked] | None = None

    def __call__(self, frame: Frame) -> Tracked:
        """Return the hands in this frame."""
        if self._last is None or self._last[0] is not frame:
            self._last = frame, self._look(frame)
        return self._last[1]


def captures_of(source: Source) -> Iterator[Frame | BadFrame]:
    """Yield what a source gives until it ends."""
    while True:
        try:
            capture = source.read(1.0)
        except EndOfSource:
            return
        if capture is not None:
            yield capture


def together(
    captures: Iterable[Frame | BadFrame],
    camera: Camera,
    look: Look,
    methods: Sequence[Method[Any]],
    profiles: Mapping[str, Profile],
    settings: SensingSettings,
) -> dict[str, tuple[TouchFrame, ...]]:
    """Return what each method publishes, by its name; the tracker is as late as it is live.

    Every frame goes to all methods before the next is read, so each is decoded once.
    """
    runs = [
        replay(Played(copy, camera), look, method, method.start(profiles[method.name], settings))
        for method, copy in zip(methods, tee(captures, len(methods)), strict=True)
    ]
    told = list(zip(*runs, strict=True))
    return {
        method.name: tuple(each[index] for each in told) for index, method in enumerate(methods)
    }
