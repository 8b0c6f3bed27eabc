"""`halo canvas`: surfaces of several nodes, from Zenoh, served as one.

Zenoh samples -> a thread a node: receiver -> merger (`halo_service.canvas`) -> publisher -> outputs
"""
