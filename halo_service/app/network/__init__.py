"""Networks of several machines: a Zenoh router, and what is wrong with a network."""
