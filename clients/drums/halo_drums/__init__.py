"""Drums under one hand, shaped by the height of the other.

Rule: a pure core (`player`: frames to gestures; `voices`, `bank`, `mixer`: gestures to sound) and
a thin rim (`speakers`, `midi`, `view`, `app`). It knows `halo_client` and `halo_protocol` alone.
"""
