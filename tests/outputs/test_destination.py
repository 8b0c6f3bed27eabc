"""Destinations are read, or refused in one sentence with the remedy."""

from __future__ import annotations

import pytest

from halo_service.errors import UserError
from halo_service.outputs.destination import Destination, Stream, parse_destination

READ = [
    ("127.0.0.1:4256", Destination("127.0.0.1", 4256)),
    ("127.0.0.1:7000/flat", Destination("127.0.0.1", 7000, Stream("flat"))),
    ("a.local:7000/flat,rate=60", Destination("a.local", 7000, Stream("flat", rate_hz=60.0))),
    ("[::1]:9,surface=wall", Destination("::1", 9, Stream(surface="wall"))),
    ("x:1,bundles=off", Destination("x", 1, Stream(bundles=False))),
    ("x:1/flat,changes=on,rate=0.5", Destination("x", 1, Stream("flat", 0.5, changes=True))),
    ("x:1, timetags=on", Destination("x", 1, Stream(timetags=True))),
    ("239.1.2.3:1,ttl=4,interface=lo", Destination("239.1.2.3", 1, Stream(), 4, "lo")),
    ("239.1.2.3:1,interface=127.0.0.1", Destination("239.1.2.3", 1, interface="127.0.0.1")),
    ("10.0.0.255:1/tuio2", Destination("10.0.0.255", 1, Stream("tuio2"))),
]


@pytest.mark.parametrize(("text", "destination"), READ, ids=[text for text, _ in READ])
def test_a_destination_is_read(text: str, destination: Destination) -> None:
    assert parse_destination(text) == destination


@pytest.mark.parametrize(
    ("text", "destination"),
    [
        ("127.0.0.1", Destination("127.0.0.1", 3333, Stream("tuio11"))),
        ("[::1]", Destination("::1", 3333, Stream("tuio11"))),
        ("127.0.0.1:3334/tuio2", Destination("127.0.0.1", 3334, Stream("tuio2"))),
        ("wall,rate=30", Destination("wall", 3333, Stream("tuio11", 30.0))),
    ],
)
def test_tuio_has_a_port_and_a_format(text: str, destination: Destination) -> None:
    assert parse_destination(text, "tuio") == destination


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", "is not a destination; write host:port, such as 127.0.0.1:4256"),
        ("127.0.0.1", "is not a destination"),
        (":4256", "is not a destination"),
        ("x:0", "port 0 is not from 1 to 65535"),
        ("x:65536", "port 65536 is not from 1 to 65535"),
        ("x:-1", "is not a destination"),
        ("x:1/tuio", "unknown format 'tuio' in 'x:1/tuio'; choose from: frames, flat, tuio11"),
        ("x:1,rte=3", "unknown option 'rte=3' in 'x:1,rte=3'; choose from: rate=, surface="),
        ("x:1,rate", "unknown option 'rate'"),
        ("x:1,rate=0", "rate must be a number of frames per second, up to 1000, not '0'"),
        ("x:1,rate=nan", "rate must be"),
        ("x:1,rate=fast", "rate must be"),
        ("x:1,surface=A/B", "surface must be the name of a surface, such as table, not 'A/B'"),
        ("x:1,bundles=no", "bundles must be on or off, not 'no'"),
        ("x:1,changes=on", "changes is an option of flat, not of frames, in 'x:1,changes=on'"),
        ("x:1/flat,timetags=on", "timetags is an option of frames, not of flat"),
        ("x:1/tuio2,bundles=off", "bundles is an option of frames and flat, not of tuio2"),
        ("x:1,ttl=256", "ttl must be a whole number from 0 to 255"),
        ("x:1,interface=nope0", "interface must be an IPv4 address of this machine or one of"),
    ],
)
def test_a_bad_destination_is_one_sentence(text: str, says: str) -> None:
    with pytest.raises(UserError) as refused:
        parse_destination(text)
    assert str(refused.value).startswith("osc: ")
    assert says in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_bad_tuio_destination_gets_an_example_of_tuio() -> None:
    with pytest.raises(UserError, match=r"such as 127\.0\.0\.1:3333 or 127\.0\.0\.1:3333/tuio2"):
        parse_destination("wall:x", "tuio")
