"""The factory calibration: its lens can be inverted, and it is like a real one."""

import json

import numpy as np
import pytest

from halo_service.virtual.camera import SERIAL, factory, pixel_rays, shrunk


@pytest.mark.parametrize("which", ["depth", "colour"])
def test_every_pixel_has_a_ray_that_comes_back_to_it(which):
    lens = getattr(factory(), which)
    rays = pixel_rays(lens)
    rows, columns = np.mgrid[: lens.height, : lens.width]
    px = lens.project(rays.reshape(-1, 3))
    assert np.abs(px - np.column_stack([columns.ravel(), rows.ravel()])).max() < 0.02


def test_one_device_over_all_seeds():
    assert factory() is factory()
    assert factory().serial == SERIAL


def test_a_smaller_image_shows_the_same_view():
    lens = factory().colour
    half = shrunk(lens, 2)
    ray = np.array([[0.31, -0.2, 1.0]])
    x, y = lens.project(ray)[0]
    assert half.project(ray)[0] == pytest.approx([(x + 0.5) / 2 - 0.5, (y + 0.5) / 2 - 0.5])


def test_magnitudes_are_those_of_a_real_device(company_data):
    text = (company_data / "azure_kinect_calibration.json").read_text()
    cameras = json.loads(text)["CalibrationInformation"]["Cameras"]
    real = {c["Location"][-2:]: c["Intrinsics"]["ModelParameters"] for c in cameras}
    ours = factory()
    # Fractions of the full sensor: 1024 px of depth, 4096 px of colour scaled to 1280.
    assert ours.depth.fx == pytest.approx(real["D0"][2] * 1024, rel=0.02)
    assert ours.colour.fx == pytest.approx(real["V0"][2] * 1280, rel=0.02)
    extrinsics = next(c["Rt"] for c in cameras if c["Location"].endswith("PV0"))
    moved = 1000.0 * np.array(extrinsics["Translation"])
    assert ours.colour_from_depth[:3, 3] == pytest.approx(moved, abs=3.0)
    rotation = np.array(extrinsics["Rotation"]).reshape(3, 3)
    assert ours.colour_from_depth[:3, :3] == pytest.approx(rotation, abs=0.01)
    assert ours.depth.fx != real["D0"][2] * 1024  # typical of it, not a copy
