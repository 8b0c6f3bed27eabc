"""The outlets of LSL.

Rule: `pylsl` is imported here alone.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterable
from typing import Any, Self

from halo_client.quiet import quiet
from halo_lsl.clock import Arrival
from halo_lsl.errors import LslError
from halo_lsl.streams import IRREGULAR, STREAMS, Setup, Stream, Tree, description, source_id

MACHINE_ONLY = """\
[multicast]
ResolveScope = machine
MachineAddresses = {127.0.0.1, 224.0.0.183}
ListenAddress = 127.0.0.1
[log]
level = -3
"""
"""Configuration of liblsl: programs on this machine find the streams, others do not.

Both addresses: one alone gives a search to a single stream of a process. The second is a multicast
group, which this machine joins on its loopback and does not send out (scope `machine`).
"""
QUIET = "[log]\nlevel = -3\n"
CONFIGURED_BY = "LSLAPICFG"
"""Environment variable of liblsl that names a configuration file; it is respected."""
READS = 5
"""Of the clocks; the quickest one counts."""

try:
    import pylsl
except (RuntimeError, OSError) as error:  # pylsl without its library
    raise LslError(
        "liblsl, the library of LSL, is not on this machine; pylsl brings it for Windows, macOS "
        "and Linux on x86-64 with glibc 2.35 or newer, elsewhere install it (conda-forge has the "
        "package liblsl) and name it with PYLSL_LIB=/path/to/liblsl.so"
    ) from error


def configure(local: bool) -> None:
    """Set who can find the streams; before everything else."""
    if CONFIGURED_BY not in os.environ:
        pylsl.set_config_content(MACHINE_ONLY if local else QUIET)


def read_clocks() -> Arrival:
    """Return LSL's clock and Unix time of the same moment."""
    best: tuple[float, float, float] | None = None
    for _ in range(READS):
        before, unix_s, after = pylsl.local_clock(), time.time(), pylsl.local_clock()
        if best is None or after - before < best[0]:
            best = (after - before, (before + after) / 2, unix_s)
    assert best is not None
    return Arrival(best[1], best[2])


class Outlets:
    """The three outlets; a context manager."""

    def __init__(self, setup: Setup) -> None:
        self._outlets: dict[str, Any] = {}
        with quiet():
            for stream in STREAMS:
                try:
                    self._outlets[stream.name] = pylsl.StreamOutlet(_info(stream, setup))
                except RuntimeError as error:
                    raise LslError(f"cannot create the stream {stream.name} ({error})") from error

    def push(self, stream: Stream, values: Iterable[float | str], time_s: float) -> None:
        """Send a sample."""
        self._outlets[stream.name].push_sample(list(values), time_s)

    def close(self) -> None:
        """Remove the streams. May be called twice."""
        self._outlets.clear()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


def _info(stream: Stream, setup: Setup) -> Any:
    info = pylsl.StreamInfo(
        stream.name,
        stream.type,
        len(stream.channels),
        setup.rate_hz if stream.regular else IRREGULAR,
        pylsl.cf_string if stream.text else pylsl.cf_float32,
        source_id(stream, setup),
    )
    _append(info.desc(), description(stream, setup))
    return info


def _append(parent: Any, tree: Tree) -> None:
    for name, value in tree.items():
        for each in value if isinstance(value, list) else [value]:
            if isinstance(each, dict):
                _append(parent.append_child(name), each)
            else:
                parent.append_child_value(name, each)
