"""A profile on disk is the profile that was saved, and never half of it."""

from __future__ import annotations

import json
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest

from halo_service.errors import UserError
from halo_service.files import folder_lock
from halo_service.geometry import k4a
from halo_service.geometry.camera import Camera, Lens
from halo_service.geometry.surface import Surface
from halo_service.profile import Background, Correction, Profile, TouchState, TouchStates
from halo_service.profile.store import load, profile_path, require_fit, save
from halo_service.virtual.camera import factory


@pytest.fixture
def profile() -> Profile:
    lens = Lens(8, 6, 500.0, 501.0, 3.5, 2.5, (0.5, -0.02, 1e-5, -7e-5, -0.003, 0.9, 0.09, -0.01))
    camera = Camera("A1", "NFOV_UNBINNED", 30, lens, lens, np.eye(4))
    rng = np.random.default_rng(1)
    background = Background(
        rng.normal(500, 1, (6, 8)).astype(np.float32),
        rng.uniform(0, 2, (6, 8)).astype(np.float32),
        rng.uniform(0, 1, (6, 8)) > 0.2,
    )
    states = TouchStates(
        *(TouchState(100.0 * n, 10.0 / n, 25.0 * n) for n in range(1, 5)), 6.0, 13.0
    )
    return Profile("desk", camera, Surface("table", 300.0, 200.0, np.eye(4)), background, states, 3)


def assert_same(a: Profile, b: Profile) -> None:
    for name in ("mean_mm", "noise_mm", "valid"):
        np.testing.assert_array_equal(getattr(a.background, name), getattr(b.background, name))
    np.testing.assert_array_equal(a.surface.camera_from_surface, b.surface.camera_from_surface)
    assert (a.name, a.revision, a.touch) == (b.name, b.revision, b.touch)
    assert (a.camera.serial, a.camera.depth) == (b.camera.serial, b.camera.depth)


@pytest.mark.parametrize("touch", [True, False])
def test_what_is_saved_is_loaded(profile: Profile, tmp_path: Path, touch: bool) -> None:
    saved = profile if touch else replace(profile, touch=None)
    save(saved, tmp_path / "p")
    assert_same(load(tmp_path / "p"), saved)


def test_saving_again_leaves_one_text_and_one_array_file(profile: Profile, tmp_path: Path) -> None:
    save(profile, tmp_path)
    darker = replace(profile.background, mean_mm=profile.background.mean_mm + 1)
    save(replace(profile, background=darker, revision=4), tmp_path)
    assert sorted(p.name[:10] for p in tmp_path.iterdir() if p.name != ".lock") == [
        "background",
        "profile.js",
    ]
    assert load(tmp_path).revision == 4


@pytest.mark.parametrize("killed_after", [0, 1, 2])
def test_a_kill_while_saving_leaves_the_old_or_the_new_profile(
    profile: Profile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, killed_after: int
) -> None:
    save(profile, tmp_path)
    moves = 0
    really = Path.replace

    def replace_until_killed(self: Path, target: Path) -> Path:
        nonlocal moves
        moves += 1
        if moves > killed_after:
            raise KeyboardInterrupt
        return really(self, target)

    changed = replace(profile.background, mean_mm=profile.background.mean_mm + 1)
    monkeypatch.setattr(Path, "replace", replace_until_killed)
    try:
        save(replace(profile, background=changed, revision=4), tmp_path)
    except KeyboardInterrupt:
        assert killed_after < 2
    assert load(tmp_path).revision == (4 if killed_after == 2 else 3)


@pytest.mark.parametrize(
    ("spoil", "says"),
    [
        (lambda text: text.replace('"format": 1', '"format": 2'), "newer halo-service"),
        (lambda text: text[: len(text) // 2], "cannot be read"),
        (lambda text: text.replace('"revision"', '"version"'), "cannot be read"),
        (lambda text: json.dumps([1, 2]), "cannot be read"),
        (lambda text: text.replace("background-", "elsewhere-"), "cannot be read"),
    ],
    ids=["newer", "cut", "key missing", "foreign", "arrays missing"],
)
def test_a_profile_that_cannot_be_read_is_one_sentence(
    profile: Profile, tmp_path: Path, spoil: object, says: str
) -> None:
    save(profile, tmp_path)
    text = tmp_path / "profile.json"
    text.write_text(spoil(text.read_text()))  # type: ignore[operator]
    with pytest.raises(UserError, match=says):
        load(tmp_path)


@pytest.mark.parametrize(
    ("path", "value", "says"),
    [
        (("camera", "depth", "fx"), "far", "camera: depth: 'fx' must be a number, not 'far'"),
        (
            ("camera", "depth", "distortion"),
            [0.0],
            "camera: depth: 'distortion' has too few elements: .0.0.",
        ),
        (("camera", "serial"), 7, "camera: 'serial' must be text, not 7"),
        (("touch", "hover", "signal"), None, "touch: hover: 'signal' must be a number, not None"),
        (
            ("touch_by_hand", "third"),
            {},
            "touch_by_hand: 'third' must be unknown, left or right, not 'third'",
        ),
        (("steps", "touch"), {"date": 3}, "steps: touch: 'date' must be text, not 3"),
        (("steps", "touch"), 3, "steps: 'touch' must be a table"),
    ],
)
def test_a_wrong_value_is_named_with_its_place(
    profile: Profile, tmp_path: Path, path: tuple[str, ...], value: object, says: str
) -> None:
    save(profile, tmp_path)
    data = json.loads((tmp_path / "profile.json").read_text())
    inner = data
    for key in path[:-1]:
        inner = inner[key]
    inner[path[-1]] = value
    (tmp_path / "profile.json").write_text(json.dumps(data))
    with pytest.raises(UserError, match=says):
        load(tmp_path)


def arrays_of(folder: Path) -> Path:
    (path,) = folder.glob("background-*.npz")
    return path


def outcome(folder: Path) -> str:
    """What `load` says: anything but a profile or one sentence goes through."""
    try:
        load(folder)
    except UserError as error:
        return str(error)
    return ""


def test_an_array_file_cut_anywhere_is_one_sentence(profile: Profile, tmp_path: Path) -> None:
    save(profile, tmp_path)
    path = arrays_of(tmp_path)
    whole = path.read_bytes()
    for length in range(0, len(whole), 7):
        path.write_bytes(whole[:length])
        assert "cannot be read" in outcome(tmp_path), f"cut at {length}"


@pytest.mark.parametrize("name", ["profile.json", "background-*.npz"])
def test_a_flipped_byte_is_never_a_traceback(profile: Profile, tmp_path: Path, name: str) -> None:
    save(profile, tmp_path)
    (path,) = tmp_path.glob(name)
    whole = path.read_bytes()
    said = set()
    for place in range(0, len(whole), 3):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        said.add(outcome(tmp_path).partition("(")[0])
    assert any("cannot be read" in each for each in said)


def test_saving_anew_mends_a_damaged_array_file(profile: Profile, tmp_path: Path) -> None:
    save(profile, tmp_path)
    arrays_of(tmp_path).write_bytes(b"")
    save(profile, tmp_path)
    assert_same(load(tmp_path), profile)


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("name", "Table"),
        ("name", "control"),
        ("name", "sim"),
        ("name", ""),
        ("name", "a" * 33),
        ("name", "../up"),
        ("name", "table\n"),
        ("name", 3),
        ("width_mm", 0.0),
        ("width_mm", -300.0),
        ("height_mm", float("nan")),
        ("height_mm", float("inf")),
        ("height_mm", "wide"),
        ("camera_from_surface", [[float("nan")] * 4] * 4),
        ("camera_from_surface", [[1.0] * 3] * 3),
    ],
)
def test_a_surface_that_cannot_be_is_refused(
    profile: Profile, tmp_path: Path, key: str, value: object
) -> None:
    save(profile, tmp_path)
    data = json.loads((tmp_path / "profile.json").read_text())
    data["surface"][key] = value
    (tmp_path / "profile.json").write_text(json.dumps(data))
    with pytest.raises(UserError, match="cannot be read"):
        load(tmp_path)


def test_where_no_profile_is_one_is_asked_for(tmp_path: Path) -> None:
    with pytest.raises(UserError, match="there is no profile at"):
        load(tmp_path)


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"serial": "B2"}, "belongs to camera A1, and this is B2"),
        ({"depth_mode": "WFOV_UNBINNED"}, "belongs to depth mode NFOV_UNBINNED"),
        ({"depth": Lens(8, 6, 499.0, 501.0, 3.5, 2.5)}, "belongs to depth lens"),
    ],
)
def test_a_profile_of_another_camera_is_refused(
    profile: Profile, changed: dict[str, object], says: str
) -> None:
    require_fit(profile, profile.camera)
    with pytest.raises(UserError, match=says):
        require_fit(profile, replace(profile.camera, **changed))  # type: ignore[arg-type]


def test_a_camera_that_went_through_a_calibration_file_is_the_same() -> None:
    camera = factory()
    mode = {"depth_mode": camera.depth_mode, "colour_resolution": "720P", "fps": camera.fps}
    again = k4a.from_json(k4a.to_json(camera), **mode)  # type: ignore[arg-type]
    flat = np.full((camera.depth.height, camera.depth.width), 500, np.float32)
    surface = Surface("table", 300.0, 200.0, np.eye(4))
    made = Profile("desk", camera, surface, Background(flat, flat, flat > 0), None, 1)
    require_fit(made, again)
    nudged = replace(again.depth, fx=again.depth.fx * (1.0 + 1e-9))
    require_fit(made, replace(again, depth=nudged))
    other = replace(again.depth, fx=again.depth.fx * (1.0 + 1e-4))
    with pytest.raises(UserError, match="belongs to depth lens"):
        require_fit(made, replace(again, depth=other))


def test_a_name_lives_in_the_data_folder_and_a_path_where_it_says() -> None:
    assert profile_path("./here") == Path("here")
    assert profile_path("desk").parts[-3:] == ("halo-service", "profiles", "desk")


def test_the_text_can_be_read_by_a_person(profile: Profile, tmp_path: Path) -> None:
    save(profile, tmp_path)
    data = json.loads((tmp_path / "profile.json").read_text())
    assert data["touch"] == json.loads(json.dumps(asdict(profile)["touch"]))
    assert data["camera"]["serial"] == "A1"


def swept(profile: Profile) -> Profile:
    """With a correction that knows the dent."""
    rng = np.random.default_rng(2)
    x, y, pitch, yaw = (np.arange(n, dtype=np.float32) for n in (4, 3, 2, 5))
    return replace(
        profile,
        correction=Correction(
            x, y, pitch, yaw,
            strength=rng.uniform(size=(4, 3, 2, 5)).astype(np.float32),
            samples=rng.uniform(size=(7, 9)).astype(np.float32),
            base="pilots",
            readings=rng.uniform(size=(4, 4, 3)).astype(np.float32),
            deviations=rng.uniform(size=(4, 4, 3)).astype(np.float32),
            dent_by_pitch=rng.uniform(size=2).astype(np.float32),
            tops_mm=rng.uniform(size=(2, 4, 3)).astype(np.float32),
        ),
    )  # fmt: skip


def test_a_correction_is_loaded_as_it_was_saved(profile: Profile, tmp_path: Path) -> None:
    saved = swept(profile)
    save(saved, tmp_path)
    loaded = load(tmp_path).correction
    for name in (
        "x_mm",
        "yaw_deg",
        "strength",
        "samples",
        "readings",
        "deviations",
        "dent_by_pitch",
        "tops_mm",
    ):
        np.testing.assert_array_equal(getattr(loaded, name), getattr(saved.correction, name))


@pytest.mark.parametrize(
    ("columns", "same"),
    [(5, 5), (6, 5), (8, 8)],
    ids=["the signal alone", "signal and dent", "all readings, without the upper side"],
)
def test_a_profile_from_before_there_were_several_readings_is_read_and_has_none(
    profile: Profile, tmp_path: Path, columns: int, same: int
) -> None:
    known = swept(profile).correction
    assert known is not None
    old = replace(
        known, samples=known.samples[:, :columns], readings=None, deviations=None, tops_mm=None
    )
    save(replace(profile, correction=old), tmp_path)
    file = tmp_path / "profile.json"
    text = json.loads(file.read_text(encoding="utf-8"))
    for state in ("hover", "subtle", "touch", "pressure"):
        held = text["touch"][state]
        del held["readings"], held["raw_readings"], held["noise"]
        held["deep_mm"] = held["deep_raw_mm"] = 9.0
    del text["touch"]["hard"]
    file.write_text(json.dumps(text), encoding="utf-8")
    loaded = load(tmp_path)
    assert loaded.touch is not None and loaded.correction is not None
    assert loaded.touch == profile.touch
    assert (loaded.correction.readings, loaded.correction.deviations) == (None, None)
    assert loaded.correction.tops_mm is None
    np.testing.assert_array_equal(loaded.correction.samples[:, :same], old.samples[:, :same])
    assert loaded.correction.samples.shape[1] == 9
    assert np.isnan(loaded.correction.samples[:, same:]).all()


def test_states_from_before_angles_were_stored_get_the_one_of_their_place(
    profile: Profile, tmp_path: Path
) -> None:
    """Straight below the camera, which looks along the normal: 90 degrees less the pitch."""
    assert profile.touch is not None
    surface = replace(profile.surface, camera_from_surface=np.eye(4))
    middle = surface.from_camera(np.array([[0.0, 0.0, 500.0]]))[0]
    high = np.eye(4)
    high[2, 3] = 500.0
    high[:2, 3] = -middle[0] - 150.0, -middle[1] - 100.0
    surface = replace(surface, camera_from_surface=high)
    held = replace(
        profile.touch.hover,
        top_mm=20.0,
        pitch_deg=30.0,
        x_mm=150.0 + middle[0],
        y_mm=100.0 + middle[1],
    )
    save(replace(profile, surface=surface, touch=replace(profile.touch, hover=held)), tmp_path)
    loaded = load(tmp_path).touch
    assert loaded is not None and loaded.hover.seen_deg == pytest.approx(60.0)


def test_samples_that_are_too_few_columns_are_one_sentence(
    profile: Profile, tmp_path: Path
) -> None:
    known = swept(profile).correction
    assert known is not None
    save(replace(profile, correction=replace(known, samples=known.samples[:, :3])), tmp_path)
    with pytest.raises(UserError, match="too few columns"):
        load(tmp_path)


def test_a_profile_that_another_program_writes_is_one_sentence(
    profile: Profile, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("halo_service.files.LOCK_WAIT_S", 0.05)
    with (
        folder_lock(tmp_path),
        pytest.raises(UserError, match="another program is writing it"),
    ):
        save(profile, tmp_path)
    save(profile, tmp_path)
