"""Routers, TLS and access: the recipes of docs/networks.md, each run with the page's own files."""

from __future__ import annotations

import shutil
import signal
import time
from collections.abc import Callable

import pytest

from tests.networks.lab import Lab, Network, Program
from tests.networks.page import Recipe, recipe
from tests.networks.watching import arrive, frames, waited

pytestmark = pytest.mark.long

ROUTER = "A router between two networks"
CALLS = "If the router has to call the tables"
TLS = "TLS for both sides"
BY_CERTIFICATE, BY_CARD = "By certificate", "By network card"
QUIET_S = 1.2
"""Time after which nothing can be said to arrive."""
OPEN = """
import sys, time, zenoh
config = zenoh.Config.from_file("zenoh.json5")
config.insert_json5("mode", '"client"')
session = zenoh.open(config)
"""
PUBLISH = f"""{OPEN}
while True:
    for key in sys.argv[1:]:
        session.put(key, b"forged")
    time.sleep(0.02)
"""
SUBSCRIBE = f"""{OPEN}
subscriber = session.declare_subscriber("halo/**", lambda each: print(each.key_expr, flush=True))
time.sleep(60.0)
"""


def two_networks(lab: Lab) -> tuple[Network, Network]:
    """Tables at eth0 of the router, laptops at its eth1."""
    tables = lab.network("eth0", router="192.168.10.1/24", table="192.168.10.10/24")
    return tables, lab.network("eth1", router="192.168.20.1/24", laptop="192.168.20.20/24")


def test_a_router_passes_frames_between_two_networks_and_may_restart(lab: Lab) -> None:
    two_networks(lab)
    page = recipe(ROUTER)
    page.write(lab)
    router, table = page.start(lab, "router"), page.start(lab, "table")
    monitor = page.start(lab, "laptop", 0, "--json")
    bridge = page.start(lab, "laptop", 1)
    local = lab.machines["laptop"].start(
        "halo", "monitor", "--from", "osc://127.0.0.1:7000", "--json"
    )
    arrive(monitor)
    arrive(local)
    direct = "import socket; socket.create_connection(('192.168.10.10', 7447), 2.0)"
    assert "unreachable" in lab.machines["laptop"].run("python", "-c", direct).stderr
    router.end(signal.SIGKILL)
    time.sleep(1.0)
    page.start(lab, "router").wait_for("ready")
    print(f"frames come {arrive(monitor):.1f} s after the router is there again,")
    print(f"from the bridge {arrive(local):.1f} s later")
    waited(lambda: frames(local)[-1]["pointers"], 5.0)
    table.end(signal.SIGKILL)
    waited(lambda: not frames(monitor)[-1]["pointers"], 2.5)
    waited(lambda: not frames(local)[-1]["pointers"], 2.5)
    assert "desk/table" in bridge.end()


def test_a_router_can_call_the_tables(lab: Lab) -> None:
    two_networks(lab)
    page, calls = recipe(ROUTER), recipe(CALLS)
    calls.write(lab)
    page.start(lab, "table")
    calls.start(lab, "router")
    arrive(page.start(lab, "laptop", 0, "--json"))


@pytest.fixture
def certificates(lab: Lab, external_program: Callable[[str], str]) -> Recipe:
    """Machines of two networks with the page's certificates; one more is for a visitor."""
    external_program("openssl")
    two_networks(lab)
    page = recipe(TLS)
    page.files["router", "certificates.sh"] += "certificate visitor DNS:visitor\n"
    page.write(lab)
    router = lab.machines["router"]
    done = router.run("sh", "certificates.sh")
    assert done.returncode == 0, done.stderr
    for machine, names in (("table", ["table"]), ("laptop", ["laptop", "visitor"])):
        for name in ("ca.pem", *(f"{name}.{kind}" for name in names for kind in ("pem", "key"))):
            shutil.copy(router.folder / name, lab.machines[machine].folder)
    return page


def with_file(page: Recipe, lab: Lab, name: str, *changes: tuple[str, str]) -> Program:
    """Start the laptop's command with a changed copy of its Zenoh configuration."""
    text = page.files["laptop", "zenoh.json5"]
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    laptop = lab.machines["laptop"]
    (laptop.folder / name).write_text(text)
    return laptop.start("halo", "monitor", "--from", f"zenoh://?config={name}", "--json")


def test_with_tls_machines_without_our_certificate_are_refused_and_nothing_can_be_read(
    lab: Lab, certificates: Recipe
) -> None:
    page = certificates
    page.start(lab, "router").wait_for("ready")
    page.start(lab, "table")
    allowed = page.start(lab, "laptop", 0, "--json")
    arrive(allowed)
    elsewhere = lab.machines["laptop"].folder / "elsewhere"
    elsewhere.mkdir()
    script = page.files["router", "certificates.sh"]
    assert lab.machines["laptop"].run("sh", "-c", f"cd elsewhere; {script}").returncode == 0
    (lab.machines["laptop"].folder / "halo.toml").write_text(page.files["table", "halo.toml"])
    assert "desk" in lab.machines["laptop"].run("halo", "list").stdout
    refused = [
        with_file(page, lab, "none.json5", ("connect_", "listen_")),
        with_file(page, lab, "plain.json5", ("tls/192", "tcp/192")),
        with_file(page, lab, "other.json5", ("laptop.", "elsewhere/laptop.")),
        with_file(page, lab, "other_router.json5", ("ca.pem", "elsewhere/ca.pem")),
    ]
    for program in refused:
        program.wait_for("trying again")
    arrive(allowed)
    assert [frames(program) for program in refused] == [[]] * len(refused)
    assert [network.readable for network in lab.networks] == [0, 0]


def test_only_named_certificates_may_publish_and_read_and_a_wrong_name_denies_all(
    lab: Lab, certificates: Recipe
) -> None:
    page = certificates
    page.files |= recipe(BY_CERTIFICATE).files
    page.write(lab)
    router = page.start(lab, "router")
    router.wait_for("ready")
    page.start(lab, "table")
    allowed = page.start(lab, "laptop", 0, "--json")
    visitor = with_file(page, lab, "visitor.json5", ("laptop.", "visitor."))
    listener = lab.machines["laptop"].start("python", "-c", SUBSCRIBE)
    publish = ("python", "-c", PUBLISH, "halo/1/desk/table/forged", "halo/1/other/table/forged")
    forger = lab.machines["laptop"].start(*publish)
    arrive(allowed)
    listener.wait_for("halo/1/desk/table/frame")
    time.sleep(QUIET_S)
    assert "forged" not in listener.text, "a reader cannot publish"
    forger.end()
    lab.machines["table"].start(*publish)
    listener.wait_for("halo/1/desk/table/forged")
    time.sleep(0.5)
    assert "halo/1/other" not in listener.text, "a table cannot publish under another name"
    assert frames(visitor) == []
    assert "trying again" not in visitor.text, "it is connected, and receives nothing"
    assert {each["node"] for each in frames(allowed)} == {"desk"}
    router.end()
    text = page.files["router", "router.json5"]
    page.files["router", "router.json5"] = text.replace('["laptop"]', '["laptpo"]')
    page.write(lab)
    page.start(lab, "router").wait_for("desk is connected")
    before = len(frames(allowed))
    time.sleep(QUIET_S)
    assert len(frames(allowed)) <= before + 1, "its end without pointers"


def test_without_tls_network_cards_say_who_may_publish_and_read(lab: Lab) -> None:
    two_networks(lab)
    page = recipe(ROUTER)
    page.files |= recipe(BY_CARD).files
    page.write(lab)
    router = lab.machines["router"].start("halo", "router", "router.json5")
    page.start(lab, "table")
    arrive(page.start(lab, "laptop", 0, "--json"))
    router.wait_for("desk is connected")
    (laptop := lab.machines["laptop"]).folder.joinpath("halo.toml").write_text(
        'node = "fake"\n[zenoh]\nconnect = ["tcp/192.168.20.1:7447"]\n'
    )
    laptop.start("halo", "test-pattern").wait_for("ready")
    time.sleep(QUIET_S)
    assert "fake" not in router.text
