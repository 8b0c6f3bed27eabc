"""Colour under a finger: pressure makes a stroke wider, denser and wetter.

Rule: a pure core (`painter`, `stroke`, `brushes`: frames to strokes; `canvas`, `svg`: strokes to
pictures) and thin input and output (`view`, `app`). It imports `halo_client` and
`halo_protocol`, never the service.
"""

import os

# Otherwise pygame prints a greeting to stdout.
os.environ.setdefault("PYGAME_HIDE_SUPPORT_PROMPT", "1")
