"""The conformance script as an input of the Python client, for clients that must agree with it."""

from __future__ import annotations

from halo_service.app.conformance.script import Step


class Script:
    """An input that sets the clock to the time of each step."""

    url = "script"

    def __init__(self, now: list[float], script: list[Step]) -> None:
        self._now, self._steps = now, iter(script)

    def receive(self, timeout_s: float) -> tuple[bytes, str] | None:
        step = next(self._steps)
        self._now[0] = step.at_s
        return None if step.datagram is None else (step.datagram, "script")

    def close(self) -> None:
        """Nothing is open."""
