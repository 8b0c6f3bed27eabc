"""`halo replay`: a recording in, one line of JSON per frame out; the same bytes on every run."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path

from halo_service.app.files import written
from halo_service.app.service.fit_watcher import watched
from halo_service.app.sources import open_recording
from halo_service.evaluation.methods import method_named
from halo_service.outputs.jsonl import frame_line
from halo_service.profile import Profile
from halo_service.profile.store import load, profile_path, require_fit
from halo_service.runtime.replay import DetectHands
from halo_service.runtime.replay import replay as sensed
from halo_service.settings import Settings
from halo_service.sources import Source

NODE = "replay"


def replay(recording: Path, out: str, settings: Settings, method: str) -> int:
    """Replay a recording into a file, or to the terminal for `-`; return the number of frames.

    `method`: a name of `evaluation.methods`; raises `UserError` for an unknown one.
    Without a profile the frames have no pointers. The file appears when it is complete.
    """
    chosen = method_named(method)
    with closing(open_recording(recording)) as source:
        profile = load(profile_path(settings.profile)) if settings.profile else None
        if profile is not None:
            require_fit(profile, source.camera)
        session = session_of(recording)
        state = chosen.start(profile, settings.sensing)
        with _detector(source, profile, settings, chosen.paced) as detect, written(out) as file:
            count = 0
            for touch_frame in sensed(source, detect, chosen, state):
                file.write(frame_line(touch_frame, NODE, session, count))
                count += 1
    return count


def session_of(recording: Path) -> str:
    """Return a session name from the content of the file: the same on every run."""
    with recording.open("rb") as file:
        return f"r{hashlib.file_digest(file, 'sha256').hexdigest()[:15]}"


@contextmanager
def _detector(
    source: Source, profile: Profile | None, settings: Settings, paced: bool
) -> Iterator[DetectHands]:
    """Yield the hand tracker; without a profile no hands are needed, so none is loaded."""
    if profile is None:
        yield lambda frame: None
        return
    from halo_service.app.hand_detector import HandDetector

    with closing(HandDetector(source.camera, profile, settings.tracking, paced=paced)) as detector:
        yield watched(detector.detect, profile)
