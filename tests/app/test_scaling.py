"""A projector on a scaled desktop is refused, also where its pixels are not stated."""

from __future__ import annotations

from pathlib import Path

import pytest

from halo_service.app.projector import screens
from halo_service.app.projector.scaling import doubt_about
from halo_service.app.projector.screens import ScreenRequest, screen_for
from halo_service.errors import UserError

PANEL = ["1920x1080", "1920x1080", "1280x720"]
PROJECTOR = ["1280x800", "1024x768", "1280x720i"]
LARGE = ["3840x2160", "1920x1080"]
WAYLAND = {"WAYLAND_DISPLAY": "wayland-0"}
FULL, SMALL, SCALED = (1920, 1080), (1280, 800), (1536, 864)


def connected(folder: Path, *displays: list[str]) -> Path:
    """The kernel's folder of connectors; one of them is free."""
    for number, modes in enumerate([*displays, []]):
        connector = folder / f"card0-HDMI-A-{number}"
        connector.mkdir(parents=True)
        (connector / "status").write_text("connected\n" if modes else "disconnected\n")
        (connector / "modes").write_text("\n".join(modes))
    (folder / "version").write_text("drm 1.1.0")
    return folder


@pytest.mark.parametrize(
    ("environment", "displays", "desktops", "scaled"),
    [
        ({}, [PANEL, PROJECTOR], [FULL, SMALL], False),
        ({}, [PANEL, PROJECTOR], [FULL, (1024, 768)], False),  # a mode that the user chose
        ({}, [PANEL, PROJECTOR], [FULL, (800, 1280)], False),  # turned
        ({}, [PANEL], [(3072, 1728)], True),  # 125 % on X11: drawn large, then made smaller
        (WAYLAND, [PANEL, PROJECTOR], [FULL, SMALL], False),
        (WAYLAND, [PANEL], [SCALED], True),  # 125 %
        (WAYLAND, [LARGE], [FULL], True),  # 200 %: half is a mode, too
        (WAYLAND, [PANEL, LARGE], [FULL, FULL], True),
        ({"XDG_SESSION_TYPE": "wayland"}, [PANEL, PROJECTOR], [SCALED, SMALL], True),
        (WAYLAND, [], [SCALED], False),  # a virtual machine: nothing is known
    ],
)
def test_a_scaled_desktop_is_noticed_by_what_the_displays_have(
    tmp_path: Path,
    environment: dict[str, str],
    displays: list[list[str]],
    desktops: list[tuple[int, int]],
    scaled: bool,
) -> None:
    doubt = doubt_about(
        desktops[-1], desktops, "linux", connected(tmp_path, *displays), environment
    )
    assert bool(doubt) == scaled
    assert not scaled or "set the scale of each display to 100 %, or state" in doubt


def test_on_macos_the_pixels_are_to_be_stated_and_windows_gives_real_ones(tmp_path: Path) -> None:
    assert "--size-px" in doubt_about(FULL, [FULL], "darwin", connected(tmp_path, PANEL), {})
    assert doubt_about(SCALED, [SCALED], "win32", connected(tmp_path / "b", PANEL), {}) == ""


class Camera:
    """A source that is no virtual user."""


def test_the_display_is_refused_unless_its_pixels_are_stated_or_it_is_a_window(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("SDL_VIDEODRIVER", "dummy")
    seen = []

    def doubt(size_px: tuple[int, int], desktops_px: list[tuple[int, int]]) -> str:
        seen.append((size_px, desktops_px))
        return "the desktop is scaled"

    monkeypatch.setattr(screens, "doubt_about", doubt)
    with pytest.raises(UserError, match="display 0: the desktop is scaled"):
        screen_for(Camera(), ScreenRequest())  # type: ignore[arg-type]
    ((size_px, desktops_px),) = seen
    assert desktops_px == [size_px]
    for request in (ScreenRequest(size_px=size_px), ScreenRequest(window=True)):
        with screen_for(Camera(), request):  # type: ignore[arg-type]
            assert len(seen) == 1
