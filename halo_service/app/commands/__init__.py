"""The verbs of `halo`, one module each."""
