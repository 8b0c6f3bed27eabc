"""The methods that the bench runs on the same frames: ours and its rivals.

Rule: ideas are free, code of others is not taken. A rival is as good as it can honestly be: its
constants were chosen on tuning users (201 to 203), by the F1 of their touches alone and not by
places, heights or forces; never on those that are reported.
"""

from __future__ import annotations

from typing import Any

from halo_service.errors import UserError
from halo_service.evaluation.methods.direct import DIRECT
from halo_service.evaluation.methods.paper.method import PAPER
from halo_service.evaluation.methods.wilson import WILSON
from halo_service.runtime.method import OURS, Method

METHODS: dict[str, Method[Any]] = {method.name: method for method in (OURS, PAPER, DIRECT, WILSON)}
"""By the name that `--method` knows them by."""
AS_CALIBRATED = tuple(name for name, method in METHODS.items() if method.learn is None)
"""The names of those that a profile serves as `halo calibrate` makes it."""

BY_SURFACE = (DIRECT.name, WILSON.name)
"""The names of those that go by the empty surface alone, without any touch states."""


def method_named(name: str) -> Method[Any]:
    """Return a method by its name; raises `UserError` that tells the known ones."""
    if name not in METHODS:
        raise UserError(f"unknown method '{name}'; known: {', '.join(METHODS)}")
    return METHODS[name]
