"""The service and a Zenoh router. Each runs in a process of its own."""

from __future__ import annotations

import json
import logging
import os
import resource
import signal
import sys
import threading
from contextlib import suppress
from multiprocessing.connection import Connection
from pathlib import Path

from tests.faults import FAULTS, FaultyCamera, FaultyTracker


def serve(folder: Path, ports: dict[str, int], pipe: Connection) -> None:
    """Run the real service on the drawn camera; commands come through the pipe."""
    from halo_service.app.logs import set_up_logging
    from halo_service.app.service import serve as service
    from halo_service.outputs.settings import ControlSettings, OscSettings, ZenohSettings
    from halo_service.settings import Settings
    from halo_service.web.settings import WebSettings

    log = (folder / "service.log").open("a")
    os.dup2(log.fileno(), sys.stderr.fileno())
    set_up_logging(logging.INFO)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    service.open_source = lambda *_: (FaultyCamera(), FaultyCamera)  # type: ignore[assignment]
    service.HandDetector = lambda *_, **__: FaultyTracker()  # type: ignore[assignment, misc]
    service.model_for = lambda *_: Path()
    threading.Thread(target=_obey, args=(pipe,), daemon=True).start()
    service.serve(
        Settings(
            node="soak",
            profile=str(folder / "profile"),
            osc=OscSettings(destinations=(f"127.0.0.1:{ports['osc']}",)),
            control=ControlSettings(port=ports["control"]),
            zenoh=ZenohSettings(
                listen=("tcp/127.0.0.1:0",), connect=(f"tcp/127.0.0.1:{ports['router']}",)
            ),
            web=WebSettings(port=ports["web"], announce=False),
        )
    )


def _obey(pipe: Connection) -> None:
    with suppress(EOFError, OSError):
        while True:
            order, fault = pipe.recv()
            if fault == "disk full":
                size = 0 if order == "begin" else resource.RLIM_INFINITY
                hard = resource.getrlimit(resource.RLIMIT_FSIZE)[1]
                resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
            elif order == "begin":
                FAULTS.begin(fault)
            else:
                FAULTS.end(fault)
            pipe.send("done")


def route(port: int) -> None:
    """Run a Zenoh router until it is killed."""
    import zenoh

    config = zenoh.Config()
    for key, value in {
        "mode": "router",
        "listen/endpoints": [f"tcp/127.0.0.1:{port}"],
        "scouting/multicast/enabled": False,
    }.items():
        config.insert_json5(key, json.dumps(value))
    with zenoh.open(config):
        signal.pause()
