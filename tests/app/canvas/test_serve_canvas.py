"""A canvas is an ordinary surface for its clients, through real Zenoh sessions."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from dataclasses import dataclass, field, replace
from pathlib import Path

import pytest

import halo_client
import halo_protocol as wire
from halo_client.source import ZenohSource
from halo_service.app.canvas.merger import Merger
from halo_service.app.canvas.nodes import follow_nodes
from halo_service.app.canvas.publisher import CanvasPublisher
from halo_service.app.cli import main
from halo_service.canvas.layout import Layout, PlacedSurface, load
from halo_service.host_clock import CLOCK
from halo_service.outputs.frame_encoder import FrameEncoder
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.outgoing import Outgoing, OutgoingFrame, OutgoingReport
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput
from tests.app.bridge.test_bridge import Port, opened_router, until
from tests.app.conftest import HALO, Spawn
from tests.outputs.samples import SIZE_MM, TOUCHING, frame

LAYOUT = """
width_mm = 560.0
height_mm = 200.0
[[surface]]
node = "left"
[[surface]]
node = "right"
x_mm = 260.0
[[projector]]
width_px = 1280
height_px = 800
projector_from_canvas = [[4, 0, 0], [0, 4, 0], [0, 0, 1]]
[[projector]]
name = "east"
width_px = 1280
height_px = 800
points = [[280, 0, 0, 0], [560, 0, 1280, 0], [560, 200, 1280, 800], [280, 200, 0, 800]]
"""
SEEN_LEFT = replace(TOUCHING, u=270.0 / 300.0, x_mm=270.0, y_mm=100.0, v=0.5)
SEEN_RIGHT = replace(TOUCHING, u=12.0 / 300.0, x_mm=12.0, y_mm=100.0, v=0.5, id=31)
"""One finger that both see, 2 mm apart on the canvas."""


@dataclass
class Node:
    """A service without a camera."""

    name: str
    endpoint: str
    pointer: wire.Pointer
    number: int = 0
    closed: bool = False
    output: ZenohOutput = field(init=False)

    def __post_init__(self) -> None:
        settings = ZenohSettings(listen=(self.endpoint,))
        self.output = ZenohOutput(settings, self.name, "table")

    def close(self) -> None:
        """Once, also where the test fails before: an open session would block the exit."""
        if not self.closed:
            self.closed = True
            self.output.close()

    def send(self) -> None:
        self.number += 1
        time_us = time.time_ns() // 1000
        header = wire.Frame(
            self.name, f"s{self.name}", self.number, *divmod(time_us, 10**6), 1, self.number * 33
        )
        self.output.send(OutgoingReport("table", self.scene))
        self.output.send(OutgoingFrame("table", SIZE_MM, header, (self.pointer,), (), ()))

    @property
    def scene(self) -> wire.Scene:
        return wire.Scene(self.name, f"s{self.name}", wire.VERSION, *SIZE_MM, 2, 1, 2, 30.0)


@pytest.fixture
def stack() -> Iterator[ExitStack]:
    with ExitStack() as stack:
        yield stack


def pointers(port: Port) -> list[wire.Pointer]:
    return [each for each in port.messages() if isinstance(each, wire.Pointer)]


def test_a_client_of_the_canvas_gets_one_finger_with_the_right_homography(
    spawn: Spawn, free_port: Callable[[], int], stack: ExitStack, tmp_path: Path
) -> None:
    every, east = Port(), Port()
    for port in (every, east):
        stack.callback(port.close)
    ends = [f"tcp/127.0.0.1:{free_port()}" for _ in range(3)]
    nodes = [Node("left", ends[0], SEEN_LEFT), Node("right", ends[1], SEEN_RIGHT)]
    for node in nodes:
        stack.callback(node.close)
    (layout := tmp_path / "layout.toml").write_text(LAYOUT)
    (config := tmp_path / "halo.toml").write_text(f'node = "hall"\n[web]\nport = {free_port()}\n')
    canvas = spawn(
        HALO, "canvas", "serve", layout, "--config", config, "--connect", ends[0],
        "--connect", ends[1], "--zenoh-listen", ends[2], "--control-port", str(free_port()),
        "--osc", every.place, "--osc", f"{east.place}/frames,surface=table-east",
    )  # fmt: skip
    after: list[wire.Pointer] = []

    def merged() -> bool:
        for node in nodes:
            node.send()
        every.got.clear()
        after[:] = pointers(every)
        ours = [each for each in after if 270.3 < each.x_mm < 271.7]
        return len(ours) == len(after) > 0

    until(merged, every_s=0.03)
    (finger,) = {each.id: each for each in after}.values()
    assert finger.u == pytest.approx(finger.x_mm / 560.0)
    assert (finger.state, finger.slot, finger.contacts) == (1, 0, 1)

    def reported() -> bool:
        nodes[0].send()
        wanted = {wire.Scene, wire.Health, wire.Homography, wire.Pointer}
        return all(
            wanted <= {type(message) for message in port.messages()} for port in (every, east)
        )

    until(reported, every_s=0.03)
    (scene,) = {each for each in every.messages() if isinstance(each, wire.Scene)}
    assert (scene.node, scene.width_mm, scene.calibration) == ("hall-canvas", 560.0, 2)
    placed = {port: set() for port in (every, east)}
    for port, found in placed.items():
        found |= {
            (surface, message.projector_from_surface[2])
            for each in port.drain()
            for surface, message in wire.decode(each)
            if isinstance(message, wire.Homography)
        }
    assert {surface for surface, _ in placed[every]} == {"table"}
    assert {surface for surface, _ in placed[east]} == {"table-east"}
    url = f"zenoh://?connect={ends[2]}&node=hall-canvas&surface=table-east"
    with halo_client.connect(url) as client:  # the nodes send nothing any more
        until(lambda: client.poll(0.05) is None or client.services.homographies)
    nodes[1].close()
    every.got.clear()

    def ended() -> bool:
        headers = [each for each in every.messages() if isinstance(each, wire.Frame)]
        return bool(headers) and headers[-1].count == 0

    until(ended, 6.0, 0.05)
    ups = {(each.id, each.contacts) for each in every.messages() if isinstance(each, wire.Up)}
    assert ups == {(finger.id, 1)}
    canvas.send_signal(signal.SIGTERM)
    assert canvas.wait(20.0) == 0
    assert canvas.stderr is not None
    said = canvas.stderr.read()
    assert "left/table: " in said
    assert "right/table is lost; its touches are ended" in said


class Collected:
    """A carrier that collects what it gets."""

    def __init__(self) -> None:
        self.frames: list[OutgoingFrame] = []

    def send(self, outgoing: Outgoing) -> None:
        if isinstance(outgoing, OutgoingFrame):
            self.frames.append(outgoing)

    def close(self) -> None:
        pass


def test_a_router_that_is_killed_and_restarted_leaves_no_finger_and_brings_all_back(
    free_port: Callable[[], int], stack: ExitStack
) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    router = opened_router(endpoint)
    settings = ZenohSettings(listen=("tcp/127.0.0.1:0",), connect=(endpoint,))
    outputs = [
        stack.enter_context(closing(ZenohOutput(settings, name, "table")))
        for name in ("left", "right")
    ]
    layout = Layout(560.0, 200.0, (PlacedSurface("left"), PlacedSurface("right", x_mm=260.0)))
    collected = Collected()
    names = NameWatch("hall", "s1")
    publisher = CanvasPublisher(
        layout, FrameEncoder("hall", "s1", 0), [collected], names, 0, lambda: 0
    )
    merger = Merger(layout, publisher)
    nodes = [(each.node, each.surface) for each in layout.surface]
    follow_nodes(nodes, ZenohSource((endpoint,)), merger.handle, stack)
    number = 0

    def turn() -> None:
        nonlocal number
        number += 1
        for output, name in zip(outputs, ("left", "right"), strict=True):
            outgoing = frame(number, (TOUCHING,))
            header = replace(outgoing.header, node=name)
            output.send(replace(outgoing, header=header))
        merger.turn()

    def shows(count: int) -> Callable[[], bool]:
        def showing() -> bool:
            turn()
            return bool(collected.frames) and collected.frames[-1].header.count == count

        return showing

    until(shows(2), every_s=0.02)
    before = {pointer.id for pointer in collected.frames[-1].pointers}
    router.close()
    until(shows(0), 8.0, 0.05)
    assert {up.id for each in collected.frames for up in each.ups} == before
    stack.callback(opened_router(endpoint).close)
    until(shows(2), every_s=0.02)
    assert not before & {pointer.id for pointer in collected.frames[-1].pointers}
    numbers = [each.header.frame for each in collected.frames]
    assert numbers == list(range(len(numbers)))


class Healths(Collected):
    """A carrier that collects healths."""

    def __init__(self) -> None:
        super().__init__()
        self.healths: list[wire.Health] = []

    def send(self, outgoing: Outgoing) -> None:
        if isinstance(outgoing, OutgoingReport) and isinstance(outgoing.message, wire.Health):
            self.healths.append(outgoing.message)


def test_its_latency_has_that_of_its_nodes_so_that_a_canvas_of_it_is_not_late() -> None:
    layout = Layout(300.0, 200.0, (PlacedSurface("left"),))
    carrier, names = Healths(), NameWatch("hall", "s1")
    publisher = CanvasPublisher(
        layout, FrameEncoder("hall", "s1", 0), [carrier], names, 0, lambda: 0
    )
    merger = Merger(layout, publisher)
    merger.turn()
    node = wire.Health("left", "s1", 30.0, 200.0, 0, 0, 3, 1)
    merger.handle(("left", "table"), [wire.Report("table", node)])
    for number in range(35):
        exposed_us = CLOCK.unix_us() - 200_000
        sent = wire.TouchFrame("table", "left", "s1", number, exposed_us, ())
        merger.handle(("left", "table"), [sent])
        time.sleep(0.03)
    merger.turn()
    before, after = carrier.healths
    assert before.latency_ms == -1.0
    assert after.latency_ms >= 190.0


@pytest.mark.parametrize(
    ("layout", "options", "says"),
    [
        (None, [], "file not found; check the path"),
        ("width_mm = 1", [], "'height_mm' is missing"),
        (LAYOUT, ["--node", "left"], "choose another name for the canvas with --node"),
        (LAYOUT, ["--node", "Left"], "--node"),
        (LAYOUT, ["--connect", "nonsense"], "write endpoints as tcp/HOST:PORT"),
        (LAYOUT, ["--osc", "nowhere"], "is not a destination"),
        ('name = "sim"\n' + LAYOUT, [], "change its name in the layout"),
    ],
)
def test_what_is_wrong_is_one_sentence(
    layout: str | None,
    options: list[str],
    says: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    file = tmp_path / "layout.toml"
    if layout is not None:
        file.write_text(layout)
    assert main(["canvas", "serve", str(file), "--no-web", "--no-zenoh", *options]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert says in said[-1]
    assert len([each for each in said if not each.startswith("halo: zenoh")]) == 1


def test_it_needs_no_camera_and_no_hand_tracker(tmp_path: Path) -> None:
    (file := tmp_path / "layout.toml").write_text(LAYOUT)
    assert len(load(file).projector) == 2
    script = (
        "import sys; from halo_service.app.canvas import run; from halo_service.web import server;"
        "from halo_service.settings import load; load(None); print(*sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    imported = set(done.stdout.split())
    assert "halo_service.app.canvas.run" in imported, done.stderr
    rooms = ("sources", "hand_tracking", "virtual", "evaluation")
    assert not {"mediapipe", "pyk4a", *(f"halo_service.{room}" for room in rooms)} & imported
