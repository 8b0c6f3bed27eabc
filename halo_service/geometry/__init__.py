"""Lenses, planes and frames of reference: pure functions on arrays."""
