"""The hand model: built once, when it is first needed, and cached in the user's cache folder.

The current MediaPipe package contains no model. The two networks of the Hand Landmarker are in
an older package of the same project (Apache-2.0 licence); a bundle is the uncompressed zip of
both. The user's own installer downloads the package from its configured index, and the networks
are used only if their hashes are the ones we tested with.

`python -m halo_service.hand_tracking.model` downloads the model in advance and prints its path.
"""

from __future__ import annotations

import hashlib
import importlib.util
import logging
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

from halo_service.errors import UserError
from halo_service.files import cache_folder

log = logging.getLogger(__name__)

_PACKAGE = "mediapipe==0.10.21"
_NETWORKS = {
    "hand_detector.tflite": (
        "mediapipe/modules/palm_detection/palm_detection_full.tflite",
        "1b14e9422c6ad006cde6581a46c8b90dd573c07ab7f3934b5589e7cea3f89a54",
    ),
    "hand_landmarks_detector.tflite": (
        "mediapipe/modules/hand_landmark/hand_landmark_full.tflite",
        "11c272b891e1a99ab034208e23937a8008388cf11ed2a9d776ed3d01d0ba00e3",
    ),
}
"""Name in the bundle: path in the package, sha256."""
_BUNDLE_SHA256 = "76839f622b2923ac8ee857300422283621490de0122425c2313ab8f040a7d100"
"""Of the whole bundle; its bytes depend on the networks alone."""
_BUNDLE = "hand_landmarker-0.10.21.task"
_OR_ELSE = (
    "connect to the network and try again, or run `python -m halo_service.hand_tracking.model` on "
    "another machine, copy the file that it prints, and set `tracking.model` in halo.toml to "
    "its path"
)

# The networks are the same in every build of the package: request the one that certainly exists,
# so that it works on machines and Pythons without a build of their own.
_UV = (
    *("--python-platform", "x86_64-unknown-linux-gnu", "--python-version", "3.11"),
    *("--link-mode", "copy"),  # no warning if uv's cache is on another disk
)
_PIP = (
    *("--platform", "manylinux_2_28_x86_64", "--python-version", "3.11"),
    *("--implementation", "cp", "--abi", "cp311"),
)

_PLACES = ("INDEX", "CERT", "HOST", "PROXY", "TLS", "SSL", "KEYRING", "CACHE", "FIND_LINKS")
"""In names of settings that say where packages are and how to reach them."""


def model_path() -> Path:
    """Return the path of our own bundle in the cache; the file may not exist yet."""
    return cache_folder() / _BUNDLE


def hand_model(configured: Path | None) -> Path:
    """Return the path of a Hand Landmarker bundle: `configured`, or ours, downloaded if needed.

    Raises UserError if the configured file is not a bundle, or ours can be neither found nor
    built. Several processes may call it at the same time.
    """
    if configured is not None:
        return _checked(configured)
    path = model_path()
    if not _is_ours(path):
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            # In the same folder, because only there the final move is atomic.
            with tempfile.TemporaryDirectory(dir=path.parent, prefix=".model-") as scratch:
                _make(path, Path(scratch))
        except OSError as error:
            raise UserError(
                f"the hand model cannot be written to {path.parent} ({error}); free some space "
                "or make it writable, or set `tracking.model` in halo.toml to a model's path"
            ) from error
    return path


def _checked(configured: Path) -> Path:
    if not configured.is_file():
        raise UserError(
            f"tracking.model: {configured} does not exist; correct the path, or remove the key "
            "to have the model downloaded"
        )
    if not zipfile.is_zipfile(configured):
        raise UserError(
            f"tracking.model: {configured} is not a Hand Landmarker bundle (.task); set another "
            "path, or remove the key to have the model downloaded"
        )
    return configured


def _is_ours(path: Path) -> bool:
    return path.is_file() and hashlib.sha256(path.read_bytes()).hexdigest() == _BUNDLE_SHA256


def _make(path: Path, scratch: Path) -> None:
    sys.stderr.write("Downloading the hand model (once, 35 MB) ...\n")
    sys.stderr.flush()
    target = scratch / "package"
    _install(target)
    bundle = scratch / path.name
    with zipfile.ZipFile(bundle, "w", zipfile.ZIP_STORED) as archive:
        for name, (inside, sha256) in _NETWORKS.items():
            archive.writestr(_entry(name), _network(target / inside, sha256))
    bundle.replace(path)


def _install(target: Path) -> None:
    command = [*_installer(), "--target", str(target), _PACKAGE]
    environment = dict(os.environ)
    reasons = []
    # Settings that suit other packages, such as PIP_USER or PIP_REQUIRE_HASHES, prevent this one:
    # the second try is without them.
    for tried in (environment, _without_settings(environment)):
        try:
            done = subprocess.run(
                command,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                check=False,
                env=tried,
            )
        except OSError as error:
            raise UserError(
                f"the hand model could not be downloaded ({command[0]}: {error.strerror}); "
                f"{_OR_ELSE}"
            ) from error
        log.debug("hand model: %s\n%s", " ".join(command), done.stdout)
        if done.returncode == 0:
            return
        reasons.append(_reason(done.stdout))
    raise UserError(f"the hand model could not be downloaded ({reasons[0]}); {_OR_ELSE}")


def _without_settings(environment: dict[str, str]) -> dict[str, str]:
    """Return an environment in which pip and uv follow no settings but where packages are."""
    passed = {
        name: value
        for name, value in environment.items()
        if not name.startswith(("PIP_", "UV_")) or any(word in name for word in _PLACES)
    }
    return {**passed, "PIP_CONFIG_FILE": os.devnull, "UV_NO_CONFIG": "1"}


def _reason(said: str) -> str:
    """Return why an installer failed, in one line."""
    lines = [line.strip() for line in said.splitlines() if line.strip()]
    errors = [line for line in lines if line.lower().startswith("error")] or lines[-1:]
    causes = [line for line in lines if line.startswith("Caused by:")][-1:]
    return "; ".join([*errors[:1], *causes])[:300] or "the installer gave no reason"


def _installer() -> list[str]:
    """The command that downloads a package: uv, however it can be called, else pip."""
    # `uv run` leaves its own path in UV.
    uv = os.environ.get("UV") or shutil.which("uv")
    if uv is not None or importlib.util.find_spec("uv") is not None:
        command = [uv] if uv is not None else [sys.executable, "-m", "uv"]
        return [*command, "pip", "install", "--python", sys.executable, "--no-deps", *_UV]
    if importlib.util.find_spec("pip") is not None:
        return [sys.executable, "-m", "pip", "install", "--no-deps", *_PIP]
    raise UserError(
        "the hand model must be downloaded once, but neither uv nor pip is installed; "
        f"install uv (see docs/install.md), or {_OR_ELSE}"
    )


def _network(path: Path, sha256: str) -> bytes:
    content = path.read_bytes() if path.is_file() else b""
    if hashlib.sha256(content).hexdigest() != sha256:
        raise UserError(
            f"the downloaded hand model is not the tested one ({path.name} differs), so it is "
            f"not used; {_OR_ELSE}"
        )
    return content


def _entry(name: str) -> zipfile.ZipInfo:
    """A zip entry without a date or a trace of the machine."""
    entry = zipfile.ZipInfo(name, date_time=(1980, 1, 1, 0, 0, 0))
    entry.create_system = 3
    entry.external_attr = 0o644 << 16
    return entry


def main() -> int:
    """Download the model if it is not cached, and print its path."""
    try:
        sys.stdout.write(f"{hand_model(None)}\n")
    except UserError as error:
        sys.stderr.write(f"{error}\n")
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
