"""The Max patcher is what its script writes; its lines and addresses exist. Not run in Max."""

from __future__ import annotations

import json
import runpy
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import halo_protocol as wire
from halo_service.outputs.formats.flat import FlatFormat
from tests.outputs.samples import TOUCHING, frame

FOLDER = Path(__file__).parents[3] / "clients" / "max"
PATCH = FOLDER / "halo.maxpat"
REFERENCE = {
    "udpreceive": (1, 1), "change": (1, 3), "*": (2, 1), "!-": (2, 1),
    "scale": (6, 1), "cycle~": (2, 1), "clip": (3, 1), "pack": (2, 1), "line~": (2, 2),
    "*~": (2, 1), "comment": (1, 0), "flonum": (1, 2), "toggle": (1, 1), "button": (1, 1),
    "pictslider": (2, 2), "ezdac~": (2, 0),
}  # fmt: skip
"""Inlets and outlets with the arguments used here, from the reference pages of Max."""


@pytest.fixture(scope="module")
def patcher() -> dict[str, Any]:
    return dict(json.loads(PATCH.read_text())["patcher"])


@pytest.fixture(scope="module")
def boxes(patcher: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {each["box"]["id"]: each["box"] for each in patcher["boxes"]}


@pytest.fixture(scope="module")
def lines(patcher: dict[str, Any]) -> list[tuple[list[Any], list[Any]]]:
    found = [each["patchline"] for each in patcher["lines"]]
    return [(line["source"], line["destination"]) for line in found]


def test_the_file_is_what_its_script_writes(boxes: dict[str, Any], patcher: dict[str, Any]) -> None:
    written = runpy.run_path(str(FOLDER / "make_patch.py"))["patch"]()
    assert PATCH.read_text() == written, "run `python3 clients/max/make_patch.py`"
    assert len(boxes) == len(patcher["boxes"]), "an id is used twice"


def test_each_line_joins_an_outlet_and_an_inlet_that_exist(
    boxes: dict[str, Any], lines: list[Any]
) -> None:
    for (source, outlet), (destination, inlet) in lines:
        assert 0 <= outlet < boxes[source]["numoutlets"]
        assert 0 <= inlet < boxes[destination]["numinlets"]
    assert len(lines) == len({str(line) for line in lines})


def test_objects_are_those_of_max_with_their_inlets_and_outlets(boxes: dict[str, Any]) -> None:
    for box in boxes.values():
        words = box["text"].split() if box["maxclass"] == "newobj" else [box["maxclass"]]
        count = len(words)
        expected = (count, count) if words[0] == "route" else REFERENCE[words[0]]
        assert (box["numinlets"], box["numoutlets"]) == expected, words


def test_each_address_is_sent_and_shown(boxes: dict[str, Any], lines: list[Any]) -> None:
    """All slots in use, as the service sends them; each route's outlets lead somewhere."""
    fingers = tuple(replace(TOUCHING, id=100 + slot, slot=slot) for slot in range(10))
    datagrams = FlatFormat().frame(frame(1, fingers))
    sent = {address for raw in datagrams for address, _ in wire.parse_osc(raw)}
    used = {tuple(source) for source, _ in lines}
    routes = {
        name: box["text"].split()[1:]
        for name, box in boxes.items()
        if box.get("text", "").startswith("route ")
    }
    assert len(routes) == 10
    for name, addresses in routes.items():
        assert set(addresses) <= sent
        assert {(name, outlet) for outlet in range(len(addresses))} <= used


def test_the_port_is_the_one_of_the_readme(boxes: dict[str, Any]) -> None:
    (receiver,) = [box for box in boxes.values() if box.get("text", "").startswith("udpreceive")]
    port = receiver["text"].split()[1]
    assert f"halo serve --osc 127.0.0.1:{port}/flat" in (FOLDER / "README.md").read_text()
