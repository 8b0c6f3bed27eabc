"""Both arrangements on the same frames: what is counted is whole, whatever the machine does."""

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
from halo_service.evaluation.latency.raw_frames import Player, handed, unpacked
from halo_service.evaluation.latency.regressor import Regressor, regressor_for
from halo_service.evaluation.latency.simulate import Take, draw
from halo_service.evaluation.latency.stopwatch import Stopwatch
from halo_service.outputs.recorder import Recorder
from halo_service.profile import HeldState, Profile, TouchStates
from halo_service.profile.store import save
from halo_service.settings import Settings, TrackingSettings
from halo_service.sources import EndOfSource
from halo_service.virtual.sensor import Sensor
from halo_service.virtual.sim_url import parse_sim_url

SECONDS = 0.5
STAGES = {
    "ours": ["wait", "unpack", "sense", "encode", "send"],
    "sequential": [
        "wait", "unpack", "decode", "warp", "blend", "hands", "halo", "correct", "touch",
        "encode", "send",
    ],
}  # fmt: skip
STATES = TouchStates(
    hover=HeldState(500.0, 10.0, 0.0),
    subtle=HeldState(1500.0, 1.0, 0.0),
    touch=HeldState(2000.0, 0.0, 25.0),
    pressure=HeldState(3000.0, 0.0, 200.0),
    line_px_at_hover=6.0,
    finger_thickness_mm=14.0,
)


@pytest.fixture(scope="module")
def take() -> Take:
    return draw("sim:pointing", parse_sim_url("sim:pointing?seed=201"), SECONDS, lambda: None)


@pytest.fixture(scope="module")
def profile(take: Take) -> Profile:
    sensor = Sensor(parse_sim_url("sim:pointing?seed=201").room, colour_times=0)
    background = solve_background([sensor.frame(33_333 * k).depth for k in range(45)])
    surface = surface_from_view(solve_plane(background, take.camera))
    return Profile("bench", take.camera, surface, background, STATES, 1)


@pytest.fixture(scope="module")
def regressor(take: Take, profile: Profile) -> Regressor:
    fitted = regressor_for(profile, choose_base("auto", take.camera.serial))
    assert fitted is not None
    return fitted


@pytest.fixture(scope="module")
def blocks(take: Take, profile: Profile, regressor: Regressor) -> list[Block]:
    settings = Settings(tracking=TrackingSettings(max_hands=1))
    with Listener() as listener:
        service = Service(take, profile, regressor, settings)
        return list(run(take, service, listener, rounds=2))


def test_the_two_take_turns_and_every_other_round_begins_with_the_other(
    blocks: list[Block],
) -> None:
    order = [block.arrangement for block in blocks]
    assert order == ["ours", "sequential", "sequential", "ours"]


def test_both_were_offered_the_same_frames_and_told_of_each_that_they_took(
    take: Take, blocks: list[Block]
) -> None:
    offered = [each.time_us for each in take.captures]
    assert len(offered) == round(30 * SECONDS)
    for block in blocks:
        told = [row.time_us for row in block.rows]
        assert block.offered == len(offered)
        assert len(told) + block.dropped == block.offered
        assert set(told) <= set(offered)
        assert told == sorted(set(told))


def test_every_packet_reached_the_client(blocks: list[Block]) -> None:
    for block in blocks:
        assert block.heard.frames == len(block.rows) + block.unasked
        assert block.heard.datagrams >= block.heard.frames


def test_the_paper_s_order_finds_a_hand_and_asks_the_regressor_in_time(blocks: list[Block]) -> None:
    for block in blocks:
        asked = any("correct" in row.stages_ns for row in block.rows)
        assert asked == (block.arrangement == "sequential")


def test_each_frame_passed_every_stage_in_order(blocks: list[Block]) -> None:
    for block in blocks:
        for row in block.rows:
            found = block.arrangement == "ours" or "correct" in row.stages_ns
            skipped = () if found else ("halo", "correct")  # a frame without hands
            wanted = [name for name in STAGES[block.arrangement] if name not in skipped]
            assert list(row.stages_ns) == wanted
            assert all(each >= 0 for each in row.stages_ns.values())
            assert row.latency_ns == sum(row.stages_ns.values())


def test_frames_come_out_as_they_went_in(take: Take) -> None:
    frame = unpacked(take.captures[0], take.camera)
    assert frame.depth.shape == frame.ir.shape == (576, 640)
    again = handed(frame)
    assert (again.time_us, again.depth, again.ir) == (
        frame.time_us,
        frame.depth.tobytes(),
        frame.ir.tobytes(),
    )
    assert again.jpeg == frame.colour == take.captures[0].jpeg


def test_a_late_reader_gets_the_newest_frame_and_what_it_missed_is_counted(take: Take) -> None:
    # A millionth of a second apart: when the first has been read, all others are due.
    at_once = [replace(each, time_us=n) for n, each in enumerate(take.captures)]
    player = Player(at_once, take.camera, take.kind, Stopwatch())
    first, newest = player.read(1.0), player.read(1.0)
    assert first is not None and newest is not None
    assert (first.time_us, newest.time_us) == (0, len(at_once) - 1)
    assert player.dropped == len(at_once) - 2
    with pytest.raises(EndOfSource):
        player.read(1.0)


def test_too_few_samples_are_no_regressor(profile: Profile) -> None:
    assert profile.correction is None
    assert regressor_for(profile, None) is None


def test_a_recording_is_benched_with_its_profile_into_json(
    take: Take, profile: Profile, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with Recorder(tmp_path / "x.mkv", take.camera, fps=30, colour=True) as recorder:
        for each in take.captures:
            recorder.write(unpacked(each, take.camera))
    save(profile, tmp_path / "desk")
    asked = ("--hands", "1", "--seconds", "9", "--profile", str(tmp_path / "desk"))
    files = ("--source", f"recording:{tmp_path / 'x.mkv'}", "--json", str(tmp_path / "x.json"))
    assert main(["bench", *asked, *files]) == 0
    said = json.loads((tmp_path / "x.json").read_text())
    assert set(said) == {"halo_bench", "protocol", "machine", "cases"}
    (case,) = said["cases"]
    assert (case["hands"], case["contacts"]) == (1, None)  # nobody knows a recording's truth
    for name in ("ours", "sequential"):
        figures = case[name]
        assert figures["frames"] + figures["dropped"] == 2 * len(take.captures)
        assert figures["heard"] == figures["frames"]
        assert list(figures["stages"]) == STAGES[name]
    assert [goal["name"] for goal in case["goals"]] == [
        "received -> sent, median",
        "received -> sent, p99",
        "sequential order / ours, median",
    ]
    assert "one hand: recording:" in capsys.readouterr().out
