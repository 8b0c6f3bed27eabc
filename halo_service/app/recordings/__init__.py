"""Recordings: write one, draw one of the virtual camera, replay one."""
