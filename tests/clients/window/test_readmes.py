"""The programs in the READMEs are complete, at most 20 lines long, and run."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import pytest

from halo_protocol import Frame, encode_frame
from tests.ports import free_port

CLIENTS = Path(__file__).parents[3] / "clients"
WITHOUT_DEVICES = {
    "48_000, 20)": "48_000, 20, backends=[miniaudio.Backend.NULL])",
    'mido.open_output("my table", virtual=True)': "mido.ports.EchoPort()",
    "127.0.0.1:4256": "127.0.0.1:{port}",
}


@pytest.mark.parametrize("client", ["drums", "lsl", "midi", "paint", "type"])
def test_the_program_in_the_readme_runs(client: str, wire: Any, tmp_path: Path) -> None:
    text = (CLIENTS / client / "README.md").read_text()
    program = text.partition("```python\n")[2].partition("```")[0]
    assert len([line for line in program.splitlines() if line.strip()]) <= 20
    port = free_port()
    path = tmp_path / "program.py"
    for device, substitute in WITHOUT_DEVICES.items():
        program = program.replace(device, substitute.format(port=port))
    path.write_text(program)
    lsl = tmp_path / "lsl_api.cfg"
    lsl.write_text("[multicast]\nResolveScope = machine\n[log]\nlevel = -3\n")
    env = os.environ | {"SDL_VIDEODRIVER": "dummy", "LSLAPICFG": str(lsl)}
    with (
        subprocess.Popen([sys.executable, path], stderr=subprocess.PIPE, text=True, env=env) as run,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as out,
    ):
        for number in range(90):
            header = Frame("desk", "s1", number, 1000, number * 10_000, 1)
            touching = [wire.finger(at=(100.0, 90.0), pressure=0.6)]
            for datagram in encode_frame("table", header, touching, [], []):
                out.sendto(datagram, ("127.0.0.1", port))
            time.sleep(0.03)
        running = run.poll() is None
        run.terminate()
        assert run.stderr is not None
        assert running, run.stderr.read()
