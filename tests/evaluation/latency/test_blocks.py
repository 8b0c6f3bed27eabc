"""Both arrangements on the same frames: counts are complete, however slow the machine is."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from halo_calibration.base_model import choose_base
from halo_calibration.solvers.background import solve_background
from halo_calibration.solvers.plane import solve_plane, surface_from_view
from halo_service.app.benchmarking.bench import Service
from halo_service.app.cli import main
from halo_service.evaluation.latency.blocks import Block, run
from halo_service.evaluation.latency.listener import Listener
from halo_service.evaluation.latency.raw_frames import PacedSource, to_raw, unpack
from halo_service.evaluation.latency.regressor import Regressor, regressor_for
from halo_service.evaluation.latency.simulate import LatencyRecording, simulate
from halo_service.evaluation.latency.stopwatch import Stopwatch
from halo_service.outputs.recorder import Recorder
from halo_service.profile import Profile, TouchState, TouchStates
from halo_service.profile.store import save
from halo_service.settings import Settings, TrackingSettings
from halo_service.sources import EndOfSource
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import parse_sim_url
from tests.kind_sensor import KIND_URL

SIM = f"sim:pointing?seed=201&{KIND_URL}"

SECONDS = 0.5
STAGES = {
    "ours": ["wait", "unpack", "sense", "encode", "send"],
    "sequential": [
        "wait", "unpack", "decode", "warp", "blend", "hands", "halo", "correct", "touch",
        "encode", "send",
    ],
}  # fmt: skip
STATES = TouchStates(
    hover=TouchState(500.0, 10.0, 0.0),
    subtle=TouchState(1500.0, 1.0, 0.0),
    touch=TouchState(2000.0, 0.0, 25.0),
    pressure=TouchState(3000.0, 0.0, 200.0),
    line_px_at_hover=6.0,
    finger_thickness_mm=14.0,
)


@pytest.fixture(scope="module")
def recording() -> LatencyRecording:
    return simulate("sim:pointing", parse_sim_url(SIM), SECONDS, lambda: None)


@pytest.fixture(scope="module")
def profile(recording: LatencyRecording) -> Profile:
    sensor = Sensor(parse_sim_url(SIM).room, colour_times=0)
    background = solve_background([sensor.frame(33_333 * k).depth for k in range(45)])
    surface = surface_from_view(solve_plane(background, recording.camera))
    return Profile("bench", recording.camera, surface, background, STATES, 1)


@pytest.fixture(scope="module")
def regressor(recording: LatencyRecording, profile: Profile) -> Regressor:
    fitted = regressor_for(profile, choose_base("auto", recording.camera.serial))
    assert fitted is not None
    return fitted


@pytest.fixture(scope="module")
def blocks(recording: LatencyRecording, profile: Profile, regressor: Regressor) -> list[Block]:
    settings = Settings(tracking=TrackingSettings(max_hands=1))
    with Listener() as listener:
        service = Service(recording, profile, regressor, settings)
        return list(run(recording, service, listener, rounds=2))


def test_the_two_take_turns_and_the_first_one_alternates(
    blocks: list[Block],
) -> None:
    order = [block.arrangement for block in blocks]
    assert order == ["ours", "sequential", "sequential", "ours"]


def test_both_get_the_same_frames_and_publish_each_that_they_read(
    recording: LatencyRecording, blocks: list[Block]
) -> None:
    offered = [each.time_us for each in recording.frames]
    assert len(offered) == round(30 * SECONDS)
    for block in blocks:
        published = [row.time_us for row in block.rows]
        assert block.offered == len(offered)
        assert len(published) + block.dropped == block.offered
        assert set(published) <= set(offered)
        assert published == sorted(set(published))


def test_every_packet_reached_the_client(blocks: list[Block]) -> None:
    for block in blocks:
        assert block.received.frames == len(block.rows) + block.extra_packets
        assert block.received.datagrams >= block.received.frames


def test_the_papers_order_finds_a_hand_and_runs_the_regressor_in_time(blocks: list[Block]) -> None:
    for block in blocks:
        corrected = any("correct" in row.stages_ns for row in block.rows)
        assert corrected == (block.arrangement == "sequential")


def test_each_frame_passed_every_stage_in_order(blocks: list[Block]) -> None:
    for block in blocks:
        for row in block.rows:
            found = block.arrangement == "ours" or "correct" in row.stages_ns
            skipped = () if found else ("halo", "correct")  # a frame without hands
            expected = [name for name in STAGES[block.arrangement] if name not in skipped]
            assert list(row.stages_ns) == expected
            assert all(each >= 0 for each in row.stages_ns.values())
            assert row.latency_ns == sum(row.stages_ns.values())


def test_frames_come_out_as_they_went_in(recording: LatencyRecording) -> None:
    frame = unpack(recording.frames[0], recording.camera)
    assert frame.depth.shape == frame.ir.shape == (576, 640)
    again = to_raw(frame)
    assert (again.time_us, again.depth, again.ir) == (
        frame.time_us,
        frame.depth.tobytes(),
        frame.ir.tobytes(),
    )
    assert again.jpeg == frame.colour == recording.frames[0].jpeg


def test_a_late_reader_gets_the_newest_frame_and_what_it_missed_is_counted(
    recording: LatencyRecording,
) -> None:
    # A millionth of a second apart: when the first has been read, all others are due.
    at_once = [replace(each, time_us=n) for n, each in enumerate(recording.frames)]
    player = PacedSource(at_once, recording.camera, recording.kind, Stopwatch())
    first, newest = player.read(1.0), player.read(1.0)
    assert first is not None and newest is not None
    assert (first.time_us, newest.time_us) == (0, len(at_once) - 1)
    assert player.dropped == len(at_once) - 2
    with pytest.raises(EndOfSource):
        player.read(1.0)


def test_too_few_samples_give_no_regressor(profile: Profile) -> None:
    assert profile.correction is None
    assert regressor_for(profile, None) is None


def test_a_recording_is_measured_with_its_profile_into_json(
    recording: LatencyRecording,
    profile: Profile,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    with Recorder(tmp_path / "x.mkv", recording.camera, fps=30, colour=True) as recorder:
        for each in recording.frames:
            recorder.write(unpack(each, recording.camera))
    save(profile, tmp_path / "desk")
    options = ("--hands", "1", "--seconds", "9", "--profile", str(tmp_path / "desk"))
    files = ("--source", f"recording:{tmp_path / 'x.mkv'}", "--json", str(tmp_path / "x.json"))
    monkeypatch.setattr("halo_service.app.benchmarking.bench.ROUNDS", 1)
    assert main(["bench", *options, *files]) == 0
    report = json.loads((tmp_path / "x.json").read_text())
    assert set(report) == {"halo_bench", "protocol", "machine", "cases"}
    (case,) = report["cases"]
    assert (case["hands"], case["contacts"]) == (1, None)  # a recording's truth is unknown
    for name in ("ours", "sequential"):
        figures = case[name]
        assert figures["frames"] + figures["dropped"] == len(recording.frames)
        assert figures["received"] == figures["frames"]
        assert list(figures["stages"]) == STAGES[name]
    assert [goal["name"] for goal in case["goals"]] == [
        "received -> sent, median",
        "received -> sent, p99",
        "sequential order / ours, median",
    ]
    assert "one hand: recording:" in capsys.readouterr().out
