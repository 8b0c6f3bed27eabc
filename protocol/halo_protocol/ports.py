"""Default UDP ports: HALO on a phone's keypad. 9000 and 9001, which many use, are VRChat's."""

DEFAULT_PORT = 4256
"""Where a service sends messages, on its own machine."""
DEFAULT_CONTROL_PORT = 4257
"""Where a service receives messages."""
