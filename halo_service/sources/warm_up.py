"""The note about the temperature of a camera that was just opened.

Rule: pure. Depth moves by about 2 mm while a cold camera warms up, for 40 to 50 minutes in one
measurement (Toelgyessy 2021, Azure Kinect); how warm a camera already is, only some report.
"""

from __future__ import annotations

from halo_service.sources import Source, Warm

MOVES_MM, MINUTES = 2, 30
"""In the note; never measured on a Femto."""


def warm_up_note(source: Source) -> str:
    """Return the note for a camera that was opened just now."""
    temperature_c = source.temperature_c() if isinstance(source, Warm) else None
    shown = "" if temperature_c is None else f" (sensor {temperature_c:.0f} °C)"
    return (
        f"cold{shown}: distance may move by {MOVES_MM} mm in the next {MINUTES} minutes; "
        "calibrate after that, if it did not run before"
    )
