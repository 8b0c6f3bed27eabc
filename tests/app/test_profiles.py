"""`halo profile show` describes a profile."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from halo_service.app.cli import main
from halo_service.profile import Profile
from halo_service.profile.store import save


def test_each_state_is_shown_with_its_dent_where_it_is_known(
    profile: Profile, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert profile.touch is not None
    dented = replace(profile.touch.touch, readings=(2000.0, 11.04, 7.0, 3.0))
    save(replace(profile, touch=replace(profile.touch, touch=dented)), tmp_path / "desk")
    assert main(["profile", "show", str(tmp_path / "desk")]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert "all fingers: touch 2000 mm px, dent 11.0 mm, with 25 g (assumed)" in printed
    assert "all fingers: hover 500 mm px at 10 mm (assumed)" in printed
