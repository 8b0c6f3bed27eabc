"""Places in the Unity client's core: world coordinates, projector camera, services by mDNS."""

from __future__ import annotations

import json
import random
import secrets
from collections.abc import Callable
from contextlib import closing

import numpy as np
import numpy.typing as npt
import pytest
from zeroconf import IPVersion, ServiceInfo, Zeroconf

Run = Callable[..., list[str]]
Matrix = npt.NDArray[np.float64]
WIDTH_MM, HEIGHT_MM = 400.0, 260.0
UNITY_FROM_WIRE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, -1.0, 0.0]])
"""x stays, up is -z (out of the surface), forward is -y (to the far edge or the marker's top)."""


def geometry(run: Run, *questions: tuple[str, *tuple[float, ...]]) -> list[Matrix]:
    lines = [" ".join([what, *(repr(float(each)) for each in rest)]) for what, *rest in questions]
    return [np.array(json.loads(line)) for line in run(lines, "geometry")]


def local_m(x_mm: float, y_mm: float, hover_mm: float) -> Matrix:
    """Metres from the middle of the surface."""
    return np.array([x_mm - WIDTH_MM / 2, hover_mm, HEIGHT_MM / 2 - y_mm]) / 1000


@pytest.mark.parametrize(
    ("x_mm", "y_mm", "hover_mm", "metres"),
    [
        (200.0, 130.0, 0.0, (0.0, 0.0, 0.0)),
        (0.0, 0.0, 0.0, (-0.2, 0.0, 0.13)),
        (400.0, 260.0, 0.0, (0.2, 0.0, -0.13)),
        (200.0, 130.0, 25.0, (0.0, 0.025, 0.0)),
    ],
    ids=["middle", "far left", "near right", "above"],
)
def test_the_surface_is_in_metres_and_left_handed(
    run_csharp: Run, x_mm: float, y_mm: float, hover_mm: float, metres: tuple[float, ...]
) -> None:
    (found,) = geometry(run_csharp, ("local", x_mm, y_mm, hover_mm, WIDTH_MM, HEIGHT_MM))
    assert found == pytest.approx(metres, abs=1e-7)
    assert found == pytest.approx(local_m(x_mm, y_mm, hover_mm), abs=1e-7)


def rotation(chance: random.Random) -> Matrix:
    turned, _ = np.linalg.qr([[chance.gauss(0, 1) for _ in range(3)] for _ in range(3)])
    return np.asarray(turned * np.sign(np.linalg.det(turned)))


def test_a_marker_places_the_surface(run_csharp: Run) -> None:
    """A point of the surface through Unity's transform is where the wire's matrix says."""
    chance = random.Random(3)
    shifts = [np.array([chance.uniform(-500, 500) for _ in range(3)]) for _ in range(8)]
    poses = [(rotation(chance), shift_mm) for shift_mm in shifts]
    rows = [np.column_stack(pose).ravel() for pose in poses]
    places = geometry(run_csharp, *(("marker", WIDTH_MM, HEIGHT_MM, *each) for each in rows))
    for (turned, shift_mm), (position, up, forward) in zip(poses, places, strict=True):
        right = np.cross(up, forward)  # in a left-handed frame, too: x = y cross z
        x_mm, y_mm, hover_mm = (chance.uniform(0, most) for most in (400, 260, 50))
        axes = np.column_stack([right, up, forward])
        found = position + axes @ local_m(x_mm, y_mm, hover_mm)
        on_wire = turned @ (x_mm, y_mm, -hover_mm) + shift_mm
        assert found == pytest.approx(UNITY_FROM_WIRE @ on_wire / 1000, abs=1e-6)


HOMOGRAPHIES = {
    "straight": [[4.0, 0.0, 20.0], [0.0, 4.0, 10.0], [0.0, 0.0, 1.0]],
    "turned by 180 degrees": [[-4.0, 0.0, 1900.0], [0.0, -4.0, 1070.0], [0.0, 0.0, 1.0]],
    "from the side": [[3.1, 0.4, 150.0], [-0.3, 3.6, 90.0], [4e-4, -3e-4, 1.1]],
    "negative scale": [[-3.1, -0.4, -150.0], [0.3, -3.6, -90.0], [-4e-4, 3e-4, -1.1]],
}


@pytest.mark.parametrize("name", HOMOGRAPHIES)
def test_the_projectors_camera_lights_the_right_pixels(run_csharp: Run, name: str) -> None:
    homography = np.array(HOMOGRAPHIES[name])
    size_px, distance_m = (1920.0, 1080.0), 2.0
    numbers = (WIDTH_MM, HEIGHT_MM, *size_px, distance_m, *homography.ravel())
    (found,) = geometry(run_csharp, ("projector", *numbers))
    projection = found.reshape(4, 4)
    for x_mm, y_mm in [(0, 0), (400, 0), (400, 260), (0, 260), (123, 45)]:
        mapped = homography @ (x_mm, y_mm, 1.0)
        clips = []
        for height_mm in (0.0, 30.0):
            local = local_m(x_mm, y_mm, height_mm)
            # The camera looks down: its x is right, its y the far edge, and -z is forward.
            seen = np.array([local[0], local[2], local[1] - distance_m, 1.0])
            clips.append(projection @ seen)
        assert all(clip[3] > 0 for clip in clips), "in front of the camera"
        on, above = (clip[:3] / clip[3] for clip in clips)
        pixel = (on[0] + 1) / 2 * size_px[0], (1 - on[1]) / 2 * size_px[1]
        assert pixel == pytest.approx(mapped[:2] / mapped[2], abs=0.01)
        assert -1 < above[2] < on[2] < 1, "higher is nearer, and both are drawn"


def test_a_degenerate_homography_gives_no_camera(run_csharp: Run) -> None:
    line = " ".join(["projector", "400", "260", "1920", "1080", "2", *["0"] * 9])
    assert run_csharp([line], "geometry") == ["null"]


def test_answers_of_mdns_are_bounded(run_csharp: Run) -> None:
    """Random answers, among them names that refer to themselves, raise nothing."""
    chance = random.Random(11)
    heads = [bytes(2) + b"\x84\0\0\0\0\3\0\0\0\0", bytes(2) + b"\x84\0\0\1\xff\xff\xff\xff\xff\xff"]
    loop = heads[0] + b"\xc0\x0c" + bytes(10)
    answers = [chance.choice(heads) + chance.randbytes(chance.randrange(120)) for _ in range(2000)]
    *counts, _ = run_csharp([raw.hex() for raw in (loop, *answers)], "dns")
    assert set(counts) == {"0"}


@pytest.mark.long
def test_services_are_found_by_name(run_csharp: Run) -> None:
    """A real responder on the loopback."""
    run = secrets.token_hex(4)
    kind = "_osc._udp.local."
    facts = {"node": f"halo-test-{run}", "session": "s1", "surface": "table", "rate_hz": "30"}
    ours = ServiceInfo(
        kind, f"halo-test-{run}.{kind}", port=4299, parsed_addresses=["127.0.0.1"],
        properties=facts, server=f"halo-test-{run}.local.",
    )  # fmt: skip
    other = ServiceInfo(
        kind, f"other-test-{run}.{kind}", port=4300, parsed_addresses=["127.0.0.1"],
        properties={"program": "other"}, server=f"other-test-{run}.local.",
    )  # fmt: skip
    with closing(Zeroconf(interfaces=["127.0.0.1"], ip_version=IPVersion.V4Only)) as responder:
        responder.register_service(ours)
        responder.register_service(other)
        found = [each for each in json.loads(run_csharp([], "find", "2")[0]) if run in str(each)]
    node = f"halo-test-{run}"
    source = f"osc://?hello=127.0.0.1:4299&node={node}"
    assert found == [{"node": node, "surface": "table", "source": source}]
