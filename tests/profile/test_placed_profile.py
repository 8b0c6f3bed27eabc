"""Projector and anchor are stored with the profile; a profile without them is read as before."""

import json
from dataclasses import replace

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.profile import Anchor, Profile, Projector
from halo_service.profile.store import load, save

HOMOGRAPHY = np.array([[2.5, 0.1, 90.0], [-0.1, 2.4, 31.0], [1e-4, -2e-4, 1.0]])


def placed(profile: Profile) -> Profile:
    """The drawn profile with a projector and an anchor."""
    pose = np.eye(4)
    pose[:3, 3] = (-60.0, -40.0, 0.5)
    return replace(
        profile,
        projector=Projector(1280, 800, HOMOGRAPHY),
        anchor=Anchor("apriltag-36h11", 7, 80.0, pose),
    )


def test_projector_and_anchor_are_saved(profile, tmp_path):
    saved = placed(profile)
    save(saved, tmp_path)
    read = load(tmp_path)
    assert (read.projector.width_px, read.projector.height_px) == (1280, 800)
    np.testing.assert_array_equal(read.projector.projector_from_surface, HOMOGRAPHY)
    assert (read.anchor.family, read.anchor.marker) == ("apriltag-36h11", 7)
    assert read.anchor.size_mm == 80.0
    np.testing.assert_array_equal(read.anchor.anchor_from_surface, saved.anchor.anchor_from_surface)


def test_a_profile_of_before_has_neither(profile, tmp_path):
    save(profile, tmp_path)
    text = json.loads((tmp_path / "profile.json").read_text())
    assert (text.pop("projector"), text.pop("anchor")) == (None, None)
    (tmp_path / "profile.json").write_text(json.dumps(text))
    read = load(tmp_path)
    assert (read.projector, read.anchor) == (None, None)


@pytest.mark.parametrize(
    ("thing", "field", "value", "why"),
    [
        ("projector", "width_px", 0, "projector: 'width_px' must be more than 0, not 0"),
        (
            "projector",
            "projector_from_surface",
            [[1, 0], [0, 1]],
            "projector_from_surface: must be a 3 x 3 matrix",
        ),
        (
            "projector",
            "projector_from_surface",
            [[float("nan")] * 3] * 3,
            "projector_from_surface: must be a 3 x 3 matrix",
        ),
        (
            "anchor",
            "anchor_from_surface",
            [[1, 0, 0]] * 3,
            "anchor_from_surface: must be a 4 x 4 matrix",
        ),
        ("anchor", "marker", "seven", "anchor: 'marker' must be a whole number, not 'seven'"),
        ("anchor", "size_mm", None, "anchor: 'size_mm' must be a number, not None"),
    ],
)
def test_a_damaged_projector_or_anchor_is_refused(profile, tmp_path, thing, field, value, why):
    save(placed(profile), tmp_path)
    text = json.loads((tmp_path / "profile.json").read_text())
    text[thing][field] = value
    (tmp_path / "profile.json").write_text(json.dumps(text))
    with pytest.raises(UserError, match=why):
        load(tmp_path)
