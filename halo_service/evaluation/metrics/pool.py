"""Many recordings' scores as one: tuples are joined, counts added, nested scores pooled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, is_dataclass
from itertools import chain
from typing import Any, TypeVar

Scores = TypeVar("Scores")


def pool(kind: type[Scores], parts: Sequence[Scores]) -> Scores:
    """Return one `kind` for all `parts`; its defaults where there are none."""
    if not parts:
        return kind()
    columns = ([getattr(part, each.name) for part in parts] for each in fields(kind))  # type: ignore[arg-type]
    return kind(*map(_joined, columns))


def _joined(values: Sequence[Any]) -> Any:
    first = values[0]
    if isinstance(first, tuple):
        return tuple(chain.from_iterable(values))
    return pool(type(first), values) if is_dataclass(first) else sum(values)
