"""Finds where surfaces are relative to each other: by touches of both, or by one printed marker."""
