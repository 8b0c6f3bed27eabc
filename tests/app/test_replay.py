"""`halo replay`: the service's golden test. The same recording gives the same bytes."""

from __future__ import annotations

import json
import math
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from halo_service.app.cli import main
from halo_service.app.virtual_user.cache import cached_profile
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.outputs.jsonl import frame_line
from halo_service.outputs.recorder import Recorder
from halo_service.profile import Profile
from halo_service.profile.store import save
from halo_service.sensing.detector import Detector
from halo_service.sensing.pointers import describe
from halo_service.settings import Settings
from halo_service.values import Contact, Finger, Fingertip, Side, Signal, TouchFrame
from halo_service.virtual.offline import frames
from halo_service.virtual.sim_url import parse_sim_url
from tests.kind_sensor import KIND_URL

SECONDS = 3.5
MODE = "NFOV_2X2BINNED"
"""A quarter of the pixels: the recording is read seven times."""


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recording of the virtual demo, its truth, and a profile of its room."""
    return recorded(tmp_path_factory.mktemp("session"), MODE)


def recorded(folder: Path, mode: str) -> Path:
    request = parse_sim_url(f"sim:demo?seed=3&mode={mode}&{KIND_URL}")
    camera, truth = request.room.camera(), []
    with Recorder(folder / "recording.mkv", camera, fps=camera.fps, colour=True) as recorder:
        for frame, lines in frames(request, SECONDS):
            if frame is not None:
                recorder.write(frame)
            truth += lines
    (folder / "truth.json").write_text(json.dumps(truth))
    save(cached_profile(request.room, Settings(), virtual_profile), folder / "profile")
    return folder


def replay(session: Path, out: Path, *options: str) -> list[dict[str, Any]]:
    assert main(["replay", str(session / "recording.mkv"), "--jsonl", str(out), *options]) == 0
    return [json.loads(line) for line in out.read_text().splitlines()]


@pytest.mark.slow
def test_rendered_frames_become_touches_and_twice_the_same(session: Path, tmp_path: Path) -> None:
    profile = ("--profile", str(session / "profile"))
    lines = replay(session, tmp_path / "once.jsonl", *profile)
    replay(session, tmp_path / "again.jsonl", *profile)
    assert (tmp_path / "once.jsonl").read_bytes() == (tmp_path / "again.jsonl").read_bytes()

    pointers = [pointer for line in lines for pointer in line["pointers"]]
    assert len(pointers) > 0.8 * len(lines)
    assert {pointer["state"] for pointer in pointers} == {"hover", "touch"}
    assert {"diagnostics", "u", "v", "hover_mm", "pressure", "force_g"} <= set(pointers[0])
    downs = [event for line in lines for event in line["events"] if event["kind"] == "down"]
    contacts = [
        line for line in json.loads((session / "truth.json").read_text()) if "contact" in line
    ]
    # The virtual sensor's truth against what was sensed of it: a first sight, not the bench.
    assert len(contacts) * 0.5 <= len(downs) <= len(contacts) * 1.5


@pytest.mark.slow
def test_touches_are_found_at_15_frames_a_second(tmp_path: Path) -> None:
    folder = recorded(tmp_path, "WFOV_UNBINNED")
    lines = replay(folder, tmp_path / "lines.jsonl", "--profile", str(folder / "profile"))
    times = [line["time_us"] for line in lines]
    assert min(later - earlier for earlier, later in pairwise(times)) > 60_000
    downs_us = [
        line["time_us"] for line in lines for event in line["events"] if event["kind"] == "down"
    ]
    truth = json.loads((folder / "truth.json").read_text())
    contacts = [line["contact"] for line in truth if "contact" in line]
    assert len(contacts) == 2
    for down_us, contact in zip(downs_us, contacts, strict=False):  # a third has not ended
        assert abs(down_us - contact["from_us"]) < 70_000


DIAGNOSTICS = (
    "camera_mm", "tip_px", "halo", "halo_corrected", "level", "top_mm", "pitch_deg", "yaw_deg",
    "dent_mm", "probability", "height_deviation_mm", "force_deviation_g",
)  # fmt: skip


@pytest.mark.parametrize(("read", "written"), [(9.123456, 9.1235), (math.nan, None)])
def test_a_line_has_the_diagnostics_of_a_touch_and_null_for_a_hidden_dent(
    profile: Profile, read: float, written: float | None
) -> None:
    assert profile.touch is not None
    tip = Fingertip(
        Side.RIGHT, Finger.INDEX, (320, 288), (320, 313), (150, 100), (0, 0, 500), 14, 45, 0, 1
    )
    signal, contact = Signal(900.0, 800.0, (900.0, read, read, read)), Contact(True, 1, 0)
    pointer = describe(1, 0, tip, signal, Detector(0.7, 0.5, 0, True), contact, profile.touch)
    line = json.loads(frame_line(TouchFrame(0, "desk", 300.0, 200.0, (pointer,)), "n", "s", 0))
    diagnostics = line["pointers"][0]["diagnostics"]
    assert tuple(diagnostics) == DIAGNOSTICS
    assert [diagnostics["halo"], diagnostics["halo_corrected"], diagnostics["level"]] == [
        900.0,
        800.0,
        0.5,
    ]
    assert (diagnostics["dent_mm"], diagnostics["probability"]) == (written, 0.7)


@pytest.mark.slow
def test_another_method_reports_touches_too_and_twice_the_same(
    session: Path, tmp_path: Path
) -> None:
    options = ("--profile", str(session / "profile"), "--method", "paper")
    lines = replay(session, tmp_path / "once.jsonl", *options)
    replay(session, tmp_path / "again.jsonl", *options)
    assert (tmp_path / "once.jsonl").read_bytes() == (tmp_path / "again.jsonl").read_bytes()
    kinds = [event["kind"] for line in lines for event in line["events"]]
    assert kinds.count("down") > 0
    assert kinds.count("down") - kinds.count("up") in (0, 1)  # the take may end in a touch


@pytest.mark.slow
def test_without_a_profile_there_are_frames_without_pointers(session: Path, tmp_path: Path) -> None:
    lines = replay(session, tmp_path / "none.jsonl")
    assert [line["frame"] for line in lines] == list(range(len(lines)))
    assert all(line["pointers"] == [] and line["events"] == [] for line in lines)


@pytest.mark.slow
def test_a_recording_that_breaks_off_leaves_no_file(session: Path, tmp_path: Path) -> None:
    whole = (session / "recording.mkv").read_bytes()
    (tmp_path / "cut.mkv").write_bytes(whole[: len(whole) // 2])
    code = main(["replay", str(tmp_path / "cut.mkv"), "--jsonl", str(tmp_path / "out.jsonl")])
    assert code == 2
    assert [path.name for path in tmp_path.iterdir()] == ["cut.mkv"]


def test_the_real_recording_is_one_frame_without_pointers(
    company_data: Path, tmp_path: Path
) -> None:
    out = tmp_path / "desk.jsonl"
    assert main(["replay", str(company_data / "azure_kinect_desk.mkv"), "--jsonl", str(out)]) == 0
    (line,) = [json.loads(line) for line in out.read_text().splitlines()]
    assert line["time_us"] == 463945
    assert line["pointers"] == []


def test_an_unknown_method_is_answered_with_the_known_ones(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out.jsonl"
    code = main(["replay", str(tmp_path / "any.mkv"), "--jsonl", str(out), "--method", "magic"])
    assert code == 2
    assert "unknown method 'magic'; choose from: ours" in capsys.readouterr().err
    assert not out.exists()
