"""The virtual camera: a hand, a table, a light and a sensor that are not there.

It produces what the SDK of a real one would hand over, and the truth separately. The
halo is phenomenological (`halo` says what that means): figures measured here are claims about
the pipeline, not about the world.

Read in this order: `room` (what a seed draws), `skeleton`, `hand` and `mesh` (the hand),
`motion` and `scenario` (what it does), `scene`, `depth_image`, `colour_image` (what is seen),
`halo`, `dents`, `sensor_model`, `exposure`, `optics`, `noise`, `sensor` (what is measured),
`camera` and `clock` (by which device), `offline` and `live` (the two ways to run it).
"""
