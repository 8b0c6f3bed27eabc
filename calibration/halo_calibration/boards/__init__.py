"""Boards to print or project: what they look like, how they are found, and the sheets."""
