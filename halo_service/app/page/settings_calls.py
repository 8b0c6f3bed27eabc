"""The settings on the page: forms from the schema, written to `halo.toml`, applied at once where
that is possible."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from halo_service.app.service.carriers import destinations
from halo_service.errors import UserError
from halo_service.outputs.osc import OscOutput
from halo_service.sensing import State
from halo_service.settings import Settings, load, settings_path
from halo_service.settings.file import DEFAULT_FILE
from halo_service.settings.schema import schema_text
from halo_service.settings.write import Change, write
from halo_service.web.control_page.calls import Call

AT_ONCE = frozenset({"sensing", "osc", "tuio"})
"""Sections of which changes are used by the running service."""
SECRET = {"page": ("token",)}
"""Settings that a viewer must not see."""


class SettingsCalls:
    """Reads and changes the settings of one service."""

    def __init__(
        self,
        running: Settings,
        path: Path | None,
        osc: OscOutput,
        request: Callable[[Callable[[State], State]], None],
    ) -> None:
        """`running`: file and command line together; `path`: of the file; `request`: see
        `PageObserver.request`."""
        self._running, self._path = running, path
        self._osc, self._request = osc, request

    def table(self) -> dict[str, Call]:
        """Return the calls."""
        return {"settings": Call(self._read, reads=True), "change-settings": Call(self._change)}

    def profile_at_start(self) -> str:
        """Return the profile that the file names; empty: none, or the file cannot be read."""
        try:
            return load(self._path).profile
        except UserError:
            return ""

    def _read(self, request: dict[str, Any]) -> dict[str, Any]:
        del request
        path = settings_path(self._path) or DEFAULT_FILE
        return {
            "schema": json.loads(schema_text()),
            "values": _shown(load(self._path)),
            "defaults": _shown(Settings()),
            "running": _shown(self._running),
            "file": str(path.resolve()),
            "exists": path.exists(),
            "at_once": sorted(AT_ONCE),
        }

    def _change(self, request: dict[str, Any]) -> dict[str, Any]:
        changes = [_change(each) for each in request["changes"]]
        if not 0 < len(changes) <= 100:
            raise UserError("send between 1 and 100 settings")
        before = load(self._path)
        after = write(self._path, changes)
        self._apply(before, after, {each.section for each in changes})
        later = sorted({each.section for each in changes} - AT_ONCE)
        return {"values": _shown(after), "running": _shown(self._running), "later": later}

    def _apply(self, before: Settings, after: Settings, sections: set[str]) -> None:
        """Use what can be used while the service runs."""
        if "sensing" in sections and before.sensing != after.sensing:
            self._running = replace(self._running, sensing=after.sensing)
            self._request(lambda state: replace(state, settings=after.sensing))
        if sections & {"osc", "tuio"}:
            changed = replace(self._running, osc=after.osc, tuio=after.tuio)
            wanted = destinations(changed)
            self._running = changed

            def send_elsewhere(state: State) -> State:
                self._osc.set_fixed(wanted)
                return state

            self._request(send_elsewhere)


def _change(value: Any) -> Change:
    """Read one change of a request. Raises `UserError`."""
    section, key = value["section"], value["key"]
    if not isinstance(section, str) or not isinstance(key, str):
        raise UserError("a setting is named by a section and a key")
    return Change(section, key, value["value"])


def _shown(settings: Settings) -> dict[str, Any]:
    """Return the values, without those that are secret."""
    values = asdict(settings)
    for section, keys in SECRET.items():
        for key in keys:
            values[section][key] = ""
    return values
