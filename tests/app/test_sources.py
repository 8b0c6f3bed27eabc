"""What a source is called, and what opens."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import pytest

from halo_service.app.sources import open_source
from halo_service.errors import UserError
from halo_service.settings import SourceSettings, load
from halo_service.sources import azure_kinect


def test_a_recording_in_the_home_folder_is_found_there(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.setenv("USERPROFILE", str(tmp_path))  # what Windows calls it
    (tmp_path / "halo.toml").write_text('[source]\nname = "recording:~/recording.mkv"\n')
    for settings in (
        SourceSettings("recording:~/recording.mkv"),
        load(tmp_path / "halo.toml").source,
    ):
        with pytest.raises(UserError) as caught:
            open_source(settings)
        assert str(caught.value).startswith(f"{tmp_path / 'recording.mkv'} does not exist")


def test_a_recording_of_a_user_who_is_none_is_one_sentence() -> None:
    with pytest.raises(UserError, match="does not exist"):
        open_source(SourceSettings("recording:~no-such-user/recording.mkv"))


@pytest.mark.parametrize(("comes_after", "waited"), [(0, 0), (3, 3), (99, 5)])
def test_at_the_start_a_camera_is_waited_for(
    monkeypatch: pytest.MonkeyPatch, comes_after: int, waited: int
) -> None:
    slept: list[float] = []
    monkeypatch.setattr(azure_kinect, "connected", lambda: int(len(slept) >= comes_after))
    monkeypatch.setattr(azure_kinect, "_sdk", none_connected)
    with pytest.raises(UserError, match="no Azure Kinect is plugged in"):
        open_source(SourceSettings("azure-kinect", wait_s=5.0), sleep=slept.append)
    assert slept == [1.0] * waited


def none_connected() -> object:
    return SimpleNamespace(connected_device_count=lambda: 0)
