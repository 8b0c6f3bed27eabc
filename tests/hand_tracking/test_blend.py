"""The image for the hand tracker: colour where it belongs, infrared at any brightness."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera, Lens
from halo_service.hand_tracking.blend import SHRINK, ColourWarp, blend, toned
from halo_service.virtual.camera import factory

DEVICE = Path(__file__).parents[2] / "../shared/data/azure_kinect_calibration.json"
MADE_UP = Camera(
    serial="0",
    depth_mode="NFOV_UNBINNED",
    fps=30,
    depth=Lens(640, 576, 504.0, 504.0, 320.0, 330.0, (0.5, -0.02, 0, 0, 0, 0.85, 0.07, -0.01)),
    colour=Lens(1280, 720, 612.0, 612.0, 640.0, 366.0, (0.06, -0.04, 0, 0, 0, 0, 0, 0)),
    # 32 mm from the depth camera, which looks 6 degrees lower.
    colour_from_depth=np.array(
        [
            [1, 0, 0, -32],
            [0, np.cos(0.105), np.sin(0.105), -2],
            [0, -np.sin(0.105), np.cos(0.105), 4],
            [0, 0, 0, 1],
        ]
    ),
)


def real_device() -> Camera:
    if not DEVICE.exists():
        pytest.skip("no shared/data/azure_kinect_calibration.json")
    return k4a.from_json(
        DEVICE.read_bytes(), depth_mode="NFOV_UNBINNED", colour_resolution="720P", fps=30
    )


CAMERAS = {"made up": lambda: MADE_UP, "the virtual one": factory, "a real device": real_device}


def warp_of(camera: Camera, background_mm: float = 500.0) -> ColourWarp:
    shape = (camera.depth.height, camera.depth.width)
    return ColourWarp(camera, np.full(shape, background_mm, np.float32))


def exactly(camera: Camera, z_mm: float, every: int = 1) -> np.ndarray:
    """(2, h, w): where a plane at that depth is seen by the colour camera, px of full size."""
    assert camera.colour is not None
    rows, columns = np.mgrid[: camera.depth.height : every, : camera.depth.width : every]
    rays = camera.depth.rays(np.column_stack([columns.ravel(), rows.ravel()]).astype(float))
    pose = camera.colour_from_depth
    px = camera.colour.project(rays * z_mm @ pose[:3, :3].T + pose[:3, 3])
    return px.T.reshape(2, *rows.shape)


@pytest.mark.parametrize("camera", CAMERAS.values(), ids=CAMERAS)
def test_the_short_way_to_colour_is_less_than_half_a_pixel_off(camera):
    camera = camera()
    warp = warp_of(camera)
    worst = 0.0
    for z_mm in (300, 350, 420, 500, 600, 800, 1000):
        exact = exactly(camera, z_mm, every=5)
        places = warp.places(np.full((576, 640), z_mm, np.uint16))
        assert places is not None
        full_size = (places[:, ::5, ::5] + 0.5) * SHRINK - 0.5
        seen = (np.abs(exact[0] - 640) <= 640) & (np.abs(exact[1] - 360) <= 360)
        worst = max(worst, np.linalg.norm(full_size - exact, axis=0)[seen].max())
    print(f"worst error {worst:.2f} px")
    assert worst < 0.5


def test_a_pixel_without_depth_counts_as_background():
    warp = warp_of(MADE_UP, 620.0)
    depth = np.full((576, 640), 620, np.uint16)
    holes = depth.copy()
    holes[100:200, 300:400] = 0
    np.testing.assert_allclose(warp.places(holes), warp.places(depth), atol=1e-3)


def seen_by_colour(camera: Camera, z_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """A colour picture of a plane with a soft pattern, and the pattern in depth pixels (RGB)."""

    def pattern(x, y):
        waves = [np.sin(x / 90), np.cos(y / 70), np.sin((x + y) / 110)]
        return (127 + 100 * np.stack(waves, axis=-1)).astype(np.uint8)

    rows, columns = np.indices((camera.colour.height, camera.colour.width))
    return pattern(columns, rows)[..., ::-1], pattern(*exactly(camera, z_mm))


@pytest.mark.parametrize("as_jpeg", [True, False])
def test_colour_lands_on_the_depth_pixel_that_it_belongs_to(as_jpeg):
    picture, expected = seen_by_colour(MADE_UP, 480)
    colour = (
        cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 95])[1].tobytes()
        if as_jpeg
        else np.ascontiguousarray(picture)
    )
    dark = np.zeros((576, 640), np.uint16)
    blended = blend(dark, colour, warp_of(MADE_UP), np.full_like(dark, 480))
    assert blended.shape == (576, 640, 3)
    assert blended.dtype == np.uint8
    # Inside the colour camera's view, which is less high than the depth camera's.
    x, y = exactly(MADE_UP, 480)
    seen = (x > 2) & (x < 1277) & (y > 2) & (y < 717)
    assert seen.mean() > 0.7
    assert np.abs(blended - 0.3 * expected)[seen].max() < 4


NO_COLOUR = {"none": None, "no bytes": b"", "a broken JPEG": b"\xff\xd8\xff\xe0 not a picture"}


@pytest.mark.parametrize("colour", NO_COLOUR.values(), ids=NO_COLOUR)
def test_without_colour_the_infrared_is_shown_alone(colour):
    ir = np.arange(576 * 640, dtype=np.uint32).reshape(576, 640).astype(np.uint16)
    picture = blend(ir, colour, warp_of(MADE_UP), np.full((576, 640), 500, np.uint16))
    for channel in range(3):
        np.testing.assert_array_equal(picture[..., channel], toned(ir))


def test_a_camera_without_colour_needs_none():
    camera = Camera("0", "NFOV_UNBINNED", 30, MADE_UP.depth, None, np.eye(4))
    ir = np.full((576, 640), 900, np.uint16)
    picture = blend(ir, np.zeros((720, 1280, 3), np.uint8), warp_of(camera), ir)
    np.testing.assert_array_equal(picture[..., 0], toned(ir))


@pytest.mark.parametrize("gain", [0.05, 1.0, 8.0])
def test_the_infrared_s_brightness_does_not_matter(gain):
    ramp = np.linspace(100, 6000, 640).astype(np.uint16)[None].repeat(576, axis=0)
    seen = toned((ramp * gain).astype(np.uint16)).astype(int)
    assert np.abs(seen - toned(ramp)).max() <= 12  # at a twentieth, the steps of the sensor show
    assert seen[0, -1] >= 250


def test_a_reflex_does_not_darken_the_rest():
    ir = np.full((576, 640), 900, np.uint16)
    ir[200:300, 200:300] = 1800
    with_reflex = ir.copy()
    with_reflex[:40] = 65535
    np.testing.assert_array_equal(toned(with_reflex)[40:], toned(ir)[40:])
    assert (toned(with_reflex)[:40] == 255).all()


@pytest.mark.parametrize("everywhere", [0, 1, 65535])
def test_infrared_without_any_contrast_is_no_error(everywhere):
    picture = toned(np.full((576, 640), everywhere, np.uint16))
    assert (picture == (0 if everywhere == 0 else 255)).all()


def test_a_background_of_another_size_is_refused():
    with pytest.raises(ValueError, match="does not fit the camera"):
        ColourWarp(MADE_UP, np.full((10, 10), 500, np.float32))
