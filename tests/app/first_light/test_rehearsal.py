"""A rehearsal on the virtual camera with all that is known of the real sensor's errors."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from halo_service.app.cli import main
from halo_service.app.first_light import run as first_light
from halo_service.app.first_light.plan import PlanOptions, tasks_of
from halo_service.app.virtual_user.cache import cached_profile
from halo_service.app.virtual_user.profile import virtual_profile
from halo_service.profile.store import save
from halo_service.settings import Settings
from halo_service.virtual.sim_url import parse_sim_url

SOURCE = "sim:calibration,sensor=true,seed=217"
"""A user with an even halo: this session has no sweep, which a weak corner needs."""


@pytest.mark.long
def test_a_session_ends_in_a_report_and_a_small_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    room = parse_sim_url(SOURCE).room
    save(cached_profile(room, Settings(), virtual_profile), tmp_path / "profile")
    monkeypatch.setattr(first_light, "missing", lambda _: [])  # no sweep: it takes a minute

    def shorter(surface, options: PlanOptions):
        tasks = list(tasks_of(surface, options))
        return [tasks[0], tasks[7], tasks[8], tasks[11]]

    monkeypatch.setattr(first_light, "tasks_of", shorter)
    folder = tmp_path / "table"
    given = ["--profile", str(tmp_path / "profile"), "--source", SOURCE, "--silent", "--brief"]
    assert main(["first-light", str(folder), *given]) == 0
    printed = capsys.readouterr()
    assert printed.out.strip() == str(folder / "report.html")
    assert "4 of 4  Press until the scale shows 289 grams." in printed.err
    assert {path.name for path in folder.iterdir()} == {
        "first-light.mkv", "first-light.json", "report.html", "profile",
    }  # fmt: skip
    script = json.loads((folder / "first-light.json").read_text())
    assert [line["step"] for line in script] == ["target", "target", "hover", "pressure"]
    assert (folder / "first-light.mkv").stat().st_size < 200e6 * 4 / 52
    report = (folder / "report.html").read_text()
    assert "<td>touches reported, of those requested</td><td>100.0 %</td>" in report
    assert "<dd>2 touches, 1 heights, 1 forces</dd>" in report
    assert "A rehearsal: the camera, the hand and the table were virtual." in report
    assert main(["first-light", str(folder), *given]) == 2
    assert "has a session already" in capsys.readouterr().err
