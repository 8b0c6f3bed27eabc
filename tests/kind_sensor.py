"""The kind sensor: white noise and few errors.

Why tests ask for it: the sensing, the calibration and the halo's curves were built on it, and are
not ready for the true sensor yet. On the true one these tests would measure that, and not what
they are for. Users of the kind sensor have plain hands and plain halos.
"""

from halo_service.virtual.sensor_model import KIND

KIND_URL = "sensor=kind"
"""For a source's name."""
KIND_ROOM = {"sensor": KIND}
"""For a room."""
