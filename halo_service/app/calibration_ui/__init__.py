"""The steps of `halo calibrate`, in a terminal."""
