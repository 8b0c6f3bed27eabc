"""The wizard's frames: from the running camera, or from a virtual user who follows prompts."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from halo_service.app.calibration_ui.place import PLACED
from halo_service.app.page.frame_tap import FrameTap
from halo_service.app.page.observer import PageObserver
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.errors import UserError
from halo_service.sensing import State
from halo_service.sources import Exposing, Source
from halo_service.sources.switched import SwitchedSource
from halo_service.virtual.live import VirtualKinect


class ExposingTap(FrameTap):
    """The frames of a camera with a settable exposure."""

    def __init__(self, source: Source, set_exposure: Callable[[float | None], None]) -> None:
        super().__init__(source.kind, source.camera)
        self.expose = set_exposure


@contextmanager
def wizard_source(
    switched: SwitchedSource, observer: PageObserver, paused: threading.Event, step: str
) -> Iterator[Source]:
    """Yield the frames for one step. `switched`: the source of the service. Raises `UserError`."""
    if switched.shown is not None:
        raise UserError("a recording is replayed: stop the replay in Record first")
    live = switched.source
    if isinstance(live, VirtualKinect):
        # Printed boards need the full colour picture; hands are found in a smaller one.
        with _paused(paused):
            yield VirtualUser(live.room, colour_times=1 if step in PLACED else 2)
        return
    if live.kind == "recording":
        raise UserError(
            "a recording cannot follow prompts: start the service with a camera, or with "
            "--source sim"
        )
    tap = _tap(live, observer)
    observer.taps.add(tap.put)
    try:
        yield tap
    finally:
        observer.taps.discard(tap.put)


@contextmanager
def _paused(paused: threading.Event) -> Iterator[None]:
    """Let the service rest: two virtual hands are too much for a small machine."""
    if paused.is_set():
        yield
        return
    paused.set()
    try:
        yield
    finally:
        paused.clear()


def _tap(live: Source, observer: PageObserver) -> FrameTap:
    if not isinstance(live, Exposing):
        return FrameTap(live.kind, live.camera)
    camera = live

    def expose(exposure_ms: float | None) -> None:
        """Set it in the live loop, the one thread that uses the camera."""

        def change(state: State) -> State:
            camera.expose(exposure_ms)
            return state

        observer.request(change)

    return ExposingTap(live, expose)
