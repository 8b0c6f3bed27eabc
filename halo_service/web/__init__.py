"""HTTP and WebSocket server: the stream for browsers.

Rule: it runs in a thread of its own and never delays a frame. Every byte of a request is
distrusted, and only pages of allowed hosts may connect.
"""
