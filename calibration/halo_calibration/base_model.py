"""Base models: pilots' samples of one camera's halo, as text.

The virtual sensor's is in the same folder. It describes a simulation, so it serves a real
camera only where the user names it, and then says so.
"""

from __future__ import annotations

import logging
from pathlib import Path

import numpy as np

from halo_calibration.solvers.correction import Base
from halo_service.errors import UserError
from halo_service.files import data_folder, from_home, read_text

log = logging.getLogger(__name__)

VIRTUAL = Path(__file__).with_name("virtual_base.txt")
HEAD = "halo-service base model 2"
"""First line; a newer layout says another number."""
COLUMNS = {"halo-service base model 1": 5, HEAD: 6}
"""Of a row, by the first line: the first layout knew nothing of dents."""
KNOWN = 5
"""Columns that hold a number in every row; a dent may have been hidden."""


def pilot_path(camera_serial: str) -> Path:
    """Return where a camera's own base model lives."""
    return data_folder() / "bases" / f"{camera_serial}.txt"


def choose_base(wanted: str, camera_serial: str) -> Base | None:
    """Return the base model to use: `auto`, `none`, or a file.

    `auto`: the camera's own, from `halo calibrate pilot`, or None; never another camera's.
    """
    if wanted == "none":
        return None
    if wanted != "auto":
        base = read_base(from_home(wanted))
        if not is_device(camera_serial, base.camera_serial):
            log.warning(
                "base: '%s' was made on camera %s, this is %s: its correction may be wrong here",
                base.name, base.camera_serial, camera_serial,
            )  # fmt: skip
        return base
    own = pilot_path(camera_serial)
    if own.is_file():
        return read_base(own)
    if VIRTUAL.is_file():
        virtual = read_base(VIRTUAL)
        if is_device(camera_serial, virtual.camera_serial):
            return virtual
    return None


def is_device(camera_serial: str, device: str) -> bool:
    """Say whether a serial is a device's: a virtual camera appends its room to it."""
    return camera_serial == device or camera_serial.startswith(f"{device}-")


def read_base(path: Path) -> Base:
    """Read a base model. Raises `UserError` for any other file."""
    try:
        head, name, serial, *rows = read_text(path).splitlines()
        if head not in COLUMNS:
            raise ValueError(f"its first line is not '{HEAD}'")
        samples = np.array([row.split() for row in rows if not row.startswith("#")], np.float64)
        if samples.ndim != 2 or samples.shape[1] != COLUMNS[head]:
            raise ValueError(f"its rows are not {COLUMNS[head]} numbers each")
        if not np.isfinite(samples[:, :KNOWN]).all():
            raise ValueError("its places, angles and signals are not all numbers")
        missing = COLUMNS[HEAD] - COLUMNS[head]
        samples = np.pad(samples, ((0, 0), (0, missing)), constant_values=np.nan)
    except (OSError, ValueError) as error:
        raise UserError(
            f"the base model {path} cannot be read ({error}); make one with 'halo calibrate pilot'"
        ) from error
    return Base(name.removeprefix("name "), serial.removeprefix("camera "), samples)


def write_base(base: Base, path: Path) -> None:
    """Write a base model as text that diffs line by line."""
    lines = [HEAD, f"name {base.name}", f"camera {base.camera_serial}"]
    lines.append(
        "# x_mm y_mm (from the middle) pitch_deg yaw_deg signal dent (both of the pilot's at 45)"
    )
    lines += [
        f"{x:.0f} {y:.0f} {p:.0f} {w:.0f} {s:.3f} {d:.3f}" for x, y, p, w, s, d in base.relative
    ]
    path.parent.mkdir(parents=True, exist_ok=True)
    temporary = path.with_name(f".{path.name}.part")
    temporary.write_text("\n".join(lines) + "\n", encoding="utf-8")
    temporary.replace(path)
