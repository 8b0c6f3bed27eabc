"""Calibration: makes the profile that the service needs.

Solvers are pure, arrays in and values out, and refuse what they cannot use (`CalibrationError`).
Steps feed them from any source, guided (a person is prompted) or by a script (a recording).
"""
