"""Recordings from the page: into the user's data folder, under a name made here, and replayed in
the camera's place.

Rule: a request names one of the listed recordings; it never gives a path.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from datetime import datetime
from pathlib import Path
from typing import Any

from halo_service.app.page.frame_tap import FrameTap
from halo_service.app.page.observer import PageObserver
from halo_service.app.recordings.record import Recorded, copy_frames
from halo_service.errors import UserError
from halo_service.files import data_folder
from halo_service.outputs.recorder import Recorder
from halo_service.profile.store import difference
from halo_service.sources.recording import Recording
from halo_service.sources.switched import SwitchedSource
from halo_service.web.control_page.calls import Call

LONGEST_S = 600.0
WAITING = 30
MOST_SHOWN = 50


class RecordCalls:
    """One recording or replay at a time."""

    def __init__(
        self, source: SwitchedSource, observer: PageObserver, setup_runs: Callable[[], str]
    ) -> None:
        """`setup_runs`: the step of the set-up that runs; empty: none."""
        self._source, self._observer, self._setup_runs = source, observer, setup_runs
        self._running: _Recording | None = None
        self._replayed = ""

    def table(self) -> dict[str, Call]:
        """Return the calls."""
        return {
            "recordings": Call(self._list, reads=True),
            "start-recording": Call(self._start),
            "stop-recording": Call(self._stop),
            "replay": Call(self._replay),
            "stop-replay": Call(self._stop_replay),
        }

    def close(self) -> None:
        """Complete a recording."""
        if self._running is not None:
            self._running.close()

    @property
    def replayed(self) -> str:
        """Name of the recording that is shown in the camera's place; empty: none."""
        return self._replayed if self._source.shown is not None else ""

    def _list(self, request: dict[str, Any]) -> dict[str, Any]:
        del request
        running = self._running
        return {
            "recordings": [
                {"name": each.name, "path": str(each), "bytes": each.stat().st_size}
                for each in _recordings()
            ],
            "running": running is not None and running.runs,
            "writes": running.name if running is not None and running.runs else "",
            "replayed": self.replayed,
            "result": running.result if running else "",
        }

    def _start(self, request: dict[str, Any]) -> dict[str, Any]:
        if self._running is not None and self._running.runs:
            raise UserError("a recording runs already; stop it first")
        if self.replayed:
            raise UserError("a recording is replayed; stop the replay first")
        camera = self._source.camera
        colour = request.get("colour") is True and camera.colour is not None
        folder = _folder()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError(f"{folder} cannot be made ({error.strerror})") from error
        path = folder / f"{datetime.now():%Y-%m-%d %H.%M.%S}.mkv"
        self._running = _Recording(path, self._source, self._observer, colour)
        return {"path": str(path)}

    def _stop(self, request: dict[str, Any]) -> dict[str, Any]:
        del request
        if self._running is None:
            raise UserError("no recording runs")
        self._running.close()
        return {"result": self._running.result}

    def _replay(self, request: dict[str, Any]) -> dict[str, Any]:
        """Show a listed recording in the camera's place, again and again until it is stopped."""
        path = {each.name: each for each in _recordings()}.get(request["name"])
        if path is None:
            raise UserError("there is no such recording any more")
        if self._running is not None and self._running.runs:
            raise UserError("a recording runs; stop it first")
        if self._setup_runs():
            raise UserError(f"the step '{self._setup_runs()}' of the set-up runs; stop it first")
        recording = Recording(path, realtime=True, loop=True)
        differs = difference(self._source.camera, recording.camera)
        if differs is not None:
            recording.close()
            what, ours, theirs = differs
            raise UserError(
                f"this recording is of {what} {theirs}, and the service uses {ours}; start a "
                f"service for it: halo serve --source 'recording:{path}'"
            )
        self._replayed = path.name
        self._source.show(recording)
        return {}

    def _stop_replay(self, request: dict[str, Any]) -> dict[str, Any]:
        del request
        self._source.show(None)
        return {}


class _Recording:
    """Writes the frames of the live loop in a thread of its own."""

    def __init__(
        self, path: Path, source: SwitchedSource, observer: PageObserver, colour: bool
    ) -> None:
        self.name = path.name
        self.result = ""
        """How it went; empty while it runs."""
        camera = source.camera
        self._observer = observer
        self._tap = FrameTap(source.kind, camera, WAITING)
        self._recorder = Recorder(path, camera, fps=camera.fps, colour=colour)
        self._stopped = threading.Event()
        observer.taps.add(self._tap.put)
        self._thread = threading.Thread(target=self._run, name="record", daemon=True)
        self._thread.start()

    @property
    def runs(self) -> bool:
        return self._thread.is_alive()

    def close(self) -> None:
        """Stop and complete the file."""
        self._stopped.set()
        self._thread.join()

    def _run(self) -> None:
        try:
            with self._recorder:
                recorded = copy_frames(self._tap, self._recorder, LONGEST_S, self._stopped)
            self.result = _sentence(recorded)
        except UserError as error:
            self.result = str(error)
        finally:
            self._observer.taps.discard(self._tap.put)


def _sentence(recorded: Recorded) -> str:
    lost = recorded.lost + recorded.bad
    return f"{recorded.frames} frames" + (f", {lost} lost" if lost else "")


def _recordings() -> list[Path]:
    """Return the newest recordings that were made here, newest first."""
    return sorted(_folder().glob("*.mkv"), reverse=True)[:MOST_SHOWN]


def _folder() -> Path:
    return data_folder() / "recordings"
