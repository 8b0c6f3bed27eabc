"""What a solver says when it cannot use what it was given."""

from __future__ import annotations

from halo_service.errors import UserError

NO_HALO = (
    "this surface shows no halo: mirrors, glass and other polished surfaces send the light away; "
    "put paper, cloth or a wooden board there, and calibrate again"
)


class CalibrationError(UserError):
    """A measurement is not good enough: one sentence that says why, and what to do."""
