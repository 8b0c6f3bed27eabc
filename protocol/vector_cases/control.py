"""Messages between a client and the control port: asking for the stream, and commands."""

from __future__ import annotations

from halo_protocol import VERSION
from halo_protocol.handshake import CONTROL, EXPIRED, GOODBYE, LEASE, WELCOME, hello, with_token
from halo_protocol.osc import padded
from vector_cases.build import ControlCase, floats, ints, message

_TOKEN = "t0123456789abcdef"
_REASON = "hello: unknown format 'midi' in '127.0.0.1:5000/midi'; choose from: frames, flat"


def _words(*words: str) -> bytes:
    return b"".join(map(padded, words))


def _welcome(outcome: str, token: str, reason: str) -> bytes:
    words = _words("desk", "s1", VERSION, outcome, token, reason)
    return message(WELCOME, "ssssssi", words, ints(10_000))


def _status(profile: str, error: str, paused: int) -> bytes:
    words = _words("desk", "s1", VERSION, profile, error)
    return message(f"{CONTROL}status", "sssssi", words, ints(paused))


def _client(name: str, description: str, datagram: bytes) -> ControlCase:
    return ControlCase(name, description, "client", datagram)


def _service(name: str, description: str, datagram: bytes) -> ControlCase:
    return ControlCase(name, description, "service", datagram)


CONTROLS = [
    _client("hello", "Asks for all frames, to the port that sent it; 256 bytes.", hello("frames")),
    _client(
        "hello-with-options",
        "Asks for 30 frames a second in the format `flat`, to port 7000 of its host.",
        hello("flat,rate=30", 7000),
    ),
    _service("welcome", "The stream starts with a lease.", _welcome("accepted", _TOKEN, "")),
    _service(
        "welcome-refused", "An unknown format: no token.", _welcome("refused", "", _REASON[:80])
    ),
    _client("lease", "Starts the stream, or continues it.", with_token(LEASE, _TOKEN)),
    _service("expired", "The token is unknown: say hello again.", with_token(EXPIRED, _TOKEN)),
    _client("goodbye", "Ends the stream.", with_token(GOODBYE, _TOKEN)),
    _client("pause", "Without arguments.", message(f"{CONTROL}pause", "")),
    _client("pause-by-a-button", "A button is pressed.", message(f"{CONTROL}pause", "i", ints(1))),
    _client(
        "pause-by-a-released-button", "Ignored: a 0.", message(f"{CONTROL}pause", "i", ints(0))
    ),
    _client("resume", "Any argument but 0.", message(f"{CONTROL}resume", "f", floats(1.0))),
    _client("background", "Measures the background again.", message(f"{CONTROL}background", "")),
    _client(
        "profile", "Changes to another profile.", message(f"{CONTROL}profile", "s", padded("desk"))
    ),
    _client("setting", "A number.", message(f"{CONTROL}sensing/up_level", "f", floats(0.125))),
    _client(
        "setting-of-words", "A word.", message(f"{CONTROL}sensing/fingers", "s", padded("all"))
    ),
    _client("status-request", "256 bytes.", message(f"{CONTROL}status", "s", padded("." * 224))),
    _service("status", "A pause, and no error.", _status("desk", "", 1)),
    _service(
        "status-with-error",
        "The last command failed.",
        _status("", "send the name of a profile, such as desk", 0),
    ),
]
