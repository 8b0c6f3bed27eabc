"""Merges the surfaces of several nodes into one: layout, clocks, fusion.

Rule: pure. No sockets and no clock; times and frames are arguments. Only `layout` reads a file.

node frames -> clocks (time here) -> layout (place on the canvas) -> fusion -> canvas frames
"""
