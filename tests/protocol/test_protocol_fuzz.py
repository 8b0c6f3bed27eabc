"""No bytes make a reader raise anything but `ProtocolError`."""

import contextlib
import json
from collections.abc import Iterator
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from halo_protocol import Assembler, ProtocolError, decode, from_json, parse_osc
from halo_protocol.osc import BUNDLE, padded
from halo_protocol.table import ROW_OF_KIND, ROWS
from tests.golden import VECTORS


def golden() -> Iterator[bytes]:
    for name in ("frames", "reports", "readings", "malformed"):
        for vector in json.loads((VECTORS / f"{name}.json").read_text())["vectors"]:
            for holder in vector.get("datagrams", [vector]):
                yield bytes.fromhex(holder["hex"])


GOLDEN = sorted(set(golden()), key=len)

# Meaningful pieces: random bytes alone would never pass the first check.
WORDS = st.sampled_from(
    [
        BUNDLE,
        bytes(8),
        b"\0\0\0\x14",
        b"\0\0\0\x40",
        b"\xff\xff\xff\xff",
        b"\x7f\xc0\0\0",
        b"\x7f\xff\xff\xff",
        padded("desk"),
        *(padded(f"/halo/1/table/{row.kind}") for row in ROWS),
        *(padded(f",{row.tags}") for row in ROWS),
        padded(",[]TFNIhdtcrmSb"),
    ]
)
NOISE = st.one_of(
    st.binary(max_size=200),
    st.lists(WORDS | st.binary(min_size=4, max_size=4), max_size=20).map(b"".join),
)


@st.composite
def bent(draw: st.DrawFn) -> bytes:
    """A golden datagram with a few bytes changed, removed or inserted."""
    raw = bytearray(draw(st.sampled_from(GOLDEN)))
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, len(raw)))
        if draw(st.booleans()):
            raw[at : at + 1] = draw(st.binary(min_size=1, max_size=1))
        else:
            raw[at : at + draw(st.sampled_from([0, 4, 8]))] = draw(WORDS)
    return bytes(raw)


def read_by_all(datagram: bytes) -> None:
    for reader in (decode, parse_osc, lambda data: Assembler().receive_data(data, 0.0)):
        with contextlib.suppress(ProtocolError):
            reader(datagram)


@settings(max_examples=300, deadline=None)
@given(NOISE)
def test_random_bytes_raise_only_protocol_error(datagram: bytes) -> None:
    read_by_all(datagram)


@settings(max_examples=300, deadline=None)
@given(bent())
def test_changed_datagrams_raise_only_protocol_error(datagram: bytes) -> None:
    read_by_all(datagram)


@settings(max_examples=50, deadline=None)
@given(st.lists(st.tuples(bent() | st.sampled_from(GOLDEN), st.floats(0, 10)), max_size=30))
def test_an_assembler_survives_any_sequence(sequence: list[tuple[bytes, float]]) -> None:
    assembler = Assembler()
    for datagram, now_s in sequence:
        with contextlib.suppress(ProtocolError):
            assembler.receive_data(datagram, now_s)
        assembler.expire(now_s)


@settings(max_examples=50, deadline=None)
@given(
    st.sampled_from(sorted(ROW_OF_KIND)),
    st.dictionaries(
        st.sampled_from([field.name for row in ROWS for field in row.fields]),
        st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.lists(st.floats()),
    ),
)
def test_any_json_raises_only_protocol_error(kind: str, view: dict[str, Any]) -> None:
    with contextlib.suppress(ProtocolError):
        from_json(kind, view)
