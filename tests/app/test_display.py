"""A picture on the projector's display; with SDL's dummy driver where there is no screen."""

from __future__ import annotations

import importlib.util

import numpy as np
import pytest

from halo_service.app.projector.display import Display
from halo_service.app.projector.screens import ScreenRequest, screen_for
from halo_service.errors import UserError


@pytest.fixture(autouse=True)
def no_screen(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")


def test_a_display_shows_pictures_until_it_is_closed() -> None:
    with Display(0) as display:
        width, height = display.size_px
        for grey in (0, 255):
            display.show(np.full((height, width, 3), grey, np.uint8))
        assert display.open
    assert not display.open
    display.show(np.zeros((height, width, 3), np.uint8))  # into nothing, and no error
    display.close()


def test_a_display_that_is_not_there_is_a_sentence() -> None:
    with pytest.raises(UserError, match="there is no display 9"):
        Display(9)


def test_a_display_counts_as_closed_when_its_process_dies() -> None:
    with Display(0, full_screen=False) as display:
        width, height = display.size_px
        display._process.kill()
        display._process.join()
        display.show(np.zeros((height, width, 3), np.uint8))
        assert not display.open


def test_without_pygame_it_says_what_brings_it(monkeypatch: pytest.MonkeyPatch) -> None:
    find = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda name: None if name == "pygame" else find(name)
    )
    with pytest.raises(UserError, match="uv sync --extra projector"):
        Display(0)


class Camera:
    """A source that is no virtual user."""


def test_a_scaled_desktop_is_refused_where_the_projectors_pixels_are_stated() -> None:
    with Display(0) as display:
        size_px = display.size_px
    with screen_for(Camera(), ScreenRequest(size_px=size_px)) as screen:  # type: ignore[arg-type]
        assert screen.size_px == size_px
    with pytest.raises(UserError, match=r"its desktop is scaled.*to 100 % and its resolution to"):
        screen_for(Camera(), ScreenRequest(size_px=(3840, 2160)))  # type: ignore[arg-type]
