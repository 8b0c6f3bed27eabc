"""All nodes in reach: how fast, how late, which clock, which versions.

Zenoh (scene, health, liveliness tokens) and mDNS -> `Fleet` -> table, lines, control page
"""
