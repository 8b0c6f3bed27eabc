"""`halo bridge`: nodes from Zenoh, served as OSC, TUIO and WebSocket on another machine.

Zenoh sample -> receiver (assembly, losses) -> relay (messages again) -> OSC, TUIO, WebSocket
"""
