"""Fingers that cross the seams of a canvas, what nodes report of them, and how it is merged."""
