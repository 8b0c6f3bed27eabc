"""Virtual profiles in the cache folder: a room is measured once, not at every start.

Rule: a file is found by everything that its profile depends on: room, settings, hand model, and
the code of the simulation, the sensing and the calibration.
"""

from __future__ import annotations

import hashlib
import logging
import os
import shutil
from collections.abc import Callable
from pathlib import Path

import halo_calibration
import halo_service
from halo_service.app.hand_detector import model_for
from halo_service.errors import UserError
from halo_service.files import cache_folder
from halo_service.profile import Profile
from halo_service.profile.store import exists, load, save
from halo_service.settings import Settings
from halo_service.virtual.room import Room

log = logging.getLogger(__name__)

PARTS = ("virtual", "sensing", "hand_tracking", "geometry", "profile", "app/virtual_user")
"""Folders of halo_service: the code in them decides what is measured."""
MOST_ROOMS = 16
"""Rooms that stay in the cache; each takes 3 MB."""


def cached_profile(
    room: Room, settings: Settings, measure: Callable[[Room, Settings], Profile]
) -> Profile:
    """Return the profile of a virtual room, measured if it is not in the cache."""
    if room.projected is not None or room.sheets:
        return measure(room, settings)  # it also depends on a file that may change
    try:
        folder = cache_folder() / "virtual-profiles" / key_of(room, settings)
    except UserError:  # a user without a home
        return measure(room, settings)
    if exists(folder):
        try:
            os.utime(folder)  # it was used
            return load(folder)
        except (UserError, OSError) as error:
            log.debug("virtual profile: %s; measuring again", error)
    profile = measure(room, settings)
    _store(profile, folder)
    return profile


def key_of(room: Room, settings: Settings) -> str:
    """Name all that a room's profile depends on."""
    digest = hashlib.sha256(repr((room, settings.sensing)).encode())
    digest.update(hashlib.sha256(model_for(settings.tracking).read_bytes()).digest())
    digest.update(_code())
    return digest.hexdigest()[:24]


def _code() -> bytes:
    """Hash the code that simulates, senses and calibrates."""
    service = Path(halo_service.__file__).parent
    folders = [Path(halo_calibration.__file__).parent, *(service / part for part in PARTS)]
    digest = hashlib.sha256()
    for folder in folders:
        for path in sorted(folder.rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.digest()


def _store(profile: Profile, folder: Path) -> None:
    """Write a profile, and remove those that were not used for longest."""
    try:
        save(profile, folder)
        used = sorted(folder.parent.iterdir(), key=lambda each: each.stat().st_mtime, reverse=True)
        for old in used[MOST_ROOMS:]:
            shutil.rmtree(old, ignore_errors=True)
    except (UserError, OSError) as error:
        log.debug("virtual profile: not stored: %s", error)
