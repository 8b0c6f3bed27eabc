"""Drums under one hand, shaped by the height of the other.

Rule: a pure core (`player`: frames to gestures; `voices`, `bank`, `mixer`: gestures to sound) and
thin input and output (`speakers`, `midi`, `view`, `app`). It imports `halo_client` and
`halo_protocol`, never the service.
"""
