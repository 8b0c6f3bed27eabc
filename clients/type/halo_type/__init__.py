"""Typing on a table: the pure part of a client. No I/O, no clock, no window."""
