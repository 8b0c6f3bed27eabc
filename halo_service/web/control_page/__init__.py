"""The server of the control page: static files, calls and the live stream.

Rule: it runs in a thread of its own. It serves a fixed table of files, so no path of a request is
ever opened. What the page can do comes from the app as a table of calls.
"""
