"""The hand model: downloaded once, checked, never half there. Needs the network the first time."""

import os
import stat
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from halo_service.errors import UserError
from halo_service.hand_tracking import model

COMMAND = [sys.executable, "-m", "halo_service.hand_tracking.model"]
posix = pytest.mark.skipif(sys.platform == "win32", reason="stands in for uv by a script")


def environment(cache: Path, **more: str) -> dict[str, str]:
    return {**os.environ, "XDG_CACHE_HOME": str(cache), **more}


def installer(folder: Path, script: str) -> str:
    """A program in the place of uv that runs `script`."""
    path = folder / "installer"
    path.write_text(f"#!{sys.executable}\nimport sys\nfrom pathlib import Path\n{script}")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)
    return str(path)


def test_the_model_is_there_and_is_the_tested_one():
    path = model.hand_model(None)
    with zipfile.ZipFile(path) as bundle:
        assert bundle.testzip() is None
        assert [e.compress_type for e in bundle.infolist()] == [zipfile.ZIP_STORED] * 2
        assert bundle.namelist() == ["hand_detector.tflite", "hand_landmarks_detector.tflite"]


def test_the_second_time_nothing_is_downloaded(monkeypatch):
    path = model.hand_model(None)
    before = path.stat()
    monkeypatch.setenv("UV", "/nowhere/uv")
    assert model.hand_model(None) == path
    assert path.stat() == before


@posix
def test_processes_that_start_together_all_get_the_whole_model(tmp_path):
    together = [
        subprocess.Popen(
            COMMAND,
            env=environment(tmp_path),
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        for _ in range(2)
    ]
    said = [process.communicate() for process in together]
    assert [process.returncode for process in together] == [0, 0], said
    paths = {out.strip() for out, _ in said}
    assert len(paths) == 1
    (path,) = map(Path, paths)
    # The bytes depend on nothing but the networks; nothing else is left behind.
    assert path.read_bytes() == model.hand_model(None).read_bytes()
    assert [p.name for p in path.parent.iterdir()] == [path.name]
    assert "Downloading the hand model (once, 35 MB) ..." in said[0][1] + said[1][1]


BAD_FETCHES = {
    "offline": (
        "sys.exit('no route to host')",
        "could not be downloaded (no route to host); connect to the network",
    ),
    "settings of pip": (
        "print('Looking in indexes')\nprint(\"ERROR: Can not combine '--user' and '--target'\")\n"
        "sys.exit(1)",
        "could not be downloaded (ERROR: Can not combine '--user' and '--target'); connect",
    ),
    "offline uv": (
        "sys.exit('error: Failed to fetch\\n  Caused by: Network connectivity is disabled')",
        "(error: Failed to fetch; Caused by: Network connectivity is disabled); connect",
    ),
    "something else": (
        "folder = Path(sys.argv[sys.argv.index('--target') + 1]) / 'mediapipe/modules'\n"
        "for name in ('palm_detection/palm_detection', 'hand_landmark/hand_landmark'):\n"
        "    path = folder / f'{name}_full.tflite'\n"
        "    path.parent.mkdir(parents=True)\n"
        "    path.write_bytes(b'not the network')\n",
        "is not the tested one",
    ),
    "an empty package": ("", "is not the tested one"),
}


@posix
@pytest.mark.parametrize(("script", "message"), BAD_FETCHES.values(), ids=BAD_FETCHES)
def test_a_download_that_fails_is_one_sentence_and_leaves_nothing(tmp_path, script, message):
    cache = tmp_path / "cache"
    done = subprocess.run(
        COMMAND,
        env=environment(cache, UV=installer(tmp_path, script)),
        capture_output=True,
        text=True,
        check=False,
    )
    assert (done.returncode, done.stdout) == (2, "")
    last = done.stderr.splitlines()[-1]
    assert message in last
    assert "set `tracking.model` in halo.toml" in last
    assert "--no-deps" not in done.stderr
    assert "Traceback" not in done.stderr
    assert list(cache.glob("halo-service/*")) == []


@posix
def test_the_installers_own_output_is_in_the_debug_log(tmp_path, monkeypatch, caplog):
    monkeypatch.setenv("UV", installer(tmp_path, "sys.exit('no route to host')"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    with caplog.at_level("DEBUG", logger="halo_service"), pytest.raises(UserError) as caught:
        model.hand_model(None)
    assert "no route to host" in caplog.text
    assert str(caught.value).startswith("the hand model could not be downloaded (no route to host)")


@posix
@pytest.mark.parametrize(
    "setting", ["PIP_USER", "PIP_REQUIRE_HASHES", "UV_OFFLINE", "UV_REQUIRE_HASHES"]
)
def test_settings_for_other_packages_do_not_prevent_the_download(tmp_path, monkeypatch, setting):
    script = (
        "import os, json\n"
        f"if {setting!r} in os.environ: sys.exit('error: it forbids this')\n"
        "assert os.environ['UV_DEFAULT_INDEX'] == 'ours'\n"
        f"Path({str(tmp_path)!r}, 'done').touch()"
    )
    monkeypatch.setenv("UV", installer(tmp_path, script))
    monkeypatch.setenv("UV_DEFAULT_INDEX", "ours")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    monkeypatch.setenv(setting, "1")
    with pytest.raises(UserError, match="is not the tested one"):  # of an empty package
        model.hand_model(None)
    assert (tmp_path / "done").exists()


@posix
def test_a_damaged_model_is_downloaded_again(tmp_path):
    path = Path(subprocess.check_output(COMMAND, env=environment(tmp_path), text=True).strip())
    whole = path.read_bytes()
    path.write_bytes(whole[:-1])
    subprocess.run(COMMAND, env=environment(tmp_path), check=True)
    assert path.read_bytes() == whole


@posix
def test_an_unwritable_cache_is_an_error_with_a_remedy(tmp_path):
    (tmp_path / "halo-service").write_text("a file where the folder should be")
    done = subprocess.run(
        COMMAND, env=environment(tmp_path), capture_output=True, text=True, check=False
    )
    assert done.returncode == 2
    assert "cannot be written to" in done.stderr


def test_a_configured_model_replaces_ours(tmp_path):
    own = tmp_path / "own.task"
    with zipfile.ZipFile(own, "w") as bundle:
        bundle.writestr("hand_detector.tflite", b"")
    assert model.hand_model(own) == own


@pytest.mark.parametrize(
    ("content", "message"), [(None, "does not exist"), (b"x", "not a Hand Land")]
)
def test_a_configured_file_that_is_not_a_model_is_refused(tmp_path, content, message):
    own = tmp_path / "own.task"
    if content is not None:
        own.write_bytes(content)
    with pytest.raises(UserError, match=message):
        model.hand_model(own)
