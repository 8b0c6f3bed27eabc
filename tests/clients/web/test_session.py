"""halo.js follows a service and reports its touches like halo_client. Needs node."""

from __future__ import annotations

import json
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from halo_client import Began, Follow, Moved, Receiver, touches
from halo_protocol import ANY, Event, TouchFrame, event_to_json
from halo_service.app.conformance.script import Step, steps
from tests.clients.scripted import Script

pytestmark = pytest.mark.skipif(shutil.which("node") is None, reason="node is not installed")


def in_python(
    script: list[Step], follow: Follow, monkeypatch: pytest.MonkeyPatch
) -> dict[str, Any]:
    now = [0.0]
    monkeypatch.setattr("halo_client.receiver.time.monotonic", lambda: now[0])
    receiver = Receiver(Script(now, script), follow)
    found = [line for _ in script for event in receiver.poll(0.0) for line in lines(event)]
    return {"found": json.loads(json.dumps(found)), "bad": receiver.losses.bad}


def lines(event: Event) -> Iterator[dict[str, Any]]:
    yield event_to_json(event)
    if isinstance(event, TouchFrame):
        for touch in touches(event):
            kind = "down" if isinstance(touch, Began) else "up"
            kind = "move" if isinstance(touch, Moved) else kind
            key = touch.key
            parts = (key.node, key.surface, key.session, key.id, key.contacts)
            yield {"kind": kind, "key": "/".join(map(str, parts))}


def in_javascript(script: list[Step], follow: Follow) -> dict[str, Any]:
    raw = [{"hex": s.datagram.hex() if s.datagram else None, "at_s": s.at_s} for s in script]
    options: dict[str, Any] = {"everything": follow.everything}
    options |= {} if follow.node == ANY else {"node": follow.node}
    options |= {} if follow.surface == ANY else {"surface": follow.surface}
    done = subprocess.run(
        ["node", str(Path(__file__).with_name("session.mjs"))],
        input=json.dumps({"steps": raw, "follow": options}),
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout))


@pytest.mark.parametrize(
    ("follow", "services"),
    [
        # The first service is followed until it is lost, 3 s after its last frame; then the next.
        # All are lost with the last step, where the frame that ends "strangers" is the next.
        (Follow(), {"plain", "collision", "strangers"}),
        (Follow("restart"), {"restart"}),
        (Follow("collision"), {"collision"}),
        (Follow("right", "table"), {"right"}),
        (Follow("left", "wall"), set()),
        (Follow(everything=True), None),
    ],
    ids=["first", "restart", "collision", "node", "other-surface", "all"],
)
def test_both_clients_report_the_same(
    follow: Follow, services: set[str] | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    script = steps()
    expected = in_python(script, follow, monkeypatch)
    assert in_javascript(script, follow) == expected
    nodes = {each["node"] for each in expected["found"] if "node" in each}
    assert services in (None, nodes)
