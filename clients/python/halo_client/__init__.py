"""Receive touch, hover and pressure from a halo service: OSC, WebSocket, Zenoh or a file.

    for frame in halo_client.frames("osc://127.0.0.1:4256"):
        for pointer in frame.pointers:
            print(pointer.id, pointer.x_mm, pointer.y_mm, pointer.pressure)

or, with functions that are called:

    with halo_client.connect("ws://127.0.0.1:4258/halo") as receiver:
        receiver.on_down(lambda touch: print(touch.down.u, touch.down.v))
        receiver.run()

It depends on `halo_protocol` and never on the service.
"""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import replace
from typing import overload

from halo_client.errors import ClientError
from halo_client.follow import FIRST, Follow
from halo_client.known_services import KnownServices
from halo_client.picture import PictureTransform
from halo_client.receiver import Input, Losses, Receiver
from halo_client.silence import Silence, waiting
from halo_client.source import (
    DEFAULT_SOURCE,
    FileSource,
    OscSource,
    Source,
    WebSource,
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
    "Follow",
    "Input",
    "KnownServices",
    "Losses",
    "Moved",
    "OscSource",
    "PictureTransform",
    "Receiver",
    "Silence",
    "Source",
    "Touch",
    "TouchKey",
    "WebSource",
    "ZenohSource",
    "connect",
    "frames",
    "parse_source",
    "touches",
    "waiting",
]


def connect(source: str | Source = DEFAULT_SOURCE, *, everything: bool = False) -> Receiver:
    """Open a source; close the receiver, or use it in a `with`.

    `"osc://127.0.0.1:4256"` receives datagrams on a port of this machine,
    `"osc://?hello=127.0.0.1:4257"` asks a service to send them, `"ws://127.0.0.1:4258/halo"` and
    `"zenoh://?connect=tcp/127.0.0.1:7447"` subscribe, `"recording.jsonl"` replays a recorded
    stream at its own speed. It follows the first service that sends a frame, or the one named by
    `?node=...&surface=...`; `everything` reports all services. A service may start later or
    restart. `ClientError` if the source cannot be opened.
    """
    if isinstance(source, str):
        source = parse_source(source)
    follow = FIRST if isinstance(source, FileSource) else source.follow
    return Receiver(_open(source), replace(follow, everything=follow.everything or everything))


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
    """Yield each frame when it arrives; with a timeout, None after each wait without a frame.

    A live source never ends; a recorded stream does.

    The source is opened with the first frame that is read, and closed with the iterator.
    """
    with connect(source) as receiver:
        yield from receiver.frames(timeout_s)


def _open(source: Source) -> Input:
    # Imported when needed: a UDP client does not wait for Zenoh to load.
    if isinstance(source, OscSource):
        from halo_client.udp import UdpInput

        return UdpInput(source)
    if isinstance(source, FileSource):
        from halo_client.jsonl import JsonlInput

        return JsonlInput(source)
    if isinstance(source, WebSource):
        from halo_client.websocket_input import WebSocketInput

        return WebSocketInput(source)
    from halo_client.zenoh_input import ZenohInput

    return ZenohInput(source)
