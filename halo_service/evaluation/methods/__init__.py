"""The methods that the evaluation runs on the same frames: ours and its rivals.

Rule: the rivals are written from their papers, without code of others, and as good as they can
honestly be: their constants were chosen on tuning users (201 to 203) by the F1 of their touches
alone, not by places, heights or forces; never on reported users.
"""

from __future__ import annotations

from typing import Any

from halo_service.errors import UserError
from halo_service.evaluation.methods.direct import DIRECT
from halo_service.evaluation.methods.paper.method import PAPER
from halo_service.evaluation.methods.wilson import WILSON
from halo_service.runtime.method import OURS, Method

METHODS: dict[str, Method[Any]] = {method.name: method for method in (OURS, PAPER, DIRECT, WILSON)}
"""By the name for `--method`."""
READS_PROFILE = tuple(name for name, method in METHODS.items() if method.learn is None)
"""Methods that read a profile as `halo calibrate` makes it."""

NEEDS_NO_STATES = (DIRECT.name, WILSON.name)
"""Methods that need the empty surface alone, and no touch states."""


def method_named(name: str) -> Method[Any]:
    """Return a method by its name; raises `UserError` with the names for an unknown one."""
    if name not in METHODS:
        raise UserError(f"unknown method '{name}'; choose from: {', '.join(METHODS)}")
    return METHODS[name]
