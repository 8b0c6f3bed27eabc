"""The profiles on the page: list, compare, copy, rename, delete, export, import, use."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

from halo_service.app import profiles
from halo_service.app.service.profile_reloader import ProfileReloader
from halo_service.errors import UserError
from halo_service.profile.archive import unpack
from halo_service.profile.store import TEXT, exists, load, profile_path, profiles_path
from halo_service.web.control_page.calls import Call

MOST_COPIES = 100


class ProfileCalls:
    """Works on the profiles in the user's data folder."""

    def __init__(
        self,
        reloader: ProfileReloader,
        in_use: Callable[[], str],
        at_start: Callable[[], str] = str,
    ) -> None:
        """`in_use`: returns the name of the profile that the service uses; `at_start`: of the one
        that the settings file names."""
        self._reloader, self._in_use, self._at_start = reloader, in_use, at_start

    def table(self) -> dict[str, Call]:
        """Return the calls."""
        return {
            "profiles": Call(self._list, reads=True),
            "use-profile": Call(self._use),
            "copy-profile": Call(lambda r: _done(profiles.copy(_name(r), _name(r, "to")))),
            "rename-profile": Call(lambda r: _done(profiles.rename(_name(r), _name(r, "to")))),
            "delete-profile": Call(self._delete),
            "export-profile": Call(_export),
            "import-profile": Call(_import, takes_file=True),
        }

    def _list(self, request: dict[str, Any]) -> dict[str, Any]:
        del request
        names = sorted(path.parent.name for path in profiles_path().glob(f"*/{TEXT}"))
        return {
            "profiles": [_described(name) for name in names],
            "in_use": self._in_use(),
            "at_start": self._at_start(),
            "error": self._reloader.error,
        }

    def _use(self, request: dict[str, Any]) -> dict[str, Any]:
        folder = profile_path(_name(request))
        load(folder)  # its sentences say what is wrong
        self._reloader.switch(folder)
        return {}

    def _delete(self, request: dict[str, Any]) -> dict[str, Any]:
        name = _name(request)
        if name == self._in_use():
            raise UserError(f"the service uses '{name}'; use another profile first")
        profiles.delete(name)
        return {}


def _described(name: str) -> dict[str, Any]:
    try:
        profile = load(profile_path(name))
    except UserError as error:
        return {"name": name, "error": str(error)}
    return {
        "name": name,
        "calibrated": profile.calibrated,
        "revision": profile.revision,
        "facts": list(profiles.facts(profile)),
        "results": list(profiles.results(profile)),
        "steps": {
            step: {"quality": record.quality, "date": record.date, "note": record.note}
            for step, record in profile.steps.items()
        },
    }


def _export(request: dict[str, Any]) -> bytes:
    with tempfile.TemporaryDirectory(prefix="halo-export-") as folder:
        out = Path(folder) / "profile"
        profiles.export(_name(request), out)
        return out.read_bytes()


def _import(content: bytes) -> dict[str, Any]:
    with tempfile.TemporaryDirectory(prefix="halo-import-") as folder:
        path = Path(folder) / "the file"
        path.write_bytes(content)
        try:
            return _done(profiles.import_profile(path, _free_name(unpack(path).name)))
        except UserError as error:
            raise UserError(str(error).replace(str(path), "the file")) from error


def _free_name(name: str) -> str:
    """Return a profile's name, with a number where there is one already. Raises `UserError`."""
    profiles.check_name(name)
    numbered = (name, *(f"{name[:60]}-{number}" for number in range(2, MOST_COPIES)))
    return next((each for each in numbered if not exists(profile_path(each))), name)


def _done(folder: Path) -> dict[str, Any]:
    return {"name": folder.name}


def _name(request: dict[str, Any], key: str = "name") -> str:
    """Return the name of a profile. Raises `UserError`: a request must not choose a folder."""
    name = request[key]
    if not isinstance(name, str):
        raise UserError("name a profile")
    profiles.check_name(name)
    return name
