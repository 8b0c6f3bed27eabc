"""Colour under a finger: pressure makes a stroke wider, denser and wetter.

Rule: a pure core (`painter`, `stroke`, `brushes`: frames to strokes; `canvas`, `svg`: strokes to
pictures) and a thin rim (`view`, `app`). It knows `halo_client` and `halo_protocol` alone.
"""

import os

# pygame greets on stdout otherwise.
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
