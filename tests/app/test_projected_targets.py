"""From one recording and its script to touches that land where the projector's light is.

Only the recording is passed on: the room is calibrated, the touches are sensed and published as a
client receives them, and the homography maps them to the projector. At the end comes the truth.
"""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from halo_calibration.boards.board import SHEET
from halo_calibration.guided.guide import PROMPTS, Prompt
from halo_service.app.cli import main
from halo_service.app.virtual_user.user import STATES
from halo_service.geometry.camera import Points
from halo_service.outputs.recorder import Recorder
from halo_service.profile.store import load
from halo_service.virtual.camera import factory
from halo_service.virtual.room import Room, draw_room
from tests.filmed import Film
from tests.kind_sensor import KIND_ROOM

pytestmark = pytest.mark.long

SEED = 205
TARGETS = [(x, y) for y in (280.0, 520.0) for x in (420.0, 650.0, 880.0)]
"""In the projector's pixels."""
READY_S = 1.5
"""From a prompt to the finger that holds its state."""
BOARD, HELD, TOUCHED = 12, 30, 69
"""Frames of a board, of a state, and from one target, touched once, to the next."""
WITHIN_MM = 3.0


def film(room: Room, out: Path) -> Film:
    """Record the empty table, the sheet, the board, the four states, and the touched targets."""
    with Recorder(out, factory(), fps=factory().fps, colour=True) as recorder:
        made = Film(room, recorder)
        made.user.follow(PROMPTS["background"])
        made.step("background", 60)
        made.user.follow(Prompt("sheet", "", board=SHEET))
        made.step("surface", BOARD, by="markers")
        made.board(BOARD)
        for state, (height_mm, force_g) in STATES.items():
            made.user.follow(PROMPTS[state])
            made.pause(READY_S)
            known = {"force_g": force_g} if force_g else {"height_mm": height_mm}
            made.step(state, HELD, **known)
        for target in TARGETS:
            made.user.follow(Prompt("cross", "", at_px=target))
            made.record(TOUCHED)
    return made


def through(matrix: Points, points: Points) -> Points:
    """(N, 2) points through a (3, 3) homography."""
    there = np.column_stack([points, np.ones(len(points))]) @ matrix.T
    return np.asarray(there[:, :2] / there[:, 2:], dtype=np.float64)


def test_touches_land_where_the_projected_targets_are(tmp_path: Path) -> None:
    room, recording, profile = (
        draw_room(SEED, exposure_ms=4.0, **KIND_ROOM),
        tmp_path / "recording.mkv",
        "placed",
    )
    script = film(room, recording).written(tmp_path)
    place = str(tmp_path / profile)
    made = ["calibrate", "--source", f"recording:{recording}", "--script", str(script)]
    assert main([*made, "--profile", place]) == 0
    published = tmp_path / "published.jsonl"
    assert main(["replay", str(recording), "--profile", place, "--jsonl", str(published)]) == 0

    known = load(Path(place))
    assert known.projector is not None
    size_mm = known.surface.width_mm, known.surface.height_mm
    events = [
        event for line in published.read_text().splitlines() for event in json.loads(line)["events"]
    ]
    downs = np.array([(e["u"], e["v"]) for e in events if e["kind"] == "down"]) * size_mm
    # What a client draws lies where the room's own projector throws that pixel.
    table_from_projector = np.linalg.inv(room.projector.projector_from_surface())
    drawn = through(table_from_projector, through(known.projector.projector_from_surface, downs))
    targets = through(table_from_projector, np.array(TARGETS))
    apart = np.linalg.norm(drawn[:, None] - targets[None], axis=2)
    off, meant = apart.min(axis=1), apart.argmin(axis=1)
    print(f"{len(off)} touches: median {np.median(off):.1f} mm, at most {off.max():.1f} mm")
    assert set(meant.tolist()) == set(range(len(TARGETS)))
    assert len(off) == len(TARGETS)
    assert off.max() <= WITHIN_MM
