"""`halo profile`: list, show, copy, export and import profiles."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from halo_service.app.files import refuse_existing
from halo_service.app.tables import print_tables
from halo_service.errors import UserError
from halo_service.evaluation.report.table import Table
from halo_service.profile import Profile
from halo_service.profile.archive import pack, unpack
from halo_service.profile.model import TouchState
from halo_service.profile.store import (
    TEXT,
    exists,
    load,
    option_for,
    profile_path,
    profiles_path,
    save,
)

Rows = Iterator[tuple[str, str]]
"""What it is, and its value."""
NAME = re.compile(r"[\w-][\w .-]{0,63}")
"""Valid names of profiles in the data folder."""


def print_list() -> None:
    """Print one row for each profile in the data folder of the user."""
    folder = profiles_path()
    rows = [_row(each) for each in sorted(path.parent for path in folder.glob(f"*/{TEXT}"))]
    if not rows:
        print(f"no profiles in {folder}; make one with: halo calibrate --profile desk")
        return
    lines = (f"{a}: {b}, camera {serial}" if serial else f"{a}: {b}" for a, b, serial in rows)
    print_tables(
        Table("", ("profile", "calibrated", "camera"), tuple(rows)), plain="\n".join(lines)
    )


def print_profile(name: str) -> None:
    """Print what is in a profile."""
    folder = profile_path(name)
    profile = load(folder)
    title = f"{profile.name}: {profile.calibrated}, revision {profile.revision}, {folder}"
    first, then = tuple(facts(profile)), tuple(results(profile))
    lines = [*(f"{key} {value}" for key, value in first), *(f"{a}: {b}" for a, b in then)]
    print_tables(Table(title, ("", ""), (*first, *then)), plain="\n".join([title, *lines]))


def copy(name: str, to: str) -> Path:
    """Copy a profile; raises `UserError` if the new name exists."""
    profile, folder = load(profile_path(name)), _new_folder(to)
    save(_renamed(profile, folder), folder)
    return folder


def rename(name: str, to: str) -> Path:
    """Give a profile another name; raises `UserError` if the new name exists."""
    folder = copy(name, to)
    delete(name)
    return folder


def delete(name: str) -> Path:
    """Remove a profile, also one that cannot be read; raises `UserError` if there is none."""
    folder = profile_path(name)
    if not exists(folder):
        load(folder)  # its sentence says that there is none
    try:
        for path in sorted(folder.glob("*")):
            if path.name in (TEXT, ".lock") or path.suffix in (".npz", ".part"):
                path.unlink()
        if not any(folder.iterdir()):
            folder.rmdir()  # what is not of the profile stays
    except OSError as error:
        raise UserError(f"the profile {folder} cannot be removed ({error.strerror})") from error
    return folder


def export(name: str, out: Path, force: bool = False) -> None:
    """Write a profile into one file; raises `UserError` if there is such a file, unless `force`."""
    refuse_existing(out, force=force)
    pack(profile_path(name), out)


def import_profile(path: Path, name: str | None) -> Path:
    """Read a profile from a file; raises `UserError` if its name exists."""
    profile = unpack(path)
    if name is None:
        check_name(profile.name)  # the file is not ours: the name may be ../../anywhere
    folder = _new_folder(name or profile.name)
    save(_renamed(profile, folder), folder)
    return folder


def _new_folder(name: str) -> Path:
    folder = profile_path(name)
    if option_for(folder) == folder.name:
        check_name(name)
    if exists(folder):
        raise UserError(f"profile: {folder} exists already; choose another name")
    return folder


def is_name(name: str) -> bool:
    """Say whether a text is the name of a profile in the data folder, new or not."""
    return NAME.fullmatch(name) is not None


def check_name(name: str) -> None:
    """Raise `UserError` for a name that is not one of a profile in the data folder."""
    if not is_name(name):
        raise UserError(f"profile: '{name[:60]}' is not a valid name; use letters, digits, - and _")


def _renamed(profile: Profile, folder: Path) -> Profile:
    return replace(profile, name=folder.name)


def _row(folder: Path) -> tuple[str, str, str]:
    try:
        profile = load(folder)
    except UserError as error:
        return folder.name, str(error), ""
    return profile.name, profile.calibrated, profile.camera.serial


def facts(profile: Profile) -> Rows:
    """Yield what a profile belongs to."""
    camera, surface = profile.camera, profile.surface
    yield "camera", f"{camera.serial}, {camera.depth_mode}"
    yield "surface", f"{surface.name}, {surface.width_mm:g} x {surface.height_mm:g} mm"
    yield "halo threshold", f"{profile.halo_threshold_mm:g} mm"
    if profile.projector is not None:
        yield "projector", f"{profile.projector.width_px} x {profile.projector.height_px} px"
    if profile.anchor is not None:
        anchor = profile.anchor
        yield "anchor", f"{anchor.family} {anchor.marker}, {anchor.size_mm:g} mm"


def results(profile: Profile) -> Rows:
    """Yield how its steps went and what they measured."""
    yield from _steps(profile)
    yield from _states(profile)
    yield from _correction(profile)


def _steps(profile: Profile) -> Rows:
    from halo_service.app.calibration_ui.verdict import step_sentence  # OpenCV takes its time

    for step, record in profile.steps.items():
        yield step, f"{record.quality}, {record.date}. {step_sentence(step, record)}"


def _correction(profile: Profile) -> Rows:
    if profile.correction is not None:
        base = profile.correction.base or "none"
        yield "correction", f"{len(profile.correction.samples)} samples, base model {base}"


def _states(profile: Profile) -> Rows:
    sets = {"all fingers": profile.touch} | {
        f"{side.name.lower()} hand": states for side, states in profile.by_hand.items()
    }
    for fingers, states in sets.items():
        if states is not None:
            for name in ("hover", "subtle", "touch", "pressure", "hard"):
                held = getattr(states, name)
                if held is not None:
                    yield fingers, f"{name} {_state(held)}"


def _state(held: TouchState) -> str:
    origin = "given" if held.stated else "assumed"
    if held.height_mm > 0.0:
        what = f"at {held.height_mm:g} mm ({origin})"
    elif held.force_g >= 0.0:
        what = f"with {held.force_g:g} g ({origin})"
    else:
        what = "with unknown force"
    dent = f", dent {held.readings[1]:.1f} mm," if any(held.readings[1:2]) else ""
    return f"{held.signal:.0f} mm px{dent} {what}"
