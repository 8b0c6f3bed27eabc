"""Source URLs are read, or refused in one sentence."""

import pytest

from halo_client import (
    ClientError,
    Follow,
    OscSource,
    Source,
    WebSource,
    ZenohSource,
    parse_source,
)

HERE = ("tcp/127.0.0.1:7447",)


@pytest.mark.parametrize(
    ("url", "source"),
    [
        ("osc://127.0.0.1:4256", OscSource("127.0.0.1", 4256)),
        ("osc://0.0.0.0:9005/", OscSource("0.0.0.0", 9005)),
        ("osc://[::1]:4256", OscSource("::1", 4256)),
        ("osc://", OscSource("127.0.0.1", 4256)),
        ("osc://:0", OscSource("127.0.0.1", 0)),
        ("osc://?node=desk", OscSource("127.0.0.1", 4256, Follow("desk"))),
        ("osc://:1?follow=all", OscSource("127.0.0.1", 1, Follow(everything=True))),
        ("osc://?hello=127.0.0.1", OscSource("", 0, hello=("127.0.0.1", 4257))),
        (
            "osc://0.0.0.0:5000?hello=table.local:4300&rate=30&node=desk",
            OscSource("0.0.0.0", 5000, Follow("desk"), ("table.local", 4300), "frames,rate=30"),
        ),
        ("osc://?hello=[::1]:5", OscSource("", 0, hello=("::1", 5))),
        ("ws://127.0.0.1:4258/halo", WebSource("ws://127.0.0.1:4258/halo")),
        ("ws://[::1]?surface=wall", WebSource("ws://[::1]:4258/halo", Follow(surface="wall"))),
        ("wss://table.local:443/", WebSource("wss://table.local:443/halo")),
        ("zenoh://", ZenohSource(HERE)),
        ("zenoh://?connect=tcp/10.0.0.1:1", ZenohSource(("tcp/10.0.0.1:1",))),
        ("zenoh://?connect=tcp/a:1&connect=udp/b:2", ZenohSource(("tcp/a:1", "udp/b:2"))),
        ("zenoh://?multicast=on", ZenohSource((), multicast=True)),
        ("zenoh://?multicast=off", ZenohSource(HERE)),
        ("zenoh://?listen=tcp/0.0.0.0:7448", ZenohSource((), listen=("tcp/0.0.0.0:7448",))),
        (
            "zenoh://?mode=client&node=desk&surface=table",
            ZenohSource(HERE, mode="client", follow=Follow("desk", "table")),
        ),
    ],
)
def test_a_source_is_understood(url: str, source: Source) -> None:
    assert parse_source(url) == source


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("", "unknown source"),
        ("127.0.0.1:4256", "use osc://"),
        ("udp://127.0.0.1:4256", "use osc://"),
        ("osc://127.0.0.1:99999", "cannot read"),
        ("osc://127.0.0.1:x", "cannot read"),
        ("osc://127.0.0.1:4256/path", "needs a host and a port"),
        (
            "osc://127.0.0.1:4256?a=b",
            "osc: unknown setting 'a'; choose from: hello, rate, node, surface, follow",
        ),
        ("osc://?node=A", "osc: node must be"),
        ("osc://?follow=some", "osc: follow is first or all"),
        ("osc://?rate=30", "rate needs hello"),
        ("osc://?hello=", "hello is the control port"),
        ("osc://?hello=host:99999", "cannot read hello"),
        ("osc://?hello=host/path", "hello is the control port"),
        ("ws://", "ws needs a host"),
        ("ws://host/other", "ws needs a host"),
        ("ws://host?hello=other", "ws: unknown setting 'hello'"),
        ("zenoh://host", "accepts settings only"),
        (
            "zenoh://?conect=tcp/127.0.0.1:1",
            "unknown setting 'conect'; choose from: connect, listen",
        ),
        ("zenoh://?multicast=maybe", "multicast is off or on"),
        ("zenoh://?mode=router", "mode is auto, peer or client"),
        ("zenoh://?node=**", "node must be"),
        ("zenoh://?surface=control", "reserved"),
    ],
)
def test_a_source_is_refused_with_the_choices(url: str, says: str) -> None:
    with pytest.raises(ClientError, match=says.replace("?", r"\?")) as refused:
        parse_source(url)
    assert "\n" not in str(refused.value)
