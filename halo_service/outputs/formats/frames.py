"""The protocol's own frames, as SPEC.md describes them."""

from __future__ import annotations

from halo_protocol.osc import message_spans
from halo_service.outputs.outgoing import OutgoingFrame, OutgoingReport


class FramesFormat:
    """Whole frames in bundles."""

    def __init__(self, *, bundles: bool = True, timetagged: bool = False) -> None:
        """`bundles` false: one message per datagram; `timetagged`: with the frame's time."""
        self._bundles = bundles
        self._timetagged = timetagged

    def frame(self, frame: OutgoingFrame) -> list[bytes]:
        """Return the datagrams of a frame."""
        datagrams = frame.encoded(timetagged=True) if self._timetagged else frame.datagrams
        return datagrams if self._bundles else _messages(datagrams)

    def report(self, report: OutgoingReport) -> list[bytes]:
        """Return the datagram of a report."""
        return report.datagrams if self._bundles else _messages(report.datagrams)


def _messages(datagrams: list[bytes]) -> list[bytes]:
    """Unpack bundles; a header or alive list that is in each part comes once."""
    messages = [each[start:end] for each in datagrams for start, end in message_spans(each)]
    first_of = dict.fromkeys(messages)
    alive = [each for each in first_of if b"/alive\0" in each[:64]]
    return [each for each in first_of if each not in alive] + alive
