"""What pydantic found wrong, as sentences that a user can act on."""

from __future__ import annotations

from dataclasses import fields, is_dataclass
from difflib import get_close_matches
from types import UnionType
from typing import Any, get_args, get_origin, get_type_hints

from pydantic import ValidationError
from pydantic_core import ErrorDetails

WORDS = {
    "string_type": "text",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "int_parsing": "a whole number",
    "float_type": "a number",
    "float_parsing": "a number",
    "bool_type": "true or false",
    "tuple_type": "a list of text",
}
BOUNDS = {
    "greater_than": "gt",
    "greater_than_equal": "ge",
    "less_than": "lt",
    "less_than_equal": "le",
    "finite_number": "",
}
"""Errors of a number's range, and the bound that it violates."""


def sentences(error: ValidationError, kind: type) -> list[str]:
    """Return one sentence per error; `kind`: the dataclass that was validated."""
    return [_sentence(each, kind) for each in error.errors()]


def _sentence(error: ErrorDetails, kind: type) -> str:
    """Say one error as `section: 'key' must be ..., not ...`."""
    keys = [part for part in error["loc"] if isinstance(part, str) and part != "[key]"]
    *sections, key = keys or [""]
    where = "".join(f"{each}: " for each in _sections(error["loc"]))
    shown = _shown(error["input"])
    match error["type"]:
        case "value_error":  # by a check of our own, which does not know where it is used
            return f"{where}{key}: {error['ctx']['error']}"
        case "unexpected_keyword_argument":
            return where + _unknown(key, [each.name for each in fields(_element(kind, sections))])
        case "missing" if isinstance(error["loc"][-1], int):
            return f"{where}'{key}' has too few elements: {shown}"
        case "missing":
            return f"{where}'{key}' is missing"
        case "dataclass_type" if isinstance(error["loc"][-1], int):
            return f"{where}'{key}' must be tables: [[{key}]]"
        case "dataclass_type":
            return f"{where}'{key}' must be a table: [{key}]"
        case "tuple_type" if is_dataclass(_element(kind, keys)):
            return f"{where}'{key}' must be tables: [[{key}]]"
    return f"{where}'{key}' must be {_allowed(error, kind, keys)}, not {shown}"


def _sections(loc: tuple[int | str, ...]) -> list[str]:
    """Return the tables that hold a value; one of a list with its number, from 1."""
    names: list[str] = []
    number = ""
    for part in reversed([part for part in loc if part != "[key]"]):
        if isinstance(part, int):
            number = f" {part + 1}"
        else:
            names.insert(0, part + number)
            number = ""
    return names[:-1]


def _unknown(key: str, known: list[str]) -> str:
    near = get_close_matches(key, known, 1)
    hint = f"; did you mean '{near[0]}'?" if near else ""
    return f"unknown key '{key}'; known: {', '.join(known)}{hint}"


def _allowed(error: ErrorDetails, kind: type, keys: list[str]) -> str:
    """Say what a value must be."""
    if error["type"] in BOUNDS:
        return _range(get_type_hints(_element(kind, keys[:-1]), include_extras=True)[keys[-1]])
    if error["type"] == "literal_error":
        return str(error["ctx"]["expected"]).replace("'", "")
    if error["type"] == "string_pattern_mismatch":
        return f"text that matches {error['ctx']['pattern']}"
    if error["type"] == "string_type" and len(error["loc"]) > len(keys):
        return WORDS["tuple_type"]
    return WORDS.get(error["type"], error["msg"].partition(" be ")[2] or error["msg"])


def _range(hint: Any) -> str:
    """Say a number's range by its annotations: `Gt`, `Ge` or `Interval`."""
    bounds = {
        name: bound
        for each in getattr(hint, "__metadata__", ())
        for name in ("gt", "ge", "le")
        if (bound := getattr(each, name, None)) is not None
    }
    match bounds:
        case {"ge": least, "le": most}:
            return f"from {least:g} to {most:g}"
        case {"ge": least}:
            return f"{least:g} or more"
        case {"gt": least}:
            return f"more than {least:g}"
    return "a finite number"


def _element(kind: Any, keys: list[str]) -> Any:
    """Return the same as `_inner`, or the type of its elements where it is a list."""
    kind = _inner(kind, keys)
    return get_args(kind)[0] if get_origin(kind) is tuple else kind


def _inner(kind: Any, keys: list[str]) -> Any:
    """Return the type that is found by following keys from a dataclass."""
    for key in keys:
        if get_origin(kind) is tuple:
            kind = get_args(kind)[0]
        hint = get_type_hints(kind)[key] if is_dataclass(kind) else get_args(kind)[-1]
        kind = get_args(hint)[0] if isinstance(hint, UnionType) else hint  # X | None
    return kind


def _shown(value: object) -> str:
    """Return a value as it is shown in a sentence, at most 60 characters."""
    text = f"{value:g}" if type(value) is float else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."
