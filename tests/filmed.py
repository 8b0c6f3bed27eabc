"""One recording of a virtual person who follows prompts, and the script of what they did when."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np

from halo_calibration.boards.board import Projected
from halo_calibration.guided.guide import Prompt
from halo_service.app.virtual_user.user import VirtualUser
from halo_service.outputs.recorder import Recorder
from halo_service.virtual.room import Room

Line = dict[str, float | str]


class Film:
    """A recording as it is being made; its script and its person lie open."""

    def __init__(self, room: Room, recorder: Recorder) -> None:
        self.user = VirtualUser(room, colour_times=1)
        self.script: list[Line] = []
        self._recorder = recorder
        self._index = 0

    def pause(self, seconds: float) -> None:
        """Let the person go on while nothing is recorded."""
        self.user.skip(seconds)
        self._index += round(seconds * self.user.camera.fps)

    def record(self, frames: int) -> tuple[float, float]:
        """Record what the person does now; return from when to when, seconds."""
        fps = self.user.camera.fps
        from_s = self._index / fps
        for _ in range(frames):
            # Matroska counts in milliseconds.
            time_us = round(self._index * 1e3 / fps) * 1000
            self._recorder.write(dataclasses.replace(self.user.read(1.0), time_us=time_us))
            self._index += 1
        return from_s, (self._index - 0.5) / fps

    def step(self, step: str, frames: int, **fields: float | str) -> None:
        """Record a step of the calibration."""
        from_s, to_s = self.record(frames)
        self.script.append({"step": step, "from_s": from_s, "to_s": to_s, **fields})

    def board(self, frames: int) -> None:
        """Record the projector's board, then darkness again."""
        width, height = self.user.projector_px
        picture = Projected(width, height).picture()
        self.user.project(np.repeat(picture[..., None], 3, axis=2))
        self.user.follow(Prompt("board", ""))
        self.step("projector", frames, width_px=width, height_px=height)
        self.user.project(np.zeros((height, width, 3), np.uint8))

    def written(self, folder: Path) -> Path:
        """Write the script into a folder."""
        script = folder / "script.json"
        script.write_text(json.dumps(self.script))
        return script
