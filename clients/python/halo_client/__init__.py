"""Receive touch, hover and pressure from a halo service, over OSC or Zenoh.

    for frame in halo_client.frames("osc://127.0.0.1:9000"):
        for pointer in frame.pointers:
            print(pointer.id, pointer.x_mm, pointer.y_mm, pointer.pressure)

It knows the promise (`halo_protocol`) and never the service.
"""

from __future__ import annotations

from collections.abc import Generator
from typing import overload

from halo_client.errors import ClientError
from halo_client.known import Known
from halo_client.receiver import Input, Losses, Receiver
from halo_client.source import (
    DEFAULT_SOURCE,
    OscSource,
    ZenohSource,
    parse_source,
)
from halo_protocol import TouchFrame

__all__ = [
    "DEFAULT_SOURCE",
    "ClientError",
    "Input",
    "Known",
    "Losses",
    "OscSource",
    "Receiver",
    "ZenohSource",
    "frames",
    "parse_source",
    "receive",
]


def receive(source: str | OscSource | ZenohSource = DEFAULT_SOURCE) -> Receiver:
    """Open a source; close the receiver, or use it in a `with`.

    `"osc://127.0.0.1:9000"` hears datagrams on a port of this machine,
    `"zenoh://?connect=tcp/127.0.0.1:7447"` subscribes. `ClientError` where it cannot be opened.
    """
    if isinstance(source, str):
        source = parse_source(source)
    return Receiver(_open(source))


@overload
def frames(source: str = ..., timeout_s: None = None) -> Generator[TouchFrame, None, None]: ...
@overload
def frames(source: str, timeout_s: float) -> Generator[TouchFrame | None, None, None]: ...
@overload
def frames(*, timeout_s: float) -> Generator[TouchFrame | None, None, None]: ...
def frames(
    source: str = DEFAULT_SOURCE, timeout_s: float | None = None
) -> Generator[TouchFrame | None, None, None]:
    """Each frame as it comes, for ever; with a timeout, None whenever none came for so long.

    The source is opened with the first frame that is asked for, and closed with the iterator.
    """
    with receive(source) as receiver:
        yield from receiver.frames(timeout_s)


def _open(source: OscSource | ZenohSource) -> Input:
    # Imported when asked for: a client of UDP does not wait for Zenoh to load.
    if isinstance(source, OscSource):
        from halo_client.udp import UdpInput

        return UdpInput(source)
    from halo_client.zenoh_input import ZenohInput

    return ZenohInput(source)
