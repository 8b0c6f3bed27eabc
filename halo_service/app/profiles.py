"""`halo profile`: list, show, copy, export and import profiles."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from halo_service.errors import UserError
from halo_service.profile import Profile
from halo_service.profile.archive import pack, unpack
from halo_service.profile.model import TouchState
from halo_service.profile.store import TEXT, exists, load, profile_path, profiles_path, save

NAME = re.compile(r"[\w-][\w .-]{0,63}")
"""Valid names of profiles in the data folder."""


def list_profiles() -> list[str]:
    """Return one line for each profile in the data folder of the user."""
    folder = profiles_path()
    found = sorted(path.parent for path in folder.glob(f"*/{TEXT}"))
    return [_line(each) for each in found] or [
        f"no profiles in {folder}; make one with: halo calibrate --profile desk"
    ]


def show(name: str) -> list[str]:
    """Return the lines that describe a profile."""
    folder = profile_path(name)
    profile = load(folder)
    camera, surface = profile.camera, profile.surface
    lines = [
        f"{profile.name}: {profile.calibrated}, revision {profile.revision}, {folder}",
        f"camera {camera.serial}, {camera.depth_mode}",
        f"surface {surface.name}, {surface.width_mm:g} x {surface.height_mm:g} mm",
        f"halo threshold {profile.halo_threshold_mm:g} mm",
    ]
    if profile.projector is not None:
        lines.append(f"projector {profile.projector.width_px} x {profile.projector.height_px} px")
    if profile.anchor is not None:
        anchor = profile.anchor
        lines.append(f"anchor {anchor.family} {anchor.marker}, {anchor.size_mm:g} mm")
    for step, record in profile.steps.items():
        figures = ", ".join(f"{key} {value:g}" for key, value in record.figures.items())
        note = f" ({record.note})" if record.note else ""
        lines.append(f"{step}: {record.quality}, {record.date}. {figures}{note}")
    lines += _states(profile)
    if profile.correction is not None:
        base = profile.correction.base or "none"
        lines.append(f"correction: {len(profile.correction.samples)} samples, base model {base}")
    return lines


def copy(name: str, to: str) -> Path:
    """Copy a profile; raises `UserError` if the new name exists."""
    profile, folder = load(profile_path(name)), _new_folder(to)
    save(_renamed(profile, folder), folder)
    return folder


def export(name: str, out: Path) -> None:
    """Write a profile into one file."""
    pack(profile_path(name), out)


def import_profile(path: Path, name: str | None) -> Path:
    """Read a profile from a file; raises `UserError` if its name exists."""
    profile = unpack(path)
    if name is None:
        _check_name(profile.name)  # the file is not ours: the name may be ../../anywhere
    folder = _new_folder(name or profile.name)
    save(_renamed(profile, folder), folder)
    return folder


def _new_folder(name: str) -> Path:
    folder = profile_path(name)
    if folder.parent == profiles_path():
        _check_name(name)
    if exists(folder):
        raise UserError(f"profile: {folder} exists already; choose another name")
    return folder


def _check_name(name: str) -> None:
    if not NAME.fullmatch(name):
        raise UserError(f"profile: '{name[:60]}' is not a valid name; use letters, digits, - and _")


def _renamed(profile: Profile, folder: Path) -> Profile:
    return replace(profile, name=folder.name)


def _line(folder: Path) -> str:
    try:
        profile = load(folder)
    except UserError as error:
        return f"{folder.name}: {error}"
    return f"{profile.name}: {profile.calibrated}, camera {profile.camera.serial}"


def _states(profile: Profile) -> list[str]:
    sets = {"all fingers": profile.touch} | {
        f"{side.name.lower()} hand": states for side, states in profile.by_hand.items()
    }
    return [
        f"{fingers}: {name} {_state(getattr(states, name))}"
        for fingers, states in sets.items()
        if states is not None
        for name in ("hover", "subtle", "touch", "pressure")
    ]


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
