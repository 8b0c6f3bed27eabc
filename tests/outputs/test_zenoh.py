"""The same bytes as Zenoh samples, for present subscribers and for late joiners."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import pytest
import zenoh

import halo_protocol as wire
from halo_service.errors import UserError
from halo_service.outputs import zenoh_port
from halo_service.outputs.name_watch import NameWatch
from halo_service.outputs.outgoing import OutgoingFrame, OutgoingReport
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput

WAIT_S = 20.0


@pytest.fixture
def endpoint(free_port: Callable[[], int]) -> str:
    return f"tcp/127.0.0.1:{free_port()}"


@pytest.fixture
def output(endpoint: str) -> Iterator[ZenohOutput]:
    carrier = ZenohOutput(ZenohSettings(listen=(endpoint,)), "desk", "table")
    yield carrier
    carrier.close()


@pytest.fixture
def client(endpoint: str, output: ZenohOutput) -> Iterator[zenoh.Session]:
    config = zenoh.Config()
    config.insert_json5("mode", json.dumps("client"))
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    config.insert_json5("scouting/multicast/enabled", "false")
    session = zenoh.open(config)
    yield session
    session.close()


SCENE = wire.Scene("desk", "s1", "1.0.0", 300.0, 200.0, 2, 0, 0, 30.0)


def frame_of(count: int) -> OutgoingFrame:
    pointers = tuple(
        wire.Pointer(n, n, 2, 1, 0, 0.5, 0.5, 150, 100, 3, 0, 0, 0, 1, 0, -1) for n in range(count)
    )
    header = wire.Frame("desk", "s1", 1, 1, 0, count)
    return OutgoingFrame("table", (300.0, 200.0), header, pointers, (), ())


def test_each_datagram_is_a_sample_under_its_key(
    output: ZenohOutput, client: zenoh.Session
) -> None:
    frame = frame_of(12)
    assert len(frame.datagrams) == 2
    got: list[tuple[str, bytes]] = []
    arrived = threading.Event()

    def keep(sample: zenoh.Sample) -> None:
        got.append((str(sample.key_expr), bytes(sample.payload)))
        if len(got) >= 2:
            arrived.set()

    subscriber = client.declare_subscriber("halo/1/**", keep)
    for _ in range(100):  # until the subscription has reached the peer
        output.send(frame)
        if arrived.wait(0.1):
            break
    subscriber.undeclare()
    assert got[:2] == [("halo/1/desk/table/frame", each) for each in frame.datagrams]


def test_a_late_joiner_queries_retained_messages(
    output: ZenohOutput, client: zenoh.Session
) -> None:
    old, new = (OutgoingReport("table", replace(SCENE, revision=n)) for n in (1, 2))
    output.send(old)
    output.send(new)
    replies = list(client.get("halo/1/*/*/scene", timeout=WAIT_S))
    assert [bytes(reply.ok.payload) for reply in replies if reply.ok] == new.datagrams


def test_frames_are_not_retained(output: ZenohOutput, client: zenoh.Session) -> None:
    output.send(frame_of(1))
    assert list(client.get("halo/1/*/*/frame", timeout=2.0)) == []


def test_a_token_announces_the_node(output: ZenohOutput, client: zenoh.Session) -> None:
    tokens = list(client.liveliness().get("halo/1/*/alive", timeout=WAIT_S))
    assert [str(token.ok.key_expr) for token in tokens if token.ok] == ["halo/1/desk/alive"]


def opened_with(settings: ZenohSettings, monkeypatch: pytest.MonkeyPatch) -> dict[str, object]:
    """The configuration for Zenoh, which is not opened, because it would use the usual port."""
    got: list[zenoh.Config] = []

    def refuse(config: zenoh.Config) -> None:
        got.append(config)
        raise zenoh.ZError("enough seen")

    monkeypatch.setattr(zenoh, "open", refuse)
    monkeypatch.setattr(zenoh_port, "_is_free", lambda port: True)
    with pytest.raises(UserError, match="enough seen"):
        ZenohOutput(settings, "desk", "table")
    keys = ("listen/endpoints", "connect/endpoints", "scouting/multicast/enabled")
    return {key.partition("/")[0]: json.loads(got[0].get_json(key)) for key in keys}


ELSEWHERE = "tcp/127.0.0.1:7999"
FILE = {
    "listen": {"endpoints": [ELSEWHERE]},
    "connect": {"endpoints": ["tcp/127.0.0.1:7998"]},
    "scouting": {"multicast": {"enabled": True}},
}


@pytest.mark.parametrize(
    ("file", "options", "opened"),
    [
        (None, {}, (["tcp/127.0.0.1:7447"], [], False)),
        ({}, {}, (["tcp/127.0.0.1:7447"], [], False)),
        (FILE, {}, ([ELSEWHERE], ["tcp/127.0.0.1:7998"], True)),
        (
            FILE,
            {"listen": ("udp/127.0.0.1:1",)},
            (["udp/127.0.0.1:1"], ["tcp/127.0.0.1:7998"], True),
        ),
        (FILE, {"connect": ("udp/127.0.0.1:1",)}, ([ELSEWHERE], ["udp/127.0.0.1:1"], True)),
        ({"listen": {"endpoints": []}}, {}, ([], [], False)),
        ({}, {"multicast": True}, (["tcp/127.0.0.1:7447"], [], True)),
    ],
)
def test_settings_override_the_file_and_the_file_overrides_defaults(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    file: object,
    options: dict[str, object],
    opened: tuple[object, ...],
) -> None:
    path = tmp_path / "zenoh.json5"
    path.write_text(json.dumps(file))
    settings = ZenohSettings(config="" if file is None else str(path), **options)  # type: ignore[arg-type]
    assert tuple(opened_with(settings, monkeypatch).values()) == opened


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (None, "file not found"),
        ("{ listen: ", "expected array"),
        ("{ lisen: 3 }", "unknown field `lisen`"),
    ],
)
def test_a_configuration_that_cannot_be_read_is_one_sentence(
    tmp_path: Path, content: str | None, says: str
) -> None:
    path = tmp_path / "zenoh.json5"
    if content is not None:
        path.write_text(content)
    with pytest.raises(UserError, match="correct \\[zenoh\\] config, or leave it out") as caught:
        ZenohOutput(ZenohSettings(config=str(path)), "desk", "table")
    assert says in str(caught.value)
    assert "may have the port" not in str(caught.value)
    assert ".rs" not in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("listen", ["tcp/256.0.0.1:1", "rubbish", "foo/127.0.0.1:1"])
def test_an_invalid_endpoint_is_reported_without_positions_in_zenohs_source(listen: str) -> None:
    with pytest.raises(UserError, match="zenoh: cannot listen at") as caught:
        ZenohOutput(ZenohSettings(listen=(listen,)), "desk", "table")
    assert ".rs" not in str(caught.value)


def test_an_endpoint_in_use_is_one_sentence(endpoint: str, output: ZenohOutput) -> None:
    with pytest.raises(UserError, match="another service or router may have the port"):
        ZenohOutput(ZenohSettings(listen=(endpoint,)), "desk", "table")


def test_a_router_that_starts_later_and_one_that_ends_are_noticed(
    endpoint: str, caplog: pytest.LogCaptureFixture
) -> None:
    """Also where its endpoint is a name, which links do not show."""
    named = endpoint.replace("127.0.0.1", "localhost")
    settings = ZenohSettings(listen=("tcp/127.0.0.1:0",), connect=(named,))
    with closing(ZenohOutput(settings, "desk", "table")) as service:
        assert service.missing == 1
        config = zenoh.Config()
        config.insert_json5("mode", json.dumps("router"))
        config.insert_json5("listen/endpoints", json.dumps([endpoint]))
        config.insert_json5("scouting/multicast/enabled", "false")
        router = zenoh.open(config)
        waited(lambda: service.missing == 0)
        router.close()
        waited(lambda: service.missing == 1)
    said = [each.getMessage() for each in caplog.records if each.name.startswith("halo_service")]
    assert said == [
        f"zenoh: no connection to {named}; trying again until it answers",
        f"zenoh: connected to {named}",
        f"zenoh: no connection to {named}; trying again until it answers",
    ]


def waited(condition: Callable[[], bool]) -> None:
    until = time.monotonic() + WAIT_S
    while not condition():
        assert time.monotonic() < until
        time.sleep(0.02)


def test_two_services_with_one_name_both_notice(endpoint: str) -> None:
    one, two = NameWatch("desk", "s1"), NameWatch("desk", "s2")
    with (
        closing(ZenohOutput(ZenohSettings(listen=(endpoint,)), "desk", "table", one)) as first,
        closing(
            ZenohOutput(
                ZenohSettings(listen=("tcp/127.0.0.1:0",), connect=(endpoint,)),
                "desk",
                "table",
                two,
            )
        ) as second,
    ):
        until = time.monotonic() + WAIT_S
        while time.monotonic() < until:
            first.send(OutgoingReport("table", SCENE))
            second.send(OutgoingReport("table", replace(SCENE, session="s2")))
            time.sleep(0.05)
            if one.collision(time.monotonic()) and two.collision(time.monotonic()):
                return
    pytest.fail("a collision was not noticed")


def test_a_service_does_not_collide_with_itself(endpoint: str) -> None:
    names = NameWatch("desk", "s1")
    with closing(ZenohOutput(ZenohSettings(listen=(endpoint,)), "desk", "table", names)) as alone:
        for _ in range(10):
            alone.send(OutgoingReport("table", SCENE))
            time.sleep(0.02)
    assert not names.collision(time.monotonic())
