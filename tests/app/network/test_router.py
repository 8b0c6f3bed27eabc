"""`halo router` is a Zenoh router: a service and a client meet at it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing

import pytest

import halo_client
from halo_service.app.cli import main
from halo_service.outputs.settings import ZenohSettings
from halo_service.outputs.zenoh import ZenohOutput
from tests.app.bridge.test_bridge import scene, until
from tests.app.conftest import HALO, Spawn


def test_a_service_and_a_client_meet_at_it(spawn: Spawn, free_port: Callable[[], int]) -> None:
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    router = spawn(HALO, "router", "--listen", endpoint)
    assert router.stderr is not None
    lines = [router.stderr.readline(), router.stderr.readline()]
    assert endpoint in lines[0]
    assert "ready" in lines[1]
    settings = ZenohSettings(listen=("tcp/127.0.0.1:0",), connect=(endpoint,))
    with halo_client.connect(f"zenoh://?connect={endpoint}") as receiver:
        with closing(ZenohOutput(settings, "desk", "table")) as service:
            until(lambda: service.send(scene()) or receiver.poll(0.02))
        assert "desk is connected" in router.stderr.readline()
        assert "desk has left" in router.stderr.readline()
    router.terminate()
    assert router.wait(20.0) == 0


@pytest.mark.parametrize(
    ("options", "says"),
    [
        ([], "name an address to listen on, such as --listen tcp/0.0.0.0:7447"),
        (["--listen", "nonsense"], "zenoh: cannot listen at nonsense (Endpoints"),
        (["--listen", "nonsense"], "; write endpoints as tcp/HOST:PORT"),
        (["--listen", "tcp/256.0.0.1:1"], "name another one with --listen"),
        (["nowhere.json5"], "nowhere.json5 cannot be read (file not found)"),
    ],
)
def test_wrong_options_are_one_sentence(
    options: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["router", *options]) == 2
    said = capsys.readouterr().err.strip().splitlines()
    assert len(said) == 1
    assert says in said[0]
