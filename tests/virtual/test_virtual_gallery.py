"""The gallery: a picture with a field for each material and state, or one sentence."""

import cv2
import pytest

from halo_service.errors import UserError
from halo_service.virtual.curves import STATES
from halo_service.virtual.gallery import (
    BORDER_PX,
    CAPTION_PX,
    FIELD_PX,
    LEGEND,
    VARIANTS,
    gallery,
    save,
)
from halo_service.virtual.materials import MATERIALS
from tests.kind_sensor import KIND_ROOM


@pytest.fixture(scope="module")
def saved(tmp_path_factory):
    path = tmp_path_factory.mktemp("gallery") / "gallery.png"
    save(path, seed=2, **KIND_ROOM)
    return path


def halo_px(image, row):
    """White pixels of the halo in each state of one row."""
    side, first = 2 * FIELD_PX, BORDER_PX * (len(LEGEND) + 1)
    top = first + row * (side + CAPTION_PX) + CAPTION_PX
    return [
        int((image[top : top + FIELD_PX, x + FIELD_PX : x + side] == 255).all(axis=2).sum())
        for x in (BORDER_PX + k * (side + BORDER_PX) for k in range(len(STATES)))
    ]


def test_every_material_and_state_has_its_field(saved):
    image = cv2.imread(str(saved))
    side = 2 * FIELD_PX
    rows = len(MATERIALS) + len(VARIANTS)
    assert image.shape[0] == BORDER_PX * (len(LEGEND) + 1) + rows * (side + CAPTION_PX)
    assert image.shape[1] >= len(STATES) * side
    white = halo_px(image, list(MATERIALS).index("suede"))
    assert white == sorted(white)  # the halo grows from state to state
    assert white[-1] > white[0] + 100


def test_a_halo_shows_at_hover_on_all_materials_but_mirrors(saved):
    image = cv2.imread(str(saved))
    for row, material in enumerate(MATERIALS):
        assert (halo_px(image, row)[0] >= 12) == (material != "mirror"), material


@pytest.mark.parametrize(
    "name, sentence", [("picture.txt", "name it"), ("absent/picture.png", "cannot be written")]
)
def test_a_gallery_that_cannot_be_written_is_one_sentence(tmp_path, name, sentence, monkeypatch):
    drawn = []
    monkeypatch.setattr("halo_service.virtual.gallery.gallery", lambda *_: drawn.append(1))
    with pytest.raises(UserError, match=sentence):
        save(tmp_path / name)
    assert not drawn  # refused at once, not after 20 s of drawing
    assert not list(tmp_path.iterdir())


def test_one_user_gives_one_gallery(tmp_path, monkeypatch):
    two = {name: MATERIALS[name] for name in ("paper", "foam")}
    monkeypatch.setattr("halo_service.virtual.gallery.MATERIALS", two)
    monkeypatch.setattr("halo_service.virtual.gallery.VARIANTS", {})
    save(tmp_path / "gallery.png", seed=2, **KIND_ROOM)
    assert (gallery(2, **KIND_ROOM) == cv2.imread(str(tmp_path / "gallery.png"))).all()
