"""Receive touch, hover and pressure from a halo service, over OSC or Zenoh, or from a file.

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
from halo_client.placing import Placing
from halo_client.receiver import Input, Losses, Receiver
from halo_client.silence import Silence, waiting
from halo_client.source import (
    DEFAULT_SOURCE,
    FileSource,
    OscSource,
    Source,
    ZenohSource,
    parse_source,
)
from halo_client.touches import Began, Ended, Moved, Touch, TouchKey, touches
from halo_protocol import TouchFrame

__all__ = [
    "DEFAULT_SOURCE",
    "Began",
    "ClientError",
    "Ended",
    "FileSource",
    "Input",
    "Known",
    "Losses",
    "Moved",
    "OscSource",
    "Placing",
    "Receiver",
    "Silence",
    "Source",
    "Touch",
    "TouchKey",
    "ZenohSource",
    "frames",
    "parse_source",
    "receive",
    "touches",
    "waiting",
]


def receive(source: str | Source = DEFAULT_SOURCE) -> Receiver:
    """Open a source; close the receiver, or use it in a `with`.

    `"osc://127.0.0.1:9000"` hears datagrams on a port of this machine,
    `"zenoh://?connect=tcp/127.0.0.1:7447"` subscribes, `"take.jsonl"` plays a recorded stream at
    its own pace. `ClientError` where it cannot be opened.
    """
    if isinstance(source, str):
        source = parse_source(source)
    return Receiver(_open(source))


@overload
def frames(
    source: str | Source = ..., timeout_s: None = None
) -> Generator[TouchFrame, None, None]: ...
@overload
def frames(source: str | Source, timeout_s: float) -> Generator[TouchFrame | None, None, None]: ...
@overload
def frames(*, timeout_s: float) -> Generator[TouchFrame | None, None, None]: ...
def frames(
    source: str | Source = DEFAULT_SOURCE, timeout_s: float | None = None
) -> Generator[TouchFrame | None, None, None]:
    """Each frame as it comes; with a timeout, None whenever none came for so long.

    It goes on for ever, but for a recorded stream, which ends.

    The source is opened with the first frame that is asked for, and closed with the iterator.
    """
    with receive(source) as receiver:
        yield from receiver.frames(timeout_s)


def _open(source: Source) -> Input:
    # Imported when asked for: a client of UDP does not wait for Zenoh to load.
    if isinstance(source, OscSource):
        from halo_client.udp import UdpInput

        return UdpInput(source)
    if isinstance(source, FileSource):
        from halo_client.jsonl import JsonlInput

        return JsonlInput(source)
    from halo_client.zenoh_input import ZenohInput

    return ZenohInput(source)
