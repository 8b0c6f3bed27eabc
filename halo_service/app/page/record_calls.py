"""Recordings from the page: into the user's data folder, under a name made here."""

from __future__ import annotations

import threading
from datetime import datetime
from pathlib import Path
from typing import Any

from halo_service.app.page.frame_tap import FrameTap
from halo_service.app.page.observer import PageObserver
from halo_service.app.recordings.record import Recorded, copy_frames
from halo_service.errors import UserError
from halo_service.files import data_folder
from halo_service.geometry.camera import Camera
from halo_service.outputs.recorder import Recorder
from halo_service.values import SourceKind
from halo_service.web.control_page.calls import Call

LONGEST_S = 600.0
WAITING = 30
MOST_SHOWN = 50


class RecordCalls:
    """One recording at a time."""

    def __init__(self, kind: SourceKind, camera: Camera, observer: PageObserver) -> None:
        self._kind, self._camera, self._observer = kind, camera, observer
        self._running: _Recording | None = None

    def table(self) -> dict[str, Call]:
        """Return the calls."""
        return {
            "recordings": Call(self._list, reads=True),
            "start-recording": Call(self._start),
            "stop-recording": Call(self._stop),
        }

    def close(self) -> None:
        """Complete a recording."""
        if self._running is not None:
            self._running.close()

    def _list(self, request: dict[str, Any]) -> dict[str, Any]:
        del request
        files = sorted(_folder().glob("*.mkv"), reverse=True)[:MOST_SHOWN]
        running = self._running
        return {
            "recordings": [
                {"name": each.name, "path": str(each), "bytes": each.stat().st_size}
                for each in files
            ],
            "running": running is not None and running.runs,
            "result": running.result if running else "",
        }

    def _start(self, request: dict[str, Any]) -> dict[str, Any]:
        if self._running is not None and self._running.runs:
            raise UserError("a recording runs already; stop it first")
        colour = request.get("colour") is True and self._camera.colour is not None
        folder = _folder()
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError(f"{folder} cannot be made ({error.strerror})") from error
        path = folder / f"{datetime.now():%Y-%m-%d %H.%M.%S}.mkv"
        self._running = _Recording(path, self._kind, self._camera, self._observer, colour)
        return {"path": str(path)}

    def _stop(self, request: dict[str, Any]) -> dict[str, Any]:
        del request
        if self._running is None:
            raise UserError("no recording runs")
        self._running.close()
        return {"result": self._running.result}


class _Recording:
    """Writes the frames of the live loop in a thread of its own."""

    def __init__(
        self,
        path: Path,
        kind: SourceKind,
        camera: Camera,
        observer: PageObserver,
        colour: bool,
    ) -> None:
        self.result = ""
        """How it went; empty while it runs."""
        self._observer = observer
        self._tap = FrameTap(kind, camera, WAITING)
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


def _folder() -> Path:
    return data_folder() / "recordings"
