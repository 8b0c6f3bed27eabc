"""Typing on a table: the guest's pure core. No I/O, no clock, no window."""
