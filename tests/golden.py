"""The golden vectors of the protocol's minor version."""

from __future__ import annotations

from pathlib import Path

from halo_protocol import VERSION

PROTOCOL = Path(__file__).parents[1] / "protocol"
VECTORS = PROTOCOL / "vectors" / VERSION.rpartition(".")[0]
