"""Orbbec's Femto cameras, which have the Azure Kinect's depth sensor, through `pyorbbecsdk2`.

This was never run with a real Femto. Tested without one: the installed SDK has every name that is
used here and lists zero devices, its own frames become ours, and a fake pipeline replaces the
device.
"""
