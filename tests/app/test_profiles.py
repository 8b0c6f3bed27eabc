"""`halo profile` shows, renames, deletes and exports profiles, and loses none by accident."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from halo_service.app.cli import main
from halo_service.profile import Profile
from halo_service.profile.store import load, profile_path, profiles_path, save


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


def test_a_profile_is_renamed_and_deleted(
    profile: Profile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path))
    save(replace(profile, name="desk"), profile_path("desk"))
    save(replace(profile, name="other"), profile_path("other"))
    assert main(["profile", "rename", "desk", "other"]) == 2  # it would replace one
    assert main(["profile", "rename", "desk", "bench"]) == 0
    assert load(profile_path("bench")).name == "bench"
    assert not profile_path("desk").exists()
    assert main(["profile", "delete", "bench"]) == 0
    assert [path.name for path in profiles_path().iterdir()] == ["other"]
    assert main(["profile", "delete", "bench"]) == 2


def test_a_damaged_profile_can_be_deleted_and_other_files_stay(
    profile: Profile, tmp_path: Path
) -> None:
    save(profile, tmp_path / "desk")
    (tmp_path / "desk" / "profile.json").write_text("{")
    (tmp_path / "desk" / "notes.txt").write_text("mine")
    assert main(["profile", "delete", str(tmp_path / "desk")]) == 0
    assert [path.name for path in (tmp_path / "desk").iterdir()] == ["notes.txt"]


def test_an_export_replaces_a_file_only_when_asked(
    profile: Profile, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    save(profile, tmp_path / "desk")
    out = tmp_path / "desk.halo-profile"
    out.write_text("mine")
    command = ["profile", "export", str(tmp_path / "desk"), str(out)]
    assert main(command) == 2
    assert "exists already; choose another name, or add --force" in capsys.readouterr().err
    assert out.read_text() == "mine"
    assert main([*command, "--force"]) == 0
    assert out.read_bytes().startswith(b"PK")
