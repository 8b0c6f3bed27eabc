"""Record the short streams of this folder: virtual hands, sensed by the service.

    uv run python -m tests.clients.recorded.record

Each NAME.jsonl is what a client receives, each NAME.truth.json what the virtual hand really did:
its touches, and the force of its index finger at the time of each frame. Takes half a minute.
"""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

import halo_client
from halo_client import FileSource
from halo_protocol import event_to_json
from tests.clients.streams import Session, sense
from tests.kind_sensor import KIND_URL

FOLDER = Path(__file__).parent
STREAMS = {
    "drumming": (f"sim:drumming?seed=4&{KIND_URL}", 8.0),
    "painting": (f"sim:painting?seed=3&{KIND_URL}", 9.0),
}
"""Scenario and length: many touches; long strokes of changing force."""
DIGITS = 3


def main() -> None:
    """Write all streams."""
    for name, (scenario, seconds) in STREAMS.items():
        with tempfile.TemporaryDirectory() as folder:
            session = sense(scenario, seconds, Path(folder) / "stream.jsonl")
            stream = list(halo_client.frames(FileSource(session.stream, paced=False)))
        lines = [
            json.dumps(_rounded(event_to_json(each)), separators=(",", ":")) for each in stream
        ]
        (FOLDER / f"{name}.jsonl").write_text("\n".join(lines) + "\n")
        truth = json.dumps(truth_of(session), separators=(",", ":"))
        (FOLDER / f"{name}.truth.json").write_text(truth + "\n")


def truth_of(session: Session) -> dict[str, Any]:
    """Times of touches, us; force of the pressing index finger by frame time, g."""
    contacts = [line["contact"] for line in session.truth if "contact" in line]
    forces = {
        line["time_us"]: finger["force_g"]
        for line in session.truth
        for finger in line.get("fingers", [])
        if finger["finger"] == "index" and finger["touching"]
    }
    return {"downs_us": [each["from_us"] for each in contacts], "forces_g": forces}


def _rounded(value: Any) -> Any:
    if isinstance(value, float):
        return round(value, DIGITS)
    if isinstance(value, dict):
        return {key: _rounded(each) for key, each in value.items()}
    if isinstance(value, list):
        return [_rounded(each) for each in value]
    return value


if __name__ == "__main__":
    main()
