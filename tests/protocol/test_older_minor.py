"""A later reader reads an older minor version; vectors of a released one are not overwritten."""

import json
import shutil
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

from halo_protocol import ProtocolError, Up, codec, decode, encode, from_json, to_json
from halo_protocol.checks import CHECKS
from halo_protocol.table import ROW_OF_KIND, ROW_OF_MESSAGE, UP, Row
from halo_protocol.version import VERSION
from tests.golden import PROTOCOL, VECTORS
from tests.protocol.appended import AXIS, READ, REFUSED, SPIN, UP_VIEW, view


@dataclass(frozen=True, slots=True)
class LaterUp(Up):
    spin: float = SPIN
    axis: tuple[float, ...] = AXIS


@pytest.fixture
def _reader_of_1_2(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    row = Row.of("up", LaterUp, f"{UP} | spin:f axis:f3", "later")
    monkeypatch.setitem(ROW_OF_KIND, "up", row)
    monkeypatch.setitem(ROW_OF_MESSAGE, LaterUp, row)
    monkeypatch.setitem(CHECKS, LaterUp, CHECKS[Up])
    codec._row_of.cache_clear()
    yield
    codec._row_of.cache_clear()


@pytest.mark.usefixtures("_reader_of_1_2")
@pytest.mark.parametrize(("datagram", "expected"), READ.values(), ids=READ)
def test_missing_fields_have_their_defaults(datagram: bytes, expected: dict[str, Any]) -> None:
    ((surface, message),) = decode(datagram)
    assert (surface, to_json(message)) == ("table", expected)


@pytest.mark.usefixtures("_reader_of_1_2")
@pytest.mark.parametrize(("datagram", "sentence"), REFUSED.values(), ids=REFUSED)
def test_a_message_ends_at_the_end_of_an_appended_field(datagram: bytes, sentence: str) -> None:
    with pytest.raises(ProtocolError) as refused:
        decode(datagram)
    assert str(refused.value).endswith(sentence)


@pytest.mark.usefixtures("_reader_of_1_2")
def test_all_fields_are_written() -> None:
    assert encode("table", LaterUp(*UP_VIEW.values(), 2.5, (1.0, 2.0, 3.0))).endswith(
        READ["1.2"][0]
    )


@pytest.mark.usefixtures("_reader_of_1_2")
def test_a_view_of_an_older_version_is_read() -> None:
    assert to_json(from_json("up", UP_VIEW)) == view(SPIN, AXIS)
    assert to_json(from_json("up", {**UP_VIEW, "spin": 2.5})) == view(2.5, AXIS)
    with pytest.raises(ProtocolError, match="up has no 'contacts'"):
        from_json("up", {name: UP_VIEW[name] for name in UP_VIEW if name != "contacts"})


def generated(folder: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(folder / "generate.py")]
    return subprocess.run(command, capture_output=True, text=True, timeout=60)


def test_vectors_of_a_released_minor_are_not_overwritten(tmp_path: Path) -> None:
    folder = tmp_path / "protocol"
    shutil.copytree(PROTOCOL, folder, ignore=shutil.ignore_patterns("__pycache__"))
    minor = VECTORS.name
    vectors = folder / "vectors" / minor / "reports.json"
    changed = vectors.read_text().replace("table", "other")
    vectors.write_text(changed)
    version = folder / "halo_protocol" / "version.py"
    source = version.read_text()
    released = source.replace("\nRELEASED: tuple[str, ...] = (", f'\nRELEASED = ("{minor}", ')
    assert released != source
    version.write_text(released)

    done = generated(folder)
    assert done.returncode == 1
    assert done.stderr == (
        f"vectors/{minor} would change, but {minor} is released: "
        "raise VERSION in halo_protocol/version.py first\n"
    )
    assert vectors.read_text() == changed

    version.write_text(released.replace(f'VERSION = "{VERSION}"', 'VERSION = "1.99.0"'))
    done = generated(folder)
    assert done.returncode == 0, done.stderr
    assert vectors.read_text() == changed
    new = json.loads((folder / "vectors" / "1.99" / "reports.json").read_text())
    assert new["protocol"] == "1.99.0"
