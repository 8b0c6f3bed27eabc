"""A recording in the camera's place: however it ends, the camera is used again."""

from __future__ import annotations

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.sources import EndOfSource, SourceLost
from halo_service.sources.switched import MOST_OLD, SwitchedSource
from halo_service.values import Frame
from halo_service.virtual.room import Room

CAMERA = Room().camera()
PICTURE = np.zeros((1, 1), np.uint16)


class Scripted:
    """A source that gives frames of these times, or raises; then nothing comes."""

    camera = CAMERA

    def __init__(self, kind: str, *script: int | Exception) -> None:
        self.kind, self._script, self.closed = kind, list(script), 0

    def read(self, timeout_s: float) -> Frame | None:
        now = self._script.pop(0) if self._script else None
        if isinstance(now, Exception):
            raise now
        return None if now is None else Frame(now, PICTURE, PICTURE)

    def close(self) -> None:
        self.closed += 1


def times(source: SwitchedSource, count: int) -> list[int | None]:
    captures = [source.read(0.0) for _ in range(count)]
    return [None if each is None else each.time_us for each in captures]


@pytest.mark.parametrize("end", [EndOfSource(), UserError("cut.mkv is cut off")])
def test_the_camera_is_used_again_where_a_recording_ends(end: Exception) -> None:
    camera = Scripted("camera", 1, 2, 3)
    recording = Scripted("recording", 10, 11, end)
    source = SwitchedSource(camera)  # type: ignore[arg-type]
    assert times(source, 1) == [1]
    source.show(recording)  # type: ignore[arg-type]
    assert times(source, 2) == [10, 11] and source.kind == "recording"
    assert times(source, 1) == [None], "what the camera captured meanwhile is of the past"
    assert (source.kind, recording.closed, camera.closed) == ("camera", 1, 0)
    camera._script = [20]
    assert times(source, 2) == [20, None]
    source.close()
    assert (recording.closed, camera.closed) == (1, 1)


def test_a_camera_that_was_lost_meanwhile_is_reported_and_opened_again() -> None:
    lost = SourceLost("gone")
    source = SwitchedSource(Scripted("camera", lost, lost))  # type: ignore[arg-type]
    first, second = Scripted("recording", 10), Scripted("recording", 20)
    source.show(first)  # type: ignore[arg-type]
    source.show(second)  # type: ignore[arg-type]
    assert times(source, 1) == [20] and first.closed == 1
    source.show(None)
    with pytest.raises(SourceLost):
        source.read(0.0)
    source.close()
    assert second.closed == 1
    assert source.reopened(Scripted("camera", 30)) is source  # type: ignore[arg-type]
    assert times(source, 1) == [30]


def test_old_captures_are_dropped_up_to_a_bound() -> None:
    camera = Scripted("camera", *range(MOST_OLD + 5))
    source = SwitchedSource(camera)  # type: ignore[arg-type]
    source.show(None)
    assert times(source, 1) == [MOST_OLD]
