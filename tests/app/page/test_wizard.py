"""The wizard shows what the steps of `halo calibrate` report, undoes them, and checks requests."""

from __future__ import annotations

import json
import struct
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import closing
from dataclasses import replace
from typing import Any

import cv2
import numpy as np
import pytest
from websockets.sync.client import connect

from halo_calibration.errors import CalibrationError
from halo_calibration.guided.guide import PROMPTS, Prompt
from halo_calibration.steps import Setup
from halo_calibration.steps.camera import camera_report
from halo_calibration.steps.place import dragged_change
from halo_service.app.page.frame_tap import FrameTap
from halo_service.app.page.observer import PageObserver
from halo_service.app.page.wizard.page_guide import PageGuide, Stopped
from halo_service.app.page.wizard.page_screen import PageScreen
from halo_service.app.page.wizard.requests import read_request
from halo_service.app.page.wizard.watch import verify_touches
from halo_service.app.page.wizard.wizard import Wizard
from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.app.verification.crossings import Grid
from halo_service.app.verification.session import summary_lines, verify_record
from halo_service.app.verification.verify import grid_of
from halo_service.errors import UserError
from halo_service.profile import Projector
from halo_service.profile.store import exists, load, profile_path
from halo_service.settings import Settings
from halo_service.sources import EndOfSource
from halo_service.sources.switched import SwitchedSource
from halo_service.values import Frame, TouchEvent, TouchFrame
from halo_service.web.control_page.server import PageServer
from halo_service.web.settings import PageSettings
from tests.app.page.test_calls import Noted
from tests.app.page.test_pictures import CAMERA, FLAT_MM, SHAPE, profile

NOISE_MM = np.random.default_rng(1).normal(0.0, 1.0, (6, *SHAPE))


def frame(n: int, mm: float = FLAT_MM, infrared: int = 1000) -> Frame:
    depth = np.rint(mm + NOISE_MM[n % len(NOISE_MM)]).astype(np.uint16)
    return Frame(n * 33_333, depth, np.full(SHAPE, infrared, np.uint16))


# What a step reports.


def test_the_page_shows_prompt_count_down_signal_and_results() -> None:
    shown: list[dict[str, Any]] = []
    followed: list[Prompt] = []
    guide = PageGuide(shown.append, threading.Event(), followed.append)
    guide.prompt(PROMPTS["touch"])
    for left_s in (3.0, 1.5, 0.0):
        guide.live(left_s, False, None)
    guide.map(["██··"])
    guide._shown_s = 0.0
    guide.live(0.9, True, "3 of 4 marks seen")
    guide.say("The hand moved.")
    assert followed == [PROMPTS["touch"]]
    assert shown[0]["prompt"].startswith("TOUCH")
    last = shown[-1]
    assert (last["phase"], last["left_s"], last["seen"]) == ("measure", 0.9, "3 of 4 marks seen")
    assert (last["map"], last["said"]) == (["██··"], ["The hand moved."])


def test_a_step_ends_at_once_when_it_is_stopped() -> None:
    stopped = threading.Event()
    guide = PageGuide(lambda state: None, stopped)
    guide.live(1.0, True, None)
    stopped.set()
    for act in (lambda: guide.live(1.0, True, None), lambda: guide.prompt(PROMPTS["touch"])):
        with pytest.raises(Stopped):
            act()


# The camera's placement, and corners in its picture.


def frames(**kinds: Any) -> list[Frame]:
    return [frame(n, **kinds) for n in range(60)]


def test_a_good_placement_needs_no_advice() -> None:
    report = camera_report(frames(), CAMERA)
    assert report.advice == () and report.quality == "good"
    assert report.height_mm == pytest.approx(FLAT_MM, abs=0.5)
    assert report.tilt_deg < 0.2 and report.measured_share == 1.0


@pytest.mark.parametrize(
    ("kinds", "says"),
    [
        ({"mm": 300.0}, "only 30 cm above"),
        ({"mm": 1200.0}, "120 cm above"),
        ({"infrared": 65_535}, "Too bright: 100 %"),
        ({"infrared": 20}, "Too dark"),
    ],
)
def test_a_bad_placement_says_what_to_do(kinds: dict[str, Any], says: str) -> None:
    (advice,) = camera_report(frames(**kinds), CAMERA).advice
    assert says in advice


def test_a_surface_lies_between_four_corners_of_the_picture() -> None:
    known = profile()
    places = np.array([[20.0, 10.0], [170.0, 10.0], [170.0, 80.0], [20.0, 80.0]])
    px = known.surface.in_picture(places, CAMERA.depth, np.eye(4))
    changed = dragged_change(Setup("desk", CAMERA, "2026-01-01"), px, known)(known)
    surface = changed.surface
    assert (surface.width_mm, surface.height_mm) == (
        pytest.approx(150.0, abs=0.5),
        pytest.approx(70.0, abs=0.5),
    )
    corner = surface.in_picture(np.array([[0.0, 0.0]]), CAMERA.depth, np.eye(4))
    assert np.abs(corner - px[0]).max() < 0.5
    with pytest.raises(CalibrationError, match="order"):
        dragged_change(Setup("desk", CAMERA, "2026-01-01"), px[::-1], known)
    with pytest.raises(CalibrationError, match="four corners"):
        dragged_change(Setup("desk", CAMERA, "2026-01-01"), px[:3], known)


@pytest.mark.parametrize(
    ("step", "request_"),
    [
        ("surface", {"by": "gray"}),
        ("touch", {"by": "view"}),
        ("surface", {"width_mm": 1e9}),
        ("surface", {"width_mm": float("nan")}),
        ("surface", {"width_mm": "300"}),
        ("surface", {"width_mm": True}),
        ("surface", {"corners_px": [[0, 0], [1, 0], [1, 1]]}),
        ("surface", {"corners_px": [[0, 0], [1, 0], [1, 1], [0, "1"]]}),
        ("surface", {"corners_px": [[0, 0], [1, 0], [1, 1], [0, float("inf")]]}),
        ("touch", {"hand": "both"}),
        ("touch", {"press_g": -1}),
        ("anchor", {"marker": 10**9}),
    ],
)
def test_what_a_page_cannot_ask(step: str, request_: dict[str, Any]) -> None:
    with pytest.raises(UserError):
        read_request(step, request_)


def test_what_a_page_asks() -> None:
    corners = [[1, 2], [3, 2], [3, 4], [1, 4]]
    request = read_request("surface", {"by": "picture", "width_mm": 250, "corners_px": corners})
    assert (request.place.by, request.place.width_mm) == ("picture", 250.0)
    assert request.place.corners_px == ((1, 2), (3, 2), (3, 4), (1, 4))


# Frames of the running service.


def test_a_slow_reader_gets_the_newest_frames() -> None:
    tap = FrameTap("camera", CAMERA, waiting=2)
    for n in range(4):
        tap.put(Frame(n, np.zeros((1, 1), np.uint16), np.zeros((1, 1), np.uint16)))
    tap.close()
    assert [tap.read(0.1).time_us for _ in range(2)] == [2, 3]  # type: ignore[union-attr]
    assert tap.dropped == 2
    with pytest.raises(EndOfSource):
        tap.read(0.01)


class Camera:
    """A camera that the service has open."""

    kind = "camera"
    camera = CAMERA

    def read(self, timeout_s: float) -> None:
        """Nothing: the service reads."""

    def close(self) -> None:
        """Nothing."""


@pytest.fixture
def server(free_port: Callable[[], int]) -> Iterator[PageServer]:
    with closing(PageServer(PageSettings(port=free_port()))) as server:
        yield server


def wait_until_done(wizard: Wizard) -> dict[str, Any]:
    until_s = time.monotonic() + 30.0
    while wizard.state()["running"]:
        assert time.monotonic() < until_s
        time.sleep(0.01)
    return wizard.state()


def test_steps_use_the_running_camera_and_can_be_undone(server: PageServer) -> None:
    source = SwitchedSource(Camera())  # type: ignore[arg-type]
    with (
        closing(PageObserver(Noted(), server, CAMERA, lambda: "good", dict)) as observer,
        closing(ProfileReloader(None, CAMERA, None)) as reloader,
        closing(
            Wizard(Settings(), source, observer, reloader, server, threading.Event())
        ) as wizard,
    ):
        table = wizard.table()
        assert table["wizard-profile"].run({"name": "wizard"})["missing"] == [
            "background", "touch", "sweep",
        ]  # fmt: skip
        table["wizard-run"].run({"step": "surface"})
        verdict = wait_until_done(wizard)["verdict"]
        assert not verdict["good"] and "needs the background first" in verdict["text"]

        table["wizard-run"].run({"step": "camera"})
        with pytest.raises(UserError, match="'camera' runs"):
            table["wizard-run"].run({"step": "background"})
        for n in range(90):
            while len(observer.taps) == 0 or next(iter(observer.taps)).__self__._frames.full():  # type: ignore[attr-defined]
                if not wizard.state()["running"]:
                    break
                time.sleep(0.002)
            observer.watch(frame(n))
        state = wait_until_done(wizard)
        assert state["verdict"]["good"] and "500 mm above the table" in state["verdict"]["text"]
        assert state["verdict"]["map"][0] == 24 * "█"
        assert state["steps"]["camera"]["quality"] == "good" and state["missing"][0] == "background"
        assert not exists(profile_path("wizard")) and observer.taps == set()

        from halo_service.profile.store import save

        save(replace(profile(), name="wizard"), profile_path("wizard"))
        table["wizard-run"].run({"step": "surface", "width_mm": 180, "height_mm": 90})
        state = wait_until_done(wizard)
        assert state["verdict"]["good"], state["verdict"]
        changed = load(profile_path("wizard"))
        assert changed.surface.width_mm == 180.0
        assert set(changed.steps) == {"surface", "camera"}, "how the camera is placed is stored too"
        assert table["wizard-undo"].run({})["can_undo"] is False
        assert load(profile_path("wizard")).surface.width_mm == 200.0
        with pytest.raises(UserError, match="nothing to undo"):
            table["wizard-undo"].run({})
        for name in ("../desk", "", 7):
            with pytest.raises(UserError):
                table["wizard-profile"].run({"name": name})


class Dark:
    """A projector that shows nothing."""

    changes = True
    size_px = 640, 400

    def show(self, picture: Any) -> None:
        """Nothing."""


def test_a_verification_counts_the_touches_of_the_running_service_and_can_be_stopped(
    server: PageServer,
) -> None:
    to_px = Projector(640, 400, np.diag([3.2, 4.0, 1.0]))
    shown: list[dict[str, Any]] = []
    stopped = threading.Event()
    guide = PageGuide(shown.append, stopped)
    with closing(PageObserver(Noted(), server, CAMERA, lambda: "good", dict)) as observer:
        settings, screen = Settings(), Dark()

        def verify() -> Grid:
            known = replace(profile(), projector=to_px)
            return verify_touches(known, Camera(), screen, guide, settings, observer)  # type: ignore[arg-type]

        with ThreadPoolExecutor(1) as pool:
            running = pool.submit(verify)
            grid = grid_of(replace(profile(), projector=to_px), screen)
            for n, (x_mm, y_mm) in enumerate(grid.places):
                while not observer.touch_taps:
                    time.sleep(0.002)
                event = TouchEvent("down", n, 0, float(x_mm) + 1.0, float(y_mm), 0.0, 0.0, 1)
                observer.frame(TouchFrame(n * 33_333, "table", 200.0, 100.0, (), (event,)))
            verified = running.result(10.0)
        assert shown[0]["prompt"].startswith("VERIFY") and shown[-1]["share"] <= 1.0
        lines, good = summary_lines(verified, 5.0)
        assert good and "median 1.0 mm, p95 1.0 mm" in lines[0]
        record = verify_record(verified, "2026-01-01")
        assert record is not None and record.figures["median_mm"] == 1.0
        assert "1.0 mm off, 3.2 px" in shown[-1]["said"][-1]
        stopped.set()
        with pytest.raises(Stopped):
            verify()
        assert observer.touch_taps == set()


# The projector's page.


def test_a_picture_is_shown_when_the_projector_page_has_drawn_it(server: PageServer) -> None:
    screen = PageScreen(server)
    server.on_message = screen.take
    with pytest.raises(UserError, match="open the projector page"):
        screen.size_px  # noqa: B018 - raises
    origin: Any = f"http://127.0.0.1:{server.port}"
    picture = np.random.default_rng(1).integers(0, 255, (400, 640, 3)).astype(np.uint8)
    with connect(f"ws://127.0.0.1:{server.port}/live", origin=origin) as page:
        for size in ([1, 1], [10**6, 400], "large", [640, 400]):
            page.send(json.dumps({"projector": size}))
        while not screen.is_open:
            time.sleep(0.01)
        assert screen.size_px == (640, 400)
        shown = threading.Thread(target=screen.show, args=(picture,))
        shown.start()
        message = page.recv(10.0)
        assert isinstance(message, bytes)
        (length,) = struct.unpack_from("<I", message)
        header = json.loads(message[4 : 4 + length])
        drawn = cv2.imdecode(np.frombuffer(message[4 + length :], np.uint8), cv2.IMREAD_COLOR)
        assert np.array_equal(drawn, picture)
        page.send(json.dumps({"drawn": header["number"] + 1}))
        shown.join(0.2)
        assert shown.is_alive()
        page.send(json.dumps({"drawn": header["number"]}))
        shown.join(10.0)
        assert not shown.is_alive()
    while screen.is_open:
        time.sleep(0.01)
